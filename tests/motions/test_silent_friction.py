"""Systems whose friction is 0 for a time, or from the start, move as those without it, in as many steps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import lagrange_cli as lagrange
from lagrange_cli.api import kept
from tests.families.test_events import keep_families
from tests.motions.test_vanishing_friction import CHAIN, TOLERANCES, damped, pushed_chain
from tests.support.draws import examples

ERRORS = {"taylor": 1e-12, "ias15": 1e-12, "DOP853": 1e-9, "Radau": 1e-7}
BY = pytest.mark.parametrize("method", TOLERANCES)
ON_A_LINE = """
sizes: {{N: {count}}}
parameters: {{k: 30, F: 0}}
coordinates: {{"x[i in range(N)]": {{initial: 0}}}}
masses: {{"block[i in range(N)]": 1 + i/10}}
positions: {{"block[i in range(N)]": "x[i]"}}
potential: sum(k*(x[i] - x[i - 1])**2/2 for i in range(1, N)) + k*x[0]**2/2
generalized_forces: {{"x[{pushed}]": 3*sin(t)}}
"""
IN_A_PLANE = """
sizes: {{N: {count}}}
parameters: {{k: 30, F: 0}}
coordinates: {{"x[i in range(N)]": {{initial: 0}}, "y[i in range(N)]": {{initial: 0}}}}
masses: {{"block[i in range(N)]": 1 + i/10}}
positions: {{"block[i in range(N)]": "(x[i], y[i])"}}
potential: sum(k*((x[i] - x[i - 1])**2 + (y[i] - y[i - 1])**2)/2 for i in range(1, N)) + k*x[0]**2/2
forces: {{"block[{pushed}]": "(3*sin(t), 2*sin(2*t))"}}
"""
HINGED = """
sizes: {{N: {count}}}
parameters: {{k: 30, F: 0}}
coordinates: {{"a[i in range(N)]": {{initial: 0}}}}
masses: {{"bob[i in range(N)]": 1}}
positions:
  "bob[0]": (sin(a[0]), -cos(a[0]))
  "bob[i in range(1, N)]": "bob[i - 1] + (sin(a[i]), -cos(a[i]))"
potential: sum(-9.81*(N - i)*cos(a[i]) for i in range(N))
generalized_forces: {{"a[{pushed}]": 3*sin(t)}}
"""
RESTING = """
sizes: {{N: {count}}}
parameters: {{k: 30, F: 0}}
coordinates: {{"x[i in range(N)]": {{initial: 0}}, "z[i in range(N)]": {{initial: 0}}}}
masses: {{"block[i in range(N)]": 1}}
positions: {{"block[i in range(N)]": "(x[i], z[i])"}}
potential: sum(9.81*z[i] for i in range(N)) + sum(k*(x[i] - x[i - 1])**2/2 for i in range(1, N))
constraints: {{"floor[i in range(N)]": "z[i]"}}
generalized_forces: {{"x[{pushed}]": 3*sin(t)}}
"""
SYSTEMS = {
    "line": (ON_A_LINE, "dissipation: sum(({limit})*abs(x_dot[i]) for i in range(N))"),
    "each": (ON_A_LINE, "dissipation: sum((i + 1)*({limit})*abs(x_dot[i]) for i in range(N))"),
    "neighbours": (
        ON_A_LINE,
        "dissipation: sum(({limit})*abs(x_dot[i] - x_dot[i - 1]) for i in range(1, N))",
    ),
    "plane": (IN_A_PLANE, "dissipation: sum(({limit})*norm((x_dot[i], y_dot[i])) for i in range(N))"),
    "hinges": (
        HINGED,
        "dissipation: ({limit})*abs(a_dot[0])"
        " + sum(({limit})*abs(a_dot[i] - a_dot[i - 1]) for i in range(1, N))",
    ),
    "angles": (HINGED, "dissipation: sum(({limit})*abs(a_dot[i]) for i in range(N))"),
    "pressed": (
        RESTING,
        'forces: {{"block[i in range(N)]": "(-({limit})*floor[i].multiplier*sign(x_dot[i]), 0)"}}',
    ),
}


def solved(text: str, method: str, stop: float = 2.0, **more: object) -> lagrange.Trajectory:
    """The motion to a time."""
    found = lagrange.solve(text, stop=stop, samples=21, method=method, tolerance=TOLERANCES[method], **more)
    assert found.status == "complete"
    return found


def places(motion: lagrange.Trajectory) -> NDArray[np.float64]:
    """The coordinates, by time."""
    return np.hstack([motion.q[name].reshape(len(motion.t), -1) for name in sorted(motion.q)])


@pytest.mark.exhaustive(keep=3)
@BY
@pytest.mark.parametrize("count", [2, 7, 20])
@pytest.mark.parametrize("case", SYSTEMS)
@pytest.mark.parametrize("limit", ["F", "F*(2 + sin(t))", "where(t < 9, 0, 4)"])
def test_without_a_limit_there_is_no_friction(
    case: str, count: int, method: str, limit: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From rest, where velocities begin with many derivatives that are 0. Systems with friction by
    multipliers are written out, and so is what they are compared with."""
    frame, friction = SYSTEMS[case]
    text = frame.format(count=count, pushed=0)
    rubbing = solved(text + friction.format(limit=limit), method)
    if case == "pressed":
        kept.SYSTEMS.clear()
        keep_families(monkeypatch, whole=False)
    free = solved(text, method)
    kept.SYSTEMS.clear()
    assert places(rubbing) == pytest.approx(places(free), abs=ERRORS[method])
    assert rubbing.attributes["steps"] <= 1.5 * free.attributes["steps"] + 40


