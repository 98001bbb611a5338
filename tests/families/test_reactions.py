"""Forces of constraint in loops on components of places that no coordinate moves: R = -F there."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.errors import NotDefined
from lagrange_cli.families import consistency
from lagrange_cli.families import system as systems
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.records import replace
from lagrange_cli.run.derive import derive_system
from tests.families.test_closed_chains import CHAIN as CLOSED
from tests.families.test_closed_chains import PINNED, exactly_followed
from tests.support.families import begun, followed
from tests.support.motion import Motion, run

BEADS = """
sizes: {{N: {count}}}
parameters: {{m: 0.3, g: 2.0, k: 1.5}}
coordinates:
  x[i in range(N)]: {{initial: "i", velocity: 0.3}}
  z: {{initial: 0.5}}
masses: {{"bead[i in range(N)]": m}}
positions: {{"bead[i in range(N - 1)]": {place}, "bead[N - 1]": ["x[N - 1]", 1, z]}}
{more}
potential: "{potential}"
constraints:
  rod[i in range(N - 1)]: "x[i + 1] - x[i] - 1"
"""
ROD = '["x[i]", 1, "2 + i/9"]'
CASES = {
    "weight": (ROD, "sum(m*g*bead[i].z for i in range(N))", ""),
    "springs": (ROD, "sum(k*(norm(bead[i + 1] - bead[i]) - 0.4)**2/2 for i in range(N - 1))", ""),
    "a mean": (ROD, "k*(sum(bead[i].z*bead[i].y for i in range(N)) + 1)**2", ""),
    "a force": (ROD, "0", 'forces: {"bead[i in range(N)]": ["0.1*x[i]", "sin(t)", "-0.1*bead[i].vx"]}'),
    "friction": (ROD, "0", 'dissipation: "sum((bead[i].vx + bead[i].vz - i)**2/2 for i in range(N))"'),
    "coordinates": (ROD, "sum(k*x[i]**2/2 for i in range(N))", ""),
}  # fmt: skip
OUTPUTS = frozenset(["q", "reactions"])


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("case", CASES)
def test_what_rests_feels_what_acts_on_it(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    place, potential, more = CASES[case]
    text = BEADS.format(count=9, place=place, potential=potential, more=more)
    found = []
    for few in (0, 10**9):
        monkeypatch.setattr(systems, "FEWEST_BOUND", few)
        ready, motion = followed(text, OUTPUTS)
        assert ready.machine.program.loops == (few == 0)
        found.append(motion.data["reactions/bead"])
    assert np.max(np.abs(found[0] - found[1])) < 1e-12
    if case == "weight":
        assert np.allclose(found[0][:, :-1], [0.0, 0.0, 0.6], atol=1e-14) and np.all(found[0][:, -1] == 0.0)


CHAIN = """
sizes: {{N: {count}}}
parameters: {{l: 1/N, m: 1/N, g: 9.81}}
coordinates:
  a[i in range(N)]: {{initial: {angle}}}
definitions:
  x[0]: l*sin(a[0]){shift}
  x[i in range(1, N)]: x[{parent}] + l*sin(a[i])
  y[0]: -l*cos(a[0])
  y[i in range(1, N)]: y[{parent}] - l*cos(a[i])
masses: {{"b[i in range(N)]": m*(1 + i/N)}}
positions: {{"b[i in range(N)]": ["x[i]", "y[i]"]}}
potential: sum(g*m*(1 + i/N)*b[i].y for i in range(N))
{more}
"""
BODIES = """
sizes: {{N: {count}}}
coordinates:
  a[i in range(N)]: {{initial: 0.3*i, velocity: 1}}
  b[i in range(N)]: {{initial: 0.8, velocity: 0.5}}
  c[i in range(N)]: {{initial: 0.2, velocity: 3}}
