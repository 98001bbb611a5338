"""Forces on families that cancel one another where nothing moves: how large their rounding errors are."""

from __future__ import annotations

from lagrange_cli.expression.node import Node, reachable
from lagrange_cli.families.arrays import Array, Source, Term, Total, total_of
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.rounding import Sizes, Unbounded
from lagrange_cli.mechanics.static_forces import is_singular, is_steep, may_cancel
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.records import replace


def rounding_at_rest(system: FamilySystem, *, pulled: bool = False) -> Total | None:
    """The rounding errors of the forces at rest, in units of the last place, one for each coordinate; None
    where they are 0 only if coordinates are, or are known to that part of these, or where errors have no
    bound (see ``mechanics.static_forces``). If coordinates are ``pulled`` by constraints, errors are also
    those of the forces of constraint, from the multipliers."""
    rest = Resting(system)
    try:
        rest.at_rest(system.forces)
        if not rest.cancels:
            return None
        found = rest.size(system.forces)
        if not pulled or system.bonds is None:
            return found
        terms = [replace(one, node=rest.pull(one)) for one in system.bonds.pulls_on_coordinates(system.slots)]
        return total_of(found.count, [*found.terms, *terms], system.slots.graph)
    except Unbounded:
        return None


def rounding_of_joints(system: FamilySystem, signs: Array) -> FamilySystem | None:
    """The same of a system of joints: one on which nothing acts but these errors, those on coordinates and
    those on nodes, times their ``signs``; accelerations are those by rounding errors there. Constraints, that
    would reduce them, are left out."""
    rest, graph, slots = Resting(system), system.slots.graph, system.slots
    try:
        forces, *loads = (rest.at_rest(one) for one in (system.forces, *system.loads))
        if not rest.cancels and not (forces.terms and any(one.terms for one in loads)):
            return None
        sizes = [rest.size(one) for one in (system.forces, *system.loads)]
    except Unbounded:
        return None

    def signed(total: Total) -> Total:
        terms = [
            replace(one, node=one.node * slots.symbol(one.domain, signs, one.targets)) for one in total.terms
        ]
        return total_of(total.count, terms, graph)

    forces, *loads = map(signed, sizes)
    alone = replace(system, bonds=None, modes=None, smooth=None, contact=None, events=None)
    return replace(alone, forces=forces, loads=tuple(loads))


class Resting(Sizes):
    """The same of a system where velocities and multipliers are 0."""

    def __init__(self, system: FamilySystem) -> None:
        super().__init__(system)
        self.cancels = False
        """Whether there are sums that may be 0 where no coordinate is."""
        self._made: dict[Total, Total] = {}
        self._places, self._speeds = 0, 0
        """The symbols of q, and of what contains these; and those of what rests."""

    def looked(self, total: Total) -> Total:
        return self.at_rest(total)

    def at_rest(self, total: Total) -> Total:
        """A total at rest."""
        if total not in self._made:
            terms = [replace(one, node=self._still(one)) for one in total.terms]
            same = all(new.node is old.node for new, old in zip(terms, total.terms))
            self._made[total] = total if same else self.like(total, terms)
            nodes = [one.node for one in self._made[total].terms]
            apart = any(not one.symbols & self._places for one in nodes)
            if apart and len(nodes) > 1 and any(one.symbols & self._moving for one in nodes):
                self.cancels = True
        return self._made[total]

    def pull(self, term: Term) -> Node:
        """The size of a force of constraint, by a multiplier, which is known as it is."""
        bonds = self.system.bonds
        assert bonds is not None
        (multiplier,) = [one for one, slot in self.slots.inside(term.node) if slot.array is bonds.multipliers]
        slope = self.graph.diff(term.node, multiplier)
        return self.size_of(replace(term, node=self._still(replace(term, node=slope)))) * (
            self.graph.absolute(multiplier)
        )

    def _still(self, term: Term) -> Node:
        """A term where nothing moves."""
        changed: dict[Node, Node] = {}
        for symbol, slot in self.slots.inside(term.node):
            if isinstance(slot.array, Total):
                made = self.at_rest(slot.array)
                if made is not slot.array:
                    self._speeds |= symbol.symbols
                if not made.terms:
                    changed[symbol] = self.graph.zero
                elif made is not slot.array:
                    changed[symbol] = self.slots.symbol(slot.domain, made, slot.table)
                self._follow(changed.get(symbol, symbol), *(one.node for one in made.terms))
            elif slot.array is self.system.v:
                self._speeds |= symbol.symbols
                changed[symbol] = self.graph.zero
            elif slot.array is self.system.q:
                self._places |= symbol.symbols
                self._moving |= symbol.symbols
            elif slot.array.source is Source.TOTAL:
                raise Unbounded
        if any(is_singular(one, self._speeds, zero=True) for one in reachable([term.node])):
            raise Unbounded
        node = substituted(self.graph, [term.node], changed)[0] if changed else term.node
        for one in reachable([node]):
            if is_steep(one, self._moving):
                raise Unbounded
            self.cancels |= may_cancel(one, self._moving, self._places)
        return node

    def _follow(self, symbol: Node, *terms: Node) -> None:
        """A total moves as its terms do."""
        if any(one.symbols & self._places for one in terms):
            self._places |= symbol.symbols
        if any(one.symbols & self._moving for one in terms):
            self._moving |= symbol.symbols
