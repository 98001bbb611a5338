"""Tails of exponentials and of powers in large systems: no step of ias15 passes over a force in them."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.families.system import family_system
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.families import narrow
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.records import replace
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from tests.support.families import begun
from tests.support.motion import FULL, run

PASSING = """
sizes: {{N: 2}}
parameters: {{k: 3, w: {width}, R: 1, minus: -1}}
coordinates: {{"x[i in range(N)]": {{initial: -20 - 500*i}}, "y[i in range(N)]": {{initial: 0}}}}
masses: {{"bead[i in range(N)]": 1}}
embedding: {{"bead[i in range(N)]": ["x[i]", "y[i]"]}}
potential: "sum({potential} for i in range(N))"
"""
SQUARE = "(x[i]**2 + y[i]**2)"
SEEN = {
    "a core": f"0.5*exp(-{SQUARE}/(2*w**2))",
    "a hard core": f"0.5*exp(-({SQUARE}/w**2)**2)",
    "a ridge": "0.5*exp(-((x[i] - 1)/w)**2)",
    "a wall": "exp((x[i] - 3)/w)",
    "a screened charge": f"0.01*exp(-sqrt({SQUARE})/w)/sqrt({SQUARE})",
    "a screened charge, shifted": f"0.3*exp(16 - sqrt({SQUARE})/w)/sqrt({SQUARE})",
    "a broken power": f"1e-6*sqrt({SQUARE})**-2.7",
}
SHELLS = {
    "Morse's potential": f"(1 - exp((R - sqrt({SQUARE}))/w))**2",
    "a shell": f"0.3*exp(minus*(sqrt({SQUARE}) - R)/w)/sqrt({SQUARE})",
    "written otherwise": f"0.5*exp(-k*sqrt({SQUARE})/w + k*R/w)",
    "of numbers": f"0.1*exp((1 - sqrt({SQUARE}))/1e-6)",
    "from inside": f"0.2*exp((sqrt({SQUARE}) - 12)/w)",
}
HIDDEN = {
    "a ring": f"exp(-(({SQUARE} - 1)/w)**2)",
    "a core of great width": f"exp(300 - {SQUARE}/w**2)",
    "two distances": f"exp((sqrt({SQUARE}) + sqrt({SQUARE} + 1))/w)",
    "of unknown signs": "exp(k*x[i]**2 - y[i]**2)",
    "of both signs": "exp(x[i]**2 - y[i]**2)",
    "a tanh": "tanh(x[i]/w)",
    "of a power below 0": f"exp(-w/{SQUARE})",
}


@pytest.fixture(autouse=True)
def of_any_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """Families stay families, however few their members are."""
    monkeypatch.setattr(systems, "FEWEST", 0)


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("width", [0.003, 0.1])
@pytest.mark.parametrize("potential", SEEN.values(), ids=SEEN)
def test_no_force_is_passed_over(potential: str, width: float) -> None:
    """A bead comes from far, where the force is 0 to the last bit, and another one rests still further away:
    its motion by ias15 is that by series whose steps are proven, wherever and how fast it comes."""
    random = np.random.default_rng(int(1000 * width) + len(potential))
    spec, values = begun(PASSING.format(potential=potential, width=width))
    system = family_system(spec)
    assert system is not None and not narrow(system, "ias15")
    ready = [
        prepare_system(spec, derive_system, None, Compilation(method, tolerance, frozenset({"q", "v"})))
        for method, tolerance in (("taylor", FULL), ("ias15", FULL), ("ias15", 1e-3))
    ]
    felt = 0.0
    for _ in range(12):
        x, y, speed = -20 - random.random(), width * random.normal(scale=3), 2 + random.random()
        begin = replace(values, q=(x, -500.0, y, 0.0), v=(speed, 0.0, 0.0, 0.0))
        true, found, loose = (run(one, begin, 0.0, 20.0, 2) for one in ready)
        felt = max(felt, abs(true["q/x"][-1, 0] - x - 20 * speed))
        for path in ("q/x", "q/y", "v/x", "v/y"):
            assert found[path][-1] == pytest.approx(true[path][-1], rel=1e-11, abs=1e-11)
            assert loose[path][-1] == pytest.approx(true[path][-1], rel=1e-6, abs=1e-6)
    assert felt > 1e-4


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("width", [1e-6, 0.003])
@pytest.mark.parametrize("name", SHELLS)
def test_no_shell_is_passed_over(name: str, width: float) -> None:
    """A bead grazes one, or meets the wall around it. The steps that poles allow are far longer than it is
    wide."""
    random = np.random.default_rng(int(1e7 * width) + len(name))
    text = PASSING.format(potential=SHELLS[name], width=width).replace("-20 - 500*i", "-20 - 20*i")
    spec, values = begun(text)
    system = family_system(spec)
    assert system is not None and not narrow(system, "ias15")
    ready = [
        prepare_system(spec, derive_system, None, Compilation(method, tolerance, frozenset({"q", "v"})))
        for method, tolerance in (("taylor", FULL), ("ias15", FULL), ("ias15", 1e-3))
    ]
    inside, felt = name == "from inside", 0.0
    for _ in range(12):
        x, y = (0.2, random.normal()) if inside else (-20 - random.random(), 1 + 2 * width * random.normal())
        other = 0.4 if inside else -40.0
        begin = replace(values, q=(x, other, y, 0.3), v=(2 + random.random(), 0.0, 0.0, 0.0))
        stop = 6.0 if inside else 12.0
        true, found, loose = (run(one, begin, 0.0, stop, 2) for one in ready)
        felt = max(felt, abs(true["v/y"][-1, 0]))
        for path in ("q/x", "q/y", "v/x", "v/y"):
            assert found[path][-1] == pytest.approx(true[path][-1], rel=1e-6, abs=1e-6)
            assert loose[path][-1] == pytest.approx(true[path][-1], rel=1e-3, abs=1e-3)
    assert felt > 1e-4


MEETING = """
sizes: {{N: 3}}
parameters: {{a: 15}}
coordinates:
  x[i in range(N)]: {{initial: "20*cos(2*pi*i/N) - sin(2*pi*i/N)/5", velocity: "-2*cos(2*pi*i/N)"}}
  y[i in range(N)]: {{initial: "20*sin(2*pi*i/N) + cos(2*pi*i/N)/5", velocity: "-2*sin(2*pi*i/N)"}}
  z[i in range(N)]: {{initial: 0}}
