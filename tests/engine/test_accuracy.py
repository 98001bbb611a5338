"""Motions at the default tolerance against closed forms, conservation laws and other coordinates.

Steps are counted as well, so that accuracy is not bought with work.
"""

import math
from itertools import pairwise

import mpmath
import numpy as np
import pytest

from tests.engine.motion import solve

mpmath.mp.dps = 30


def relative(found, reference, size=None):
    """The largest difference, relative to the size of the motion."""
    reference = np.array([float(x) for x in reference])
    return np.max(np.abs(found - reference)) / (np.max(np.abs(reference)) if size is None else size)


def test_pendulum_from_170_degrees_against_jacobis_elliptic_functions():
    start = 170 * math.pi / 180
    k = mpmath.sin(mpmath.mpf(start) / 2)
    omega = mpmath.sqrt(mpmath.mpf(9.81))
    period = 4 * mpmath.ellipk(k**2) / omega
    motion = solve("pendulum", float(100 * period), 301, theta=start, theta_dot=0, g=9.81, l=1, m=1)
    reference = []
    for t in motion["t"]:
        u = mpmath.fmod(mpmath.mpf(float(t)), period) * omega
        cd = mpmath.ellipfun("cn", u, m=k**2) / mpmath.ellipfun("dn", u, m=k**2)
        reference.append(2 * mpmath.asin(k * cd))
    assert relative(motion["q/theta"], reference, start) <= 1e-11
    assert motion.outcome.steps <= 60 * 100


def test_rod_against_cosh():
    motion = solve("rotating_rod", 10.0, omega=1)
    r, rate = motion.q[0], motion.v[0]
    reference = [
        r * mpmath.cosh(mpmath.mpf(float(t))) + rate * mpmath.sinh(mpmath.mpf(float(t))) for t in motion["t"]
    ]
    errors = np.abs(motion["q/r"] / np.array([float(x) for x in reference]) - 1)
    assert np.max(errors) <= 1e-12
    assert motion.outcome.steps <= 20


@pytest.mark.parametrize("system", ["harmonic_oscillator", "gauge_oscillator"])
def test_oscillator_over_1000_periods(system):
    motion = solve(system, 1000 * 2 * math.pi / 2.0, 2001, k=4, m=1, x=1, x_dot=0.5)
    reference = [
        mpmath.cos(2 * mpmath.mpf(float(t))) + mpmath.sin(2 * mpmath.mpf(float(t))) / 4 for t in motion["t"]
    ]
    assert relative(motion["q/x"], reference) <= 1e-11
    assert motion.outcome.steps <= 7000


def test_atwood_and_incline_are_one_exact_step():
    motion = solve("atwood", 3.0)
    m1, m2, g = (motion.parameters[name] for name in ("m1", "m2", "g"))
    rate = (m1 - m2) * g / (m1 + m2)
    assert (
        relative(motion["q/x"], motion.q[0] + motion.v[0] * motion["t"] + rate * motion["t"] ** 2 / 2)
        <= 1e-14
    )
    assert motion.outcome.steps == 1
    motion = solve("incline", 3.0)
    rate = motion.parameters["g"] * math.sin(motion.parameters["alpha"])
    assert (
        relative(motion["q/s"], motion.q[0] + motion.v[0] * motion["t"] + rate * motion["t"] ** 2 / 2)
        <= 1e-14
    )


def test_cyclotron_motion():
    motion = solve("charged_particle", 200.0, 2001, outputs="q,v,h,p")
    p = motion.parameters
    frequency = p["e"] * p["B"] / p["m"]
    speed = np.hypot(motion["v/x"], motion["v/y"])
    assert np.max(np.abs(speed / speed[0] - 1)) <= 1e-13
    phase = np.unwrap(np.arctan2(motion["v/y"], motion["v/x"]))
    assert np.max(np.abs(phase - phase[0] + frequency * motion["t"])) <= 1e-11 * abs(frequency) * 200
    assert np.array_equal(motion["v/z"], np.full(2001, motion.v[2]))


def test_kepler_comes_back_after_100_periods():
    motion = solve("central_force_cartesian", 200 * math.pi, 3)
    names = ("x", "y")
    for name, start, rate in zip(names, motion.q, motion.v):
        assert abs(motion[f"q/{name}"][-1] - start) <= 1e-10
        assert abs(motion[f"v/{name}"][-1] - rate) <= 1e-10
    assert motion.outcome.steps <= 60 * 100


def test_kepler_is_the_same_in_polar_coordinates():
    polar = solve("central_force", 200 * math.pi, 2001)
    cartesian = solve("central_force_cartesian", 200 * math.pi, 2001)
    assert np.max(np.abs(polar["q/r"] - np.hypot(cartesian["q/x"], cartesian["q/y"]))) <= 1e-11
    assert polar.outcome.p_drift["theta"] <= 1e-13


