"""``@project``: a state back to the constraints, where rounding has led it away.

Series satisfy the constraints to the last bit, but steps add up rounding errors. Where f(q, t), or df/dt,
exceeds a few units of rounding of its terms, coordinates and then velocities are moved back, orthogonally in
the metric of the masses (E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, 1996, sec.
VII.2, with M in place of the identity):

    dq = -M^-1 A^T (A M^-1 A^T)^-1 f.

Residuals are computed from all digits of the state, with its low parts.

Coordinates that constraints give are computed from the others, after each step and with as many digits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.variables import numbered
from lagrange_cli.native.linear.blocks import all_unrolled
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Value
from lagrange_cli.native.llvm.vector import Bit
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.double_double import DoubleDouble
from lagrange_cli.native.numbers.kind import Condition, NumberKind, V, Written
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.recurrences.compensated import Compensated, Sum
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values
from lagrange_cli.native.recurrences.matrix import factored, solved
from lagrange_cli.native.state import LANES, Clock, StateLayout
from lagrange_cli.records import dataclass

C = TypeVar("C")

HEAD = "define void @project(ptr %constants, ptr %state) #0"
LOOSE = 0.5
"""The largest residual of a constraint, in units of rounding of its terms."""


@dataclass(frozen=True)
class Numbers(Generic[V, C]):
    """Those of a ``kind``, and ``careful`` ones that have all digits of the state; and how to get from one to
    the other."""

    kind: Written[V]
    careful: NumberKind[C]
    rounded: Callable[[C | None], V | None]
    exact: Callable[[V | None], C | None]


@dataclass(frozen=True)
class StatePlaces:
    """Where a state has q, v, the low parts behind them, and the time; and how often it was moved, if that is
    counted."""

    q: int
    v: int
    width: int
    time: int
    time_low: int
    count: int | None = None

    def counted(self, f: Function) -> None:
        """Count a move."""
        if self.count is not None:
            f.store(f.load("%state", self.count) + 1.0, "%state", self.count)


@dataclass(frozen=True)
class Projection(Generic[V, C]):
    """Writes ``@project(constants, state)``; for ``lanes``, ``@project_lanes``, which moves those that are
    %moving only."""

    f: Function
    residual: Residual
    places: StatePlaces
    constants: Constants
    numbers: Numbers[V, C]

    @property
    def lanes(self) -> int:
        """Motions at once."""
        return self.f.lanes

    def text(self) -> str:
        """The function's IR."""
        f, careful, at, state = self.f, self.numbers.careful, self.places, self._state()
        time = careful.load("%state", at.time, at.time_low - at.time)
        if self.residual.multipliers:
            self._move(f, time, *state)
        self._complete(time)
        f.give()
        return f.text()

    def _state(self) -> tuple[Sequence[C | None], Sequence[C | None]]:
        """q and v of the model, as they are in memory."""
        careful, at, rows = self.numbers.careful, self.places, self.residual.unknown
        q, v = ([careful.load("%state", row + i, at.width) for i in rows] for row in (at.q, at.v))
        return q, v

    def _complete(self, time: C) -> None:
        """What follows from the other coordinates."""
        careful, at, given = self.numbers.careful, self.places, self.residual.dependent
        if not given:
            return
        known = self._named(time, *self._state())
        nodes = [node for one in given for node in (one.place, one.speed) if node is not None]
        emit_values(careful, nodes, known, self.constants)
        for one in given:
            for node, row in ((one.place, at.q), (one.speed, at.v)):
                if node is not None:
                    value = careful.normalized(known[node])
                    if self.lanes > 1:
                        old = careful.load("%state", row + one.index, at.width)
                        value = careful.select("%moving", value, old)
                    careful.store(value, "%state", row + one.index, at.width)

    def _move(self, f: Function, time: C, q: Sequence[C | None], v: Sequence[C | None]) -> None:
        """Back to the constraints that are left."""
        kind, careful, at = self.numbers.kind, self.numbers.careful, self.places
        model, constraints = self.residual.model, Constraints(self.residual.model)
        size, rows = len(model.q), self.residual.unknown
        places = [one.expression if one.holonomic else None for one in model.constraints]
        off = self._residuals(places, time, q, v)
        speeds = self._residuals(constraints.speeds, time, q, v)
        known = {x: self.numbers.rounded(one) for x, one in self._named(time, q, v).items()}
        fine = kind.both(
            self._small(off, constraints, model.q, known), self._small(speeds, constraints, model.v, known)
        )
        away = ~Bit(f, fine)
        if self.lanes > 1:
            away = away & Bit(f, "%moving")
        with f.when(~away.mask().equals(0) if self.lanes > 1 else away):
            factors, regular = factored(self.residual.unpushed, all_unrolled(kind), known, self.constants)
            sure = Bit(f, regular) & away
            with f.when(~sure.mask().equals(0) if self.lanes > 1 else sure):

                def moved(
                    values: Sequence[C | None], right: list[V | None]
                ) -> tuple[list[C | None], list[V | None]]:
                    changes = solved(self.residual.unpushed, factors, right, kind.one)
                    pairs = zip(values, map(self.numbers.exact, changes))
                    after = [a if b is None else careful.normalized(careful.add(a, b)) for a, b in pairs]
                    return after, changes

                before = q, v
                q, changes = moved(q, [*[None] * size, *off])
                kicks, later = self._after(constraints, changes, known)
                v, _ = moved(v, [*kicks, *map(kind.add, speeds, later)])
                for row, values, old in zip((at.q, at.v), (q, v), before):
                    for i, value, kept in zip(rows, values, old):
                        chosen = careful.select(sure.name, value, kept) if self.lanes > 1 else value
                        careful.store(chosen, "%state", row + i, at.width)
                at.counted(f)

    def _named(self, time: C, q: Sequence[C | None], v: Sequence[C | None]) -> dict[Node, C | None]:
        model = self.residual.model
        return dict(zip((model.time, *model.q, *model.v), (time, *q, *v)))

    def _residuals(
        self, nodes: Sequence[Node | None], time: C, q: Sequence[C | None], v: Sequence[C | None]
    ) -> list[V | None]:
        """What should be 0; None stays None."""
        known = self._named(time, q, v)
        some = [node for node in nodes if node is not None]
        emit_values(self.numbers.careful, some, known, self.constants)
        return [None if node is None else self.numbers.rounded(known[node]) for node in nodes]

    def _after(
        self, constraints: Constraints, changes: list[V | None], known: dict[Node, V | None]
    ) -> tuple[list[V | None], list[V | None]]:
        """What goes to the velocities with ``changes`` of coordinates and their multipliers, and by how much
        what should be 0 of the velocities changes."""
        symbols, kicks, later = afterwards(self.residual, constraints, len(changes))
        values = {**known, **dict(zip(symbols, changes))}
        emit_values(self.numbers.kind, [*kicks, *later], values, self.constants)
        return [values[node] for node in kicks], [values[node] for node in later]

    def _small(
        self,
        residuals: Sequence[V | None],
        constraints: Constraints,
        amounts: Sequence[Node],
        known: dict[Node, V | None],
    ) -> Condition:
        """Whether they are only rounding errors of their terms, slopes times ``amounts``."""
        kind, fine = self.numbers.kind, self.numbers.kind.true
        slopes = [slope for row in constraints.slopes for slope in row.values()]
        emit_values(kind, slopes, known, self.constants)
        for residual, row in zip(residuals, constraints.slopes):
            if residual is not None:
                terms = (kind.mul(known[slope], known[amounts[k]]) for k, slope in row.items())
                size = kind.total((kind.one, kind.magnitude(term)) for term in terms)
                bound = kind.mul(kind.number(LOOSE * kind.unit), size)
                fine = kind.both(fine, kind.compare("ole", kind.magnitude(residual), bound))
        return fine


