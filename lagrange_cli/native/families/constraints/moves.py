"""What a projection computes, as totals: by how much constraints are off, and what takes the state back."""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Source, Term, Total
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.constraints.jet import Saddle, solve
from lagrange_cli.native.families.constraints.restraint import Restraint
from lagrange_cli.native.families.constraints.together import Together
from lagrange_cli.native.families.evaluation import Evaluation
from lagrange_cli.native.families.lasting import Lasting
from lagrange_cli.native.families.loops import Loop


class Offsets(Restraint):
    """What should be 0, which a projection begins with, and the slopes of this."""

    moved: Array
    """By how much coordinates are moved."""

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        super().__init__(system, lasting)
        self.off, self.off_speeds = Array(Source.TOTAL, self.count), Array(Source.TOTAL, self.count)
        """f, and df/dt or g."""
        self.columns = self.own_columns()
        """The slopes, which are computed with them."""
        self.sizes = Array(Source.TOTAL, self.count), Array(Source.TOTAL, self.count)
        """Of constraints with several terms: by how much rounding may change what should be 0."""
        self.loops = [self._loop(b) for b, _ in enumerate(self.bounds)]

    def own_columns(self) -> Sequence[Sequence[Array]]:
        """Where the slopes are."""
        return self.slopes

    def kicks_of(self) -> Total:
        """M dv without forces of constraint (``Constraints.transport``)."""
        kicks = []
        for b, one in enumerate(self.bounds):
            for slope, rows in zip(one.slopes, one.rows) if one.holonomic else ():
                rate = self.rate(slope)
                if not rate.is_zero:
                    kicks.append(Term(one.domain, -(self.own(b, self.multipliers) * rate), rows))
        return self.total(self.size, kicks)

    def later(self, bound: int) -> Node:
        """By how much what should be 0 of velocities changes as coordinates are moved."""
        graph, one = self.graph, self.bounds[bound]
        terms = [
            (graph.diff(one.speed, x) * self.slots.symbol(one.domain, self.moved, slot.table), 1.0)
            for x, slot in self.slots.inside(one.speed)
            if slot.array is self.system.q
        ]
        return graph.sum(terms)

    def _loop(self, number: int) -> Loop:
        """What is computed of a bound before it is known whether anything moves."""
        one = self.bounds[number]
        every = one.domain.every
        place = one.node if one.holonomic else self.graph.zero
        given = [(place, one.numbers, self.off), (one.speed, one.numbers, self.off_speeds)]
        given += [(node, every, array) for node, array in zip(one.slopes, self.columns[number])]
        if not one.whole:
            given += [(self.graph.one, one.numbers, array) for array in self.sizes]
        terms: list[tuple[Term, Array]] = []
        for node, targets, array in given:
            (term,) = self.total(one.domain.count, [Term(one.domain, node, targets)]).terms
            terms.append((term, array))
        # their velocities are read in any case
        sizes = [self.slots.symbol(one.domain, self.system.v, rows) for rows in one.rows]
        read = [(Term(one.domain, x, every), Array(Source.TOTAL, one.domain.count)) for x in sizes]
        return Loop(one.domain, [*terms, *read], self.slots, frozenset(self.columns[number]))

    @property
    def arrays(self) -> Sequence[Array]:
        """All that are computed."""
        columns = [one for some in self.columns for one in some]
        return [self.off, self.off_speeds, *(self.sizes if len(self.bonds.summed) else ()), *columns]


class Moves(Offsets):
    """The totals of a projection: coordinates are ``moved`` first, and then velocities."""

    moved: Total

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        super().__init__(system, lasting)
        numbers = range(len(self.bounds))
        self.right = self.of_bounds(dict.fromkeys(numbers, self.graph.zero), less=self.off)
        self.moved = self.on_coordinates(None, self.multipliers)
        self.kicks = self.kicks_of()
        self.free = self.pushed(self.kicks)
        self.right_speeds = self.of_bounds(
            {b: -self.later(b) - self.along(b, self.free) for b in numbers}, less=self.off_speeds
        )
        self.speeds = self.on_coordinates(self.of_all(self.free), self.multipliers)

    @property
    def arrays(self) -> Sequence[Array]:
        found = [self.square, self.right, self.multipliers, self.moved]
        return [*super().arrays, *found, self.kicks, self.free, self.right_speeds, self.speeds]

    def move(self, evaluation: Evaluation, saddle: Saddle) -> None:
        """Compute by how much the state is moved."""
        where = evaluation.where
        for right, total in ((self.right, self.moved), (self.right_speeds, self.speeds)):
            if total is self.speeds:
                evaluation.write([self.kicks])
                evaluation.write([self.free])
            evaluation.write([right])
            solve(saddle, where(right), where(self.multipliers))
            evaluation.write([total])


class MovesTogether(Offsets, Together):
    """The same where M is not diagonal: both are found with their forces of constraint."""

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        super().__init__(system, lasting)
        self.moved = self.solution
        numbers = range(len(self.bounds))
        self.right = self.whole(None, dict.fromkeys(numbers, self.graph.zero), more=self.off)
        self.kicks = self.kicks_of()
        self.speeds = Array(Source.TOTAL, self.saddle.count)
        later = {b: self.later(b) for b in numbers}
        self.right_speeds = self.whole(self.kicks, later, more=self.off_speeds)
        self.backs[self.speeds] = self.back(self.speeds)

    def own_columns(self) -> Sequence[Sequence[Array]]:
        if not self.lasts:
            return self.slopes
        return [[Array(Source.TOTAL, one.domain.count) for _ in one.rows] for one in self.bounds]

    @property
    def arrays(self) -> Sequence[Array]:
        return [
            *super().arrays,
            *self.before,
            self.square,
            self.right,
            self.moved,
            self.kicks,
            self.right_speeds,
            self.speeds,
        ]

    def move(self, evaluation: Evaluation, saddle: Saddle) -> None:
        """Compute by how much the state is moved."""
        for right, found in ((self.right, self.moved), (self.right_speeds, self.speeds)):
            if found is self.speeds:
                evaluation.write([self.kicks])
            evaluation.write([right])
            solve(saddle, evaluation.where(right), evaluation.where(found))
            self.spin(evaluation, found)
