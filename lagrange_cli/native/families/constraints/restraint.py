"""The equations for accelerations and multipliers with constraints, as totals, where M is diagonal.

With A for the slopes of the constraints f and c for the rest of their second derivatives, or of the first
ones of constraints g on velocities,

    M a = F + A^T lambda,    A a + c = 0,    so that    A M^-1 A^T lambda = -c - A M^-1 F.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.node import Node, union
from lagrange_cli.families.arrays import Array, Domain, Slot, Source, Term, Total
from lagrange_cli.families.bonds import Bonds, Bound
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.constraints.dense import SolvingTables
from lagrange_cli.native.families.corrected import Local, in_series
from lagrange_cli.native.families.lasting import Lasting


class Bonded:
    """What is computed of constraints, in a run of their own: what is ``lasting`` is computed before."""

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        self.system, self.lasting, self.bonds = system, lasting, self.bonds_of(system)
        self.slots, self.graph = system.slots, system.slots.graph
        self.bounds, self.count, self.size = self.bonds.bounds, self.bonds.count, system.q.count
        self.multipliers = Array(Source.TOTAL, self.count)
        """lambda."""
        self.rest = Array(Source.TOTAL, self.count)
        """c."""

    def bonds_of(self, system: FamilySystem) -> Bonds:
        """The constraints of a system."""
        assert system.bonds is not None
        return system.bonds

    @cached_property
    def joined(self) -> tuple[int, ...]:
        """For each coordinate the first of those that constraints couple with it."""
        first, pairs = np.arange(self.system.q.count), [(one.numbers, one.rows) for one in self.bounds]
        while True:
            before, least = first.copy(), np.full(self.count, len(first))
            for numbers, columns in pairs:
                for rows in columns:
                    np.minimum.at(least, numbers, first[rows])
            for numbers, columns in pairs:
                for rows in columns:
                    np.minimum.at(first, rows, least[numbers])
            first = first[first]
            if np.array_equal(first, before):
                return tuple(first.tolist())

    def total(self, count: int, terms: Sequence[Term]) -> Total:
        return self.lasting.arranged(Total(Source.TOTAL, count, tuple(terms)), kept=False)

    def series_of(
        self,
        bound: Bound,
        places: Mapping[Array, Array],
        slopes: Iterable[tuple[Node, Array, tuple[Places, Array, Node | float]]],
        multiplier: Node,
        change: Callable[[Slot], Node],
    ) -> Local:
        """What the series of a bound give: c, and for each of some symbols a column of A and, if that moves,
        what A^T lambda adds at some places of an array, with a factor. ``places`` has places by their
        velocities; ``change`` gives the acceleration of one."""
        graph, domain, every = self.graph, bound.domain, bound.domain.every
        (own,) = self.total(domain.count, [Term(domain, bound.node, every)]).terms
        node, found = in_series(self.slots, own.node, domain, places)
        moving, rate = union((self.system.time, *found)), graph.ddt(node)
        terms: list[tuple[Term, Array]] = [
            (Term(domain, graph.ddt(rate) if bound.holonomic else rate, bound.numbers), self.rest)
        ]
        columns, bent = list[tuple[Term, Array]](), False
        for symbol, column, (rows, to, factor) in slopes:
            slope = graph.diff(own.node, symbol)
            columns.append((Term(domain, slope, every), column))
            if slope.symbols & moving:
                bent = True
                terms.append((Term(domain, factor * slope * multiplier, rows), to))
        changes, unknowns = [change(one) for one in found.values()], [multiplier] * bent
        return Local(domain, [*terms, *columns], len(columns), [*found], unknowns, changes)


class Restraint(Bonded):
    """The totals of the constraints of a system whose M is diagonal."""

    definite = True
    """Whether the matrix of the equations is positive."""

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        super().__init__(system, lasting)
        self.halts = None if system.modes is None else system.modes.halts
        self.everyone = system.everyone
        self.slopes = self.all_columns()
        """A, of each bound a column for each of its coordinates."""
        self.square = self._square()

    @cached_property
    def inverses(self) -> Array:
        """1/M, and 0 of coordinates that friction holds."""
        if self.halts is None:
            return self.lasting.inverses
        node = self.of_all(self.gates) * self.of_all(self.lasting.inverses)
        whole = Total(Source.TOTAL, self.size, (Term(self.everyone, node, self.everyone.every),))
        return self.lasting.arranged(whole)

    @cached_property
    def gates(self) -> Array:
        """1, and 0 of coordinates that friction holds."""
        assert self.halts is not None
        return self.lasting.arranged(self.halts.gates)

    @cached_property
    def parts(self) -> Places:
        """For each constraint the number of the part of the equations that it is in."""
        first = np.zeros(self.count, dtype=np.int64)
        for one in self.bounds:
            if one.rows:
                first[one.numbers] = np.array(self.joined)[one.rows[0]]
        return first

    @cached_property
    def tolerance(self) -> Array:
        """For each constraint 1, or -1 where friction holds coordinates of that part."""
        joined, graph, every = np.array(self.joined), self.graph, Domain(self.count)
        held = Term(self.everyone, 1.0 - self.of_all(self.gates), joined)
        stuck = self.lasting.arranged(Total(Source.TOTAL, self.size, (held,)))
        node = graph.switch(0.5 - self.slots.symbol(every, stuck, self.parts), graph.one, -graph.one, -1)
        return self.lasting.arranged(Total(Source.TOTAL, self.count, (Term(every, node, every.every),)))

    def hold(self, domain: Domain, first: Places, second: Places) -> Node:
        """1 where two constraints hold the motion."""
        return self.graph.one

    def loose(self, domain: Domain) -> Node | None:
        """1 where one does not; None if all of them always do."""
        return None

    def all_columns(self) -> Sequence[Sequence[Array]]:
        """The columns of A."""
        return [[self.column(one, slope) for slope in one.slopes] for one in self.bounds]

    def column(self, bound: Bound, slope: Node) -> Array:
        """A column of A, which may be computed elsewhere."""
        return Array(Source.TOTAL, bound.domain.count)

    def own(self, bound: int, array: Array, places: Sequence[int] | None = None) -> Node:
        """An array at the numbers of the constraints of a bound, or at other places."""
        one = self.bounds[bound]
        return self.slots.symbol(one.domain, array, one.numbers if places is None else np.asarray(places))

    def slope(self, bound: int, column: int) -> Node:
        """A."""
        one = self.bounds[bound]
        return self.slots.own(one.domain, self.slopes[bound][column])

    def of_all(self, array: Array) -> Node:
        """An array of all coordinates."""
        return self.slots.own(self.everyone, array)

    def pushed(self, forces: Total) -> Total:
        """M^-1 times forces."""
        return self._divided(forces, self.inverses)

    def accelerated(self, forces: Total) -> Total:
        """The same of forces that are 0 already on what is held, but for what carries it along."""
        return self._divided(forces, self.lasting.inverses)

    def _divided(self, forces: Total, inverses: Array) -> Total:
        push = self.of_all(forces) * self.of_all(inverses)
        return self.total(self.size, [Term(self.everyone, push, self.everyone.every)])

    def of_bounds(self, make: Mapping[int, Node], less: Array | None = None) -> Total:
        """A total with a number for each constraint, ``less`` one of each besides."""
        terms = []
        for b, one in enumerate(self.bounds):
            node = make[b] - self.own(b, less) if less is not None and one.whole else make[b]
            terms.append(Term(one.domain, node, one.numbers))
        summed = self.bonds.summed
        if less is not None and len(summed):
            domain = Domain(len(summed))
            terms.append(Term(domain, -self.slots.symbol(domain, less, summed), summed))
        return self.total(self.count, terms)

    def on_coordinates(self, node: Node | None, multiplied: Array) -> Total:
        """M^-1 A^T times a number for each constraint, and ``node`` of each coordinate besides."""
        terms = [] if node is None else [Term(self.everyone, node, self.everyone.every)]
        for b, one in enumerate(self.bounds):
            for a, rows in enumerate(one.rows):
                inverse = self.slots.symbol(one.domain, self.inverses, rows)
                terms.append(Term(one.domain, inverse * self.slope(b, a) * self.own(b, multiplied), rows))
        return self.total(self.size, terms)

    def along(self, bound: int, array: Array) -> Node:
        """A times an array of all coordinates."""
        one = self.bounds[bound]
        symbols = [self.slots.symbol(one.domain, array, rows) for rows in one.rows]
        return self.graph.sum([(self.slope(bound, a) * x, 1.0) for a, x in enumerate(symbols)])

    def rate(self, node: Node) -> Node:
        """The rate of an expression of coordinates, velocities and t, without accelerations."""
        graph, system = self.graph, self.system
        terms = [(graph.diff(node, system.time), 1.0)]
        for x, slot in [*self.slots.inside(node)]:
            if slot.array is system.q:
                speed = self.slots.symbol(slot.domain, system.v, slot.table)
                terms.append((graph.diff(node, x) * speed, 1.0))
        return graph.sum(terms)

    def _square(self) -> Total:
        """The entries of A M^-1 A^T, and behind them 0 and 1; then, where friction may hold coordinates, what
        pivots are compared with: entries on the diagonal while it does not, and their opposites while it
        does."""
        end = len(self.entries) + 1
        one = Term(self.system.root, self.graph.one, np.array([end]))
        sizes = [] if self.halts is None else [*self._sizes_of_pivots(end + 1)]
        return self.total(end + 1 + (self.count if sizes else 0), [*self.square_terms(), one, *sizes])

    def _sizes_of_pivots(self, first: int) -> Iterator[Term]:
        for b, one in enumerate(self.bounds):
            for a, rows in enumerate(one.rows):
                inverse = self.slots.symbol(one.domain, self.lasting.inverses, rows)
                size = inverse * self.slope(b, a) * self.slope(b, a) * self.own(b, self.tolerance)
                yield Term(one.domain, size, first + one.numbers)

    def square_terms(self) -> list[Term]:
        """What these entries are made of."""
        terms = []
        for pair in self.bonds.pairs[0]:
            domain = Domain(len(pair.rows))
            one, other = (
                self.slots.symbol(domain, self.slopes[b][a], which)
                for (b, a), which in zip((pair.first, pair.second), pair.members)
            )
            inverse = self.slots.symbol(domain, self.inverses, pair.rows)
            numbers = (
                self.bounds[b].numbers[which]
                for (b, _), which in zip((pair.first, pair.second), pair.members)
            )
            both = self.hold(domain, *numbers)
            terms.append(Term(domain, both * inverse * one * other, pair.entries))
        every = Domain(self.count)
        loose = self.loose(every)
        if loose is not None:
            places = np.array([self.entries[i, i] for i in range(self.count)])
            terms.append(Term(every, loose, places))
        return terms

    @cached_property
    def entries(self) -> Mapping[tuple[int, int], int]:
        """Where entries are in the square."""
        return {(i, j): k for k, (i, j) in enumerate(self.bonds.pairs[1].tolist())}

    def placed(self, saddle: SolvingTables) -> Mapping[str, Places]:
        """The places of the entries that are factored."""
        sizes = None if self.halts is None else len(self.entries) + 2 + np.arange(self.count)
        return saddle.placed(self.bonds.pairs[1], sizes)


class AtAState(Restraint):
    """Those of the multipliers at one state."""

    @property
    def found(self) -> Sequence[Array]:
        """What is solved for."""
        return (self.bonds.multipliers,)

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        super().__init__(system, lasting)
        self.free = self.accelerated(lasting.arranged(system.forces, kept=False))
        self.right = self.of_bounds(
            {b: -self.rate(one.speed) - self.along(b, self.free) for b, one in enumerate(self.bounds)}
        )

    def column(self, bound: Bound, slope: Node) -> Array:
        return self.total(bound.domain.count, [Term(bound.domain, slope, bound.domain.every)])


class AlongMotion(Restraint):
    """Those of the equations of motion, of order k: A^T lambda without what is newest in it is added to the
    ``forces``."""

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        super().__init__(system, lasting)
        self.forces = lasting.arranged(system.forces, kept=False)
        self.arrange()

    def arrange(self) -> None:
        """Find what is solved for, and what that is made of."""
        self.free = self.accelerated(self.forces)
        """Accelerations without constraints."""
        self.right = self.of_bounds(
            {b: -self.along(b, self.free) for b, _ in enumerate(self.bounds)}, less=self.rest
        )
        self.sides = self.sides_of(self.right)
        self.rates = self.on_coordinates(None, self.multipliers)
        """The same with constraints: what these add to ``free``."""
        self.final: Array = self.finished(self.rates)
        self.locals = [self._local(b, one) for b, one in enumerate(self.bounds) if one.rows]

    def sides_of(self, right: Total) -> Sequence[Total]:
        """The right side, behind what it takes."""
        return [right]

    def finished(self, rates: Total) -> Total:
        """The accelerations, from those that all forces give."""
        return rates

    @property
    def columns_at_first(self) -> Sequence[Array]:
        """What is computed at order 0 alone, for the matrix of the equations."""
        return [one for some in self.slopes for one in some]

    @property
    def arrays(self) -> Sequence[Array]:
        """All that are computed, besides the rates."""
        own = [] if self.final is self.rates else [self.final]
        return [
            self.rest,
            *self.columns_at_first,
            self.square,
            self.free,
            *self.sides,
            self.multipliers,
            *own,
        ]

    def _local(self, number: int, bound: Bound) -> Local:
        """What the series of a bound give."""
        return self.series_of(
            bound, {self.system.v: self.system.q}, self.columns(number), self.own(number, self.multipliers),
            lambda place: self.slots.symbol(bound.domain, self.final, place.table),
        )  # fmt: skip

    def columns(self, number: int) -> Sequence[tuple[Node, Array, tuple[Places, Array, Node | float]]]:
        """The symbols of a bound's coordinates, where its slopes by these go, and its forces."""
        bound = self.bounds[number]
        pulled = [(rows, self.forces, self._moves(bound, rows)) for rows in bound.rows]
        return [*zip(bound.symbols, self.slopes[number], pulled)]

    def _moves(self, bound: Bound, rows: Places) -> Node:
        """1, and 0 where friction holds coordinates."""
        return self.graph.one if self.halts is None else self.slots.symbol(bound.domain, self.gates, rows)