def afterwards(
    residual: Residual, constraints: Constraints, many: int
) -> tuple[list[Node], Sequence[Node], Sequence[Node]]:
    """Symbols of changes of coordinates and of their multipliers, ``many`` in all; what goes to the
    velocities with them, and by how much what should be 0 of the velocities changes."""
    graph, model = residual.graph, residual.model
    symbols, size = [graph.symbol(f"change {i}") for i in range(many)], len(model.q)
    moves = symbols[:size]
    kicks = constraints.transport(tuple(symbols[size:]), tuple(moves), Energetics(model).momenta)
    places, later = numbered(model.q), []
    for speed in constraints.speeds:
        slopes = graph.gradient(speed, places)
        later.append(graph.sum([(slope * moves[k], 1.0) for k, slope in slopes.items()]))
    return symbols, kicks, later


def in_doubles(
    residual: Residual, layout: StateLayout, constants: Constants, make: Callable[[Function], Emitter]
) -> str:
    """``@project`` for a state of doubles with low parts."""
    f = Function(HEAD)
    return Projection(f, residual, places_of(layout), constants, doubles(make(f))).text()


def in_lanes(residual: Residual, places: StatePlaces, constants: Constants) -> str:
    """The same for eight motions."""
    f = Function("define internal void @project_lanes(ptr %constants, ptr %state, BIT %moving) #0", LANES)
    return Projection(f, residual, places, constants, doubles(LaneEmitter(f))).text()


def in_double_doubles(residual: Residual, layout: StateLayout, constants: Constants) -> str:
    """The same for double-double, without the third parts."""
    f = Function(HEAD)
    kind = DoubleDouble(f)
    numbers = Numbers(kind, kind, lambda x: x, lambda x: x)
    return Projection(f, residual, places_of(layout), constants, numbers).text()


def places_of(layout: StateLayout) -> StatePlaces:
    """The places of a motion."""
    times = layout.time, layout.at(Clock.TIME_LOW), layout.at(Clock.PROJECTIONS)
    return StatePlaces(0, layout.degrees, layout.width, *times)


def doubles(emitter: Emitter) -> Numbers[str, Sum]:
    """The numbers of an emitter of doubles, with low parts."""

    def rounded(value: Sum | None) -> Value:
        return None if value is None else emitter.add(*value)

    def exact(value: Value) -> Sum | None:
        return None if value is None else (value, None)

    return Numbers(emitter, Compensated(emitter), rounded, exact)
