"""Motions through kinks and jumps of the force, against closed forms: one step more at each; and friction."""

from __future__ import annotations

import math
import random

import mpmath
import numpy as np
import pytest

from lagrange_cli.integrate.ending import Ending
from tests.support.motion import follow

LINE = """
name: a line
coordinates: {{x: {{initial: {x}, velocity: {v}}}}}
masses: {{p: 1}}
embedding: {{p: [x]}}
potential: {potential}
generalized_forces: {{x: "{force}"}}
"""


def line(x: float, v: float, potential: str = "0", force: str = "0") -> str:
    return LINE.format(x=repr(x), v=repr(v), potential=potential, force=force)


@pytest.fixture
def source(request) -> random.Random:
    return random.Random(request.config.option.seed)


@pytest.mark.exhaustive(keep=0.9)
@pytest.mark.parametrize(
    "wall", ["K/2*max(0, x - A)**2", "K/2*((x - A + abs(x - A))/2)**2", "where(x > A, K/2*(x - A)**2, 0)"]
)
def test_a_ball_meets_a_one_sided_spring(wall, source):
    a, v, k = source.uniform(0.5, 2), source.uniform(0.5, 3), 10 ** source.uniform(1, 6)
    text = line(0.0, v, wall.replace("K", repr(k)).replace("A", repr(a)))
    stay = math.pi / math.sqrt(k)
    motion = follow(text, a / v + stay + 1, 11)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["q/x"][-1] == pytest.approx(a - v, abs=1e-13 * (a + v) * (1 + math.sqrt(k)))
    assert motion["v/x"][-1] == pytest.approx(-v, rel=1e-13)
    smooth = follow(line(a, v, f"{k!r}/2*(x - {a!r})**2"), stay, 3)
    assert motion.outcome.steps <= smooth.outcome.steps + 4


def test_dry_friction_stops_an_oscillation(source):
    """x'' = -x - mu sign(x'): each swing ends 2 mu nearer to the centre, until |x| <= mu."""
    mu, x = source.uniform(0.05, 0.3), source.uniform(1, 3)
    rest = x
    while abs(rest) > mu:
        rest = 2 * mu * math.copysign(1, rest) - rest
    motion = follow(line(x, 0.0, "x**2/2", f"-{mu!r}*sign(x_dot)"), 400.0, 5)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["q/x"][-1] == pytest.approx(rest, abs=1e-12)
    assert abs(motion["v/x"][-1]) <= 1e-14


def test_a_block_sticks_until_the_force_exceeds_the_friction(source):
    """x'' = c t - mu from t = mu/c on."""
    mu, c = source.uniform(0.2, 1), source.uniform(0.05, 0.2)
    motion = follow(line(0.0, 0.0, "0", f"{c!r}*t - {mu!r}*sign(x_dot)"), mu / c + 3, 11)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["q/x"][-1] == pytest.approx(c * 3**3 / 6, rel=1e-12)


@pytest.mark.exhaustive(keep=0.85)
@pytest.mark.parametrize(
    "coefficient",
    ["where(abs(x_dot) < 0.1, S, K)", "where(x_dot**2 < 0.01, S, K)", "where(0.1 > x_dot, S, K)"],
)
def test_static_friction_may_be_larger_than_sliding_friction(coefficient, source):
    """x'' = c t - S from t = S/c on, and c t - K from the velocity 0.1 on."""
    sliding, c = source.uniform(0.2, 1), source.uniform(0.05, 0.2)
    static = sliding + source.uniform(0.1, 0.5)
    force = coefficient.replace("S", repr(static)).replace("K", repr(sliding))
    motion = follow(line(0.0, 0.0, "0", f"{c!r}*t - {force}*sign(x_dot)"), static / c + 5, 11)
    assert motion.outcome.ending is Ending.COMPLETE
    slow = math.sqrt(0.2 / c)
    fast = 5 - slow
    v = 0.1 + (static - sliding + c * slow) * fast + c * fast**2 / 2
    x = c * slow**3 / 6 + 0.1 * fast + (static - sliding + c * slow) * fast**2 / 2 + c * fast**3 / 6
    assert (motion["q/x"][-1], motion["v/x"][-1]) == pytest.approx((x, v), rel=1e-12)