def test_gauge_oscillator_moves_as_the_plain_one():
    plain = solve("harmonic_oscillator", 50.0, k=4, m=1, x=1, x_dot=0)
    gauge = solve("gauge_oscillator", 50.0, k=4, m=1, x=1, x_dot=0)
    assert np.max(np.abs(plain["q/x"] - gauge["q/x"])) <= 1e-13


@pytest.mark.parametrize(
    ("system", "bound", "steps"),
    [("pendulum", 1e-13, 14000), ("rotating_hoop", 1e-13, 40000), ("double_pendulum", 5e-12, 60000)],
)
def test_drift_of_h_over_1000_seconds(system, bound, steps):
    motion = solve(system, 1000.0, 5001)
    assert motion.outcome.h_drift <= bound * abs(motion["diagnostics/h"][0])
    assert motion.outcome.steps <= steps


def test_the_hoop_conserves_h_and_not_t_plus_u():
    motion = solve("rotating_hoop", 20.0, outputs="q,v,h,energy,T,U")
    assert motion.outcome.h_drift <= 1e-13 * abs(motion["diagnostics/h"][0])
    energy = motion["diagnostics/energy"]
    assert np.max(np.abs(energy - energy[0])) > 0.01
    assert np.array_equal(energy, motion["diagnostics/T"] + motion["diagnostics/U"])


@pytest.mark.parametrize(
    ("system", "stop"),
    [
        ("driven_damped_pendulum", 100.0),
        ("rotating_rod", 10.0),
        ("double_pendulum", 50.0),
        ("rotating_hoop", 50.0),
    ],
)
def test_ledgers_close(system, stop):
    motion = solve(system, stop, outputs="q,v,p,h,ledger")
    ledgers = [path for path in motion.series if "ledger" in path]
    assert len(ledgers) == 1 + len(motion.q)
    for path in ledgers:
        quantity = motion[path.replace("ledger/", "")]
        size = max(np.max(np.abs(quantity)), 1e-3)
        if system == "rotating_rod" and path.endswith("/h"):
            size = np.max(motion["v/r"] ** 2)  # h is the small difference of two large energies
        assert np.max(np.abs(motion[path])) <= 1e-11 * size, path


def test_a_driven_pendulum_does_not_keep_h():
    motion = solve("driven_damped_pendulum", 60.0)
    assert motion.outcome.h_drift is None
    h = motion["diagnostics/h"]
    assert np.max(np.abs(h - h[0])) > 0.1


def test_action_of_free_fall():
    text = (
        "parameters: {m: 2, g: 3}\ncoordinates: {z: {initial: 1, velocity: 4}}\n"
        "masses: {p: m}\nembedding: {p: z}\npotential: m*g*z\n"
    )
    motion = solve(text, 2.0, outputs="q,action")
    t = motion["t"]
    lagrangian = np.polynomial.Polynomial([4, -3]) ** 2 - 2 * 3 * np.polynomial.Polynomial([1, 4, -1.5])
    assert np.max(np.abs(motion["diagnostics/action"] - lagrangian.integ()(t))) <= 1e-13


def test_quadratures_do_not_change_the_motion():
    plain = solve("driven_damped_pendulum", 20.0)
    ledger = solve("driven_damped_pendulum", 20.0, outputs="q,v,ledger,action")
    assert plain.outcome.steps == ledger.outcome.steps
    assert np.max(np.abs(plain["q/theta"] - ledger["q/theta"])) <= 1e-13


def test_the_taylor_method_reaches_its_tolerance():
    """Measured: the error of one Kepler orbit falls with the tolerance, about in proportion."""
    errors = []
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12):
        motion = solve("central_force_cartesian", 2 * math.pi, 3, tolerance=tolerance)
        errors.append(abs(motion["q/x"][-1] - motion.q[0]) + abs(motion["q/y"][-1]))
        assert motion.outcome.steps <= 70  # the order grows with the digits, not the steps
        assert errors[-1] <= 300 * tolerance
    assert all(fine < coarse / 5 for coarse, fine in pairwise(errors))


@pytest.mark.parametrize("method", ["DOP853", "Radau", "BDF", "LSODA"])
def test_scipys_methods_agree(method):
    reference = solve("driven_damped_pendulum", 5.0, outputs="q,v,ledger")
    other = solve("driven_damped_pendulum", 5.0, outputs="q,v,ledger", method=method, tolerance=1e-8)
    for path in ("q/theta", "v/theta"):
        assert np.max(np.abs(reference[path] - other[path])) <= 2e-5
    assert np.max(np.abs(other["diagnostics/ledger/h"])) <= 1e-4
    assert other.outcome.evaluations > other.outcome.steps > 5
