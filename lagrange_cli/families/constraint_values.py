"""The numbers of constraints of families at one state."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.families.arrays import Total
from lagrange_cli.families.bonds import Bonds
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.joint_masses import JointMasses, along
from lagrange_cli.families.joints import Articulation
from lagrange_cli.families.values import Doubles, FamilyValues
from lagrange_cli.model.start.equations import Equations, Masses, Matter
from lagrange_cli.model.start.generic import FAINT
from lagrange_cli.records import dataclass
from lagrange_cli.spec.content import names_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lagrange_cli.expression.graph import Graph

    Values = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Whole:
    """The constraints of a system of families, in the order of their ``names``; its masses, which are
    constant, or those of ``joints``; and sum m r^2."""

    names: Sequence[str]
    builder: FamilyBuilder
    bonds: Bonds
    masses: Total
    extent: Total
    joints: Articulation | None = None

    @cached_property
    def contained(self) -> Sequence[Sequence[int]]:
        """The coordinates in each constraint, on chains and trees."""
        assert self.joints is not None
        return contained(self.bonds, self.joints, self.builder.graph, self.builder.q.count)


class State:
    """Numbers of a ``kind`` at one state, where M is diagonal and constant; ``given`` are the parameters."""

    def __init__(
        self, system: Whole, kind: Doubles, given: Values, t: Any, q: Sequence[Any], v: Sequence[Any]
    ) -> None:
        self.system, self.kind, self.given = system, kind, given
        self.t, self.q, self.v = kind.number(t), kind.array(q), kind.array(v)
        with np.errstate(all="ignore"):
            builder, bounds = self.system.builder, self.system.bonds.bounds
            self.numbers = FamilyValues(builder, self.t, self.q, self.v, given, kind=kind)
            self.values = self._of([one.node for one in bounds])
            self.drifts = self._drifts()
            self.slopes = [
                [np.broadcast_to(self.numbers.node(a), one.domain.count) for a in one.slopes]
                for one in bounds
            ]

    def _of(self, nodes: Sequence[Any]) -> Values:
        """A number for each constraint."""
        made: Values = self.kind.zeros(self.system.bonds.count)
        for one, node in zip(self.system.bonds.bounds, nodes):
            np.add.at(made, one.numbers, self.numbers.node(node))
        return made

    def _drifts(self) -> Values:
        """The rates of constraints where nothing moves."""
        builder = self.system.builder
        return self._of([builder.graph.diff(one.node, builder.time) for one in self.system.bonds.bounds])

    @property
    def masses(self) -> Matter:
        """M, and sum m r^2."""
        return Masses({k: {k: m} for k, m in enumerate(self.inertia.tolist()) if m}, self.extent)

    @cached_property
    def inertia(self) -> Values:
        """M."""
        return self.numbers.of(self.system.masses)

    @cached_property
    def extent(self) -> float:
        """sum m r^2."""
        with np.errstate(all="ignore"):
            return float(self.numbers.of(self.system.extent)[0])

    @cached_property
    def rows(self) -> list[dict[int, Any]]:
        """A, row by row."""
        made: list[dict[int, Any]] = [{} for _ in range(self.system.bonds.count)]
        for one, slopes in zip(self.system.bonds.bounds, self.slopes):
            for places, values in zip(one.rows, slopes):
                for i, k, a in zip(one.numbers.tolist(), places.tolist(), values.tolist()):
                    made[i][k] = made[i].get(k, 0.0) + a
        return made

    def squares(self, scale: Values) -> Values:
        """The squares of the changes of constraints with q_k/``scale[k]``."""
        made = np.zeros(self.system.bonds.count)
        for one, slopes in zip(self.system.bonds.bounds, self.slopes):
            for places, values in zip(one.rows, slopes):
                np.add.at(made, one.numbers, (values * scale[places]) ** 2)
        return made

    def faint(self, scale: Values) -> NDArray[np.bool_]:
        """Which constraints have a slope that is all but 0 beside others (``generic.faint``)."""
        least, most = np.full(self.system.bonds.count, np.inf), np.zeros(self.system.bonds.count)
        for one, slopes in zip(self.system.bonds.bounds, self.slopes):
            for places, values in zip(one.rows, slopes):
                size = np.abs(values * scale[places])
                np.minimum.at(least, one.numbers, size)
                np.maximum.at(most, one.numbers, size)
        return least <= FAINT * most

    def rates(self, v: Values) -> Values:
        """A v."""
        made = np.zeros(self.system.bonds.count)
        for one, slopes in zip(self.system.bonds.bounds, self.slopes):
            for places, values in zip(one.rows, slopes):
                np.add.at(made, one.numbers, values * v[places])
        return made

    def refuse(self) -> None:
        """Raise ``SpecError`` at a constraint that has no value or no derivative."""
        numbers = [self.values.tolist(), self.drifts.tolist(), *(row.values() for row in self.rows)]
        if not all(all(map(math.isfinite, some)) for some in numbers):
            spec = self.system.builder.spec
            known = dict(zip(names_of(spec.parameters), self.given.tolist()))
            Equations(spec, known, self.kind.exact).at(self.t, self.q.tolist(), self.v.tolist())
            raise ArithmeticError("a constraint has no value")


class JointedState(State):
    """The same on chains and trees."""

    def _drifts(self) -> Values:
        rest = FamilyValues(self.system.builder, self.t, self.q, 0 * self.v, self.given, kind=self.kind)
        made: Values = self.kind.zeros(self.system.bonds.count)
        for one in self.system.bonds.bounds:
            np.add.at(made, one.numbers, rest.node(one.speed))
        return made

    @cached_property
    def joints(self) -> JointMasses:
        """The joints at this place."""
        found, builder = self.system.joints, self.system.builder
        assert found is not None
        with np.errstate(all="ignore"):
            return JointMasses(found, builder.graph, self.numbers, builder.q.count, self.extent)

    @property
    def masses(self) -> Matter:
        return self.joints if self.joints.nodes else Masses(self.joints.blocks, self.extent)

    @cached_property
    def inertia(self) -> Values:
        with np.errstate(all="ignore"):
            return np.array(self.joints.diagonal(self.system.builder.q.count))

    @cached_property
    def rows(self) -> list[dict[int, Any]]:
        if not self.joints.nodes:
            return super().rows
        bonds, kind, count = self.system.bonds, self.kind, self.system.builder.q.count
        assert bonds.reach is not None
        turn, turns = bonds.reach.turn, bonds.reach.turns
        with np.errstate(all="ignore"):
            pushes = kind.zeros(self.joints.nodes, len(self.joints.axes), turns)
            direct = kind.zeros(count, turns)
            for one, slopes in zip(bonds.bounds, self.slopes):
                for hold in one.holds:
                    values = self.numbers.node(hold.slope)
                    np.add.at(pushes[:, hold.component], (hold.places, turn[one.numbers]), values)
                for rows, values in zip(one.rows, slopes):
                    np.add.at(direct, (rows, turn[one.numbers]), values)
            columns = (direct + self.joints.felt(pushes)).T.tolist()
        return [{k: columns[t][k] for k in some} for t, some in zip(turn.tolist(), self.system.contained)]


def contained(bonds: Bonds, joints: Articulation, graph: Graph, count: int) -> list[list[int]]:
    """The coordinates, of so many, that each constraint on chains and trees contains."""
    reach = bonds.reach
    assert reach is not None
    pushes = np.zeros((joints.count, len(joints.nodes), reach.turns))
    found = np.zeros((count, reach.turns), dtype=bool)
    for one in bonds.bounds:
        for hold in one.holds:
            pushes[hold.places, hold.component, reach.turn[one.numbers]] = 1.0
        for rows in one.rows:
            found[rows, reach.turn[one.numbers]] = True
    if joints.nodes:
        along(joints.nodes[0].tree, pushes, back=True)
    for kind in joints.joints:
        for axis, move in enumerate(kind.moves):
            for symbol, rows in zip(kind.coordinates, kind.rows):
                if kind.nodes is not None and not graph.diff(move, symbol).is_zero:
                    found[rows] |= pushes[kind.nodes, axis] > 0
    whose = {(tree, t): i for i, t in enumerate(reach.turn.tolist()) for tree in reach.trees[i]}
    made: list[list[int]] = [[] for _ in range(bonds.count)]
    for k, t in np.argwhere(found).tolist():
        made[whose[int(reach.tree_of[k]), t]].append(k)
    return made
