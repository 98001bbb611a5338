"""Potentials with kinks: no series sees them, and no step may leap over them unnoticed."""

from __future__ import annotations

import math
import random

import mpmath
import numpy as np
import pytest

import lagrange_cli as lagrange
from lagrange_cli.integrate.ending import Ending
from tests.support.motion import follow

LINE = """
name: a line
coordinates:
  x: {{initial: {initial}, velocity: {velocity}}}
masses:
  p: 1
embedding:
  p: [x]
potential: {potential}
"""


def bouncing(t: np.ndarray) -> np.ndarray:
    """x'' = -sign(x) from rest at x = 1: parabolas, a quarter period of sqrt(2) each."""
    quarter = math.sqrt(2.0)
    phase = np.mod(t, 4 * quarter)
    fall = np.minimum(phase, 4 * quarter - phase)
    return np.where(fall <= quarter, 1 - fall**2 / 2, (2 * quarter - fall) ** 2 / 2 - 1)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("place", [0.0, 0.75, -3.0])
def test_the_motion_in_a_wedge_is_made_of_parabolas(place):
    text = LINE.format(initial=place + 1, velocity=0, potential=f"sqrt((p.x - {place})**2)")
    motion = follow(text, 50.0, 1001)
    assert motion.outcome.ending is Ending.COMPLETE
    assert np.max(np.abs(motion["q/x"] - place - bouncing(motion.t))) <= 1e-11
    assert motion.outcome.h_drift <= 1e-12 * (1 + abs(place))


@pytest.mark.exhaustive(keep=0.6)
def test_a_jump_in_a_higher_derivative_is_found_as_well():
    """U = |x|^3: the force and its slope are continuous. The period is 4 int dx / sqrt(2 (1 - x^3))."""
    text = LINE.format(initial=1, velocity=0, potential="((p.x)**2)**1.5")
    period = 4 * mpmath.quad(lambda x: 1 / mpmath.sqrt(2 * (1 - x**3)), [0, 0.5, 1])
    motion = follow(text, 10 * float(period), 11)
    assert motion.outcome.ending is Ending.COMPLETE
    assert np.max(np.abs(motion["q/x"] - 1)) <= 1e-11
    assert motion.outcome.h_drift <= 1e-12


@pytest.mark.exhaustive(keep=0.8)
def test_two_kinks_in_a_plane():
    text = """
        coordinates: {x: {initial: 1.7, velocity: 0.3}, y: {initial: 0.2, velocity: 0.1}}
        masses: {p: 1}
        embedding: {p: [x, y]}
        potential: sqrt((x - 1)**2) + sqrt((y + x)**2) + 0.1*y**2
        """
    motion = follow(text, 50.0, 501)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion.outcome.h_drift <= 1e-11


@pytest.mark.exhaustive(keep=0)
def test_what_is_sampled_changes_nothing():
    """More samples than are handed over at once, and few: the same motion through the same kinks."""
    text = LINE.format(initial=1.3, velocity=0.1, potential="sqrt((p.x - 0.5)**2) + x**4/4")
    few, many = follow(text, 16.0, 129), follow(text, 16.0, 2**17 + 1)
    assert few.outcome.steps == many.outcome.steps
    for name in ("q/x", "v/x"):
        np.testing.assert_array_equal(few[name], many[name][::1024])


def test_friction_that_is_written_as_a_quotient_holds_as_well():
    """Dry friction brings a body to rest where the other force is smaller: there it stays."""
    text = """
        coordinates: {x: {initial: 1.7, velocity: 0.3}}
        masses: {p: 1}
        embedding: {p: [x]}
        potential: 0.01*p.x**2
        generalized_forces: {x: -0.2*x_dot/sqrt(x_dot**2)}
        """
    motion = follow(text, 50.0, 501)
    assert motion.outcome.ending is Ending.COMPLETE
    # x'' = -(0.2 + 0.02 x): the amplitude about x = -10 is reached
    amplitude = math.hypot(1.7 + 10, 0.3 / math.sqrt(0.02))
    assert math.isclose(motion["q/x"][-1], amplitude - 10, rel_tol=1e-14)
    assert abs(motion["v/x"][-1]) <= 1e-15


def test_a_pole_between_two_steps_is_no_kink():
    """1/x^2 so weak that it moves nothing until it is met head-on: repelled, with the same energy."""
    text = LINE.format(initial=1, velocity=-1, potential="1e-12/p.x**2")
    motion = follow(text, 3.0, 301)
    assert motion.outcome.ending is Ending.COMPLETE
    assert np.min(motion["q/x"]) > 0
    assert motion.outcome.h_drift <= 1e-9
    assert math.isclose(motion["q/x"][-1], 2.0, rel_tol=1e-5)


