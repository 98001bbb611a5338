"""Friction in the joints of chains and trees that stay families, beside the same systems written out, closed
forms and conservation."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from tests.families.test_events import keep_families
from tests.families.test_switches import BY_RATES, LEDGERS, compare, followed, ledgers_close, ready

HEAD = """
sizes: {{N: {count}}}
parameters:
  {{g: 9.8, c: 0.7, F: 1.9, w: 0.3, "l[i in range(N)]": 1 + i/9, "m[i in range(N)]": 1 - 0.6*sin(i)**2}}
"""
CHAIN = """
coordinates: {{"a[i in range(N)]": {{initial: "{start}", velocity: "{speed}"}}}}
masses: {{"bob[i in range(N)]": "m[i]"}}
embedding:
  "bob[i in range(N)]":
  - "sum(l[j]*sin(a[j]) for j in range(i + 1))"
  - "-sum(l[j]*cos(a[j]) for j in range(i + 1))"
potential: "sum(m[i]*g*bob[i].y for i in range(N))"
"""
TREE = """
coordinates: {{"a[i in range(N)]": {{initial: "{start}", velocity: "{speed}"}}}}
definitions:
  "x[0]": "l[0]*sin(a[0])"
  "y[0]": "-l[0]*cos(a[0])"
  "x[i in range(1, N)]": "x[(i - 1)//2] + l[i]*sin(a[i])"
  "y[i in range(1, N)]": "y[(i - 1)//2] - l[i]*cos(a[i])"
masses: {{"bob[i in range(N)]": "m[i]"}}
embedding: {{"bob[i in range(N)]": ["x[i]", "y[i]"]}}
potential: "sum(m[i]*g*bob[i].y for i in range(N))"
"""
SPACE = """
coordinates:
  "a[i in range(N)]": {{initial: "0.5 + {start}", velocity: "{speed}"}}
  "b[i in range(N)]": {{initial: "0.1*i", velocity: "cos(3*i)"}}
masses: {{"bob[i in range(N)]": "m[i]"}}
embedding:
  "bob[i in range(N)]":
  - "sum(l[j]*sin(a[j])*cos(b[j]) for j in range(i + 1))"
  - "sum(l[j]*sin(a[j])*sin(b[j]) for j in range(i + 1))"
  - "-sum(l[j]*cos(a[j]) for j in range(i + 1))"
potential: "sum(m[i]*g*bob[i].z for i in range(N))"
"""
CART = CHAIN.replace("coordinates: {{", "coordinates: {{x: {{initial: 0.2, velocity: 0.4}}, ")
CART = CART.replace("masses: {{", "masses: {{cart: 2, ").replace(
    "embedding:\n", "embedding:\n  cart: [x, 0]\n"
)
CART = CART.replace('- "sum', '- "x + sum')
TOPS = """
coordinates:
  "a[i in range(N)]": {{initial: "0.9 + {start}", velocity: "{speed}"}}
  "b[i in range(N)]": {{initial: "0.1*i", velocity: "cos(3*i)"}}
  "s[i in range(N)]": {{initial: 0, velocity: "3 + i"}}
bodies:
  "top[i in range(N)]":
    mass: "m[i]"
    inertia: [1, 1, 0.5]
    position: ["sin(a[i])*sin(b[i])", "-sin(a[i])*cos(b[i])", "cos(a[i])"]
    orientation: {{euler: ["b[i]", "a[i]", "s[i]"], sequence: zxz}}
