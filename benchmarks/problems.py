"""The motions for comparing engines: shipped systems, and their conserved energies in numpy."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.report import ROOT
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import Values, resolve_values

Array = NDArray[np.floating[Any]]
Parameters = Mapping[str, float]


@dataclass(frozen=True)
class Problem:
    """A file of ``systems/``, how long it is followed, and its energy function.

    ``energy`` takes the parameters and q, v of shape (coordinates, n), and gives what is conserved, shape
    (n,). ``size`` is that of the file's families, ``settings`` what ``--set`` gives. ``samples``
    is at how many times a motion is compared with what is conserved: few, the work is the integration.
    """

    system: str
    stop: float
    energy: Callable[[Parameters, Array, Array], Array]
    size: int | None = None
    settings: tuple[tuple[str, str], ...] = ()
    samples: int = 101

    @property
    def text(self) -> str:
        """The system file."""
        return (ROOT / "systems" / f"{self.system}.yaml").read_text(encoding="utf-8")

    @property
    def sizes(self) -> dict[str, str]:
        """What ``--size`` gives."""
        return {} if self.size is None else {"N": str(self.size)}

    @cached_property
    def values(self) -> Values:
        """Parameters and the initial state, which all contenders start from."""
        return resolve_values(read_spec(self.text, self.system, self.sizes), dict(self.settings))

    def starts(self, count: int) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """q and v at the start, and ``count - 1`` times nearby: the error of a run is a matter of chance."""
        q, v = np.array(self.values.q), np.array(self.values.v)
        return [(q * (1 + k / 1000), v) for k in range(count)]

    @property
    def grid(self) -> NDArray[np.float64]:
        """The times at which samples are taken, shape (samples,)."""
        return np.linspace(0.0, self.stop, self.samples)

    def energy_errors(self, q: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
        """(E - E(0)) / |E(0)| of samples of q and v, shape (coordinates, n), the first at the start.

        It is computed with more digits than the samples have, where the machine has them.
        """
        energy = self.energy(self.values.parameters, q.astype(np.longdouble), v.astype(np.longdouble))
        return np.asarray((energy - energy[0]) / abs(energy[0]), dtype=np.float64)


def pendulums(parameters: Parameters, q: Array, v: Array) -> Array:
    """T + U of pendulums hung one from the other, all of mass 1 and length 1; angles from the downward
    vertical."""
    vx, vy = np.cumsum(np.cos(q) * v, axis=0), np.cumsum(np.sin(q) * v, axis=0)
    height = -np.cumsum(np.cos(q), axis=0)
    total: Array = ((vx**2 + vy**2) / 2 + parameters["g"] * height).sum(axis=0)
    return total


def hoop(parameters: Parameters, q: Array, v: Array) -> Array:
    """The energy in the frame that turns with the hoop, per unit of mass."""
    g, a, omega = (parameters[name] for name in ("g", "a", "omega"))
    energy: Array = (a * v[0]) ** 2 / 2 - (a * omega * np.sin(q[0])) ** 2 / 2 - g * a * np.cos(q[0])
    return energy


def kepler_polar(parameters: Parameters, q: Array, v: Array) -> Array:
    """The energy of a planet in polar coordinates r, theta, per unit of mass."""
    energy: Array = (v[0] ** 2 + (q[0] * v[1]) ** 2) / 2 - parameters["mu"] / q[0]
    return energy


def kepler(parameters: Parameters, q: Array, v: Array) -> Array:
    """The energy of a planet in Cartesian coordinates, per unit of mass."""
    energy: Array = (v**2).sum(axis=0) / 2 - parameters["mu"] / np.sqrt((q**2).sum(axis=0))
    return energy


def gravitation(parameters: Parameters) -> tuple[float, list[float]]:
    """The constant of gravity, and the masses, of a file of point masses."""
    masses = [value for name, value in parameters.items() if name.startswith("m[")]
    return parameters["G"] if "G" in parameters else parameters["k"] ** 2, masses


def point_masses(parameters: Parameters, q: Array, v: Array) -> Array:
    """T + U of point masses in their mutual gravity: all x, then all y, then all z."""
    constant, numbers = gravitation(parameters)
    masses = np.array(numbers, dtype=np.longdouble)
    count = len(masses)
    place, velocity = (each.reshape(-1, count, each.shape[1]) for each in (q, v))
    energy: Array = (masses[:, None] * (velocity**2).sum(axis=0)).sum(axis=0) / 2
    for i in range(count):
        for j in range(i):
            distance = np.sqrt(((place[:, i] - place[:, j]) ** 2).sum(axis=0))
            energy = energy - constant * masses[i] * masses[j] / distance
    return energy


DOUBLE_PENDULUM = Problem("double_pendulum", 1000.0, pendulums)
HOOP = Problem("rotating_hoop", 5000.0, hoop)
KEPLER_POLAR = Problem("central_force", 20000.0, kepler_polar)
KEPLER_CARTESIAN = Problem("central_force_cartesian", 2 * np.pi * 1e6, kepler, settings=(("e", "0.3"),))
FIGURE_EIGHT = Problem("figure_eight", 5000.0, point_masses)
SOLAR_SYSTEM = Problem("solar_system", 36525.0, point_masses)


def n_pendulum(size: int, stop: float) -> Problem:
    """``size`` pendulums, released from rest at 2.0, 2.1, 2.2, ... rad."""
    return Problem("n_pendulum", stop, pendulums, size)