def test_a_force_is_switched_on_and_off(source):
    on, off = source.uniform(1, 2), source.uniform(3, 4)
    motion = follow(line(0.0, 0.0, "0", f"where(t >= {on!r} and t < {off!r}, 1, 0)"), 6.0, 7)
    speed = off - on
    assert motion["v/x"][-1] == pytest.approx(speed, rel=1e-14)
    assert motion["q/x"][-1] == pytest.approx(speed**2 / 2 + speed * (6 - off), rel=1e-14)
    assert motion.outcome.steps == 3


def test_a_fast_switch_is_not_missed():
    """The motion is slow, what switches it is not: a square wave of the force, from its zero on."""
    omega = 37.3
    motion = follow(line(0.0, 0.0, "0", f"sign(sin({omega}*t))"), 20 * 2 * math.pi / omega, 5)
    half = math.pi / omega
    assert motion["v/x"][-1] == pytest.approx(0.0, abs=1e-13)
    assert motion["q/x"][-1] == pytest.approx(20 * half**2, rel=1e-12)


@pytest.mark.exhaustive(keep=0.7)
def test_a_motion_comes_to_rest_where_two_jumps_meet():
    """-sign(x) - 0.2 sign(x'): infinitely many swings in a finite time, each 2/3 as wide as the last."""
    motion = follow(line(1.0, 0.0, "abs(x)", "-0.2*sign(x_dot)"), 30.0, 31)
    assert motion.outcome.ending is Ending.COMPLETE
    assert abs(motion["q/x"][-1]) <= 1e-12
    still = np.abs(motion["q/x"]) <= 1e-12
    assert np.all(still[np.argmax(still) :])


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    "spelling",
    [
        "-C*sqrt(abs(x_dot))*sign(x_dot)",
        "-C*where(x_dot > 0, 1, -1)*abs(x_dot)**0.5",
        "-C*x_dot/abs(x_dot)**0.5",
    ],
)
def test_a_resistance_that_has_no_series_at_rest_brings_to_rest(spelling, source):
    """v' = -c sqrt(v) ends at t = 2 sqrt(v)/c, after 2 v^1.5/(3 c)."""
    c, v = source.uniform(0.8, 2), source.uniform(0.5, 1.5)
    motion = follow(line(0.0, v, "0", spelling.replace("C", repr(c))), 4.0, 9)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["q/x"][-1] == pytest.approx(2 * v**1.5 / (3 * c), rel=1e-13)
    assert motion["v/x"][-1] == 0.0


def test_what_such_a_resistance_has_stopped_is_moved_by_another_force():
    """From t = 4 on v' = 0.3 - 0.8 s, s = sqrt(v), and t - 4 = -2 s/0.8 - 0.6/0.64 log(1 - 0.8 s/0.3)."""
    force = "-0.8*sqrt(abs(x_dot))*sign(x_dot) + where(t > 4, 0.3, 0)"
    motion = follow(line(0.0, 1.0, "0", force), 6.0, 3)
    assert motion.outcome.ending is Ending.COMPLETE
    root = math.sqrt(motion["v/x"][-1])
    assert -2 * root / 0.8 - 0.6 / 0.64 * math.log(1 - 0.8 * root / 0.3) == pytest.approx(2.0, rel=1e-11)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("side", [1, -1])
def test_dry_friction_beside_such_a_resistance_lets_go(side):
    """From rest v' = 0.3 - 0.8 s, s = sqrt(v): t = -2 s/0.8 - 0.6/0.64 log(1 - 0.8 s/0.3), on both sides."""
    force = f"{side}*0.4 - 0.1*sign(x_dot) - 0.8*sqrt(abs(x_dot))*sign(x_dot)"
    motion = follow(line(1.0, 0.0, "0", force), 2.0, 3)
    assert motion.outcome.ending is Ending.COMPLETE
    root = math.sqrt(side * motion["v/x"][-1])
    assert -2 * root / 0.8 - 0.6 / 0.64 * math.log(1 - 0.8 * root / 0.3) == pytest.approx(2.0, rel=1e-11)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("power", [0.1, 0.25, 0.5, 0.75, 1.3])