def test_a_collision_is_no_kink():
    text = LINE.format(initial=1, velocity=-1, potential="-1e-9/sqrt(p.x**2)")
    motion = follow(text, 3.0, 301)
    assert motion.outcome.ending is Ending.STEP_UNDERFLOW
    assert math.isclose(motion.outcome.t, 1.0, rel_tol=1e-6)


def test_what_is_nothing_but_rounding_holds_nothing_up():
    text = LINE.format(initial=0, velocity=0, potential="-p.x*(exp(t)*exp(-t) - 1) + p.x**2")
    motion = follow(text, 50.0, 501)
    assert motion.outcome.ending is Ending.COMPLETE
    assert np.max(np.abs(motion["q/x"])) <= 1e-13


@pytest.mark.parametrize("stop", [1e3, 1e12, 1e30])
def test_a_wall_is_met_however_long_the_step_is(stop):
    """A free motion has no series to end its steps: the first one goes to the end."""
    motion = follow(LINE.format(initial=0, velocity=1, potential="8*max(p.x - 1, 0)**2"), stop, 3)
    gone = stop - 1 - math.pi / 4  # half a period of w = 4 in the wall
    assert abs(motion["q/x"][-1] / (1 - gone) - 1) <= 1e-14
    assert motion.outcome.h_drift <= 1e-14


@pytest.mark.parametrize("height", ["abs(x - 1)", "2*max(x, 1) - x", "where(x > 1, x - 1, 1 - x)"])
def test_what_is_observed_at_a_kink_of_a_position_does_not_jump_there(height):
    """T = v^2 on both sides of x = 1, where a sample lies; so it is there, although sign(0) is 0."""
    text = f"""
        coordinates: {{x: {{initial: 0, velocity: 1}}}}
        masses: {{p: 1}}
        embedding: {{p: [x, {height}]}}
        """
    motion = follow(text, 2.0, 5)
    assert motion.t[2] == 1
    assert motion["q/x"][2] == 1
    assert motion.outcome.h_drift == 0
    assert np.max(np.abs(motion["diagnostics/p/x"] - 2)) <= 1e-15


FORCED = """
name: a forced point
coordinates:
  x: {{initial: {initial}, velocity: {velocity}}}
lagrangian: x_dot**2/2
generalized_forces: {{x: "{force}"}}
"""


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    "force",
    [
        "1/abs(t - {c})",
        "1/sqrt(abs(t - {c}))",
        "sign(t - {c})*abs(t - {c})**(-0.4)",
        "where(t > {c}, 1/(t - {c}), 0)",
        "1/(abs(2*x - 2*{c})**0.7)",
        "-1/abs(x_dot - 1 + {c})",
    ],
)
def test_a_motion_ends_where_a_force_beside_a_switch_grows_beyond_all_bounds(force):
    c = random.Random().uniform(0.2, 0.9)
    print("c =", c)
    motion = follow(FORCED.format(initial=0, velocity=1, force=force.format(c=c)), 5.0, 2)
    assert motion.outcome.ending is not Ending.COMPLETE
    assert motion.outcome.t < 5.0


@pytest.mark.exhaustive(keep=0.25)
def test_a_force_that_begins_beyond_all_bounds_ends_the_motion_without_a_warning_of_numpy():
    motion = follow(FORCED.format(initial=0, velocity=1, force="where(t > 0.5, 1/(t - 0.5), 0)"), 5.0, 2)
    assert motion.outcome.ending is Ending.STEP_UNDERFLOW and motion.outcome.t == 0.5


def test_a_force_that_grows_like_a_logarithm_is_followed_to_rounding():
    c = random.Random().uniform(0.2, 0.9)
    print("c =", c)
    motion = follow(FORCED.format(initial=0, velocity=0, force=f"log(abs(t - {c}))"), 5.0, 11)
    assert motion.outcome.ending is Ending.COMPLETE

    def twice(u: float) -> float:  # the second integral of log|u|
        return u * u * math.log(abs(u)) / 2 - 3 * u * u / 4 if u else 0.0

    slope = -c * math.log(c) + c  # of twice, at -c
    expected = [twice(t - c) - twice(-c) - slope * t for t in motion.t]
    assert np.max(np.abs(motion["q/x"] - expected)) <= 1e-13


@pytest.mark.exhaustive(keep=0.7)
@pytest.mark.parametrize(
    "force", ["tan(a*t)", "1/cos(a*t)", "1/abs(cos(a*t))", "x*tan(a*t)**2", "1/cos(a*t)**3"]
)
def test_a_motion_ends_at_a_pole_in_time_that_is_no_double(force):
    a = random.Random().uniform(0.5, 2.0)
    print("a =", repr(a))
    motion = follow(FORCED.format(initial=1, velocity=0, force=force.replace("a*", f"{a!r}*")), 5.0, 2)
    assert motion.outcome.ending is not Ending.COMPLETE
    assert motion.outcome.t == pytest.approx(math.pi / 2 / a, rel=1e-12)


