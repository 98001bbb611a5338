"""Accelerations of a system of families at one state, without compiled code.

M a = -dU/dq + Q + dT/dq - (dp/dt at constant velocities) + A^T lambda, where A a is what the constraints say.
Rates at constant velocities are differences of values nearby.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.families.arrays import Total
from lagrange_cli.families.bonds import Bonds
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.joints.masses import JointMasses
from lagrange_cli.families.slopes import slopes
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.model.sparse import factored

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Values = NDArray[np.float64]

NEAR = 1e-5
"""The time between values nearby."""
MOST = 10_000_000
"""Numbers of A, and of the factors of M."""


class Accelerations:
    """Those of a ``system`` with parameters ``given``."""

    def __init__(self, system: FamilySystem, given: Values) -> None:
        self.system, self.given = system, given
        self.kinetic: Total | None = None
        if system.joints is not None:
            (self.kinetic,), _ = slopes(system.kinetic, system.root, system.totals, system.slots, system.q)

    def values(self, t: float, q: Values, v: Values) -> FamilyValues:
        """Numbers at a state."""
        return FamilyValues(self.system, t, q, v, self.given)

    def allowed(self, t: float, q: Values, v: Values) -> Values | None:
        """The velocities next to ``v`` that the constraints allow; None where A has too many numbers."""
        bonds = self.system.bonds
        if bonds is None:
            return v
        a = self.rows(bonds, self.values(t, q, v))
        if a is None:
            return None
        return np.asarray(v - np.linalg.lstsq(a, self.speeds(bonds, t, q, v), rcond=None)[0])

    def at(self, t: float, q: Values, v: Values) -> Values | None:
        """The accelerations; None where they are not found."""
        system, here = self.system, self.values(t, q, v)
        force = here.of(system.applied) - here.of(system.slopes)
        if self.kinetic is not None:
            force = force + here.of(self.kinetic)
            force = force - self.rate(lambda s: self.values(t + s, q + s * v, v).of(system.momenta))
        divided = self.divided(here)
        if divided is None:
            return None
        if system.bonds is None:
            return divided(force[:, None])[:, 0]
        bonds, a = system.bonds, self.rows(system.bonds, here)
        if a is None:
            return None
        wanted = -self.rate(lambda s: self.speeds(bonds, t + s, q + s * v, v))
        free, pulled = divided(force[:, None])[:, 0], divided(a.T)
        multipliers = np.linalg.lstsq(a @ pulled, wanted - a @ free, rcond=None)[0]
        return np.asarray(free + pulled @ multipliers)

    @staticmethod
    def rate(of: Callable[[float], Values]) -> Values:
        """A derivative."""
        return np.asarray((of(NEAR) - of(-NEAR)) / (2 * NEAR))

    def divided(self, here: FamilyValues) -> Callable[[Values], Values] | None:
        """M^-1 for vectors side by side."""
        system, coupled = self.system, self.system.coupled_masses
        if coupled is not None:
            factors = factored(coupled.matrix(here.of(coupled.entries)), MOST)
            return None if factors is None else lambda right: np.array(factors.solve([*right]))
        if system.joints is None:
            masses = here.of(system.masses)
            return lambda right: right / masses[:, None]
        joints = JointMasses(system.joints, system.slots.graph, here, system.q.count, 1.0)
        return joints.solver(range(system.q.count))

    def speeds(self, bonds: Bonds, t: float, q: Values, v: Values) -> Values:
        """What constraints say of the velocities: A v + b."""
        here, made = self.values(t, q, v), np.zeros(bonds.count)
        for one in bonds.bounds:
            np.add.at(made, one.numbers, np.broadcast_to(here.node(one.speed), one.domain.count))
        return made

    def rows(self, bonds: Bonds, here: FamilyValues) -> Values | None:
        """A, or None where it has too many numbers."""
        system = self.system
        made = np.zeros((bonds.count, system.q.count))
        held = system.joints if any(one.holds for one in bonds.bounds) else None
        sizes = [one.count for one in held.places] if held else []
        if bonds.count * (system.q.count + sum(sizes)) > MOST:
            return None
        pushes = [np.zeros((size, bonds.count)) for size in sizes]
        for one in bonds.bounds:
            for rows, slope in zip(one.rows, one.slopes):
                np.add.at(made, (one.numbers, rows), np.broadcast_to(here.node(slope), one.domain.count))
            for hold in one.holds:
                pull = np.broadcast_to(here.node(hold.slope), one.domain.count)
                np.add.at(pushes[hold.component], (hold.places, one.numbers), pull)
        if held is not None:
            joints = JointMasses(held, system.slots.graph, here, system.q.count, 1.0)
            made += joints.felt(pushes).T
        return made
