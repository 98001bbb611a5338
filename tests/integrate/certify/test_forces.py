"""Estimates of the errors of multipliers and reactions beside the true ones."""

from __future__ import annotations

import random

import mpmath
import numpy as np
import pytest

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
ALONG = """
parameters: {{F: {F!r}, e: {e!r}}}
coordinates: {{x: {{initial: {x}}}, y}}
masses: {{p: {m!r}}}
embedding: {{p: [x, y]}}
forces: {{p: [({b!r}*F + {a!r}*e)*exp(-t/1000), (-{a!r}*F + {b!r}*e)*exp(-t/1000)]}}
constraints: {{wire: {a!r}*x + {b!r}*y}}
"""


def tension(t: Number) -> tuple[Number, Number]:
    """S = theta'^2 + k cos(theta) of the pendulum with m = l = 1, and the angle theta."""
    (theta,) = pendulum(t)
    k, begin = Number(2.25), Number(2.5)
    return 2 * k * (mpmath.cos(theta) - mpmath.cos(begin)) + k * mpmath.cos(theta), theta


@pytest.mark.exhaustive(keep=0.2)
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


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("e", [0.0, 1e-12, 1e-6])
def test_a_small_difference_of_large_forces_has_their_rounding(e: float):
    """A force that is almost along a wire (a, b): R = lambda (a, b) with lambda = -e exp(-t/1000). It is what
    is left of forces whose roundings do not depend on the state, and are the same in run and companions."""
    given = {one: random.uniform(0.5, 2.0) for one in ("a", "b", "m")}
    text = ALONG.format(F=10 ** random.uniform(1, 4), e=e, x=random.choice([0, 0.3]), **given)
    data, _ = certified(text, 1.0, 41, outputs=("q", "multipliers", "reactions"))
    a, b = given["a"], given["b"]
    with mpmath.workdps(50):
        multiplier = [-Number(repr(e)) * mpmath.exp(-Number(t) / 1000) for t in data["t"].tolist()]
        exact = {"multipliers/wire": [Number(1)], "reactions/p": [Number(repr(a)), Number(repr(b))]}
        for path, normal in exact.items():
            truth = [n * one for one in multiplier for n in normal]
            wrong = [float(abs(Number(x) - y)) for x, y in zip(data[path].ravel().tolist(), truth)]
            enough = data[FOLDER + path].ravel() >= 0.1 * np.array(wrong)
            assert np.mean(enough) >= COVERAGE, text


@pytest.mark.exhaustive(keep=0.6)
def test_companions_take_part_in_actions_on_parameters():
    """The floor bears k, and 2 k from t = 1/2 on."""
    data, _ = certified(CHANGED, 2.0, 41, outputs=("q", "multipliers"))
    exact = [Number(2 if t > 0.5 else 1) / 3 for t in data["t"].tolist()]
    assert coverage(data, "multipliers/floor", exact) == 1
    assert np.max(data[FOLDER + "multipliers/floor"]) < 1e-14


@pytest.mark.exhaustive(keep=0.25)
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