masses: {{"bead[i in range(N)]": 1}}
embedding: {{"bead[i in range(N)]": ["x[i]", "y[i]", "z[i]"]}}
potential: sum({pair} for i in range(N) for j in range(i))
"""
APART = "norm(bead[i] - bead[j])"


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize("pair", [f"1e6*exp(-a*{APART})", f"exp(-18*({APART} - 1))"])
def test_forces_that_are_hardly_more_than_0_at_first(pair: str) -> None:
    """The first trial is not so long that its square is infinite."""
    spec, values = begun(MEETING.format(pair=pair))
    true, found = (
        run(prepare_system(spec, derive_system, None, Compilation(method, FULL, frozenset({"q", "v"}))),
            values, 0.0, 20.0, 2)
        for method in ("taylor", "ias15")
    )  # fmt: skip
    for path in ("q/x", "q/y"):
        assert found[path][-1] == pytest.approx(true[path][-1], rel=1e-9, abs=1e-9)
    straight = true["q/x"][0] + 20 * true["v/x"][0]
    assert np.max(np.abs(true["q/x"][-1] - straight)) > 1


@pytest.mark.parametrize("potential", HIDDEN.values(), ids=HIDDEN)
def test_what_may_hide(potential: str) -> None:
    """Structures that do not begin where what is halved from step to step is small."""
    system = family_system(read_spec(PASSING.format(potential=potential, width=0.1), "passing.yaml"))
    assert system is not None and narrow(system, "ias15")