@pytest.mark.exhaustive(keep=2)
@BY
@pytest.mark.parametrize("count", [5, 6, 8, 20, 60])
def test_a_chain_is_released_at_rest(count: int, method: str) -> None:
    motion = solved(CHAIN.format(count=count), method, 4)
    assert motion.q["x"] == pytest.approx(pushed_chain(count, motion.t), abs=1e-8)
    assert motion.attributes["steps"] <= (1000 if method == "Radau" else 300)


@pytest.mark.exhaustive(keep=1)
@BY
@pytest.mark.parametrize("case", [one for one in SYSTEMS if one != "pressed"])
@examples(2)
@given(seed=st.integers(0, 10**6), count=st.integers(2, 24), at=st.floats(0.2, 1.2))
def test_what_is_held_until_then_moves_as_from_then_on(
    case: str, method: str, seed: int, count: int, at: float
) -> None:
    """It is the motion that begins at rest at that time."""
    frame, friction = SYSTEMS[case]
    text = frame.format(count=count, pushed=seed % count)
    released = text + friction.format(limit=f"where(t < {at!r}, 50, 0)")
    if case == "neighbours":  # what is not held to the ground is at rest, too
        released = released.replace("sin(t)", f"where(t < {at!r}, 0, sin(t))")
    held, free = solved(released, method, 3.0), solved(text, method, 3.0, start=at)
    assert np.all(np.abs(places(held)[held.t <= at]) < 1e-12)
    assert places(held)[-1] == pytest.approx(places(free)[-1], abs=ERRORS[method])


def swinging(t: NDArray[np.float64], at: float, stop: float, force: float) -> NDArray[np.float64]:
    """An oscillator x'' = -9 x - f sign(x'), x = 1 at rest, where f is ``force`` from ``at`` to ``stop``, and
    else 0."""
    found, begin, x, v = np.zeros_like(t), 0.0, 1.0, 0.0
    while True:
        f = force if at <= begin < stop else 0.0
        way = np.sign(v) or -np.sign(x)
        if f and v == 0.0 and 9 * abs(x) <= f:
            middle, end = x, stop
            a, b = 0.0, 0.0
        else:
            middle = -way * f / 9
            a, b = x - middle, v / 3
            turn = (np.arctan2(b, a) % np.pi) / 3 or np.pi / 3
            end = min(next(one for one in (at, stop, np.inf) if one > begin), begin + turn)
        here = (t >= begin) & (t <= end)
        found[here] = middle + a * np.cos(3 * (t[here] - begin)) + b * np.sin(3 * (t[here] - begin))
        if end > t[-1]:
            return found
        phase, turned = 3 * (end - begin), end not in (at, stop)
        x, v = middle + a * np.cos(phase) + b * np.sin(phase), 3 * (b * np.cos(phase) - a * np.sin(phase))
        begin, v = end, 0.0 if turned else v


