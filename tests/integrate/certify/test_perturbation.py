"""What is rounded once for all, and a companion that has it rounded otherwise."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from lagrange_cli.integrate.certify.certificate import AS_RUN, FOLDER
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.method import Observer, Start
from lagrange_cli.integrate.methods.compiled import Beside
from lagrange_cli.integrate.methods.perturbation import perturb
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import replace
from tests.integrate.certify.test_certificate import Number, certified, coverage
from tests.support.motion import prepare, residual_of, values_of

SPRING = """
parameters: {m: 4.1, k: 4.2}
coordinates:
  x: {initial: 1.0}
lagrangian: m*x_dot**2/2 - k*x**2/2
"""
"""Its frequency sqrt(k/m) is off by what k/m is rounded, and so is its phase, more with every period."""

TOP = """
coordinates:
  theta: {initial: 0.6}
  phi: {initial: 0, velocity: 0.5}
  psi: {initial: 0, velocity: 9}
lagrangian: (theta_dot**2 + phi_dot**2*sin(theta)**2)/2 + (psi_dot + phi_dot*cos(theta))**2/4 - 3*cos(theta)
"""
"""Its momenta p_phi and p_psi are stored, and their products rounded once: so is how fast it nods."""


def nodding(t: float) -> Number:
    """theta of ``TOP``: cos(theta) runs to and fro between two roots of a cubic (Goldstein, eq. 5.62)."""
    u = mpmath.cos(Number(0.6))
    psi = (9 + u / 2) / 2
    phi = (1 - u**2) / 2 + psi * u
    twice = (phi - psi * u) ** 2 / (1 - u**2) + 6 * u  # twice the energy beyond that of psi
    low, high, far = sorted(
        mpmath.re(root)
        for root in mpmath.polyroots(
            [6, -(twice + psi**2), 2 * phi * psi - 6, twice - phi**2], maxsteps=200, extraprec=200
        )
    )
    name = "sn" if abs(u - low) < abs(u - high) else "cd"
    wave = mpmath.ellipfun(name, mpmath.sqrt(6 * (far - low)) / 2 * t, m=(high - low) / (far - low))
    return mpmath.acos(low + (high - low) * wave**2)


def test_only_what_may_be_rounded_is_put_off_and_by_an_ulp():
    parameters = np.array([9.81, 1.3, 0.0])
    exact = [9.81, -9.81 / 2, 2.6, 0.0, 1.0, 0.375, 12345.0, np.inf, np.nan]
    rounded = [9.81 / 1.3, 9.81 * 1.3, -(1.3**2), 1 / 3]
    momenta = np.array(exact + rounded)
    perturb(momenta, parameters)
    np.testing.assert_array_equal(momenta[: len(exact)], exact)
    off = momenta[len(exact) :] - rounded
    np.testing.assert_array_equal(np.abs(off), np.spacing(np.abs(rounded)))
    assert (off > 0).any() and (off < 0).any()


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize(("folder", "number"), [(AS_RUN, float), (FOLDER, str)])
def test_a_frequency_that_is_rounded_once_is_part_of_the_estimate(folder, number):
    data, _ = certified(SPRING, 2000.0, 801)
    with mpmath.workdps(50):
        frequency = mpmath.sqrt(Number(number("4.2")) / Number(number("4.1")))
        truth = [mpmath.cos(frequency * t) for t in data["t"]]
        assert max(abs(x - y) for x, y in zip(data["q/x"], truth)) > 1e-14
        assert coverage(data, "q/x", truth, folder) >= 0.98


@pytest.mark.exhaustive(keep=0.15)
def test_cyclic_momenta_are_part_of_the_estimate():
    data, _ = certified(TOP, 300.0, 301)
    with mpmath.workdps(50):
        truth = [nodding(t) for t in data["t"]]
        assert 1e-15 < max(abs(x - y) for x, y in zip(data["q/theta"], truth)) < 1e-13
        assert coverage(data, "q/theta", truth, AS_RUN) >= 0.99


@pytest.mark.parametrize("stop", [1e-9, 1.0, 40.0])
def test_a_companion_takes_part_of_the_first_step_and_then_usual_ones(stop):
    """Shorter than the first step or much longer, it has all the samples, and hardly more steps."""
    ready = prepare(
        residual_of(TOP), Compilation(method="taylor", tolerance=2.0**-52, outputs=frozenset({"q", "v"}))
    )
    values, times = values_of(TOP), Times(0.0, stop, 41, stop / 40)
    state = np.concatenate([values.q, values.v, np.zeros(len(ready.machine.program.integrals))])
    steps, motions = [], []
    for number in range(3):
        found = []
        keep = found.append
        method = replace(ready.follower, beside=Beside(number) if number else None)
        observer = Observer(lambda t, x, keep=keep: keep(x[:6].copy()))
        end = method.follow(Start(np.empty(0), state, times), observer)
        assert end.ending is Ending.COMPLETE
        steps.append(end.steps)
        motions.append(np.concatenate(found, axis=1))
    for motion in motions:
        assert motion.shape == (6, 41)
        np.testing.assert_allclose(motion, motions[0], rtol=0, atol=1e-12)
    assert steps[0] <= min(steps) and max(steps) <= steps[0] + 3
