"""Estimates of the errors of multipliers and reactions beside the true ones."""

from __future__ import annotations

import mpmath
import numpy as np

from lagrange_cli.integrate.certify.certificate import AS_RUN, FOLDER
from lagrange_cli.integrate.certify.companion import UNITS, nudged
from tests.integrate.certify.test_certificate import COVERAGE, Number, certified, coverage, pendulum

ON_A_CIRCLE = """
parameters: {k: 2.25}
coordinates: {x: {initial: sin(2.5)}, y: {initial: -cos(2.5)}}
masses: {p: 1}
embedding: {p: [x, y]}
potential: k*p.y
constraints: {rod: x**2 + y**2 - 1}
"""
CHANGED = """
parameters: {k: 1/3}
coordinates: {x: {initial: 0, velocity: 1}, y: {initial: 0}}
masses: {p: 1}
embedding: {p: [x, y]}
potential: k*p.y
constraints: {floor: y}
events:
  heavier: {when: x - 1/2, action: {set: {k: 2*k}}}
"""


def tension(t: Number) -> tuple[Number, Number]:
    """S = theta'^2 + k cos(theta) of the pendulum with m = l = 1, and the angle theta."""
    (theta,) = pendulum(t)
    k, begin = Number(2.25), Number(2.5)
    return 2 * k * (mpmath.cos(theta) - mpmath.cos(begin)) + k * mpmath.cos(theta), theta


def test_multipliers_and_reactions_of_the_cartesian_pendulum():
    """lambda = -S/2, and R = S towards the pivot. Asking for them changes no estimate of q and v."""
    data, _ = certified(ON_A_CIRCLE, 40.0, 401, outputs=("q", "v", "multipliers", "reactions"))
    with mpmath.workdps(50):
        known = [tension(Number(t)) for t in data["t"].tolist()]
        multipliers = [-s / 2 for s, _ in known]
        reactions = [x for s, a in known for x in (-s * mpmath.sin(a), s * mpmath.cos(a))]
    assert coverage(data, "multipliers/rod", multipliers) >= COVERAGE
    assert coverage(data, "reactions/p", reactions) >= COVERAGE
    assert np.max(data[FOLDER + "multipliers/rod"]) < 1e-10
    assert data[AS_RUN + "reactions/p"].shape == data["reactions/p"].shape == (401, 2)
    plain, _ = certified(ON_A_CIRCLE, 40.0, 401)
    for path, samples in plain.items():
        assert np.array_equal(samples, data[path])


def test_companions_take_part_in_actions_on_parameters():
    """The floor bears k, and 2 k from t = 1/2 on."""
    data, _ = certified(CHANGED, 2.0, 41, outputs=("q", "multipliers"))
    exact = [Number(2 if t > 0.5 else 1) / 3 for t in data["t"].tolist()]
    assert coverage(data, "multipliers/floor", exact) == 1
    assert np.max(data[FOLDER + "multipliers/floor"]) < 1e-14


def test_larger_systems_have_companions():
    """Their saddle-point matrices are factored by a function that all kinds of numbers share."""
    data, _ = certified("rolling_disc", 1.0, 11, outputs=("q", "v", "multipliers"))
    for name in ("forward", "sideways"):
        errors = data[f"{FOLDER}multipliers/{name}"]
        assert np.all((errors > 0) & (errors < 1e-14))


def test_neighbours_are_moved_apart():
    """Differences of neighbouring coordinates change, whatever their sizes."""
    states = np.array([[0.5], [0.5], [0.5], [0.5], [7.0]])
    found = nudged(states, slice(0, 4))
    moved = (found - states)[:4, 0] / np.spacing(0.5)
    assert moved.tolist() == list(UNITS[:4]) and found[4] == 7.0
    assert np.all(np.diff(moved))
