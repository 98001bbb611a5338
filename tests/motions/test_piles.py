"""Piles: balls that fall on one another and come to rest together, on a line and in the plane."""

from __future__ import annotations

import random
from itertools import count as count_from

import numpy as np
import pytest

from lagrange_cli.integrate.ending import Ending
from tests.support.motion import Motion, follow

COLUMN = """
sizes: {{N: {count}}}
parameters: {{g: 9.81, e: {e}, d: 1, A: {A}, w: 3, m: {masses}, h: {heights}, u: {speeds}}}
coordinates:
  y[i in range(N)]: {{initial: "h[i]", velocity: "u[i]"}}
masses: {{"ball[i in range(N)]": "m[i]"}}
positions: {{"ball[i in range(N)]": "y[i]"}}
potential: sum(m[i]*g*y[i] for i in range(N))
events:
"""
FLOOR = """
  floor:
    when: y[0] - A*sin(w*t)
    direction: falling
    action: {set: {"y_dot[0]": "A*w*cos(w*t) - e*(y_dot[0] - A*w*cos(w*t))"}}
"""
HIT = """
  hit[i in range(1, N)]:
    when: y[i] - y[i - 1] - d
    direction: falling
    action:
      set:
        y_dot[i]: y_dot[i] - (1 + e)*m[i - 1]*(y_dot[i] - y_dot[i - 1])/(m[i] + m[i - 1])
        y_dot[i - 1]: y_dot[i - 1] + (1 + e)*m[i]*(y_dot[i] - y_dot[i - 1])/(m[i] + m[i - 1])
"""
REVERSED = HIT.replace("y[i] - y[i - 1] - d", "y[i - 1] + d - y[i]").replace("falling", "rising")
SAME = 1e-14
"""Rounding errors of heights."""


def column(
    source: random.Random,
    heights: list[float],
    speeds: list[float],
    e: float,
    A: float = 0.0,
    *,
    varied: bool = False,
) -> str:
    """Balls above a floor, of ``varied`` masses; their events are in any order, and written either way."""
    count = len(heights)
    masses = [source.choice((1.0, source.uniform(0.2, 3.0))) if varied else 1.0 for _ in heights]
    given = {"count": count, "e": e, "A": A, "masses": masses, "heights": heights, "speeds": speeds}
    events = [FLOOR, *([source.choice((HIT, REVERSED))] if count > 1 else [])]
    source.shuffle(events)
    return COLUMN.format(**given) + "".join(events)


def stacked(source: random.Random, count: int) -> list[float]:
    """Heights of balls, many of which touch."""
    gaps = [source.choice((0.0, 0.0, source.uniform(0.01, 1.0))) for _ in range(count)]
    return [i + sum(gaps[: i + 1]) for i in range(count)]