@pytest.mark.parametrize("spelling", ["max(0, x - {a})", "(abs(x - {a}) + x - {a})/2"])
def test_a_contact_force_that_has_no_series_where_it_begins(power, spelling, source):
    """x'' = -k u^p, u = max(0, x - a): how long it stays is a beta function."""
    a, v, k = source.uniform(0.3, 2), source.uniform(0.5, 2), 10 ** source.uniform(0, 2)
    motion = follow(line(0.0, v, "0", f"-{k!r}*({spelling.format(a=repr(a))})**{power}"), 10.0, 2)
    assert motion.outcome.ending is Ending.COMPLETE
    n = power + 1
    deepest = (v * v * n / (2 * k)) ** (1 / n)
    inside = 2 * deepest / v * float(mpmath.beta(1 / n, 0.5)) / n
    assert motion["v/x"][-1] == pytest.approx(-v, rel=2e-12)
    assert motion["q/x"][-1] == pytest.approx(a - v * (10 - a / v - inside), rel=2e-12)


@pytest.mark.exhaustive(keep=0.8)
def test_a_root_of_a_square_that_is_a_function_is_a_kink():
    """sqrt(1 - cos(x)) is sqrt(2) |sin(x/2)|; v is never lost where x is 0."""
    motion = follow(line(0.5, -1.0, "sqrt(1 - cos(x))"), 20.0, 81)
    same = follow(line(0.5, -1.0, "sqrt(2)*abs(sin(x/2))"), 20.0, 81)
    assert motion.outcome.ending is Ending.COMPLETE
    assert np.count_nonzero(np.diff(np.sign(motion["q/x"]))) > 3
    assert motion["q/x"] == pytest.approx(same["q/x"], rel=0, abs=1e-12)


@pytest.mark.exhaustive(keep=0.8)
def test_a_condition_on_an_angle_changes_at_the_cut(source):
    """atan2 jumps from pi to -pi: a force that acts beyond an angle ends there."""
    c, w = source.uniform(1, 3), source.uniform(0.5, 2)
    text = f"""
    name: an angle
    coordinates: {{a: {{initial: 0, velocity: {w!r}}}, z: {{initial: 0}}}}
    masses: {{p: 1, q: 1}}
    embedding: {{p: [cos(a), sin(a)], q: [z]}}
    potential: 0
    generalized_forces: {{z: "where(atan2(sin(a), cos(a)) > {c!r}, 1, 0)"}}
    """
    motion = follow(text, 8 * math.pi / w, 5)
    turns = np.arange(5)
    assert motion["v/z"] == pytest.approx(turns * (math.pi - c) / w, rel=1e-11, abs=1e-12)


@pytest.mark.exhaustive(keep=0.6)
@pytest.mark.parametrize("place", [0, 0.4])
def test_a_difference_over_its_own_length_is_its_sign(place, source):
    """With any factor, also where the motion begins on the jump."""
    k = source.choice([-1, 1]) * source.uniform(0.5, 3)
    text = f"""
        coordinates: {{x: {{initial: {place}}}, y: {{initial: 0}}}}
        masses: {{a: 1, b: 2}}
        embedding: {{a: x, b: y}}
        generalized_forces: {{x: "{k}*UNIT + sin(2*t)", y: "-({k}*UNIT)"}}
    """
    units = "(x - y)/sqrt((x - y)**2)", "sign(x - y)"
    motion, other = (follow(text.replace("UNIT", unit), 1.5, 4) for unit in units)
    assert motion.outcome.ending is Ending.COMPLETE
    np.testing.assert_array_equal(motion["q/x"], other["q/x"])


