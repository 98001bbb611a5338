"""Motions whose solution is known in closed form, at the default tolerance.

Errors are relative to the size of the motion, and closed forms are evaluated to 40 digits at the
parameters' own doubles. Steps are counted too, since accuracy is cheap when bought by many.
"""

from __future__ import annotations

from itertools import pairwise

import mpmath
import numpy as np
import pytest

from tests.support.motion import DIGITS, error, follow, samples_of, values_of


def parameters(system: str) -> dict[str, mpmath.mpf]:
    """The parameters' doubles as numbers of many digits."""
    return {name: mpmath.mpf(value) for name, value in values_of(system).parameters.items()}


def test_pendulum_from_170_degrees_follows_jacobis_functions_for_100_periods() -> None:
    """sin(theta/2) = k cd(w t) with k = sin(theta0/2); the period is 4 K(k)/w (DLMF 22.19.2)."""
    known = parameters("pendulum")
    theta0 = 170 * np.pi / 180
    with mpmath.workdps(DIGITS):
        w = mpmath.sqrt(known["g"] / known["l"])
        k = mpmath.sin(mpmath.mpf(theta0) / 2)
        period = 4 * mpmath.ellipk(k**2) / w

    def theta(t: mpmath.mpf) -> mpmath.mpf:
        u = w * mpmath.fmod(t, period)
        return 2 * mpmath.asin(k * mpmath.ellipfun("cd", u, m=k**2))

    motion = follow("pendulum", float(100 * period), 211, sets={"theta": theta0, "theta_dot": 0})
    assert error(motion["q/theta"], samples_of(theta, motion.t)) < 1e-11
    assert 100 < motion.outcome.steps <= 6000


def test_rotating_rod_follows_cosh_over_10_radians() -> None:
    known = parameters("rotating_rod")
    omega, r0, v0 = known["omega"], mpmath.mpf(0.1), mpmath.mpf(0.02)
    motion = follow("rotating_rod", float(10 / omega), 301, sets={"r": 0.1, "r_dot": 0.02})
    exact = samples_of(lambda t: r0 * mpmath.cosh(omega * t) + v0 / omega * mpmath.sinh(omega * t), motion.t)
    relative = [abs(mpmath.mpf(x) / y - 1) for x, y in zip(motion["q/r"], exact, strict=True)]
    assert max(relative) < 1e-12  # of r itself, which grows ten thousandfold, not of the largest r
    assert 2 < motion.outcome.steps < 20


def test_atwood_weights_fall_with_a_constant_acceleration() -> None:
    known = parameters("atwood")
    a = (known["m1"] - known["m2"]) * known["g"] / (known["m1"] + known["m2"])
    motion = follow("atwood", 20.0, sets={"x": 1.0, "x_dot": -0.3})
    v = mpmath.mpf(-0.3)
    assert error(motion["q/x"], samples_of(lambda t: 1 + v * t + a * t**2 / 2, motion.t)) < 1e-14
    assert error(motion["v/x"], samples_of(lambda t: v + a * t, motion.t)) < 1e-14
    assert motion.outcome.steps == 1  # a polynomial is its own Taylor series


def test_block_slides_down_the_incline_with_g_sin_alpha() -> None:
    known = parameters("incline")
    with mpmath.workdps(DIGITS):
        a = known["g"] * mpmath.sin(known["alpha"])
    motion = follow("incline", 5.0)
    assert error(motion["q/s"], samples_of(lambda t: a * t**2 / 2, motion.t)) < 1e-14
    assert motion.outcome.steps == 1


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("system", ["harmonic_oscillator", "gauge_oscillator"])
def test_oscillators_stay_in_phase_for_1000_periods(system: str) -> None:
    """The gauge term dF/dt changes p and h, not the motion."""
    known = parameters(system)
    with mpmath.workdps(DIGITS):
        w = mpmath.sqrt(known["k"] / known["m"])
    x0, v0 = mpmath.mpf(0.7), mpmath.mpf(-1.1)
    motion = follow(system, float(2000 * mpmath.pi / w), 1501, sets={"x": 0.7, "x_dot": -1.1})
    exact = samples_of(lambda t: x0 * mpmath.cos(w * t) + v0 / w * mpmath.sin(w * t), motion.t)
    assert error(motion["q/x"], exact) < 1e-11
    assert 200 < motion.outcome.steps <= 7000


