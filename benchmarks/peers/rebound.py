"""rebound's IAS15, of point masses in a plane (H. Rein and D. S. Spiegel, MNRAS 446, 2015)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import rebound

from benchmarks.motions.equations import gravitation
from benchmarks.motions.motion import Motion
from benchmarks.motions.printed import Printed
from benchmarks.peers import Array, Course, Engine

COLUMNS = ("x", "y", "vx", "vy")


def engine(motion: Motion, *, epsilon: float) -> Engine:
    """IAS15 with its ``epsilon``; the motion is looked at after the steps that pass the samples."""
    return Engine(0.0, follower(motion.parameters, motion.grid, epsilon, exact=False))


def printed(equations: Printed, times: Array) -> Engine:
    """IAS15 at its default, sampled at ``times``: of the equations, only G and the masses are used."""
    return Engine(0.0, follower(equations.parameters, times, None, exact=True))


def follower(
    parameters: Mapping[str, Any], times: Array, epsilon: float | None, *, exact: bool
) -> Callable[[Array], Course]:
    """What follows the bodies; without ``exact`` only the last time is met to the last digit."""
    constant, masses = gravitation(parameters)

    def follow(initial: Array) -> Course:
        simulation = rebound.Simulation()
        simulation.G, simulation.integrator = constant, "ias15"
        if epsilon is not None:
            simulation.integrator.epsilon = epsilon
        for mass, *place in zip(masses, *initial.reshape(4, -1)):
            simulation.add(m=mass, **dict(zip(COLUMNS, place)))
        states = np.full((len(initial), len(times)), np.nan)
        states[:, 0] = initial
        for k, t in enumerate(times[1:], 1):
            simulation.integrate(t, exact_finish_time=int(exact or t == times[-1]))
            states[:, k] = [getattr(one, name) for name in COLUMNS for one in simulation.particles]
        return Course(states, simulation.steps_done)

    return follow
