"""The reference against closed forms, and where it ends: runs made by hand part or stop at known times."""

from __future__ import annotations

from functools import partial

import mpmath
import numpy as np
import pytest

from lagrange_cli.errors import MotionError
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.outcome import Outcome
from lagrange_cli.work_precision.reference import (
    ROUNDING,
    TOLERANCES,
    find_reference,
    round_down,
    running_sizes,
)
from lagrange_cli.work_precision.trajectory import SAMPLES, Trajectory, evenly, follow
from tests.support.motion import DIGITS, prepared, samples_of, values_of


def reference_of(system, stop, good=1e-11, **sets):
    values = values_of(system, sets)
    ready = [prepared(system, tolerance=tolerance) for tolerance in TOLERANCES]

    def run(ready, times):
        return follow(ready, values, times, 60.0, lambda: False)

    return find_reference(
        [partial(run, each) for each in ready], 0.0, stop, good, ready[0].recording.coordinates
    )


def error_of(reference, column, exact):
    """The error beside a closed form, relative to the size, to many digits."""
    times = reference.times.chunk(0, SAMPLES)
    known = samples_of(exact, times)
    apart = max(abs(mpmath.mpf(float(x)) - y) for x, y in zip(reference.q[:, column], known))
    return float(apart / max(map(abs, known)))


@pytest.mark.exhaustive(keep=0.65)
def test_an_oscillator_is_known_to_the_doubles_it_is_kept_in():
    reference = reference_of("harmonic_oscillator", 20.0)
    assert reference.times.stop == 20.0 and reference.reason == ""
    error = error_of(reference, 0, lambda t: mpmath.cos(2 * t))
    assert error <= 2 * reference.error and reference.error < 1e-15


@pytest.mark.exhaustive(keep=0.15)
def test_a_kepler_ellipse_is_known_as_well_as_the_reference_says():
    """r = a (1 - e cos E) and theta = E + 2 atan(e sin E / (1 + sqrt(1 - e^2) - e cos E)), where
    E - e sin E = t/sqrt(a^3), of the ellipse that the doubles of the initial state begin."""
    reference = reference_of("central_force", 20.0)
    values = values_of("central_force")
    with mpmath.workdps(DIGITS):
        r, speed = mpmath.mpf(values.q[0]), mpmath.mpf(values.q[0]) * mpmath.mpf(values.v[1])
        a = 1 / (2 / r - speed**2)
        e = 1 - r / a

    def anomaly(t):
        mean = t / mpmath.sqrt(a**3)
        return mpmath.findroot(lambda E: E - e * mpmath.sin(E) - mean, mean + e * mpmath.sin(mean), tol=1e-60)

    def theta(t):
        E = anomaly(t)
        return E + 2 * mpmath.atan2(e * mpmath.sin(E), 1 + mpmath.sqrt(1 - e**2) - e * mpmath.cos(E))

    # the three motions have one momentum, whose square is rounded: that they do not show
    assert error_of(reference, 0, lambda t: a * (1 - e * mpmath.cos(anomaly(t)))) <= 4 * reference.error
    assert error_of(reference, 1, theta) <= 4 * reference.error
    assert reference.error < 1e-13


@pytest.mark.exhaustive(keep=0.3)
def test_a_pendulum_near_its_top_is_known_less_well_and_the_reference_says_so():
    """sin(theta/2) = k cd(w t) with k = sin(theta0/2) (DLMF 22.19.2)."""
    reference = reference_of("pendulum", 20.0)
    values = values_of("pendulum")
    with mpmath.workdps(DIGITS):
        w = mpmath.sqrt(mpmath.mpf(values.parameters["g"]) / mpmath.mpf(values.parameters["l"]))
        k = mpmath.sin(mpmath.mpf(values.q[0]) / 2)
        period = 4 * mpmath.ellipk(k**2) / w

    def theta(t):
        return 2 * mpmath.asin(k * mpmath.ellipfun("cd", w * mpmath.fmod(t, period), m=k**2))

    error = error_of(reference, 0, theta)
    assert error <= 2 * reference.error < 1e-12
    assert reference.error > 10 * ROUNDING


@pytest.mark.exhaustive(keep=0.4)
def test_the_reference_of_a_chaotic_motion_ends_where_it_is_not_known():
    reference = reference_of("double_pendulum", 60.0)
    assert 5 < reference.times.stop < 15 and reference.asked == 60
    assert reference.error <= 1.0001e-11
    assert reference.reason == "the error of the reference exceeds 1e-11 beyond this time"
    assert reference_of("double_pendulum", 60.0, good=1e-9).times.stop > reference.times.stop