WAVES = {
    "asin(sin({w}*t))": lambda u: mpmath.asin(mpmath.sin(u)),
    "acos(cos({w}*t))": lambda u: mpmath.acos(mpmath.cos(u)),
    "asin(2*sin({w}*t/2)*cos({w}*t/2))": lambda u: mpmath.asin(mpmath.sin(u)),
    "acos(1 - 2*sin({w}*t/2)**2)": lambda u: mpmath.acos(mpmath.cos(u)),
    "asin(2*({w}*t - 3)/(1 + ({w}*t - 3)**2))": lambda u: mpmath.asin(2 * (u - 3) / (1 + (u - 3) ** 2)),
    "sqrt(1 - sin({w}*t))": lambda u: mpmath.sqrt(1 - mpmath.sin(u)),
    "sqrt(abs(sin({w}*t)))": lambda u: mpmath.sqrt(abs(mpmath.sin(u))),
}
"""Forces of the time with kinks at multiples of a quarter period, or at u = 2 and u = 4."""


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("force", WAVES)
def test_triangle_waves_are_followed_to_rounding_however_they_are_written(force, request):
    w = round(random.Random(request.config.option.seed).uniform(1, 3), 4)
    print("w =", w)
    motion = follow(FORCED.format(initial=0, velocity=0, force=force.format(w=w)), 5.0, 2)
    assert motion.outcome.ending is Ending.COMPLETE
    with mpmath.workdps(25):
        kinks = sorted(
            {*(k * mpmath.pi / (2 * mpmath.mpf(w)) for k in range(40)), *(mpmath.mpf(k) / w for k in (2, 4))}
        )
        places = [k for k in kinks if k < 5] + [mpmath.mpf(5)]
        wave = WAVES[force]
        x = mpmath.quad(lambda t: (5 - t) * wave(w * t), places)
        v = mpmath.quad(lambda t: wave(w * t), places)
    assert abs(motion["q/x"][-1] - x) <= 1e-13 * (1 + abs(x))
    assert abs(motion["v/x"][-1] - v) <= 1e-13 * (1 + abs(v))


def test_a_potential_with_arccosines_has_wedges_and_passes_them():
    """U = acos(cos(x)) is |x| up to |x| = pi, where its slope turns round."""
    text = LINE.format(initial=0, velocity=3, potential="acos(cos(p.x))")
    motion = follow(text, 10.0, 101)
    up = (3 - math.sqrt(9 - 2 * math.pi)) / 1  # x = 3 t - t^2/2 to pi, and down as long
    left = np.mod(motion.t, 2 * up)
    rise = np.minimum(left, 2 * up - left)
    within = 3 * rise - rise**2 / 2
    place = 2 * math.pi * np.floor(motion.t / (2 * up)) + np.where(left <= up, within, 2 * math.pi - within)
    assert motion.outcome.ending is Ending.COMPLETE
    assert np.max(np.abs(motion["q/x"] - place)) <= 1e-12
    assert motion.outcome.h_drift <= 1e-14
    assert motion.outcome.steps <= 25


@pytest.mark.exhaustive(keep=0.65)
@pytest.mark.parametrize("sign", [1, -1])
def test_roots_of_the_place_and_of_the_time_begin_together(sign):
    """x = sign t^3: x'' = 6 t + c t^1.5 - c sqrt(x), to either side of 0."""
    c = random.uniform(0.5, 3.0)
    text = f"""
        coordinates: {{x: {{initial: 0}}}}
        masses: {{p: 1}}
        embedding: {{p: x}}
        potential: 2/3*{c!r}*abs(x)**1.5 - {sign}*x*(6*t + {c!r}*max(0, t)**1.5)
    """
    motion = follow(text, 2.0, 3)
    assert motion.outcome.ending is Ending.COMPLETE
    np.testing.assert_allclose(motion["q/x"], sign * motion.t**3, atol=1e-9)


def test_a_constraint_keeps_away_from_a_kink_at_all_times() -> None:
    """A length that changes with t is never 0: |r| has a kink there alone."""
    text = """
coordinates: {COORDINATES}
masses: {bob: 1}
positions: {bob: "(POSITION)"}
potential: 9.81*bob.y
constraints: {rod: norm(bob) - 1 - 0.1*sin(2*t)}
observables: {right: bob.x, up: bob.y}
"""
    found = []
    for coordinates, position in (
        ("r: {initial: 1}, a: {initial: 0.4}", "r*cos(a), r*sin(a)"),
        ("x: {initial: cos(0.4)}, y: {initial: sin(0.4)}", "x, y"),
    ):
        given = text.replace("COORDINATES", coordinates).replace("POSITION", position)
        motion = lagrange.solve(given, stop=3, samples=13, outputs="observables")
        found.append([motion.datasets[f"observables/{one}"][:] for one in ("right", "up")])
    assert np.array(found[0]) == pytest.approx(np.array(found[1]), abs=1e-10)
