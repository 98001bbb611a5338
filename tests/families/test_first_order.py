"""Families without mass, whose equations of motion give velocities, against members that are written out,
closed forms, and other routes to the same numbers."""

from __future__ import annotations

import json
import math
import random
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import lagrange_cli as lagrange
from lagrange_cli.cli.main import main
from lagrange_cli.families import system as systems
from lagrange_cli.families.system import family_system
from lagrange_cli.run.massless import with_equations_of_the_massless
from lagrange_cli.spec.read import read_spec

CLOSE = {"taylor": 1e-12, "ias15": 1e-12, "DOP853": 1e-6, "Radau": 1e-6, "double-double": 1e-14}
COUNTS = 1, 2, 3, 8, 9
HEAD = """
sizes: {{N: {count}}}
parameters: {{"G[i in range(N)]": 1.1 + sin(2*i), k: {k!r}, c: {c!r}}}
"""
PLANE = """
coordinates:
  x[i in range(N)]: {{initial: "cos({a!r}*i) + 0.2*i"}}
  y[i in range(N)]: {{initial: "sin({a!r}*i)"}}
"""
LINE = """
coordinates:
  x[i in range(N)]: {{initial: "cos({a!r}*i)"}}
"""
BOBS = """
coordinates:
  x[i in range(N)]: {{initial: "cos({a!r}*i)", velocity: "sin(3*i)"}}
  z[i in range(N)]: {{initial: "0.3*cos({a!r}*i)"}}
masses: {{"bob[i in range(N)]": 1 + i % 2}}
positions: {{"bob[i in range(N)]": "x[i]"}}
"""
SOME = """
coordinates:
  x[i in range(N + 1)]: {{initial: "cos({a!r}*i)"}}
masses: {{"bob[i in range(N//2 + 1)]": 1.5}}
positions: {{"bob[i in range(N//2 + 1)]": "x[2*i]"}}
"""
PAIRS = "for i in range(N) for j in range(i)"
CASES = {
    "vortices": PLANE + """
lagrangian: >-
  sum(G[i]*y[i]*x_dot[i] for i in range(N))
  + sum(G[i]*G[j]*log(0.3 + (x[i] - x[j])**2 + (y[i] - y[j])**2)/(4*pi) PAIRS)
""",
    "a phase space that is curved": PLANE + """
lagrangian: >-
  sum((1 + x[i]**2 + k*y[i]**2)*(x[i]*y_dot[i] - y[i]*x_dot[i]) for i in range(N))
  - sum(x[i]**2 + k*cos(y[i]) for i in range(N)) - c*sum(cos(x[i] - y[j]) PAIRS)
""",
    "oscillators": LINE + """
lagrangian: sum(G[i]*x[i] for i in range(N)) + k/N*sum(cos(x[i] - x[j]) PAIRS)
dissipation: sum(x_dot[i]**2/2 for i in range(N))
""",
    "a chain in a liquid that flows": LINE + """
lagrangian: -k*sum((x[i + 1] - x[i])**2/2 for i in range(N - 1)) - sum(x[i]**4/4 for i in range(N))
dissipation: sum((1 + x[i]**2)*(x_dot[i] - c*sin(3*t))**2/2 for i in range(N))
""",
    "forces besides": LINE + """
lagrangian: -k*sum(x[i]**2/2 for i in range(N))
generalized_forces: {{"x[i in range(N)]": "-(2 + cos(x[i] + t))*x_dot[i] + G[i]*exp(-t)"}}
""",
    "soft discs": PLANE + """
lagrangian: >-
  -sum(k*max(0, 1 - (x[i] - x[j])**2 - (y[i] - y[j])**2)**2 PAIRS)
  - sum(max(0, x[i] - 0.3)**2 + y[i]**2*abs(y[i]) for i in range(N))
dissipation: sum(c*(x_dot[i]**2 + y_dot[i]**2)/2 for i in range(N))
""",
    "walls for dampers": BOBS + """
potential: sum(k*z[i]**2/2 + max(0, z[i] - x[i] - 0.2)**2 for i in range(N))
dissipation: sum(c*(x_dot[i] - z_dot[i])**2/2 for i in range(N))
""",
    "dampers in series": BOBS + """
potential: sum(k*z[i]**2/2 for i in range(N)) + sum((x[i] - x[j])**2/20 PAIRS)
dissipation: sum(c*(x_dot[i] - z_dot[i])**2/2 for i in range(N)) + sum(z_dot[i]**2/9 for i in range(N))
""",
    "some have a mass": SOME + """
potential: sum(k*(x[i + 1] - x[i])**2/2 + (x[i + 1] - x[i])**4/4 for i in range(N)) + x[0]**2
dissipation: c*sum(x_dot[i]**2/2 for i in range(N + 1))
""",
}  # fmt: skip
Samples = Mapping[str, NDArray[np.float64]]


