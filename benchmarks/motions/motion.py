"""``Motion``: a shipped system with its equations in any algebra, and the motions for comparing engines."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from benchmarks import ROOT
from benchmarks.motions import equations
from benchmarks.motions.equations import Accelerations, Energies, Parameters, of_numpy
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.values import Values, resolve_values

Array = NDArray[np.float64]


def shipped(name: str) -> str:
    """The text of a file of ``systems/``."""
    return (ROOT / "systems" / f"{name}.yaml").read_text(encoding="utf-8")


@dataclass(frozen=True)
class Motion:
    """A file of ``systems/``, how long it is followed, and its equations (``equations``).

    ``size`` is that of the file's families, ``settings`` what ``--set`` gives. ``samples`` is at how many
    times a motion is compared with what is conserved: few, the work is the integration.
    """

    system: str
    stop: float
    energies: Energies
    by_hand: Accelerations | None = None
    size: int | None = None
    settings: tuple[tuple[str, str], ...] = ()
    samples: int = 101

    @property
    def text(self) -> str:
        """The system file."""
        return shipped(self.system)

    @property
    def sizes(self) -> dict[str, str]:
        """What ``--size`` gives."""
        return {} if self.size is None else {"N": str(self.size)}

    @cached_property
    def values(self) -> Values:
        """Parameters and the initial state, which all contenders start from."""
        return resolve_values(read_spec(self.text, self.system, self.sizes), dict(self.settings))

    @property
    def parameters(self) -> Parameters:
        """The parameters, whole numbers as ``int``: algebras omit factors of 1."""
        given = self.values.parameters
        return {name: int(value) if value.is_integer() else value for name, value in given.items()}

    @property
    def initial(self) -> Array:
        """q and v at the start, one above the other, shape (2 n,)."""
        return np.array([*self.values.q, *self.values.v])

    @property
    def degrees(self) -> int:
        """The number of coordinates."""
        return len(self.values.q)

    def starts(self, count: int) -> list[Array]:
        """The initial state, and ``count - 1`` nearby: the error of a run is a matter of chance."""
        q, v = np.split(self.initial, 2)
        return [np.concatenate([q * (1 + k / 1000), v]) for k in range(count)]

    @property
    def grid(self) -> Array:
        """The times at which samples are taken, shape (samples,)."""
        return np.linspace(0.0, self.stop, self.samples)

    def energy(self, states: Array) -> Array:
        """What is conserved, of states (2 n, k): shape (k,).

        It is computed with more digits than the states have, where the machine has them.
        """
        q, v = np.split(states.astype(np.longdouble), 2)
        parameters = {name: np.longdouble(value) for name, value in self.values.parameters.items()}
        kinetic, potential = self.energies(parameters, list(q), list(v), of_numpy())
        return np.asarray(kinetic + potential)

    def energy_errors(self, states: Array) -> Array:
        """(E - E(0)) / |E(0)| of states (2 n, k), the first at the start."""
        energy = self.energy(states)
        return np.asarray((energy - energy[0]) / abs(energy[0]), dtype=np.float64)


PENDULUM = Motion("pendulum", 100.0, equations.pendulums, equations.pendulum_by_hand)
DOUBLE_PENDULUM = Motion("double_pendulum", 1000.0, equations.pendulums, equations.double_pendulum_by_hand)
HENON_HEILES = Motion("henon_heiles", 200.0, equations.henon_heiles, equations.henon_heiles_by_hand)
HOOP = Motion("rotating_hoop", 5000.0, equations.hoop, equations.hoop_by_hand)
KEPLER_POLAR = Motion("central_force", 20000.0, equations.kepler_polar, equations.kepler_polar_by_hand)
KEPLER = Motion("central_force_cartesian", 100.0, equations.kepler, equations.kepler_by_hand)
FIGURE_EIGHT = Motion("figure_eight", 5000.0, equations.point_masses, equations.point_masses_by_hand)
SOLAR_SYSTEM = Motion("solar_system", 36525.0, equations.point_masses, equations.point_masses_by_hand)


def n_pendulum(size: int, stop: float) -> Motion:
    """``size`` pendulums, released from rest at 2.0, 2.1, 2.2, ... rad."""
    return Motion("n_pendulum", stop, equations.pendulums, size=size)
