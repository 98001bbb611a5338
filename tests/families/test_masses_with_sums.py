"""Masses that contain sums over members, and positions that do, beside the same systems written out and
equations derived by hand."""

from __future__ import annotations

import random

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from lagrange_cli.families import system as systems
from lagrange_cli.spec.read import read_spec
from tests.families.test_curved_masses import in_loops, moves_exactly_alike
from tests.support.families import alike, followed

OUTPUTS = frozenset(["q", "v", "p", "h", "action", "ledger"])
METHODS = {"taylor": 2.0**-52, "ias15": 2.0**-52, "DOP853": 1e-12, "Radau": 1e-10}
SUMS = [
    "sum(a[i]**2 for i in range(N))/N",
    "sum(cos(a[i] - b[i]) for i in range(N))/N",
    "sum(a[i]*b[(i + 1) % N] for i in range(N))/N",
    "sum(sin(a[i])*sin(a[j]) for i in range(N) for j in range(i))/N",
    "sum(sum(b[j] for j in range(i))**2 for i in range(0, N, 2))/N**2",
]
OWN = ["1 + S**2", "2 + sin(S)", "1.5 + cos(a[i] - S)/2", "1 + near[i]**2", "2 + S*a[i]/9", "1 + i/9"]
OTHER = ["0", "S/9", "near[i]/5", "cos(S)/4", "1/5"]
TOGETHER = [
    "",
    "+ (2 + S)**2*X_dot**2/2",
    "+ (1 + T**2)*sum(a_dot[i]**2 for i in range(N))/4",
    "+ sum(b_dot[i] for i in range(N))**2*(1 + a[0]**2)/2",
]
FORCES = {
    "nothing": "",
    "pushes": "generalized_forces: {'a[i in range(N)]': 0.3*sin(2*t + i)*S}",
    "drag": "dissipation: sum(a_dot[i]**2/20*(1 + S**2) for i in range(N))",
}
POSITIONS = {
    "centred": "{'p[i in range(N)]': ['a[i] - S', 'b[i]'], 'o[i in range(N)]': ['a[i]', '0']}",
    "turned": (
        "{'p[i in range(N)]': ['(2 + a[i] - S)*cos(X)', '(2 + a[i] - S)*sin(X)'],"
        " 'o[i in range(N)]': ['b[i]', 'a[i]/2']}"
    ),
    "bent": "{'p[i in range(N)]': ['a[i] + S**2/9', 'b[i]*cos(S)'], 'o[i in range(N)]': ['b[i]', 'a[i]']}",
}


def starts() -> str:
    return """
coordinates:
  a[i in range(N)]: {initial: 0.3*cos(i), velocity: 0.4*sin(1 + i)}
  b[i in range(N)]: {initial: 0.3*cos(1 + i), velocity: 0.4*sin(1 + 2*i)}
  X: {initial: 0.2, velocity: 0.7}
"""


def drawn(chance: random.Random) -> str:
    """The text of a random system, whose L is given."""
    own, other, together = chance.choice(OWN), chance.choice(OTHER), chance.choice(TOGETHER)
    return f"""
sizes: {{N: {chance.choice([1, 2, 3, 8, 9])}}}
{starts()}
definitions:
  S: {chance.choice(SUMS)}
  T: {chance.choice(SUMS)}
  near[i in range(N)]: sum(b[j]*cos(a[i]) for j in range(N) if abs(i - j) < 3)/3
lagrangian: >-
  sum(({own})*a_dot[i]**2/2 + (1.5 + S**2)*b_dot[i]**2/2 + ({other})*a_dot[i]*b_dot[i] for i in range(N))
  + 2*X_dot**2 {together}
  - sum(a[i]**2 + b[i]**4/4 - S*a[i]/9 for i in range(N)) - X**2
{FORCES[chance.choice(sorted(FORCES))]}
"""


def placed(chance: random.Random, place: str = "") -> str:
    """The text of a system whose positions contain sums."""
    place = place or chance.choice(sorted(POSITIONS))
    return f"""
sizes: {{N: {chance.choice([1, 2, 3, 8])}}}
{starts()}
definitions: {{S: {chance.choice(SUMS[:3])}}}
masses: {{"p[i in range(N)]": 1 + i/9, "o[i in range(N)]": 2, cart: 3}}
embedding: {POSITIONS[place][:-1]}, cart: [X, 0]}}
potential: sum(a[i]**2 + b[i]**2 for i in range(N)) + X**2
"""