def by_hand(function, ending=Ending.COMPLETE, until=np.inf):
    """A run whose q is ``function(t)`` (samples, coordinates), and that ends at a time."""

    def run(times):
        t = times.chunk(0, SAMPLES)
        reached = t[t <= until]
        early = len(reached) < SAMPLES
        outcome = Outcome(
            ending if early else Ending.COMPLETE, f"{ending.value}, t = {until:g}", t[-1], 7, 7, None, {}
        )
        return Trajectory(function(reached), outcome, 0.0)

    return run


def circle(t):
    return np.stack([np.cos(t), np.sin(t)], axis=1)


@pytest.mark.parametrize("good", [1e-12, 1e-9, 1e-6])
def test_it_ends_where_two_runs_have_parted_by_what_is_allowed(good):
    """They part as 1e-15 exp(2 t); q is of size 1."""

    def parting(t):
        return circle(t) + 1e-15 * np.exp(2 * np.minimum(t, 100))[:, None]

    reference = find_reference([by_hand(circle), by_hand(parting)], 0.0, 1000.0, good, ["x", "x"])
    end = np.log(good / 1e-15) / 2
    assert 0.85 * end < reference.times.stop <= 1.001 * end
    assert reference.error <= 1.001 * good
    assert reference.times.count == SAMPLES == len(reference.q)
    assert reference.asked == 1000.0


def test_it_ends_before_the_motion_does_and_says_why():
    singular = by_hand(circle, Ending.STEP_UNDERFLOW, until=3.456)
    reference = find_reference([by_hand(circle), singular], 0.0, 10.0, 1e-9, ["x", "x"])
    assert reference.times.stop == pytest.approx(3.4)
    assert reference.reason == f"{Ending.STEP_UNDERFLOW.value}, t = 3.456"
    late = by_hand(circle, Ending.INTERRUPTED, until=3.456)
    reference = find_reference([late, by_hand(circle)], 0.0, 10.0, 1e-9, ["x", "x"])
    assert reference.reason == "computing the reference further would exceed --budget"


def test_a_motion_that_cannot_be_known_at_all_is_refused():
    missing = "no reference solution to compare with: the error of the reference exceeds 1e-09"
    with pytest.raises(MotionError, match=missing):
        find_reference([by_hand(circle), by_hand(lambda t: circle(t) + 1e-3)], 0.0, 10.0, 1e-9, ["x", "x"])
    nowhere = by_hand(circle, Ending.SINGULAR_MASS_MATRIX, until=0.0)
    with pytest.raises(MotionError, match="singular mass matrix"):
        find_reference([nowhere, nowhere], 0.0, 10.0, 1e-9, ["x", "x"])


def test_coordinates_of_one_group_have_one_size_and_those_at_rest_no_error():
    q = np.array([[1.0, -0.5, 0.0], [-4.0, 2.0, 0.0], [0.5, 3.0, 0.0]])
    assert running_sizes(q, ["a", "a", "z"]).tolist() == [[1, 1, 0], [4, 4, 0], [4, 4, 0]]
    assert running_sizes(q, ["a", "b", "z"]).tolist() == [[1, 0.5, 0], [4, 2, 0], [4, 3, 0]]

    def resting(t):
        return np.column_stack([circle(t), np.zeros_like(t)])

    reference = find_reference([by_hand(resting)] * 2, 0.0, 6.0, 1e-9, ["x", "x", "z"])
    assert reference.error == ROUNDING and reference.error_of(reference.q) == 0
    assert reference.error_of(reference.q + np.array([0.0, 1e-4, 0.0])) == pytest.approx(1e-4, rel=1e-4)
    assert reference.error_of(reference.q + np.array([0.0, 0.0, 1e-12])) == np.inf


@pytest.mark.parametrize(
    ("duration", "rounded"), [(8.4499, 8.4), (8.4, 8.4), (123.0, 120.0), (0.01239, 0.012)]
)
def test_durations_are_rounded_down_to_two_digits(duration, rounded):
    assert round_down(duration) == pytest.approx(rounded, rel=1e-12)


def test_sample_times_include_both_ends():
    t = evenly(1.0, 3.0).chunk(0, SAMPLES)
    assert (len(t), t[0], t[-1]) == (SAMPLES, 1.0, 3.0)