def energies(motion: Motion) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """T + U at each sample."""
    masses = np.array([motion.values.parameters[f"m[{i}]"] for i in range(motion["q/y"].shape[1])])
    found = sum((masses * motion[f"v/{x}"] ** 2 / 2.0).sum(axis=1) for x in "xy" if f"v/{x}" in motion.data)
    return np.asarray(found + (masses * 9.81 * motion["q/y"]).sum(axis=1))


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("case", range(10))
@pytest.mark.parametrize("shaken", [False, True])
def test_a_column_of_balls_comes_to_rest(case: int, shaken: bool, request: pytest.FixtureRequest) -> None:
    """None is below the floor, or in another one; the energy never grows on a floor at rest; and in the end
    they lie on one another: y_i = i d."""
    source = random.Random(f"{request.config.option.seed} {case} {shaken}")
    count, e, A = source.randint(2, 4), source.uniform(0.0, 0.55), 0.02 * shaken
    heights = [y + A for y in stacked(source, count)]
    speeds = [source.choice((0.0, source.uniform(-2.0, 2.0))) for _ in heights]
    text = column(source, heights, speeds, e, A, varied=True)
    motion = follow(text, 12.0, 241)
    assert motion.outcome.ending is Ending.COMPLETE, text
    floor, rest = A * np.sin(3.0 * motion.t), np.arange(count)
    above = np.diff(motion["q/y"] - rest, axis=1, prepend=floor[:, None])
    assert above.min() >= -SAME, text
    wandered = 2.0**-52 * count * motion.outcome.steps**0.5  # heights are rounded in each step on a floor
    assert np.abs(motion["q/y"][-1] - floor[-1] - rest).max() <= SAME + shaken * wandered, text
    assert np.abs(motion["v/y"][-1] - 3.0 * A * np.cos(3.0 * motion.t[-1])).max() <= SAME, text
    if not shaken:
        assert np.all(motion["v/y"][-1] == 0.0), text
        energy = energies(motion)
        assert np.diff(energy).max() <= SAME * energy[0], text


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("case", range(6))
def test_balls_on_an_elastic_floor_never_fall_through(case: int, request: pytest.FixtureRequest) -> None:
    """It cannot hold what has lost its speed: the motion ends there, with a message that says so."""
    source = random.Random(f"{request.config.option.seed} elastic {case}")
    heights = [y + 0.3 for y in stacked(source, source.randint(2, 3))]
    text = column(source, heights, [0.0] * len(heights), source.uniform(0.1, 0.4), varied=True)
    motion = follow(text.replace("- e*(y_dot[0] - A*w*cos(w*t))", "- y_dot[0]"), 2.0, 201)
    assert motion.outcome.ending in (Ending.COMPLETE, Ending.RECURRING), text
    above = np.diff(motion["q/y"] - np.arange(len(heights)), axis=1, prepend=0.0)
    assert above.min() >= -SAME, text


@pytest.mark.exhaustive(keep=0.25)
@pytest.mark.parametrize("e", [0.0, 0.2, 0.5])
@pytest.mark.parametrize("count", [2, 5, 10])
def test_a_ball_dropped_on_a_stack_does_not_push_it_through_the_floor(count: int, e: float) -> None:
    """The stack rests from the start: its impacts are all at one time, infinitely many if there are enough
    balls. The centre of mass never rises above its height at the start."""
    heights = [*map(float, range(count - 1)), count + 0.0]
    motion = follow(column(random.Random(0), heights, [0.0] * count, e), 0.6, 61)
    assert motion.outcome.ending is Ending.COMPLETE
    above = np.diff(motion["q/y"] - np.arange(count), axis=1, prepend=0.0)
    assert above.min() >= -SAME
    before = motion.t < np.sqrt(2.0 / 9.81)
    assert np.all(motion["v/y"][before][:, :-1] == 0.0)
    assert np.diff(energies(motion)).max() <= SAME * count**2


@pytest.mark.exhaustive(keep=0.7)
def test_two_balls_that_meet_part_with_the_speeds_of_their_impacts() -> None:
    """One hits another one that lies on the floor, with v: 3v/4 and v/4 downward; 3v/8 up; a second impact
    leaves -3v/32 and 7v/32; and the floor turns the first of these to 3v/64."""
    text = column(random.Random(0), [0.0, 1.5], [0.0, 0.0], 0.5)
    at = np.sqrt(1.0 / 9.81)
    motion = follow(text, at + 1e-3, 2)
    v, t = np.sqrt(9.81), 1e-3
    assert motion["v/y"][-1] == pytest.approx([3 * v / 64 - 9.81 * t, 7 * v / 32 - 9.81 * t], rel=1e-12)
    assert motion["events/hit/t"] == pytest.approx([at, at], rel=1e-15)


@pytest.mark.exhaustive(keep=0.5)
def test_balls_that_collapse_in_flight_fall_as_one_and_land_together() -> None:
    """Clay: after the impact no force presses them together, until they come to the floor."""
    text = column(random.Random(1), [2.0, 3.5], [1.0, -3.0], 0.0)
    motion = follow(text, 4.0, 401)
    assert motion.outcome.ending is Ending.COMPLETE
    gaps = motion["q/y"][:, 1] - motion["q/y"][:, 0] - 1.0
    assert gaps.min() >= -SAME and np.abs(gaps[motion.t > 0.5 / 4.0]).max() <= 1e-12
    assert np.all(motion["q/y"][-1] == [0.0, 1.0]) and np.all(motion["v/y"][-1] == 0.0)


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("method", ["ias15", "DOP853"])
def test_columns_rest_with_other_methods(method: str) -> None:
    text = column(random.Random(2), [0.0, 1.0, 2.4], [0.0, 0.0, 0.0], 0.3)
    tolerance = 1e-12 if method == "DOP853" else 2.0**-52
    motion = follow(text, 4.0, 41, method=method, tolerance=tolerance)
    assert motion.outcome.ending is Ending.COMPLETE
    assert np.diff(motion["q/y"] - np.arange(3), axis=1, prepend=0.0).min() >= -1e-12
    assert np.abs(motion["q/y"][-1] - np.arange(3)).max() <= 1e-13


