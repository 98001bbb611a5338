"""Rounding errors of totals: how large the terms are of which they are sums."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.node import Node, reachable
from lagrange_cli.families.arrays import Array, Chain, Domain, Source, Term, Total, total_of
from lagrange_cli.families.contacts import Coupled
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.mechanics.rounding import size_of
from lagrange_cli.records import replace


class Unbounded(Exception):
    """Rounding errors have no bound that is known."""


class Sizes:
    """The sizes of the rounding errors of totals of a ``system``, in units of the last place."""

    def __init__(self, system: FamilySystem) -> None:
        self.system, self.slots, self.graph = system, system.slots, system.slots.graph
        self._sizes: dict[Total, Total] = {}
        self._looked: dict[Total, Total] = {}
        self._moving = system.time.symbols
        """The symbols of what moves, and of what contains these."""

    def size(self, total: Total) -> Total:
        """The sizes of the errors of a total."""
        if total not in self._sizes:
            terms = [replace(one, node=self.size_of(one)) for one in self.looked(total).terms]
            self._sizes[total] = self.like(total, terms)
        return self._sizes[total]

    def looked(self, total: Total) -> Total:
        """A total whose symbols are known; what is computed from all equations together is Unbounded."""
        if total not in self._looked:
            self._looked[total] = total
            for term in total.terms:
                for symbol, slot in self.slots.inside(term.node):
                    if self._moves(slot.array):
                        self._moving |= symbol.symbols
        return total

    def _moves(self, array: Array) -> bool:
        """Whether an array moves."""
        system = self.system
        if array in (system.q, system.v) or (array is system.accelerations):
            return True
        if not isinstance(array, Total):
            if array.source is Source.TOTAL:
                raise Unbounded
            return False
        if array in solved(system):
            raise Unbounded
        return any(one.node.symbols & self._moving for one in self.looked(array).terms)

    def like(self, total: Total, terms: Sequence[Term]) -> Total:
        """A total of other terms, along the same chain if it is one."""
        chain = (total.tree, total.back) if isinstance(total, Chain) else (None, False)
        return total_of(total.count, terms, self.graph, chain[0], back=chain[1])

    def size_of(self, term: Term) -> Node:
        """The size of the error of a term."""
        graph, known = self.graph, dict(self._known(term))
        return size_of(graph, term.node, known=known, steep=False)

    def _known(self, term: Term) -> Iterator[tuple[Node, Node]]:
        """The sizes of what is constant in a term, whose error is the same at any time, and of totals."""
        for node in reachable([term.node]):
            if not node.symbols & self._moving:
                yield node, self.graph.absolute(node)
        for symbol, slot in self.slots.inside(term.node):
            if isinstance(slot.array, Total) and slot.array.terms and symbol.symbols & self._moving:
                yield symbol, self.slots.symbol(slot.domain, self.size(slot.array), slot.table)


def solved(system: FamilySystem) -> set[Total]:
    """Forces that are computed from all equations together."""
    bonds = [system.bonds, system.contact.bonds if isinstance(system.contact, Coupled) else None]
    modes = system.modes
    if modes is not None:
        bonds.append(modes.sticking)
    locked = {modes.locks.left} if modes is not None and modes.locks is not None else set()
    return {one.multipliers for one in bonds if one is not None} | locked


def of_integrands(
    system: FamilySystem, integrands: Mapping[int, tuple[Total, int]], count: int
) -> Total | None:
    """The sizes of the rounding errors of ``integrands``, each at its number among ``count`` integrals; None
    where no bound is known of any."""
    sizes, terms = Sizes(system), list[Term]()
    for total, both in places_of(integrands).items():
        try:
            size = sizes.size(total)
        except Unbounded:
            continue
        domain = Domain(len(both[0]))
        terms.append(Term(domain, system.slots.symbol(domain, size, both[0]), both[1]))
    return total_of(count, terms, system.slots.graph) if terms else None


def places_of(listed: Mapping[int, tuple[Total, int]]) -> dict[Total, tuple[Places, Places]]:
    """The places in each total of what is listed by numbers, and these numbers."""
    found: dict[Total, tuple[list[int], list[int]]] = {}
    for number, (total, index) in listed.items():
        sources, targets = found.setdefault(total, ([], []))
        sources.append(index)
        targets.append(number)
    return {total: (np.array(both[0]), np.array(both[1])) for total, both in found.items()}