@pytest.mark.exhaustive(keep=0.7)
def test_static_friction_on_a_moving_belt_is_that_of_a_floor_in_motion():
    """A coefficient that is larger at rest, relative to a belt: the same in the frame of the belt."""
    text = """
parameters: {v: VELOCITY, mu_s: 0.4, mu_k: 0.25, g: 9.81}
coordinates: {x: {velocity: START, initial: 0}}
masses: {block: 1}
positions: {block: x}
potential: 5*(x + (0.5 - v)*t)**2
generalized_forces: {x: "-where(abs(x_dot - v) < 1e-3, mu_s, mu_k)*g*sign(x_dot - v)"}
"""
    on_belt = follow(text.replace("VELOCITY", "0.5").replace("START", "0"), 4, 41)
    in_frame = follow(text.replace("VELOCITY", "0").replace("START", "-0.5"), 4, 41)
    assert np.sum(on_belt["v/x"] == 0.5) > 10  # it sticks
    assert on_belt["q/x"] == pytest.approx(in_frame["q/x"] + 0.5 * in_frame.t, abs=1e-12)


@pytest.mark.exhaustive(keep=0.95)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_friction_holds_a_charge_that_a_pole_repels(side, source):
    """U = 1/|x| and dry friction mu: from rest at 1, where 1 > mu, as far as 1/mu, where mu**2 < mu holds it.
    The pole itself has no multiplier, the friction has its own."""
    mu = source.uniform(0.3, 0.8)
    motion = follow(line(side, 0.0, "1/abs(x)", f"-{mu!r}*sign(x_dot)"), 100.0, 5)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["q/x"][-1] == pytest.approx(side / mu, rel=1e-13)
    assert abs(motion["v/x"][-1]) <= 1e-14


RING = """
name: charges on a ring
sizes: {{N: 4}}
coordinates: {{a[i in range(N)]: {{initial: "2*pi*i/N + 0.1*sin(3.7*i)"}}}}
masses: {{b[i in range(N)]: 1}}
positions: {{b[i in range(N)]: [cos(a[i]), sin(a[i])]}}
potential: sum(1/({distance}) for i in range(N) for j in range(i))
"""


@pytest.mark.exhaustive(keep=0.35)
def test_charges_on_a_ring_move_as_with_distances_that_have_no_sides():
    """|2 sin((a_i - a_j)/2)| is its argument as long as no charge passes another one, which none can."""
    motions = [
        follow(RING.format(distance=one), 10.0, 11) for one in ("norm(b[i] - b[j])", "2*sin((a[i] - a[j])/2)")
    ]
    sided, plain = ([motion[f"q/a[{i}]"] for i in range(4)] for motion in motions)
    np.testing.assert_allclose(sided, plain, rtol=0, atol=1e-12)
    assert np.ptp(sided, axis=1).min() > 0.01


AT_ZERO = """
coordinates: {x: {initial: 0}, y: {initial: 0}}
masses: {p: 1, q: 1}
positions: {p: x, q: y}
potential: x**2/2
generalized_forces: {y: "FORCE"}
"""


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
@pytest.mark.parametrize(
    ("force", "value", "mean"),
    [
        ("sign(x_dot)", 0.0, 0.0), ("sign(x)", 0.0, 0.0), ("2 + 3*sign(x_dot - 4*x)", 2.0, 2.0),
        ("where(x > 0, 1, 5)", 5.0, 3.0), ("where(x >= 0, 1, 5)", 1.0, 3.0),
        ("where(x_dot < 0, 1, 5)", 5.0, 3.0), ("where(x_dot <= 0, 1, 5)", 1.0, 3.0),
    ],
)  # fmt: skip
def test_a_switch_whose_argument_stays_0_has_its_value_there(
    force: str, value: float, mean: float, method: str
) -> None:
    """That of ``sign`` is 0, and a condition holds or does not. The force acts on another coordinate, so that
    it does not hold this one there. Where this one swings, it is as long on one side as on the other."""
    text = AT_ZERO.replace("FORCE", force)
    motion = follow(text, 2.0, 5, method=method, tolerance=1e-12)
    assert motion["q/y"] == pytest.approx(value * motion.t**2 / 2, rel=1e-12, abs=1e-300)
    moved = text.replace("x: {initial: 0}", "x: {initial: 0.5}")
    motion = follow(moved, 2.0 * math.pi, 5, method=method, tolerance=1e-12)
    assert motion["v/y"][-1] == pytest.approx(2.0 * math.pi * mean, abs=1e-6)


