"""Chains and lattices of many members, and how they move: series by numpy, in extended precision."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.motions.motion import Array, shipped

Long = NDArray[Any]
"""Of extended precision."""
ORDER, STEP = 28, 0.25
"""Of the series that give the true motion: their last term is below the rounding of extended precision."""
SPEED = 0.3


@dataclass(frozen=True)
class Lattice:
    """A file of ``systems/`` whose coordinates are a family of this shape, followed until ``stop``."""

    system: str
    shape: tuple[int, ...]
    stop: float

    @property
    def text(self) -> str:
        """The system file."""
        return shipped(self.system)

    @property
    def sizes(self) -> dict[str, str]:
        """What ``--size`` gives."""
        return {name: str(size) for name, size in zip("NM", self.shape)}

    @property
    def count(self) -> int:
        """The number of coordinates."""
        return int(np.prod(self.shape))

    def start(self, seed: int) -> Array:
        """All members at rest in their places but for random velocities: q and v, shape (2 n,)."""
        v = SPEED * np.random.default_rng(seed).normal(size=self.count)
        return np.concatenate([np.zeros(self.count), v])

    def energy(self, state: Array) -> np.longdouble:
        """T + U, in extended precision."""
        q, v = np.split(state.astype(np.longdouble), 2)
        found: np.longdouble = (v * v).sum() / 2 + SERIES[self.system].potential(q.reshape(self.shape))
        return found

    def end(self, state: Array) -> Long:
        """q and v at ``stop``, correct to more digits than those of doubles."""
        q, v = (one.reshape(self.shape) for one in np.split(state.astype(np.longdouble), 2))
        steps = round(self.stop / STEP)
        for _ in range(steps):
            series = SERIES[self.system].series(q, v)
            q, v = summed(series), summed([(k + 1) * one for k, one in enumerate(series[1:])])
        return np.concatenate([q.ravel(), v.ravel()])


def summed(series: list[Long]) -> Long:
    """The sum of a series after ``STEP``."""
    total: Long = series[-1].copy()
    for one in reversed(series[:-1]):
        total *= np.longdouble(STEP)
        total += one
    return total


def product(a: list[Long], b: list[Long], k: int) -> Long:
    """Coefficient ``k`` of a product."""
    total = a[0] * b[k]
    for j in range(1, k + 1):
        total += a[j] * b[k - j]
    return total


class Chain:
    """Beads between two walls, U = sum s^2/2 + s^3/12 over the stretches s of the springs."""

    def stretches(self, q: Long) -> Long:
        """Those of all springs."""
        found: Long = np.diff(q, prepend=0, append=0)
        return found

    def potential(self, q: Long) -> np.longdouble:
        s = self.stretches(q)
        found: np.longdouble = (s * s / 2 + s * s * s / 12).sum()
        return found

    def series(self, q: Long, v: Long) -> list[Long]:
        """Those of q."""
        found, s = [q, v], list[Long]()
        for k in range(ORDER - 1):
            s.append(self.stretches(found[k]))
            force = s[k] + product(s, s, k) / 4
            found.append(np.diff(force) / ((k + 1) * (k + 2)))
        return found


class Pendulums:
    """Pendulums on a torus: U = sum 1 - cos u + (u - u_right)^2 + (u - u_below)^2."""

    def potential(self, q: Long) -> np.longdouble:
        half = np.sin(q / 2)
        found: np.longdouble = (2 * half * half + sum((np.roll(q, -1, a) - q) ** 2 for a in (0, 1))).sum()
        return found

    def series(self, q: Long, v: Long) -> list[Long]:
        """Those of q."""
        found, sine, cosine, slope = [q, v], [np.sin(q)], [np.cos(q)], [v]
        for k in range(ORDER - 1):
            around = sum(np.roll(found[k], way, axis) for way in (1, -1) for axis in (0, 1)) - 4 * found[k]
            found.append((2 * around - sine[k]) / ((k + 1) * (k + 2)))
            slope.append((k + 2) * found[k + 2])
            sine.append(product(slope, cosine, k) / (k + 1))
            cosine.append(-product(slope, sine, k) / (k + 1))
        return found


SERIES: dict[str, Chain | Pendulums] = {"fpu_chain": Chain(), "lattice": Pendulums()}