@pytest.mark.exhaustive(keep=0.8)
def test_charge_in_a_magnetic_field_circles_at_the_cyclotron_frequency() -> None:
    """x' + i y' turns with -e B/m, z' stays."""
    known = parameters("charged_particle")
    start = {"x": 0.3, "y": -0.2, "z": 0.1, "x_dot": 1.0, "y_dot": 0.5, "z_dot": 0.25}
    with mpmath.workdps(DIGITS):
        w = known["e"] * known["B"] / known["m"]
        r0, v0 = mpmath.mpc(0.3, -0.2), mpmath.mpc(1.0, 0.5)

    def place(t: mpmath.mpf) -> mpmath.mpc:
        return r0 + v0 * (1 - mpmath.expj(-w * t)) / (1j * w)

    motion = follow("charged_particle", 200.0, 501, sets=start)
    exact = samples_of(place, motion.t)
    assert error(motion["q/x"], [r.real for r in exact]) < 1e-12
    assert error(motion["q/y"], [r.imag for r in exact]) < 1e-12
    assert error(motion["q/z"], samples_of(lambda t: mpmath.mpf(0.1) + t / 4, motion.t)) < 1e-14
    assert motion.outcome.steps < 500


@pytest.mark.exhaustive(keep=0.55)
def test_kepler_ellipse_of_eccentricity_06_closes_after_100_periods() -> None:
    start = {"r": 0.4, "r_dot": 0.0, "theta": 0.0, "theta_dot": 5.0}  # (r theta')^2 = 4 = mu (1+e)/(a(1-e))
    motion = follow("central_force", 200 * np.pi, 101, sets=start)
    assert abs(motion["q/r"] - 0.4).max() < 1e-10
    assert abs(motion["q/theta"] - 2 * np.pi * np.arange(101)).max() < 1e-10 * 200 * np.pi
    assert abs(motion["v/r"][-1]) < 1e-10
    start = {"x": 0.4, "x_dot": 0.0, "y": 0.0, "y_dot": 2.0}
    other = follow("central_force_cartesian", 200 * np.pi, 101, sets=start)
    for path, first in {"q/x": 0.4, "q/y": 0.0, "v/x": 0.0, "v/y": 2.0}.items():
        assert abs(other[path][-1] - first) < 1e-10
    assert max(motion.outcome.steps, other.outcome.steps) <= 6000


def test_kepler_places_satisfy_keplers_equation() -> None:
    """r = a (1 - e cos E) with E - e sin E = t: right between the apsides, not only there."""
    start = {"r": 0.4, "r_dot": 0.0, "theta": 0.0, "theta_dot": 5.0}
    motion = follow("central_force", 20 * np.pi, 60, sets=start)
    e = mpmath.mpf(3) / 5

    def radius(t: mpmath.mpf) -> mpmath.mpf:
        anomaly = mpmath.findroot(lambda E: E - e * mpmath.sin(E) - t, t)
        return 1 - e * mpmath.cos(anomaly)

    assert error(motion["q/r"], samples_of(radius, motion.t)) < 1e-12


def test_kepler_has_the_same_r_in_cartesian_and_polar_coordinates() -> None:
    polar = follow("central_force", 200 * np.pi, 2001)
    cartesian = follow("central_force_cartesian", 200 * np.pi, 2001)
    r = np.hypot(cartesian["q/x"], cartesian["q/y"])
    assert abs(r - polar["q/r"]).max() < 1e-11
    assert np.ptp(r) == pytest.approx(1.2, rel=1e-3)


def test_gauge_transformation_leaves_the_motion_and_changes_the_momentum() -> None:
    plain, gauge = follow("harmonic_oscillator", 100.0, 401), follow("gauge_oscillator", 100.0, 401)
    assert abs(plain["q/x"] - gauge["q/x"]).max() < 1e-12
    assert abs(plain["diagnostics/p/x"] - gauge["diagnostics/p/x"]).max() > 0.1
    assert plain.outcome.h_drift is not None
    assert gauge.outcome.h_drift is None  # L contains t


def test_conical_pendulum_keeps_its_angle_and_its_rate() -> None:
    """phi' = sqrt(g/(l cos(theta))): theta's own rate is nothing but rounding, and must not set the step."""
    known = parameters("spherical_pendulum")
    with mpmath.workdps(DIGITS):
        rate = float(mpmath.sqrt(known["g"] / (known["l"] * mpmath.cos(1))))
    start = {"theta": 1.0, "theta_dot": 0.0, "phi": 0.0, "phi_dot": rate}
    motion = follow("spherical_pendulum", 100.0, 201, sets=start)
    assert abs(motion["q/theta"] - 1.0).max() < 1e-12
    assert abs(motion["q/phi"] / rate - motion.t).max() < 1e-12 * 100
    assert motion.outcome.steps < 1000


@pytest.mark.exhaustive(keep=0.25)
def test_the_taylor_method_reaches_its_tolerance() -> None:
    """Measured: the error of one Kepler orbit falls with the tolerance, about in proportion."""
    errors = []
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12):
        motion = follow("central_force_cartesian", 2 * np.pi, 3, tolerance=tolerance)
        errors.append(abs(motion["q/x"][-1] - motion["q/x"][0]) + abs(motion["q/y"][-1]))
        assert motion.outcome.steps <= 70  # the order grows with the digits, not the steps
        assert errors[-1] <= 300 * tolerance
    assert all(fine < coarse / 5 for coarse, fine in pairwise(errors))
