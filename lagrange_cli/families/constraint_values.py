"""The numbers of constraints of families at one state."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.families.arrays import NONE, Total
from lagrange_cli.families.bonds import Bonds
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.coupled_masses import CoupledMasses
from lagrange_cli.families.joints.joints import Articulation
from lagrange_cli.families.joints.masses import JointMasses
from lagrange_cli.families.joints.responses import trees_of
from lagrange_cli.families.joints.sums import along
from lagrange_cli.families.values import Doubles, FamilyValues
from lagrange_cli.model.start.equations import Equations, Masses, Matter
from lagrange_cli.model.start.generic import FAINT
from lagrange_cli.records import dataclass
from lagrange_cli.spec.content import names_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lagrange_cli.expression.index_arrays import Places

    Values = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Whole:
    """The constraints of a system of families, in the order of their ``names``; its masses, which are
    constant, or those of ``joints``; and sum m r^2. If M is not diagonal, it is ``coupled``, and ``masses``
    has its diagonal."""

    names: Sequence[str]
    builder: FamilyBuilder
    bonds: Bonds
    masses: Total
    extent: Total
    joints: Articulation | None = None
    coupled: CoupledMasses | None = None

    @cached_property
    def contained(self) -> NDArray[np.bool_]:
        """Which coordinates constraints on chains and trees contain (coordinates, colors)."""
        return contained(self)

    @property
    def colors(self) -> Places:
        """The colors of constraints on chains and trees (see ``responses``)."""
        assert self.bonds.responses is not None
        return self.bonds.responses.colors

    @cached_property
    def owners(self) -> Places:
        """The constraint of each color that may contain a coordinate (coordinates, colors)."""
        assert self.joints is not None and self.bonds.responses is not None
        return self.bonds.responses.trees[trees_of(self.joints, self.builder.q.count)[1]]


class State:
    """Numbers of a ``kind`` at one state, where M is constant; ``given`` are the parameters."""

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
        return self._of(
            [
                builder.graph.diff(one.node, builder.time) if one.holonomic else one.at_rest(builder.graph)
                for one in self.system.bonds.bounds
            ]
        )

    @property
    def masses(self) -> Matter:
        """M, and sum m r^2."""
        coupled = self.system.coupled
        if coupled is not None:
            rows = coupled.matrix(self.numbers.of(coupled.entries))
            return Masses(dict(enumerate(rows)), self.extent)
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

    @cached_property
    def masses(self) -> Matter:
        joints = self.joints
        return joints if joints.nodes or joints.sums else Masses(joints.blocks(), self.extent)

    @cached_property
    def inertia(self) -> Values:
        with np.errstate(all="ignore"):
            return np.array(self.joints.diagonal(self.system.builder.q.count))

    @cached_property
    def rows(self) -> list[dict[int, Any]]:
        assert self.system.joints is not None
        places = self.system.joints.places
        if not places:
            return super().rows
        bonds, kind, count = self.system.bonds, self.kind, self.system.builder.q.count
        colors, owners = self.system.colors, self.system.owners
        with np.errstate(all="ignore"):
            pushes = [kind.zeros(one.count, owners.shape[1]) for one in places]
            direct = kind.zeros(count, owners.shape[1])
            for one, slopes in zip(bonds.bounds, self.slopes):
                color = colors[one.numbers]
                for hold in one.holds:
                    values = self.numbers.node(hold.slope)
                    np.add.at(pushes[hold.component], (hold.places, color), values)
                for rows, values in zip(one.rows, slopes):
                    np.add.at(direct, (rows, color), values)
            columns = direct + self.joints.felt(pushes)
        made: list[dict[int, Any]] = [{} for _ in range(bonds.count)]
        found = self.system.contained
        listed = zip(owners[found].tolist(), np.nonzero(found)[0].tolist(), columns[found].tolist())
        for i, k, a in listed:
            made[i][k] = a
        return made


def contained(whole: Whole) -> NDArray[np.bool_]:
    """Which coordinates constraints on chains and trees contain (coordinates, colors)."""
    bonds, joints, graph, count = whole.bonds, whole.joints, whole.builder.graph, whole.builder.q.count
    assert joints is not None
    colors, many = whole.colors, whole.owners.shape[1]
    pushes = [np.zeros((one.count, many)) for one in joints.places]
    direct, found = np.zeros((2, count, many), dtype=bool)
    for one in bonds.bounds:
        for hold in one.holds:
            pushes[hold.component][hold.places, colors[one.numbers]] = 1.0
        for rows in one.rows:
            direct[rows, colors[one.numbers]] = True
    for chain, push in zip(joints.nodes, pushes):
        along(chain.tree, push, back=True)
    for kind in joints.joints:
        for axis, move in enumerate(kind.moves):
            for symbol, rows in zip(kind.coordinates, kind.rows):
                if kind.nodes is not None and not graph.diff(move, symbol).is_zero:
                    found[rows] |= pushes[axis][kind.nodes] > 0
    if joints.relative is not None:
        for push, ends in zip(pushes[len(joints.nodes) :], joints.relative.chains.values()):
            np.logical_or.at(found, ends[ends != NONE], push[ends != NONE] > 0)
        found = joints.relative.behind(found)
    return found | direct
