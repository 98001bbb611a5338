"""What does not change during a motion: masses, and whatever terms contain of indices and parameters.

It is computed once, by ``@prepare``, into arrays behind the constants.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.families.arrays import Array, Source, Term, Total, total_of
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.records import replace


class Lasting:
    """Totals of a system with arrays in place of what is constant in them."""

    def __init__(self, system: FamilySystem) -> None:
        self.system, self.slots, self.graph = system, system.slots, system.slots.graph
        self.fixed: dict[Array, None] = {}
        """Totals that are constants of the motion, in the order of their computation."""
        self.changed: dict[Total, Total] = {}
        self.matrix = False
        """Whether the matrix of M and constraints lasts, where M is not diagonal."""

    @cached_property
    def masses(self) -> Total:
        """M, where it is diagonal."""
        return self.arranged(self.system.masses)

    @cached_property
    def inverses(self) -> Total:
        """1 / M."""
        everyone = self.system.everyone
        inverse = self.graph.number(1) / self.slots.own(everyone, self.masses)
        return self.arranged(total_of(everyone.count, [Term(everyone, inverse, everyone.every)], self.graph))

    def is_fixed(self, node: Node) -> bool:
        """Whether a node is a constant of the motion."""
        if node.symbols & self.system.time.symbols:
            return False
        lasting = Source.PARAMETERS, Source.WHOLE, Source.MODES
        return all(
            slot.array.source in lasting or slot.array in self.fixed for _, slot in self.slots.inside(node)
        )

    def arranged(self, total: Total, *, kept: bool = True) -> Total:
        """The total with arrays in place of what is constant in its terms; itself a constant where it can
        be, if it is ``kept`` as it is."""
        if total in self.changed:
            return self.changed[total]
        terms = [replace(one, node=self.with_arrays(one)) for one in self.followed(total)]
        made = replace(total, terms=tuple(terms))
        if kept and all(self.is_fixed(one.node) for one in terms):
            self.fixed[made] = None
        self.changed[total] = self.changed[made] = made
        return made

    def followed(self, total: Total) -> Sequence[Term]:
        """Its terms, with slots of totals that have been arranged."""
        found = []
        for term in total.terms:
            others = {
                symbol: self.slots.symbol(slot.domain, self.arranged(slot.array), slot.table)
                for symbol, slot in self.slots.inside(term.node)
                if isinstance(slot.array, Total)
            }
            node = substituted(self.graph, [term.node], others)[0] if others else term.node
            found.append(replace(term, node=node))
        return found

    def with_arrays(self, term: Term) -> Node:
        """A term's node, what is constant in it and no plain slot being one."""
        if self.is_fixed(term.node):
            return term.node
        inside = reachable([term.node])
        fixed = {node for node in inside if self.is_fixed(node)}
        used = {a for node in inside if node not in fixed for a in node.arguments if a in fixed}
        replaced: dict[Node, Node] = {}
        for node in inside:
            if node in used and node.kind not in (Kind.SYMBOL, Kind.NUMBER) and any(self.slots.inside(node)):
                array = Total(Source.TOTAL, term.domain.count, (Term(term.domain, node, term.domain.every),))
                self.fixed[array] = None
                replaced[node] = self.slots.own(term.domain, array)
        return substituted(self.graph, [term.node], replaced)[0] if replaced else term.node
