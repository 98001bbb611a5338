"""Systems whose M depends on coordinates and on t, beside the same systems written out member by member."""

from __future__ import annotations

import random

import numpy as np
import pytest

from lagrange_cli.families import system as systems
from lagrange_cli.families.conserved.conservation import constants_of
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.mechanics.conserved.symmetries import symmetries
from lagrange_cli.native.families.coupling import of_families
from lagrange_cli.run.derive import derive_system
from lagrange_cli.spec.read import read_spec
from tests.families.test_closed_chains import exactly_followed
from tests.support.families import alike, followed
from tests.support.motion import Motion

SIZES = 1, 2, 3, 8, 9, 17
NAMES = "abcd"
DRAWS = 50
"""So many systems are drawn at most until M is no constant."""
OUTPUTS = frozenset(
    ["q", "v", "p", "h", "action", "ledger", "constraints", "multipliers", "energy", "conserved"]
)
OWN = ["1", "1.2 + i/9", "2 + sin({x}[i])", "1 + {x}[i]**2/9", "1.4 + {y}[i]/5", "1.5 + cos({x}[i] - {y}[i])"]
OTHER = ["0", "1/3", "cos({x}[i] - {y}[i])/3", "{x}[i]*{y}[i]/7", "k*sin({y}[i])/9", "{x}[i]*sin({y}[i])/4"]
TIMED = "1 + cos(t + i)/5"
POTENTIALS = ["{x}[i]**2", "k*(1 - cos({x}[i]))", "{x}[i]**4/4 + {x}[i]*{y}[i]/5", "sin({x}[i] + 2*{y}[i])/2"]
BESIDE = {
    "nothing": "",
    "springs": "- sum(k*(a[i + 1] - a[i])**2/8 for i in range(N - 1))",
    "masses": "+ sum(cos(a[i + 1] - a[i])*a_dot[i]*a_dot[i + 1]/9 for i in range(N - 1))",
    "a field": "+ sum({z}[i]*a_dot[i]/3 + a[i]**2*{z}_dot[i]/9 for i in range(N))",
    "kinks": "- sum(max(a[i] - 0.3, 0)**3 for i in range(N))",
}
FORCES = {
    "nothing": "",
    "pushes": "generalized_forces: {'a[i in range(N)]': 0.3*sin(2*t + i)}",
    "drag": "dissipation: sum(a_dot[i]**2/20 + a[i]**2*a_dot[i]**2/30 for i in range(N))",
}
BONDS = {
    "nothing": "",
    "edges": "nonholonomic: {'edge[i in range(N)]': 'cos(a[i])*b_dot[i] - (1 + b[i]**2)*a_dot[i]/3'}",
    "rods": (
        "constraints: {'rod[i in range(0, N, 2)]': "
        "'sin(a[i]) + a[i]*b[i] - sin(0.3*cos(i)) - 0.09*cos(i)*cos(1 + i)'}"
    ),
    "a drive": "constraints: {drive: 'b[0] - 0.3*cos(1) - t**2/5'}",
}


def starts(count: int, *, bound: bool) -> str:
    """The coordinates at the start, without velocities that constraints determine."""
    return "\n".join(
        f"  {x}[i in range(N)]: {{initial: 0.3*cos({n} + i), velocity: 0.4*sin(1 + {n}*i)}}"
        if not bound or n != 1
        else f"  {x}[i in range(N)]: {{initial: 0.3*cos(1 + i)}}"
        for n, x in enumerate(NAMES[:count])
    )


def kinetic(chance: random.Random, count: int, *, timed: bool) -> str:
    """T of a member with so many coordinates: half the squares of forms L^T v with a regular L."""
    squares = []
    for n, x in enumerate(NAMES[:count]):
        forms = []
        for y in NAMES[n:count]:
            of = OWN if x == y else OTHER
            if x == y and timed and chance.random() < 0.3:
                of = [TIMED]
            z = chance.choice(NAMES[:count])
            factor = chance.choice(of).format(x=y, y=z)
            forms.append(f"({factor})*{y}_dot[i]")
        squares.append(f"({' + '.join(forms)})**2/2")
    return " + ".join(squares)