@BY
@pytest.mark.parametrize("count", [1, 12])
@pytest.mark.parametrize("by", ["time", "event"])
def test_a_brake_is_applied_and_let_go_again(count: int, by: str, method: str) -> None:
    text = f"""
sizes: {{N: {count}}}
parameters: {{F: {0 if by == "event" else 1.2}}}
coordinates: {{"x[i in range(N)]": {{initial: 1}}}}
masses: {{"block[i in range(N)]": 1}}
positions: {{"block[i in range(N)]": "x[i]"}}
potential: sum(9*x[i]**2/2 for i in range(N))
"""
    limit = "F" if by == "event" else "where(1.1 < t < 2.9, F, 0)"
    text += f"dissipation: sum(({limit})*abs(x_dot[i]) for i in range(N))\n"
    if by == "event":
        text += "events: {on: {when: t - 1.1, action: {set: {F: 1.2}}}"
        text += ", off: {when: t - 2.9, action: {set: {F: 0}}}}\n"
    motion = lagrange.solve(text, stop=6, samples=61, method=method, tolerance=TOLERANCES[method])
    assert motion.status == "complete"
    expected = swinging(motion.t, 1.1, 2.9, 1.2)
    assert motion.q["x"] == pytest.approx(
        np.stack([expected] * count, axis=1).reshape(motion.q["x"].shape), abs=1e-8
    )


@pytest.mark.parametrize("count", [6, 20])
def test_members_of_a_sweep_have_friction_or_none(count: int) -> None:
    frame, friction = SYSTEMS["line"]
    text = frame.format(count=count, pushed=0) + friction.format(limit="F")
    swept = lagrange.sweep(text, over={"F": [0.0, 0.5, 0.0, 1.0]}, stop=2, outputs="q")
    assert list(swept.statuses) == ["complete"] * 4
    for force, found in zip([0.0, 0.5, 0.0, 1.0], np.asarray(swept["q/x"])):
        alone = lagrange.solve(text, set={"F": force}, stop=2)
        assert found[-1] == pytest.approx(alone.q["x"][-1], abs=1e-12)


@pytest.mark.exhaustive(keep=1)
@BY
@pytest.mark.parametrize("count", [2, 15])
def test_another_kink_at_the_same_velocity_is_heard(count: int, method: str) -> None:
    """With friction that is 0, x'' = -20 x - c x' with another c for each direction of motion."""
    text = f"""
sizes: {{N: {count}}}
parameters: {{F: 0, c1: 1, c2: 4}}
coordinates: {{"x[i in range(N)]": {{initial: 1}}}}
masses: {{"block[i in range(N)]": 1}}
positions: {{"block[i in range(N)]": "x[i]"}}
potential: sum(20*x[i]**2/2 for i in range(N))
generalized_forces: {{"x[i in range(N)]": "-F*sign(x_dot[i]) - where(x_dot[i] > 0, c1, c2)*x_dot[i]"}}
"""
    motion = solved(text, method, 2.0)
    expected = damped(motion.t)
    assert motion.q["x"] == pytest.approx(np.stack([expected] * count, axis=1), abs=1e-8)


HELD_ON_A_TABLE = """
parameters: {F: 2, G: 0}
coordinates: {x: {initial: 0}, y: {initial: 0}, z: {initial: 0}, clock: {initial: 0, velocity: 1}}
masses: {block: 1.5, hand: 1}
positions: {block: [x, y, z], hand: [clock, 0, 0]}
potential: 10*z
constraints: {table: z}
"""


@BY
@pytest.mark.parametrize("outputs", ["reactions", "reactions,multipliers,ledger"])
@pytest.mark.parametrize(
    "limit", ["where(t < 1, F, 0)", "where(t <= 1, F, 0)", "where(clock < 1, F, 0)", "G"]
)
def test_reactions_are_known_where_friction_ends(limit: str, outputs: str, method: str) -> None:
    """At the instant at which it is switched off, too, when the block is at rest: there they are those of the
    motion that begins."""
    friction = f'forces: {{block: "(0.9, 1.2, 0) - ({limit})*(x_dot, y_dot, 0)/norm((x_dot, y_dot))"}}\n'
    motion = lagrange.solve(
        HELD_ON_A_TABLE + friction,
        stop=2,
        samples=5,
        method=method,
        tolerance=TOLERANCES[method],
        outputs=outputs + ",q",
    )
    assert motion.status == "complete"
    expected = np.tile([0.0, 0.0, 10.0], (5, 1))
    assert motion.reactions["block"] == pytest.approx(expected, abs=1e-9)
    since = np.maximum(motion.t - (0 if limit == "G" else 1), 0)
    assert motion.q["x"] == pytest.approx(0.3 * since**2, abs=1e-9)
    if "ledger" in outputs:
        assert np.max(np.abs(motion.ledger["h"])) < 1e-8