bodies:
  body[i in range(N)]:
    mass: 1 + i/9
    inertia: [0.02, 0.02, 0.03]
    position: ["0.4*sin(b[i])*sin(a[i])", "-0.4*sin(b[i])*cos(a[i])", "0.4*cos(b[i])"]
    orientation: {{euler: ["a[i]", "b[i]", "c[i]"], sequence: zxz}}
{more}
"""
SPRINGS = "potential: sum(norm(body[i + 1].at(0, 0.1, 0.1) - body[i].at(0, 0, 0.3))**2 for i in range(N - 1))"
ON_PARTICLES = (
    'forces: {"b[i in range(N)]": ["0.1*b[i].vy", "sin(t)"]}\n'
    'dissipation: "sum(b[i].vx**2/9 for i in range(N))"'
)
STOPS = 'forces: {"b[i in range(N)]": ["9*max(0, 0.4 - b[i].x)", "t/9 - 0.1*b[i].vx"]}'
KINKS = (
    'generalized_forces: {"a[i in range(N)]": "where(t < 0.15, 0.1, 0) - 0.01*a_dot[i]*abs(a_dot[i])"}\n'
    + STOPS
)
BENT = {"angle": "0.5 + i/9", "shift": "", "parent": "i - 1", "more": ""}
MOVED = {
    "a chain": (CHAIN, BENT),
    "a tree on a moving support": (CHAIN, {**BENT, "shift": " + 0.1*sin(t)", "parent": "(i - 1)//2"}),
    "forces": (CHAIN, {**BENT, "more": ON_PARTICLES}),
    "kinks": (CHAIN, {**BENT, "more": STOPS}),
    "bodies": (BODIES, {"more": SPRINGS}),
}


def moved(text: str, method: str = "taylor") -> tuple[Prepared, Motion]:
    """A short motion of a system, and what it was followed by."""
    spec, values = begun(text)
    ready = prepare_system(spec, derive_system, None, Compilation(method, 2.0**-52, OUTPUTS))
    return ready, run(ready, values, 0.0, 0.2, 3)


@pytest.mark.exhaustive(keep=0.2, most=4)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
@pytest.mark.parametrize("count", [1, 2, 3, 8, 9])
@pytest.mark.parametrize("case", MOVED)
def test_of_chains_and_bodies(case: str, count: int, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    (written, given), found = MOVED[case], []
    text = written.format(count=count, **given)
    for few in (0, 10**9):
        for name in ("FEWEST", "FEWEST_JOINTED", "FEWEST_TURNING"):
            monkeypatch.setattr(systems, name, few)
        ready, motion = moved(text, method)
        assert ready.machine.program.loops == (few == 0) or count == 1  # one member may be no tree
        found.append(motion.data["reactions/" + ("body" if case == "bodies" else "b")])
    size = np.max(np.abs(found[1]), initial=1.0)
    assert np.max(np.abs(found[0] - found[1])) < 2.0**-40 * size


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("case", MOVED)
def test_in_double_double(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    (written, given), found = MOVED[case], []
    for few in (0, 10**9):
        for module, name in (
            (systems, "FEWEST_JOINTED"),
            (systems, "FEWEST_TURNING"),
            (consistency, "FEWEST"),
        ):
            monkeypatch.setattr(module, name, few)
        ready, motion = exactly_followed(written.format(count=5, **given), OUTPUTS)
        assert ready.machine.program.loops == (few == 0)
        (path,) = (one for one in motion.data if one.startswith("reactions"))
        found.append((motion.data[path], motion.data[f"low/{path}"]))
    (one, low), (other, lower) = found
    assert np.max(np.abs((one - other) + (low - lower))) < 2.0**-94 * np.max(np.abs(one), initial=1.0)


def test_a_chain_at_rest_carries_the_weight_below() -> None:
    """R of each bob is its own weight: the tension above, less the one below."""
    hanging = CHAIN.format(count=20, angle=0, shift="", parent="i - 1", more="")
    ready, motion = moved(hanging)
    assert ready.machine.program.loops
    tension = np.cumsum(motion.data["reactions/b"][:, ::-1, 1], axis=1)[:, ::-1]
    weights = 9.81 / 20 * (1 + np.arange(20) / 20)
    assert np.max(np.abs(tension - np.cumsum(weights[::-1])[::-1])) < 1e-12


def test_what_is_not_known_is_said() -> None:
    text = CHAIN.format(count=20, angle=0, shift="", parent="i - 1", more="").replace("*b[i].y", "*y[i]")
    with pytest.raises(NotDefined, match="the forces on 'b' are not known, since U contains the coordinate"):
        moved(text)


PUSHED = BEADS.replace("velocity: 0.3", "velocity: 0.1").format(
    count=9, place=ROD, potential="sum(k*max(0, x[i] - 3)**2 for i in range(N))",
    more=CASES["a force"][2].replace('"0.1*x[i]"', '"sin(3*t) - i/9*x_dot[i]*abs(x_dot[i])"'),
)  # fmt: skip
ANY_WAY = {
    "places": (PUSHED, {"multipliers", "reactions"}),
    "a closed chain": (
        CLOSED.format(count=14, begin="", speed="", more=KINKS, constraints=PINNED),
        {"multipliers"},
    ),
    "an open chain": (CHAIN.format(count=12, **{**BENT, "more": STOPS}), {"reactions"}),
}


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("case", ANY_WAY)
def test_forces_of_constraint_follow_from_the_state_alone(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also beside kinks, by whichever side the last one led to, and backward in time, where drag is drag."""
    text, asked = ANY_WAY[case]
    monkeypatch.setattr(systems, "FEWEST_BOUND", 0)
    spec, values = begun(text)
    found = []
    for times in ((0.0, 0.4), (0.4, 0.0)):
        compilation = Compilation("taylor", 2.0**-52, frozenset({"q", "v", *asked}), backward=times[0] > 0.0)
        ready = prepare_system(spec, derive_system, None, compilation)
        assert ready.machine.program.loops
        motion = run(ready, values, *times, 9)
        q, v = (
            np.concatenate([np.ravel(one[-1]) for path, one in motion.data.items() if path.startswith(part)])
            for part in ("q/", "v/")
        )
        values = replace(values, q=tuple(q), v=tuple(v))
        found.append(motion.data)
    forward, backward = found
    for path, one in forward.items():
        size = np.max(np.abs(one), initial=1.0)
        assert np.max(np.abs(backward[path][::-1] - one)) <= 2.0**-40 * size, path