def test_what_touches_a_floor_and_moves_into_it_at_the_start_hits_it() -> None:
    """It would fall through otherwise. A record of the zero is none."""
    text = column(random.Random(3), [0.0], [-2.0], 0.5) + '  zero: {when: "y[0]"}\n'
    motion = follow(text, 0.1, 2)
    assert motion["events/floor/t"] == pytest.approx([0.0])
    assert motion["v/y"][-1] == pytest.approx([1.0 - 0.981], rel=1e-14)
    assert motion.outcome.happened["zero"].count == 0


LEANING = """
parameters: {{e: 0.5, s: {slope}, wall: {wall}}}
coordinates: {{x: {{initial: 0, velocity: 1}}, y: {{initial: 0, velocity: "-s"}}}}
masses: {{ball: 1}}
positions: {{ball: [x, y]}}
potential: 9.81*y
events:
  floor: {{when: y + s*x, direction: falling, action: {{set: {{y_dot: -s*x_dot - e*(y_dot + s*x_dot)}}}}}}
  wall: {{when: wall - x, direction: falling, action: {{set: {{x_dot: -e*x_dot}}}}}}
"""


@pytest.mark.parametrize("wall", [1.0, 100.0])
@pytest.mark.parametrize("falling", [1.0, -1.0])
def test_a_ball_thrown_back_along_the_floor_gets_no_speed_into_it(
    wall: float, falling: float, request: pytest.FixtureRequest
) -> None:
    """It leans so little that the wall leaves 1.5 times its slope there: from rounding errors to what is
    clearly more, also after the floor has held the ball for long."""
    slope = falling * 2.0 ** random.Random(request.config.option.seed).uniform(-49.0, -40.0)
    motion = follow(LEANING.format(slope=slope, wall=wall), 3.0 * wall, 31)
    assert motion.outcome.ending is Ending.COMPLETE and motion["v/x"][-1] == -0.5
    gaps, speeds = (motion[f"{one}/y"] + slope * motion[f"{one}/x"] for one in "qv")
    assert np.abs(gaps).max() <= 2.0**-50 * wall and abs(speeds[-1]) <= 2.0**-50


PILE = """
sizes: {{N: {count}}}
parameters: {{g: 9.81, e: {e}, R: 0.5, W: {width}, a: {xs}, b: {ys}, u: {us}, "m[i in range(N)]": 1}}
coordinates:
  x[i in range(N)]: {{initial: "a[i]", velocity: "u[i]"}}
  y[i in range(N)]: {{initial: "b[i]"}}
masses: {{"ball[i in range(N)]": "m[i]"}}
positions: {{"ball[i in range(N)]": ["x[i]", "y[i]"]}}
potential: sum(m[i]*g*y[i] for i in range(N))
events:
  floor[i in range(N)]:
    {{when: "y[i] - R", direction: falling, action: {{set: {{"y_dot[i]": "-e*y_dot[i]"}}}}}}
  left[i in range(N)]:
    {{when: "x[i] - R", direction: falling, action: {{set: {{"x_dot[i]": "-e*x_dot[i]"}}}}}}
  right[i in range(N)]:
    {{when: "W - R - x[i]", direction: falling, action: {{set: {{"x_dot[i]": "-e*x_dot[i]"}}}}}}
  hit[i in range(N), j in range(i)]:
    when: sqrt((x[i] - x[j])**2 + (y[i] - y[j])**2) - 2*R
    direction: falling
    action:
      set:
        x_dot[i]: x_dot[i] - (x[i] - x[j])*{impulse}
        y_dot[i]: y_dot[i] - (y[i] - y[j])*{impulse}
        x_dot[j]: x_dot[j] + (x[i] - x[j])*{impulse}
        y_dot[j]: y_dot[j] + (y[i] - y[j])*{impulse}
"""
SPEED = "((x[i] - x[j])*(x_dot[i] - x_dot[j]) + (y[i] - y[j])*(y_dot[i] - y_dot[j]))"
IMPULSE = f"(1 + e)/2*{SPEED}/((x[i] - x[j])**2 + (y[i] - y[j])**2)"