def drawn(chance: random.Random) -> str:
    """The text of a random system, whose L is given."""
    count = chance.randint(1, len(NAMES))
    size = chance.choice(SIZES if count < 3 else SIZES[:-1])  # code for more members is too long
    last = NAMES[count - 1]
    potential = " + ".join(
        chance.choice(POTENTIALS).format(x=x, y=chance.choice(NAMES[:count])) for x in NAMES[:count]
    )
    beside = BESIDE[chance.choice(sorted(BESIDE))].format(z=last)
    bonds = BONDS[chance.choice(sorted(BONDS))] if count > 1 and chance.random() < 0.5 else ""
    timed = chance.random() < 0.2
    return f"""
sizes: {{N: {size}}}
parameters: {{k: 1.5}}
coordinates:
{starts(count, bound=bool(bonds))}
lagrangian: >-
  sum({kinetic(chance, count, timed=timed)} for i in range(N))
  - sum({potential} for i in range(N)) {beside}
{FORCES[chance.choice(sorted(FORCES))]}
{bonds}
"""


def in_loops(monkeypatch: pytest.MonkeyPatch, *, loops: bool) -> None:
    """Members are followed in loops however few, or never."""
    for least in ("FEWEST", "FEWEST_CURVED", "FEWEST_SWITCHED", "FEWEST_BOUND", "FEWEST_NONHOLONOMIC"):
        monkeypatch.setattr(systems, least, 0 if loops else 10**9)
    monkeypatch.setattr(systems, "_LATEST", [])


def both_ways(text: str, method: str, stop: float, monkeypatch: pytest.MonkeyPatch) -> tuple[Motion, Motion]:
    """The motions of members in loops, and written out."""
    motions = []
    for loops in True, False:
        in_loops(monkeypatch, loops=loops)
        ready, motion = followed(text, frozenset(["q", "v", "p", "h"]), stop=stop, method=method)
        assert ready.machine.program.loops == loops
        motions.append(motion)
    return motions[0], motions[1]


def is_curved(text: str) -> bool:
    """Whether M of a drawn system is no constant."""
    system = systems.family_system(read_spec(text, "system.yaml"))
    assert system is not None, text
    return system.curved