def drawn(case: str, count: int, request: pytest.FixtureRequest) -> str:
    """The text of a random system."""
    chance = random.Random(f"{request.config.option.seed} {case} {count}")
    given = {name: round(chance.uniform(0.5, 1.5), 3) for name in "kca"}
    return (HEAD + CASES[case].replace("PAIRS", PAIRS)).format(count=count, **given)


def in_loops(monkeypatch: pytest.MonkeyPatch) -> None:
    """Families are followed in loops, however few their members are."""
    monkeypatch.setattr(systems, "FEWEST", 0)
    monkeypatch.setattr(systems, "FEWEST_SWITCHED", 0)
    systems._LATEST.clear()


def written_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """Members are written out."""
    monkeypatch.setattr(systems, "with_first_order", lambda spec: spec)


def moved(text: str, method: str, **asked: float) -> Samples:
    """Coordinates, velocities, momenta and h."""
    precision = method if method == "double-double" else "double"
    found = lagrange.solve(
        text, method="taylor" if method == precision else method, precision=precision,
        samples=5, outputs="q,v,p,h", **asked,
    )  # fmt: skip
    groups = {"q": found.q, "v": found.v, "p": found.p}
    return {f"{group}/{name}": one for group, some in groups.items() for name, one in some.items()} | {
        "h": found.h
    }


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.filterwarnings("ignore:.*does not detect narrow forces")
@pytest.mark.parametrize("method", CLOSE)
@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("case", CASES)
def test_they_move_as_written_out(
    case: str, count: int, method: str, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    text = drawn(case, count, request)
    with monkeypatch.context() as patch:
        written_out(patch)
        expected = moved(f"{text}# written out\n", method, stop=1.0)
    in_loops(monkeypatch)
    assert with_equations_of_the_massless(read_spec(text, "system.yaml")).first_order
    found = moved(text, method, stop=1.0)
    assert found.keys() == expected.keys()
    for path, values in expected.items():
        assert np.allclose(found[path], values, rtol=CLOSE[method], atol=CLOSE[method]), (path, text)


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.filterwarnings("ignore:.*does not detect narrow forces")
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize("case", CASES)
def test_back_to_the_start(
    case: str, method: str, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    in_loops(monkeypatch)
    text = drawn(case, 3, request)
    there = lagrange.solve(text, stop=0.4, samples=2, method=method)
    given = {}
    for group, end in ((there.q, ""), (there.v, "_dot")):
        for name, values in group.items():
            given |= {f"{name}{end}[{i}]": repr(float(x)) for i, x in enumerate(values[-1])}
    back = lagrange.solve(text, start=0.4, stop=0, samples=2, method=method, set=given)
    for name, values in there.q.items():
        assert np.allclose(back.q[name][-1], values[0], rtol=0, atol=1e-11), text


def test_a_ring_of_vortices_turns() -> None:
    """N equal vortices at the corners of a polygon turn by G (N - 1)/(4 pi R^2) (J. J. Thomson, 1883)."""
    text = """
sizes: {N: 60}
parameters: {G: 0.8, R: 1.5}
coordinates:
  x[i in range(N)]: {initial: R*cos(2*pi*i/N)}
  y[i in range(N)]: {initial: R*sin(2*pi*i/N)}
lagrangian: >-
  sum(G*y[i]*x_dot[i] for i in range(N))
  + sum(G**2*log((x[i] - x[j])**2 + (y[i] - y[j])**2)/(4*pi) for i in range(N) for j in range(i))
"""
    found = lagrange.solve(text, stop=0.2, samples=3, outputs="q,h")  # it is unstable
    z = found.q["x"] + 1j * found.q["y"]
    turned = np.exp(1j * 0.8 * 59 / (4 * math.pi * 1.5**2) * found.t)
    assert np.allclose(
        z, 1.5 * np.exp(2j * math.pi * np.arange(60) / 60) * turned[:, None], rtol=0, atol=1e-12
    )
    assert found.attributes["h_drift"] < 1e-13


@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853", "auto"])
def test_a_chain_of_overdamped_beads_relaxes(method: str) -> None:
    """c x' = -K x: each mode decays by its own rate, 4 k sin^2(m pi/(2 N + 2))/c."""
    count, c, k = 90, 2.0, 3.0
    text = f"""
sizes: {{N: {count}}}
coordinates: {{"x[i in range(N)]": {{initial: sin(i*i)}}}}
lagrangian: -{k}*(x[0]**2 + x[N - 1]**2 + sum((x[i + 1] - x[i])**2 for i in range(N - 1)))/2
dissipation: sum({c}*x_dot[i]**2/2 for i in range(N))
"""
    found = lagrange.solve(
        text, stop=30, samples=4, method=method, tolerance=1e-9 if method == "DOP853" else None
    )
    modes = np.sqrt(2 / (count + 1)) * np.sin(
        np.pi * np.outer(np.arange(1, count + 1), np.arange(1, count + 1)) / (count + 1)
    )
    rates = 4 * k * np.sin(np.arange(1, count + 1) * np.pi / (2 * count + 2)) ** 2 / c
    for t, x in zip(found.t, found.q["x"]):
        expected = modes @ (np.exp(-rates * t) * (modes @ np.sin(np.arange(count) ** 2.0)))
        assert np.allclose(x, expected, rtol=0, atol=1e-7 if method == "DOP853" else 2e-14)


def test_errors_of_velocities_do_not_add_up() -> None:
    """They follow from places: after ten times as many coarse steps they are as good."""
    text = (HEAD + CASES["oscillators"].replace("PAIRS", PAIRS)).format(count=40, k=1.5, c=1, a=1)
    errors = []
    for stop in (200, 2000):
        found = lagrange.solve(text, stop=stop, samples=2, method="DOP853", tolerance=1e-4, outputs="q,v")
        x, own = found.q["x"][-1], 1.1 + np.sin(2.0 * np.arange(40))
        rates = own - 1.5 / 40 * np.sum(np.sin(x[:, None] - x), axis=1)
        errors.append(np.max(np.abs(found.v["x"][-1] - rates)))
    assert errors[1] < 5 * errors[0] < 1e-4  # else 30 times


MANY = (HEAD + CASES["oscillators"].replace("PAIRS", PAIRS)).format(count=40, k=1, c=1, a=1)


def test_given_velocities_have_to_be_those_of_the_equations() -> None:
    with pytest.raises(lagrange.SpecError) as caught:
        lagrange.solve(MANY, stop=1, set={"x_dot[3]": 2})
    said = str(caught.value)
    assert "x_dot[3] is 2 at the start, but" in said and "'x[3]' has no mass" in said
    first = lagrange.solve(MANY, stop=1, samples=2, outputs="q,v")
    value = float(first.v["x"][0, 3])
    near = lagrange.solve(MANY, stop=1, samples=2, outputs="q,v", set={"x_dot[3]": value + 1e-9})
    assert near.v["x"][0, 3] == value and np.array_equal(near.q["x"], first.q["x"])
    far = lagrange.solve(MANY, stop=1, samples=2, outputs="q,v", set={"x_dot[3]": 2}, project_initial=True)
    assert np.array_equal(far.q["x"], first.q["x"])


def test_what_their_equations_do_not_determine_is_refused() -> None:
    text = MANY.replace("x_dot[i]**2/2", "G[i]*x_dot[i]**2/2")
    with pytest.raises(
        lagrange.SpecError, match=r"equation of motion of 'x\[7\]', which has no mass, does not"
    ):
        lagrange.solve(text, stop=1, set={"G[7]": 0})


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("case", CASES)
def test_printed_equations_are_those_that_are_solved(
    case: str, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest, tmp_path: Path, capsys
) -> None:
    in_loops(monkeypatch)
    path = tmp_path / "system.yaml"
    path.write_text(drawn(case, 60, request), encoding="utf-8")
    for form in ("lagrange", "matrix"):
        assert main(["equations", "--verify", "--form", form, str(path)]) == 0, capsys.readouterr()
    assert main(["equations", "--form", "hamilton", str(path)]) == 2
    assert "there is no Hamiltonian" in capsys.readouterr().err


def test_the_equations_of_vortices_as_textbooks_have_them() -> None:
    text = (HEAD + CASES["vortices"].replace("PAIRS", PAIRS).replace("0.3 + ", "")).format(
        count=3, k=1, c=1, a=1
    )
    shown = lagrange.equations(text, indexed=True).write()
    assert "sum(G[j]*(x[i] - x[j])/((x[i] - x[j])**2 + (y[i] - y[j])**2)" in shown
    assert "the rates of the velocities, which the equations of motion give" in shown


def test_check_says_which_have_no_mass(tmp_path: Path, capsys) -> None:
    path = tmp_path / "system.yaml"
    path.write_text(MANY, encoding="utf-8")
    assert main(["check", str(path)]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("system: 40 coordinates of first order, scleronomic")
    assert "without mass: x[0..39]\n" in shown and "give their velocities" in shown
    assert "initial values found from the equations of motion: x_dot[0] = " in shown
    assert main(["check", "--json", str(path)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["massless"] == [f"x[{i}]" for i in range(40)] and told["degrees_of_freedom"] == 0


def test_work_does_not_depend_on_their_number() -> None:
    def counted(count: int) -> int:
        spec = with_equations_of_the_massless(read_spec(MANY.replace("N: 40", f"N: {count}"), "system.yaml"))
        found = family_system(spec)
        assert found is not None and found.first_order is not None
        return len(found.slots.graph.nodes) if hasattr(found.slots.graph, "nodes") else len(found.slots.of)

    assert counted(60) == counted(400)


def test_what_loops_do_not_compute_goes_through_the_members() -> None:
    """Constraints and multipliers, by the names that members have there."""
    asked = {"stop": 1, "samples": 3, "outputs": "q,constraints,multipliers"}
    found = lagrange.solve(MANY.replace("N: 40", "N: 20"), **asked)
    assert np.max(np.abs(found.multipliers["equation of x(3)"])) < 1e-12
    expected = lagrange.solve(MANY.replace("N: 40", "N: 20"), stop=1, samples=3, outputs="q")
    assert np.allclose(found.q["x"], expected.q["x"], rtol=0, atol=1e-13)


@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_discs_that_touch_part(method: str) -> None:
    """Overdamped discs with U = k d^(5/2)/2: pairs overlap by d = (d0^(-1/2) + 5 k t/4)^(-2)."""
    text = """
sizes: {N: 60}
coordinates:
  x[i in range(N)]: {initial: 5*floor(i/2) + 0.7*(i % 2)}
  y[i in range(N)]: {initial: 0}
definitions: {"disc[i in range(N)]": "(x[i], y[i])"}
lagrangian: -sum(3*max(0, 1 - norm(disc[i] - disc[j]))**2.5/2 for i in range(N) for j in range(i))
dissipation: sum((x_dot[i]**2 + y_dot[i]**2)/2 for i in range(N))
""".replace("floor(i/2)", "(i//2)")
    found = lagrange.solve(text, stop=4, samples=5, method=method)
    apart = found.q["x"][:, 1::2] - found.q["x"][:, ::2]
    expected = 1 - (0.3**-0.5 + 1.25 * 3 * found.t) ** -2
    assert np.allclose(apart, expected[:, None], rtol=0, atol=1e-13) and not found.q["y"].any()


@pytest.mark.filterwarnings("ignore:.*does not detect narrow forces")
@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_events_are_those_of_the_members(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    text = MANY.replace("N: 40", "N: 20") + """
events:
  beat[i in range(N)]: {when: sin(x[i])}
  slow: {when: x_dot[0] - 0.9}
  far: {when: x[3] - 4, action: stop}
"""  # fmt: skip
    found = lagrange.solve(text, stop=9, samples=5, method=method)
    with monkeypatch.context() as patch:
        written_out(patch)
        expected = lagrange.solve(f"{text}# written out\n", stop=9, samples=5, method=method)
    assert found.events.keys() == expected.events.keys() and len(found.events["far/t"]) == 1
    for path, values in expected.events.items():
        assert len(values) and np.allclose(found.events[path], values, rtol=0, atol=1e-11), path
    assert np.allclose(found.q["x"][-1], expected.q["x"][-1], rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("potential", "friction"),
    [
        ("0.3*abs(x[i])", "x_dot[i]**2/2"),  # forces that jump
        ("x[i]*where(t < 0.5, 1, 2)", "x_dot[i]**2/2"),
        ("x[i]**2", "(x_dot[i] + x_dot[(i + 1) % N]/3)**2/2"),  # several velocities
        ("x[i]**2", "x_dot[i]**2*where(x[i] > 0, 1, 2)/2"),
    ],
)
def test_what_does_not_give_one_velocity_is_written_out(potential: str, friction: str) -> None:
    text = f"""
sizes: {{N: 120}}
coordinates: {{"x[i in range(N)]": {{initial: 1 + 0.1*sin(i)}}}}
lagrangian: -sum({potential} for i in range(N))
dissipation: sum({friction} for i in range(N))
"""
    spec = with_equations_of_the_massless(read_spec(text, "system.yaml"))
    assert not spec.first_order and len(spec.massless) == 120