def dropped(source: random.Random, count: int, e: float, width: float, speed: float = 1.0) -> str:
    """Balls that fall into a box, each above the one before, with horizontal speeds up to this one."""
    return PILE.format(
        count=count,
        e=e,
        width=width,
        impulse=IMPULSE,
        xs=[source.uniform(0.5, width - 0.5) for _ in range(count)],
        ys=[0.5 + 1.3 * i + source.uniform(0.0, 0.25) for i in range(count)],
        us=[source.uniform(-speed, speed) for _ in range(count)],
    )


def deepest(motion: Motion, width: float) -> float:
    """How far balls are apart from each other and from the box, at least."""
    x, y = motion["q/x"], motion["q/y"]
    pairs = [(i, j) for i in range(x.shape[1]) for j in range(i)]
    between = [np.hypot(x[:, i] - x[:, j], y[:, i] - y[:, j]).min() - 1.0 for i, j in pairs]
    return float(min(*between, y.min() - 0.5, x.min() - 0.5, (width - 0.5 - x).min()))


@pytest.mark.exhaustive(keep=0.3)
@pytest.mark.parametrize("case", range(10))
def test_balls_in_a_box_keep_out_of_each_other(case: int, request: pytest.FixtureRequest) -> None:
    """In the plane, without friction: those in a narrow box come to rest, one on two others."""
    source = random.Random(f"{request.config.option.seed} {case}")
    count, e, width = source.randint(2, 3), source.uniform(0.0, 0.4), source.choice((1.7, 2.5, 3.2))
    text = dropped(source, count, e, width)
    motion = follow(text, 8.0, 161)
    assert motion.outcome.ending is Ending.COMPLETE, text
    assert deepest(motion, width) >= -SAME, text
    energy = energies(motion)
    assert np.diff(energy).max() <= SAME * energy[0], text


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("case", range(8))
def test_balls_in_a_box_rest_in_steps_on_rates(case: int, request: pytest.FixtureRequest) -> None:
    """Flights that rounding hides from values of arguments do not follow one another for ever, and what
    leaves others while it is a little beyond 0 is not thrown back into them."""
    source = random.Random(f"{request.config.option.seed} rates {case}")
    count, width = source.randint(2, 4), source.choice((1.7, 2.5, 3.2))
    text = dropped(source, count, source.choice((0.0, source.uniform(0.0, 0.3))), width)
    asked = count_from(0)
    motion = follow(text, 3.0, 61, method="ias15", interrupted=lambda: next(asked) > 5000)
    assert motion.outcome.ending is Ending.COMPLETE, text
    assert deepest(motion, width) >= -1e-12, text
    energy = energies(motion)
    assert np.diff(energy).max() <= 1e-10 * energy[0], text


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("at", [2.0, 2.5])
def test_a_ball_dropped_on_four_that_rest_side_by_side(at: float) -> None:
    given = {"count": 5, "e": 0.5, "width": 8.0, "impulse": IMPULSE, "us": [0.0] * 5}
    text = PILE.format(xs=[1.5, 2.5, 3.5, 4.5, at], ys=[0.5] * 4 + [2.0], **given)
    motion = follow(text, 2.0, 101)
    assert motion.outcome.ending is Ending.COMPLETE
    assert deepest(motion, 8.0) >= -SAME
    assert np.diff(energies(motion)).max() <= SAME * energies(motion)[0]
    before = motion.t < 0.3
    assert np.array_equal(motion["q/y"][before][:, :4], np.full((np.count_nonzero(before), 4), 0.5))