def curved(text: str) -> FamilySystem:
    """A system that is one of families, whose M is no constant."""
    system = systems.family_system(read_spec(text, "system.yaml"))
    assert system is not None and system.curved, text
    return system


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("case", range(80))
def test_motions_are_those_of_the_members(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    chance = random.Random(f"{pytestconfig.option.seed} curved {case}")
    in_loops(monkeypatch, loops=True)
    text = next(text for text in (drawn(chance) for _ in range(DRAWS)) if is_curved(text))
    method = chance.choice(["taylor", "taylor", "ias15", "DOP853", "Radau"])
    tolerance = 1e-10 if method == "Radau" else 2.0**-52
    kinked = "max(" in text and "constraints: {" in text.replace("nonholonomic", "constraints")
    outputs = OUTPUTS - {"ledger"} if kinked else OUTPUTS  # members are written out for it
    together, found = followed(text, outputs, method=method, tolerance=tolerance)
    assert together.machine.program.loops, text
    in_loops(monkeypatch, loops=False)
    apart, expected = followed(text, outputs, method=method, tolerance=tolerance)
    assert not apart.machine.program.loops
    shared = {path: values for path, values in expected.data.items() if path in found.data}
    assert {"q/a", "v/a", "diagnostics/h"} <= shared.keys()
    alike(found.data, shared, 2.0**-40 if method in ("taylor", "ias15") else 1e-8, text, method)
    if method != "ias15":  # where rounding errors of integrals count
        assert abs(found.outcome.steps - expected.outcome.steps) <= 2 + 0.1 * expected.outcome.steps, text


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("case", range(12))
def test_motions_backward_in_time(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = drawn(random.Random(f"{pytestconfig.option.seed} backward {case}"))
    text = text.replace("cos(t + i)/5", "cos(i)/5").replace("a drive", "")
    if "drive" in text or "nonholonomic" in text:
        text = "\n".join(line for line in text.splitlines() if "drive" not in line and "edge" not in line)
    motions = []
    for loops in True, False:
        in_loops(monkeypatch, loops=loops)
        ready, motion = followed(text, frozenset(["q", "v", "p", "h"]), stop=-0.5)
        assert ready.machine.program.loops == loops, text
        motions.append(motion.data)
    alike(*motions, 2.0**-40, text)


def moves_exactly_alike(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Members move in loops as written out, in double-double."""
    motions = []
    for loops in True, False:
        in_loops(monkeypatch, loops=loops)
        ready, motion = exactly_followed(text, frozenset(["q", "v", "h"]))
        assert ready.machine.program.loops == loops, text
        motions.append(motion.data)
    alike(*motions, 2.0**-90, text)


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("case", range(8))
def test_motions_in_double_double(
    case: int, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    moves_exactly_alike(drawn(random.Random(f"{pytestconfig.option.seed} exact {case}")), monkeypatch)


BEADS = """
sizes: {{N: {count}}}
coordinates:
  a[i in range(N)]: {{initial: 0.7, velocity: 0.2}}
  b[i in range(N)]: {{initial: 0.4, velocity: -0.5}}
lagrangian: >-
  sum((1 + a[i]**2)*a_dot[i]**2/2 + cos(a[i] - b[i])*a_dot[i]*b_dot[i]/2 + b_dot[i]**2 for i in range(N))
  - sum(a[i]**2 + sin(a[i])*cos(b[i]) for i in range(N))
"""


@pytest.mark.parametrize("method", ["taylor", "DOP853"])
def test_members_alike_take_the_steps_of_one(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """And each moves as it does alone."""
    in_loops(monkeypatch, loops=False)
    _, alone = followed(BEADS.format(count=1), frozenset(["q"]), stop=3.0, method=method)
    monkeypatch.undo()
    ready, motion = followed(BEADS.format(count=61), frozenset(["q"]), stop=3.0, method=method)
    assert ready.machine.program.loops
    assert abs(motion.outcome.steps - alone.outcome.steps) <= 1 + 0.05 * alone.outcome.steps
    bound = 1e-14 if method == "taylor" else 1e-9
    assert np.max(np.abs(motion["q/a"] - alone["q/a"])) < bound


def test_matrices_of_implicit_steps_consist_of_the_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    in_loops(monkeypatch, loops=True)
    system = curved(BEADS.format(count=30))
    found = of_families(system)
    assert not found.band.full and found.band.length < 5 * 60


WITHOUT_SQUARES = """
sizes: {N: 25}
coordinates:
  a[i in range(N)]: {initial: 0.2, velocity: 0.5}
  b[i in range(N)]: {initial: i/30, velocity: 0.3}
lagrangian: sum((1 + a[i]**2)*a_dot[i]*b_dot[i] - a[i]*b[i] for i in range(N))
"""
SWINGING = """
sizes: {N: 25}
coordinates:
  a[i in range(N)]: {initial: 1.0, velocity: 0.5}
  b[i in range(N)]: {initial: 1.0, velocity: 0.3}
lagrangian: sum((a[i] - 1)*(a_dot[i]**2 + b_dot[i]**2)/2 + a_dot[i]*b_dot[i] for i in range(N))
"""


def test_masses_without_squares_are_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    """In blocks with pivots elsewhere than on the diagonal."""
    found, expected = both_ways(WITHOUT_SQUARES, "taylor", 0.5, monkeypatch)
    alike(found.data, expected.data, 2.0**-44)


@pytest.mark.parametrize("method", ["taylor", "DOP853"])
def test_pivots_are_chosen_where_masses_may_be_negative(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """At the start M is regular, but 0 on its diagonal. h is conserved, and so is p_b."""
    system = curved(SWINGING)
    assert system.saddle is not None and system.saddle.pivoting
    found, expected = both_ways(SWINGING, method, 0.5, monkeypatch)
    alike(found.data, expected.data, 2.0**-42 if method == "taylor" else 1e-8)
    assert np.ptp(found["diagnostics/p/b"], axis=0).max() < (1e-14 if method == "taylor" else 1e-9)


@pytest.mark.parametrize("method", ["taylor", "ias15"])
def test_energies_that_are_too_long_to_be_multiplied_out(
    method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Masses have the derivatives of places as factors."""
    waves = " + ".join(f"sin({n}*a[i] + b[i])/{n**2}" for n in range(1, 24))
    text = f"""
sizes: {{N: 5}}
coordinates:
  a[i in range(N)]: {{initial: i/20, velocity: 0.5}}
  b[i in range(N)]: {{initial: 1, velocity: 0.3*cos(i)}}
masses: {{'bead[i in range(N)]': 1.5}}
embedding: {{'bead[i in range(N)]': ['3*a[i] + {waves}', 'b[i] + sin(a[i])/3']}}
potential: sum(a[i]**2 + bead[i].x*bead[i].y for i in range(N))
"""
    found, expected = both_ways(text, method, 0.5, monkeypatch)
    alike(found.data, expected.data, 2.0**-42)


def test_masses_that_are_singular_end_the_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    """As on the axis of polar coordinates."""
    text = """
sizes: {N: 60}
coordinates:
  a[i in range(N)]: {initial: i/200, velocity: 0.5}
  b[i in range(N)]: {initial: 1, velocity: 0.3}
lagrangian: sum(a_dot[i]**2/2 + sin(a[i])**2*b_dot[i]**2/2 + cos(a[i]) for i in range(N))
"""
    for method in "taylor", "DOP853":
        ready, motion = followed(text, frozenset(["q"]), method=method)
        assert ready.machine.program.loops and motion.outcome.ending is Ending.SINGULAR_MASS_MATRIX


KEPT = {
    "tops": "a_dot[i]**2 + sin(a[i])**2*b_dot[i]**2 + (c_dot[i] + b_dot[i]*cos(a[i]))**2/3 - cos(a[i])",
    "apart": "(2 + sin(a[i]))*a_dot[i]**2 + b_dot[i]**2*(1 + c[i]**2) + c_dot[i]**2 - a[i]**2 - b[i]*c[i]",
    "driven": "(2 + sin(a[i]))*a_dot[i]**2 + b_dot[i]**2*(1 + t**2) + c_dot[i]**2 - a[i]**2 - b[i]**4",
    "shifted": "a_dot[i]**2*(2 + sin(a[i] - a[0])) + b_dot[i]**2 + c_dot[i]**2 + b_dot[i]*cos(a[i] - a[0])",
}


@pytest.mark.parametrize("kind", KEPT)
def test_what_is_conserved_is_what_members_conserve(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Momenta, h, and the energies of parts, with the same sentences; values do not change."""
    text = f"""
sizes: {{N: 4}}
coordinates:
  a[i in range(N)]: {{initial: 0.5 + i/9, velocity: 0.2}}
  b[i in range(N)]: {{initial: 0.4, velocity: 1}}
  c[i in range(N)]: {{initial: 0.3, velocity: -0.4*i}}
lagrangian: sum({KEPT[kind]} for i in range(N))
"""
    in_loops(monkeypatch, loops=True)
    constants = constants_of(curved(text))
    found = {one.quantity: one for one in constants.conserved}
    residual = derive_system(read_spec(text, "system.yaml"))
    others = [one.conserved for one in symmetries(residual.model, residual.conserved)]
    expected = {one.quantity: one for one in (*residual.conserved, *others)}
    assert constants.cyclic == residual.cyclic
    names = {name for name in expected if name[:2] in ("p_", "h_") or name == "h"}
    assert found.keys() - {"P_a"} == names and ("P_a" in found) == (kind == "shifted")
    assert all(one == expected[name] for name, one in found.items() if name in names)
    ready, motion = followed(text, frozenset(["q", "conserved"]))
    assert ready.machine.program.loops
    for path, values in motion.data.items():
        if "conserved" in path:
            assert np.ptp(values) < 1e-13, path


EVENTS = {
    "records": "'e[i in range(N)]': {when: 'a[i] - 0.6'}",
    "a mirror": "'e[i in range(N)]': {when: 'a[i] - 0.71', action: {set: {'a_dot[i]': '-a_dot[i]'}}}",
    "jumps": "'e[i in range(N)]': {when: 'b[i] - 0.3', action: {set: {'a[i]': 'a[i]/2', 'b[i]': 0.5}}}",
}


@pytest.mark.parametrize("kind", EVENTS)
@pytest.mark.parametrize("method", ["taylor", "DOP853"])
def test_events_are_those_of_the_members(kind: str, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (
        BEADS.format(count=9).replace("0.4, velocity", "0.4 + i/50, velocity") + f"events: {{{EVENTS[kind]}}}"
    )
    found, expected = both_ways(text, method, 1.5, monkeypatch)
    assert any("events" in path and values.size for path, values in expected.data.items())
    alike(found.data, expected.data, 2.0**-38 if method == "taylor" else 1e-8)
