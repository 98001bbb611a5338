"""The equations for accelerations and multipliers together, as totals, where M is not diagonal, or no
constant (see ``families.saddle_points``).

Where M and A are constant, their matrix is factored once; else in each step.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Domain, Slot, Source, Term, Total
from lagrange_cli.families.bonds import Bonds, Bound
from lagrange_cli.families.coupled_masses import CoupledMasses, Spin
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.saddle_points import SaddlePoint
from lagrange_cli.native.families.constraints.dense import SolvingTables
from lagrange_cli.native.families.constraints.restraint import AlongMotion, Restraint
from lagrange_cli.native.families.corrected import Local, in_series
from lagrange_cli.native.families.evaluation import Evaluation
from lagrange_cli.native.families.lasting import Lasting
from lagrange_cli.native.families.loops import needed
from lagrange_cli.records import dataclass, field, replace


class Together(Restraint):
    """The totals: ``solution`` has the accelerations, or other changes of coordinates, and behind them the
    multipliers. If the matrix ``lasts``, it is that of ``lasting_entries``."""

    definite = False

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        assert system.saddle is not None
        self.saddle: SaddlePoint = system.saddle
        self.lasts = lasting.matrix
        self.solution = Array(Source.TOTAL, self.saddle.count)
        self.masses = self.masses_in(lasting)
        super().__init__(system, lasting)
        self.backs = {self.solution: self.back(self.solution)}
        """What is added to solutions for spins, which stand alone in the matrix."""

    def bonds_of(self, system: FamilySystem) -> Bonds:
        return self.saddle.bonds

    def masses_in(self, lasting: Lasting) -> Sequence[Array]:
        """Arrays that have the entries of M together, and behind them what ``CoupledMasses`` has there."""
        return [lasting.arranged(self.saddle.masses.factored.entries)]

    @property
    def spins(self) -> Sequence[Spin]:
        """The coordinates that stand alone in the matrix."""
        return self.saddle.masses.factored.spins

    def ratio(self, spin: int, number: int) -> Node:
        """One of the ratios of masses with those of a spin."""
        return self.spins[spin].ratios[number][0]

    def back(self, array: Array) -> Total:
        """What is added to a solution for spins."""
        terms = []
        for k, spin in enumerate(self.spins):
            for j, (_, rows) in enumerate(spin.ratios):
                node = self.ratio(k, j) * self.slots.symbol(spin.domain, array, rows)
                terms.append(Term(spin.domain, -node, spin.rows))
        return self.total(array.count, terms)

    def spin(self, evaluation: Evaluation, solution: Array) -> None:
        """Add to a solution what spins have besides, once it is computed."""
        if self.spins:
            evaluation.add([self.backs[solution]])

    @property
    def before(self) -> Sequence[Total]:
        """What the matrix is made of besides, if that does not last."""
        made = [one for one in self.masses if isinstance(one, Total)]
        return needed(made, self.slots, self.lasting.fixed)

    def all_columns(self) -> Sequence[Sequence[Array]]:
        return [() for _ in self.bounds] if self.lasts else super().all_columns()

    def _square(self) -> Total:
        """The entries of the matrix, and behind them 0, 1, and what pivots of constraints are compared with;
        nothing if they last."""
        if self.lasts:
            return Total(Source.TOTAL, 0)
        return self.lasting.arranged(entries(self.system, self.masses, self.slope), kept=False)

    def placed(self, saddle: SolvingTables) -> Mapping[str, Places]:
        return saddle.placed(self.saddle.pairs, self.saddle.sizes)

    def pushes(self, force: Array) -> Iterator[Term]:
        """Forces on coordinates, less those that spins stand alone by."""
        yield Term(self.everyone, self.of_all(force), self.everyone.every)
        for k, spin in enumerate(self.spins):
            for j, (_, rows) in enumerate(spin.ratios):
                node = self.ratio(k, j) * self.slots.symbol(spin.domain, force, spin.rows)
                yield Term(spin.domain, -node, rows)

    def whole(self, force: Array | None, make: Mapping[int, Node], more: Array | None = None) -> Total:
        """The right side: forces on coordinates, and c of each constraint, ``more`` of each besides."""
        first = self.size
        terms = [] if force is None else [*self.pushes(force)]
        for b, one in enumerate(self.bounds):
            if b in make and not make[b].is_zero:
                terms.append(Term(one.domain, make[b], first + one.numbers))
        if more is not None and self.count:
            domain = Domain(self.count)
            terms.append(Term(domain, self.slots.own(domain, more), first + domain.every))
        return self.total(self.saddle.count, terms)


def entries(system: FamilySystem, masses: Sequence[Array], slope: Callable[[int, int], Node]) -> Total:
    """The entries of the matrix, from those of M, which are sums of those in ``masses``, and the ``slope`` of
    each bound by each of its coordinates."""
    saddle, slots, graph = system.saddle, system.slots, system.slots.graph
    assert saddle is not None
    bonds, diagonal = saddle.bonds, saddle.sizes[: saddle.masses.count]
    own, end = Domain(len(saddle.masses.pairs)), len(saddle.pairs)
    terms = [Term(own, graph.sum([(slots.own(own, one), 1.0) for one in masses]), own.every)]
    for (b, a), places in zip(bonds.pulls, saddle.places):
        one, value = bonds.bounds[b], slope(b, a)
        mass = graph.sum([(slots.symbol(one.domain, m, diagonal[one.rows[a]]), 1.0) for m in masses])
        inverse = graph.number(1) / graph.absolute(mass)
        terms.append(Term(one.domain, -value, places))
        terms.append(Term(one.domain, inverse * value * value, end + 2 + one.numbers))
    terms.append(Term(system.root, graph.one, np.array([end + 1])))
    return Total(Source.TOTAL, end + 2 + bonds.count, tuple(terms))


def lasting_entries(system: FamilySystem, lasting: Lasting) -> Total | None:
    """Those of a matrix that lasts; None where slopes of constraints change, or M."""
    saddle = system.saddle
    assert saddle is not None
    if not system.lasting_matrix:
        return None
    masses, bounds = [lasting.arranged(saddle.masses.entries)], saddle.bonds.bounds
    found = lasting.arranged(entries(system, masses, lambda b, a: bounds[b].slopes[a]))
    return found if found in lasting.fixed else None


class TogetherAtAState(Together):
    """Those of the accelerations and multipliers at one state."""

    @property
    def found(self) -> Sequence[Array]:
        """What is solved for."""
        return self.system.accelerations, self.bonds.multipliers

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        super().__init__(system, lasting)
        forces = lasting.arranged(system.forces, kept=False)
        self.right = self.whole(forces, {b: self.rate(one.speed) for b, one in enumerate(self.bounds)})

    def column(self, bound: Bound, slope: Node) -> Array:
        return self.total(bound.domain.count, [Term(bound.domain, slope, bound.domain.every)])


class FreeAtAState:
    """The same without constraints: accelerations alone, by factors of M, which last."""

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        self.square = Total(Source.TOTAL, 0)
        self.right = lasting.arranged(system.forces, kept=False)
        self.solution = Array(Source.TOTAL, system.q.count)
        self.found = (system.accelerations,)


class TogetherAlongMotion(Together, AlongMotion):
    """Those of the equations of motion, of order k: A^T lambda without what is newest in it is added to the
    ``forces``."""

    def arrange(self) -> None:
        self.right = self.whole(self.forces, {}, more=self.rest)
        self.final = self.solution
        self.locals = [self._local(b, one) for b, one in enumerate(self.bounds) if one.rows]
        if self.system.curved:
            self.locals += moving_masses(self, self.saddle.masses, self.masses[-1])

    @cached_property
    def ratios(self) -> Sequence[Sequence[Array]]:
        """Where the ratios are that spins have at order 0."""
        return [[Array(Source.TOTAL, one.domain.count) for _ in one.ratios] for one in self.spins]

    def ratio(self, spin: int, number: int) -> Node:
        return self.slots.own(self.spins[spin].domain, self.ratios[spin][number])

    def masses_in(self, lasting: Lasting) -> Sequence[Array]:
        if not self.saddle.masses.curved:
            return super().masses_in(lasting)
        whole = lasting.arranged(self.saddle.masses.factored.entries)
        lasts = tuple(one for one in whole.terms if lasting.is_fixed(one.node))
        return [lasting.arranged(replace(whole, terms=lasts)), Array(Source.TOTAL, whole.count)]

    @property
    def columns_at_first(self) -> Sequence[Array]:
        ratios = [one for some in self.ratios for one in some]
        return [*super().columns_at_first, *self.masses[1:], *ratios]

    @property
    def arrays(self) -> Sequence[Array]:
        return [self.rest, *self.columns_at_first, self.square, self.right, self.solution]


@dataclass
class Members:
    """What the series of the members of a domain give: terms of M a on coordinates, by the symbols of these,
    and what the matrix is made of at order 0, with the arrays that these are added to; and the ``sums`` that
    masses contain."""

    coordinates: dict[Node, Slot] = field(default_factory=dict)
    sums: dict[Node, None] = field(default_factory=dict)
    pushes: dict[Node, list[tuple[Node, float]]] = field(default_factory=dict)
    columns: list[tuple[Term, Array]] = field(default_factory=list)


def moving_masses(motion: TogetherAlongMotion, masses: CoupledMasses, entries: Array) -> Iterator[Local]:
    """What the series of masses that are no constants give: what M a has of orders before the newest one,
    with the other sign, on coordinates, and at order 0 the ``entries`` of the matrix and the ratios of spins.
    """
    slots, graph, q = motion.slots, motion.graph, motion.system.q
    kinds: dict[Domain, Members] = {}

    def series(domain: Domain, node: Node) -> tuple[Members, Node]:
        """An expression of coordinates, with arrays of what lasts."""
        (own,) = motion.total(domain.count, [Term(domain, node, domain.every)]).terms
        value, inside = in_series(slots, own.node, domain, {motion.system.v: q})
        kind = kinds.setdefault(domain, Members())
        kind.coordinates.update(inside)
        totals = ((s, slot) for s, slot in slots.inside(value) if isinstance(slot.array, Total))
        kind.sums.update((s, None) for s, slot in totals if slot.array not in motion.lasting.fixed)
        return kind, value

    for one in masses.curved:
        kind, mass = series(one.domain, one.node)
        both = [slots.symbol(one.domain, q, table) for table in (one.first, one.second)]
        kind.coordinates.update((place, slots.of[place]) for place in both)
        for place, other in (both, reversed(both)):
            kind.pushes.setdefault(place, []).append((mass * graph.ddt(graph.ddt(other)), -1.0))
    for one in masses.factored.curved:
        kind, mass = series(one.domain, one.node)
        kind.columns += [(Term(one.domain, mass, at), entries) for at in masses.places(one)]
    for spin, arrays in zip(motion.spins, motion.ratios):
        for (node, _), array in zip(spin.ratios, arrays):
            kind, ratio = series(spin.domain, node)
            kind.columns.append((Term(spin.domain, ratio, spin.domain.every), array))
    for domain, members in kinds.items():
        found = members.coordinates
        terms = [
            (Term(domain, graph.sum(some), found[place].table), motion.forces)
            for place, some in members.pushes.items()
        ]
        changes = [slots.symbol(domain, motion.final, slot.table) for slot in found.values()]
        listed = [*terms, *members.columns]
        yield Local(domain, listed, len(members.columns), [*found], [], changes, [*members.sums])