@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853", "Radau"])
def test_a_force_that_acts_in_the_air_alone_acts_in_each_flight(method: str) -> None:
    """A ball bounces with e = 1/2 until it rests. Steps on rates are longer than flights."""
    text = """
parameters: {e: 0.5}
coordinates: {x: {initial: 0.3}, y: {initial: 0}}
masses: {p: 1, q: 1}
positions: {p: x, q: y}
potential: x
generalized_forces: {y: "where(x > 0, 1, 0)"}
events: {hit: {when: x, direction: falling, action: {set: {x_dot: -e*x_dot}}}}
"""
    motion = follow(text, 20.0, 41, method=method, tolerance=1e-12)
    fall = math.sqrt(0.6)
    flights = [fall, *(2.0 * fall * 0.5**k for k in range(1, 60))]
    assert motion["v/y"] == pytest.approx(np.minimum(motion.t, sum(flights)), abs=1e-7)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853", "Radau"])
@pytest.mark.parametrize("force", [0.5, 1.4])
def test_dry_friction_lets_a_kink_hold(method: str, force: float) -> None:
    """The motion crosses the kink ever more often, at velocities that each crossing reduces by the same part;
    then the kink holds it, as friction alone could not. It ended with steps that were too short."""
    text = f"""
coordinates: {{s: {{initial: 0.05}}}}
masses: {{block: 1}}
embedding: {{block: [s]}}
potential: 2*abs(s)
generalized_forces: {{s: -{force}*sign(s_dot)}}
"""
    tolerance = {"DOP853": 1e-10, "Radau": 1e-9}.get(method, 2.0**-52)
    motion = follow(text, 3, 61, method=method, tolerance=tolerance)
    ahead, back = 2 - force, 2 + force
    speed, ends = np.sqrt(2 * ahead * 0.05), np.sqrt(2 * 0.05 / ahead)
    ends += speed / back * (1 + np.sqrt(back / ahead)) / (1 - np.sqrt(ahead / back))
    rests = motion.t > ends + 1e-6
    assert np.any(rests) and np.any(np.abs(motion["v/s"][~rests]) > 0)
    assert np.max(np.abs(motion["q/s"][rests])) < 1e-15
    assert np.all(motion["v/s"][rests] == 0)
    held = follow(text, 1, 3, outputs=("q", "reactions"), sets={"s": 0})
    assert np.all(held["reactions/block"] == 0)  # the sum of both forces is known, not what each of them is


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    ("potential", "equal", "other"),
    [
        ("where(k == 1, max(0, x - 1/2)**2, x**2)", "(x - 1/2)**2", "x**2"),
        ("where(k != 1, max(0, x - 1/2)**2, x**2)", "x**2", "(x - 1/2)**2"),
        ("where(k == 1, where(x > 0, x**2, 0), x**4)", "x**2", "x**4"),
        ("sqrt(1 + where(k != 1, x, 0)**3)", "0", "sqrt(1 + x**3)"),
        ("(1 + where(k == 1, max(0, x), 0))**2.5", "(1 + x)**2.5", "0"),
    ],
)
@pytest.mark.parametrize("k", [0, 1, 2])
def test_a_parameter_may_have_exactly_the_value_of_a_condition(
    k: int, potential: str, equal: str, other: str
) -> None:
    """The conditions ``k == 1`` and ``k != 1`` differ from ``k >= 1`` and ``k > 1`` at one value."""
    text = "\nparameters: {{k: {}}}\ncoordinates: {{x: {{initial: 1}}}}\nlagrangian: x_dot**2/2 - {} + 0*k\n"
    found = follow(text.format(k, potential), 0.3, 4)
    known = follow(text.format(k, equal if k == 1 else other), 0.3, 4)
    np.testing.assert_allclose(found["q/x"], known["q/x"], rtol=1e-14)