def both(text: str, method: str, stop: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Members in loops move as those written out, in about as many steps."""
    motions = []
    for loops in True, False:
        in_loops(monkeypatch, loops=loops)
        ready, motion = followed(text, OUTPUTS, stop=stop, method=method, tolerance=METHODS[method])
        assert ready.machine.program.loops == loops, text
        motions.append(motion)
    found, expected = motions
    alike(found.data, expected.data, 2.0**-40 if method in ("taylor", "ias15") else 1e-8, text, method)
    steps, usual = found.outcome.steps, expected.outcome.steps
    assert steps <= 6 + 1.1 * usual, text  # integrands that begin at 0 may divide the first ones of ``ias15``


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("case", range(40))
def test_motions_are_those_of_the_members(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} sums {case}")
    text = drawn(chance) if case % 3 else placed(chance)
    both(text, chance.choice([*METHODS]), 0.5, monkeypatch)


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("place", POSITIONS)
def test_positions_may_contain_sums(
    place: str, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    both(placed(random.Random(f"{pytestconfig.option.seed} {place}"), place), "taylor", 0.5, monkeypatch)


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("case", range(12))
def test_motions_backward_in_time(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} backward {case}")
    text = drawn(chance) if case % 3 else placed(chance)
    both(text, "taylor", -0.5, monkeypatch)


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("case", range(8))
def test_motions_in_double_double(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} exact {case}")
    moves_exactly_alike(drawn(chance) if case % 2 else placed(chance), monkeypatch)


ARM = """
sizes: {{N: {count}}}
coordinates:
  phi: {{initial: 0.1, velocity: 1}}
  r[i in range(N)]: {{initial: 0.5 + i/10, velocity: 0.1*sin(i)}}
lagrangian: >-
  (3 + sum(r[i]**2 for i in range(N)))*phi_dot**2/2 + sum(r_dot[i]**2/2 - 5*(r[i] - 0.5)**2 for i in range(N))
{more}
"""


@pytest.mark.parametrize("count", [60, 1000])
def test_beads_on_an_arm_move_as_derived_by_hand(count: int) -> None:
    """With I = 3 + sum r^2: I phi'' = -2 phi' sum r r', r'' = r phi'^2 - 10 (r - 1/2)."""
    _, found = followed(ARM.format(count=count, more=""), frozenset(["q", "v", "p", "h"]), stop=1.0)

    def rates(_: float, state: NDArray[np.float64]) -> NDArray[np.float64]:
        r, w, v = state[1 : count + 1], state[count + 1], state[count + 2 :]
        turning = -2 * w * np.dot(r, v) / (3 + np.dot(r, r))
        return np.concatenate([state[count + 1 :], [turning], r * w**2 - 10 * (r - 0.5)])

    i = np.arange(count)
    start = np.concatenate([[0.1], 0.5 + i / 10, [1.0], 0.1 * np.sin(i)])
    known = solve_ivp(rates, (0.0, 1.0), start, method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    np.testing.assert_allclose(found["q/phi"][-1], known[0], rtol=1e-11)
    np.testing.assert_allclose(found["q/r"][-1], known[1 : count + 1], rtol=1e-10)
    assert np.ptp(found["diagnostics/p/phi"]) <= 2.0**-44 * abs(found["diagnostics/p/phi"][0])


@pytest.mark.parametrize("beside", ["", "+ sum(a[i]**2*b_dot[i]**2 for i in range(N))"])
@pytest.mark.parametrize("written", ["W*X_dot**2/2", "sum(w[i]*X_dot**2/2 for i in range(N))", "particle"])
def test_masses_may_be_sums_of_constants(written: str, beside: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """An oscillator with W = 1 + 2 + ... + 9 and X = 0.2 cos(wt) + 0.7/w sin(wt), w^2 = 2/W."""
    in_loops(monkeypatch, loops=True)
    kinetic = f"lagrangian: {written} + sum(a_dot[i]**2 + b_dot[i]**2 for i in range(N)) {beside} -"
    if written == "particle":
        if beside:
            return
        kinetic = """
masses: {cart: W, "p[i in range(N)]": 1}
positions: {cart: [X, 0], "p[i in range(N)]": ["a[i]", "b[i]"]}
potential:"""
    text = f"""
sizes: {{N: 9}}
parameters: {{"w[i in range(N)]": 1 + i}}
{starts()}
definitions: {{W: sum(w[i] for i in range(N))}}
{kinetic} (X**2 + sum(a[i]**2 for i in range(N)))
"""
    ready, found = followed(text, frozenset(["q"]), stop=2.0)
    assert ready.machine.program.loops
    w, t = np.sqrt(2 / 45), found["t"]
    np.testing.assert_allclose(found["q/X"], 0.2 * np.cos(w * t) + 0.7 / w * np.sin(w * t), rtol=1e-14)


def test_constraints_and_events_beside_sums_in_masses(monkeypatch: pytest.MonkeyPatch) -> None:
    more = """
constraints: {"tie[i in range(1, N, 2)]": "r[i]**2 - r[i - 1]**2 - (0.5 + i/10)**2 + (0.4 + i/10)**2"}
events: {"out[i in range(N)]": {when: "r[i] - 0.55 - i/10"}}
"""
    text = ARM.format(count=9, more=more).replace(", velocity: 0.1*sin(i)", "")
    both(text, "taylor", 0.7, monkeypatch)


def test_the_code_does_not_grow_with_the_sums() -> None:
    lines = []
    for count in 60, 600:
        ready, _ = followed(ARM.format(count=count, more=""), frozenset(["q"]), stop=0.1, samples=2)
        lines.append(len(ready.machine.program.text.splitlines()))
    assert lines[0] == lines[1]


@pytest.mark.parametrize(
    "mass",
    ["1 + max(0, S)**3", "1 + sum(max(0, a[i])**3 for i in range(N))", "1 + sum(a_dot[i] for i in range(N))"],
)
def test_other_masses_are_written_out(mass: str, monkeypatch: pytest.MonkeyPatch) -> None:
    in_loops(monkeypatch, loops=True)
    text = f"""
sizes: {{N: 3}}
{starts()}
definitions: {{S: sum(a[i] for i in range(N))}}
lagrangian: >-
  sum(a_dot[i]**2 + b_dot[i]**2 for i in range(N)) + ({mass})*X_dot**2
  - sum(a[i]**2 for i in range(N))
"""
    assert systems.family_system(read_spec(text, "system.yaml")) is None