potential: "sum(m[i]*g*cos(a[i]) for i in range(N))"
"""
ALONE = 'generalized_forces: {{"a[i in range(N)]": "{force}"}}\n'
POWER = 'dissipation: "{force}"\n'
CASES = {
    "a chain": (CHAIN, ALONE, "-F*sign(a_dot[i])"),
    "a chain by its dissipation": (CHAIN, POWER, "sum(F*abs(a_dot[i])*(1 + i) for i in range(N))"),
    "a chain with drag, and a limit by places": (
        CHAIN, ALONE, "-(F + c*a[i]**2)*sign(a_dot[i]) - c*a_dot[i]*abs(a_dot[i])",
    ),
    "a chain with less friction in motion": (CHAIN, ALONE, "-3*F*sign(a_dot[i])/(1 + c*abs(a_dot[i]))"),
    "motors": (CHAIN, ALONE, "-F*sign(a_dot[i] - w*(-1)**i)"),
    "some joints of a chain": (CHAIN, ALONE, "where(i % 2 == 0, -9*F*sign(a_dot[i]), 0)"),
    "a chain that is driven": (CHAIN, ALONE, "-F*sign(a_dot[i]) + where(t < 0.4, 7, -3)*sin(5*t)"),
    "detents of a chain": (CHAIN, ALONE, "-4*sign(a[i] - 0.1)"),
    "friction and detents": (CHAIN, ALONE, "-F*sign(a_dot[i]) - where(a[i] > 0.3, 5, 0)"),
    "a tree": (TREE, ALONE, "-F*sign(a_dot[i])"),
    "a chain in space": (SPACE, POWER, "sum(F*abs(a_dot[i]) + F*abs(b_dot[i])/2 for i in range(N))"),
    "a chain in space, about one axis": (SPACE, POWER, "sum(F*abs(b_dot[i]) for i in range(N))"),
    "a cart that rubs": (CART, POWER, "9*abs(x_dot) + sum(F*abs(a_dot[i]) for i in range(N))"),
    "tops": (TOPS, POWER, "sum(F*abs(s_dot[i])/5 + c*abs(a_dot[i]) for i in range(N))"),
}  # fmt: skip
MOVING = "0.3*sin(i)", "cos(i)"


def written(case: str, count: int, start: str = MOVING[0], speed: str = MOVING[1]) -> str:
    """The text of a system file."""
    form, key, force = CASES[case]
    return (HEAD + form + key).format(count=count, start=start, speed=speed, force=force)


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9, 17])
@pytest.mark.parametrize("case", CASES)
def test_joints_rub_as_written_out(case: str, count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(written(case, count), monkeypatch, stop=0.9)


@pytest.fixture(autouse=True)
def no_body_is_written_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bodies stay families, however few they are, where others do."""
    monkeypatch.setattr(systems, "FEWEST_TURNING", 0)


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("case", CASES)
def test_joints_may_begin_at_rest(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(written(case, 9, speed="0"), monkeypatch, stop=0.9)


@pytest.mark.exhaustive(keep=0.15)
@BY_RATES
@pytest.mark.parametrize("case", CASES)
def test_joints_in_steps_on_rates(case: str, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(written(case, 3), monkeypatch, stop=0.9, method=method)


@pytest.mark.exhaustive(keep=0.35)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize("case", CASES)
def test_ledgers_have_the_forces_that_hold_joints(
    case: str, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    ledgers_close(written(case, 9), monkeypatch, method)


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("case", ["a chain", "motors", "tops"])
def test_joints_backward_in_time(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    compare(written(case, 3), monkeypatch, LEDGERS, stop=-0.5, backward=True)


@pytest.mark.exhaustive(keep=0.35)
def test_links_that_friction_holds_do_not_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    """With all other links held, the first one is a pendulum with all masses at its end, which keeps its
    energy."""
    keep_families(monkeypatch, whole=True)
    force = "where(i == 0, 0, -1e6*sign(a_dot[i]))"
    text = (HEAD + CHAIN + ALONE).format(count=1000, start="1.1*cos(i)", speed="0", force=force)
    found = followed(ready(text), text, 2.0)
    alone = (HEAD + CHAIN).format(count=1, start="1.1*cos(i)", speed="0")
    expected = followed(ready(alone), alone, 2.0)
    assert np.allclose(found["q/a"][:, 0], expected["q/a"][:, 0], rtol=0.0, atol=1e-13)
    assert not found["v/a"][:, 1:].any()
    h = found["diagnostics/h"]
    assert np.all(np.abs(h - h[0]) <= 1e-13 * abs(h[0]))


@pytest.mark.exhaustive(keep=0.6)
@pytest.mark.parametrize("limit", [0.999, 1.001])
def test_a_joint_holds_what_hangs_from_it_up_to_its_limit(
    limit: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A level chain: joint i carries l g times the masses beyond. Where the first one lets go, all masses
    fall as it turns, by what its friction lacks."""
    keep_families(monkeypatch, whole=True)
    force = f"-where(i == 0, {limit}, 1.001)*g*l[i]*sum(m[j] for j in range(i, N))*sign(a_dot[i])"
    text = (HEAD + CHAIN + ALONE).format(count=9, start="pi/2", speed="0", force=force)
    found = followed(ready(text), text, 0.06)["v/a"]
    assert not found[:, 1:].any()
    expected = -9.8 * max(0.0, 1.0 - limit) * np.linspace(0.0, 0.06, 7)
    assert np.allclose(found[:, 0], expected, rtol=1e-5, atol=0.0)


@pytest.mark.exhaustive(keep=0.25)
def test_the_code_does_not_grow_with_the_joints(monkeypatch: pytest.MonkeyPatch) -> None:
    keep_families(monkeypatch, whole=True)
    counts = [len(ready(written("a chain", n)).machine.program.text.splitlines()) for n in (72, 200)]
    assert counts[0] == counts[1]
