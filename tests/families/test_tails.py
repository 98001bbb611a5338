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
sizes: {{N: 1}}
parameters: {{k: 3, w: {width}}}
coordinates: {{"x[i in range(N)]": {{initial: -20}}, "y[i in range(N)]": {{initial: 0}}}}
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
HIDDEN = {
    "a ring": f"exp(-(({SQUARE} - 1)/w)**2)",
    "a shell far out": f"exp(300 - sqrt({SQUARE})/w)/sqrt({SQUARE})",
    "of unknown signs": "exp(k*x[i]**2 - y[i]**2)",
    "of both signs": "exp(x[i]**2 - y[i]**2)",
    "a tanh": "tanh(x[i]/w)",
    "of a power below 0": f"exp(-w/{SQUARE})",
}


@pytest.fixture(autouse=True)
def of_any_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """Families stay families, however few their members are."""
    monkeypatch.setattr(systems, "FEWEST", 0)


@pytest.mark.parametrize("width", [0.003, 0.1])
@pytest.mark.parametrize("potential", SEEN.values(), ids=SEEN)
def test_no_force_is_passed_over(potential: str, width: float) -> None:
    """A bead comes from far, where the force is 0 to the last bit: its motion by ias15 is that by series
    whose steps are proven, wherever and how fast it comes."""
    random = np.random.default_rng(int(1000 * width) + len(potential))
    spec, values = begun(PASSING.format(potential=potential, width=width))
    system = family_system(spec)
    assert system is not None and not narrow(system, "ias15")
    ready = {
        method: prepare_system(spec, derive_system, None, Compilation(method, FULL, frozenset({"q", "v"})))
        for method in ("taylor", "ias15")
    }
    felt = 0.0
    for _ in range(12):
        x, y, speed = -20 - random.random(), width * random.normal(scale=3), 2 + random.random()
        begin = replace(values, q=(x, y), v=(speed, 0.0))
        true, found = (run(one, begin, 0.0, 20.0, 2) for one in ready.values())
        felt = max(felt, abs(true["q/x"][-1, 0] - x - 20 * speed))
        for path in ("q/x", "q/y", "v/x", "v/y"):
            assert found[path][-1] == pytest.approx(true[path][-1], rel=1e-11, abs=1e-11)
    assert felt > 1e-4


@pytest.mark.parametrize("potential", HIDDEN.values(), ids=HIDDEN)
def test_what_may_hide(potential: str) -> None:
    """Structures that do not begin where what is halved from step to step is small."""
    system = family_system(read_spec(PASSING.format(potential=potential, width=0.1), "passing.yaml"))
    assert system is not None and narrow(system, "ias15")
