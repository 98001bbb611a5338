"""Stiff motions: files, rates as one writes them by hand, and how they end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.motions.motion import Array

Rates = Callable[[float, Array, Array], None]
"""(t, y, dy) -> None: y' for y = (q_0, v_0, q_1, v_1, ..), which is banded in chains."""
RELAXING = """
coordinates: {x: {initial: 2}}
lagrangian: (x_dot**2 - x**2)/2
generalized_forces: {x: 1000*(1 - x**2)*x_dot}
"""
CHAIN = """
sizes: {N: %d}
coordinates: {x[i in range(N)]: {initial: sin(3*i)/10}}
masses: {bead[i in range(N)]: 1}
embedding: {bead[i in range(N)]: x[i]}
definitions:
  stretch[0]: x[0]
  stretch[i in range(1, N)]: x[i] - x[i - 1]
  rate[0]: x_dot[0]
  rate[i in range(1, N)]: x_dot[i] - x_dot[i - 1]
potential: sum(stretch[i]**2/2 for i in range(N))*1e4
dissipation: sum(rate[i]**2/2 for i in range(N))*1e3
"""
STIFFNESS, DAMPING = 1e4, 1e3


@dataclass(frozen=True)
class Stiff:
    """A motion of ``count`` coordinates until ``stop``: the system ``text``, its ``rates``, in whose Jacobian
    no entry is more than ``reach`` from the diagonal, and q at the end, None where it has no closed form."""

    name: str
    text: str
    stop: float
    rates: Rates
    start: Array
    reach: int
    end: Callable[[Stiff], Array] | None = None

    @property
    def count(self) -> int:
        """The number of coordinates."""
        return len(self.start) // 2

    @property
    def pairs(self) -> Array:
        """q and v of each coordinate side by side."""
        return np.asarray(np.array(np.split(self.start, 2)).T.ravel())


def relaxing(t: float, y: Array, dy: Array) -> None:
    """Van der Pol's oscillator."""
    dy[0] = y[1]
    dy[1] = 1000.0 * (1.0 - y[0] * y[0]) * y[1] - y[0]


def damped_chain(t: float, y: Array, dy: Array) -> None:
    """Beads on springs beside dampers; the first one is fixed to a wall."""
    last = len(y) // 2 - 1
    for i in range(last + 1):
        x, v = y[2 * i], y[2 * i + 1]
        force = -1e4 * x - 1e3 * v
        if i > 0:
            force += 1e4 * y[2 * i - 2] + 1e3 * y[2 * i - 1]
        if i < last:
            force += 1e4 * (y[2 * i + 2] - x) + 1e3 * (y[2 * i + 3] - v)
        dy[2 * i] = v
        dy[2 * i + 1] = force


def at_rest(motion: Stiff) -> Array:
    """Where the beads of the chain are at the end, by its modes."""
    count = motion.count
    matrix = np.diag([2.0] * (count - 1) + [1.0]) - np.eye(count, k=1) - np.eye(count, k=-1)
    values, modes = np.linalg.eigh(matrix)
    half, product = values * DAMPING / 2, values * STIFFNESS
    fast = half + np.sqrt(half * half - product + 0j)
    slow = product / fast
    course = (fast * np.exp(-slow * motion.stop) - slow * np.exp(-fast * motion.stop)) / (fast - slow)
    return np.asarray(modes @ (course.real * (modes.T @ motion.start[:count])))


def chain(count: int) -> Stiff:
    """So many beads."""
    start = np.concatenate([np.sin(3.0 * np.arange(count)) / 10, np.zeros(count)])
    return Stiff(f"{count} beads", CHAIN % count, 0.3, damped_chain, start, 3, at_rest)


MOTIONS = (
    Stiff("van der Pol's oscillator", RELAXING, 2000.0, relaxing, np.array([2.0, 0.0]), 1),
    chain(10),
    chain(300),
)
