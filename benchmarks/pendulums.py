"""The problem that the engines are compared on: pendulums hung one from the other, released from rest.

All rods have length 1 and all bobs mass 1; angles are from the downward vertical.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

GRAVITY = 9.81
SAMPLES = 101
"""At how many times the motion is compared with what is conserved: few, the work is the integration."""


@dataclass(frozen=True)
class Pendulums:
    """Where they are released (rad), and how long they are followed (s)."""

    angles: tuple[float, ...]
    stop: float

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.angles)

    @property
    def grid(self) -> NDArray[np.float64]:
        """The times at which samples are taken, shape (SAMPLES,)."""
        return np.linspace(0.0, self.stop, SAMPLES)

    def system_file(self) -> str:
        """The system as a user writes it, every position written out."""
        numbers = range(1, self.count + 1)
        lines = [f"parameters: {{m: 1.0, l: 1.0, g: {GRAVITY}}}", "coordinates:"]
        lines += [f"  q{i}: {{initial: {angle!r}}}" for i, angle in zip(numbers, self.angles)]
        lines += ["masses:", *(f"  bob{i}: m" for i in numbers), "embedding:"]
        for i in numbers:
            x = " + ".join(f"l*sin(q{j})" for j in range(1, i + 1))
            y = " - ".join(f"l*cos(q{j})" for j in range(1, i + 1))
            lines.append(f"  bob{i}: [{x}, -{y}]")
        lines.append("potential: " + " + ".join(f"m*g*bob{i}.y" for i in numbers))
        return "\n".join(lines) + "\n"

    def energy_error(self, q: NDArray[np.float64], v: NDArray[np.float64]) -> float:
        """max |E - E(0)| / |E(0)| over the samples of ``q`` (rad) and ``v`` (rad/s), shape (count, n)."""
        energy = energies(q, v)
        start = np.array(self.angles)[:, None]
        released = energies(start, np.zeros_like(start))[0]
        return float(np.max(np.abs(energy - released)) / abs(released))


def energies(q: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    """T + U, shape (n,), for angles and their velocities of shape (count, n)."""
    vx, vy = np.cumsum(np.cos(q) * v, axis=0), np.cumsum(np.sin(q) * v, axis=0)
    height = -np.cumsum(np.cos(q), axis=0)
    total: NDArray[np.float64] = (0.5 * (vx**2 + vy**2) + GRAVITY * height).sum(axis=0)
    return total
