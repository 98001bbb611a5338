"""The motions of the benchmarks: their energies, equations by hand, and what integrates them."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from benchmarks.motions.equations import of_numpy
from benchmarks.motions.motion import (
    DOUBLE_PENDULUM,
    FIGURE_EIGHT,
    HOOP,
    KEPLER,
    KEPLER_POLAR,
    PENDULUM,
    SOLAR_SYSTEM,
    Motion,
    n_pendulum,
)
from benchmarks.peers import engine
from benchmarks.peers.comparison import measured

MOTIONS = (
    (PENDULUM, 1.0),
    (DOUBLE_PENDULUM, 1.0),
    (HOOP, 1.0),
    (KEPLER_POLAR, 1.0),
    (KEPLER, 1.0),
    (FIGURE_EIGHT, 1.0),
    (SOLAR_SYSTEM, 100.0),
    (n_pendulum(4, 1.0), 1.0),
)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(("motion", "stop"), MOTIONS, ids=lambda each: getattr(each, "system", ""))
def test_the_energy_of_each_motion_is_conserved(motion: Motion, stop: float) -> None:
    short = replace(motion, stop=stop)
    found = measured(partial(engine, "lagrange"), short, 2)
    assert found.energy_error < 1e-13
    start = short.starts(2)[1]
    q, v = np.split(start, 2)
    moved = np.stack([start, np.concatenate([1.01 * q, v])], axis=1)
    assert abs(short.energy_errors(moved)[1]) > 1e-4


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    "motion", [motion for motion, _ in MOTIONS if motion.by_hand is not None], ids=lambda each: each.system
)
def test_accelerations_by_hand_are_those_of_the_motion(motion: Motion) -> None:
    """By the velocities shortly after the start: v(t) = v + a t + O(t^2)."""
    assert motion.by_hand is not None
    step = 1e-4 * (100.0 if motion is SOLAR_SYSTEM else 1.0)
    around = replace(motion, stop=2 * step, samples=3)
    before, middle, after = engine("lagrange", around).follow(motion.initial).states.T
    q, v = np.split(middle, 2)
    found = np.array(motion.by_hand(motion.parameters, list(q), list(v), of_numpy()), dtype=float)
    expected = np.split(after - before, 2)[1] / (2 * step)
    assert found == pytest.approx(expected, rel=1e-5, abs=1e-6 * np.abs(expected).max())


@pytest.mark.exhaustive(keep=0.6)
def test_sympy_and_scipy_integrate_the_same_motion() -> None:
    short = replace(PENDULUM, stop=1.0)
    ours, theirs = (engine(peer, short).follow(short.initial).states[:, -1] for peer in ("lagrange", "scipy"))
    assert theirs == pytest.approx(ours, rel=1e-9)
