"""Friction of members that is 0 for a time, or from the start (see ``mechanics.guards.silence``).

One mode more says whether it is, for all members of which the same parameters and modes tell that. Where
parameters alone do that no event changes, it is known from the start.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from lagrange_cli.expression.node import Kind, Node, factors_of, reachable, union
from lagrange_cli.families.arrays import Domain, Term
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.mechanics.guards.silence import Silence
from lagrange_cli.records import dataclass
from lagrange_cli.spec.content import names_of

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places

Use: TypeAlias = "tuple[Domain, Node]"
"""Members that have a switch, and its argument."""
Sides: TypeAlias = "tuple[Mapping[Node, Node], Mapping[Node, Node]]"
"""What is in place of expressions where an argument is positive, and else."""
HALF = 0.5
"""What whole numbers from 0 on are compared with."""


@dataclass(frozen=True, eq=False)
class Silencing:
    """Friction by its arguments in domains, ``held``: what it makes of expressions in some ``terms`` on
    either side. The sides of ``known`` arguments are modes, too."""

    system: FamilySystem
    held: Mapping[Use, Sides]
    terms: Sequence[Term]
    known: Collection[Node]

    @cached_property
    def _tells(self) -> Mapping[Use, Node]:
        """What is 0 where friction by an argument changes nothing."""
        system, slots = self.system, self.system.slots
        fixed = slots.symbols_of(system.given, system.whole) | union(system.parameters.values())
        silence, found = Silence(slots.graph, fixed, self.known), dict[Use, Node]()
        for use, sides in self.held.items():
            nodes = [one.node for one in self.terms if one.domain is use[0]]
            tells = silence.differing(nodes, *sides)
            if tells.symbols:
                found[use] = tells
        return found

    @cached_property
    def lasting(self) -> Mapping[Use, Node]:
        """The same where it does not change in a motion."""
        return {use: node for use, node in self._tells.items() if self._lasts(node)}

    def _lasts(self, node: Node) -> bool:
        system, changed = self.system, self._set_by_events
        if any(one.kind is Kind.SWITCH and one.arguments[0] in self.known for one in reachable([node])):
            return False
        given = [slot.table for _, slot in system.slots.inside(node) if slot.array is system.given]
        if changed.size:
            places = names_of(system.spec.parameters).starts
            inside = (name for name, one in system.parameters.items() if one.symbols & node.symbols)
            given += [np.array([places[name]]) for name in inside]
        return not any(np.isin(table, changed).any() for table in given)

    @cached_property
    def _set_by_events(self) -> Places:
        """The parameters that events set."""
        events, count = self.system.events, 2 * self.system.q.count
        if events is None or not events.changed.size:
            return np.zeros(0, dtype=np.int64)
        found: Places = events.changed[1][events.changed[1] >= count] - count
        return found

    @cached_property
    def changing(self) -> Mapping[Use, Use]:
        """Where it does, what is negative while friction changes nothing, of the same members."""
        return {use: (use[0], node - HALF) for use, node in self._tells.items() if use not in self.lasting}


def sides_of(nodes: Sequence[Node], argument: Node) -> Sides:
    """Those of the switches with an argument in some expressions."""
    inside = reachable(nodes)
    switches = [one for one in inside if one.kind is Kind.SWITCH and one.arguments[0] is argument]
    return {one: one.arguments[1] for one in switches}, {one: one.arguments[2] for one in switches}


def sides_along(nodes: Sequence[Node], square: Node) -> Sides:
    """Those of products with roots of the ``square`` of a vector: they are others without these."""
    roots = {}
    for one in reachable(nodes):
        factors = [(a, e) for a, e in factors_of(one) if a is not square or e % 1.0 != 0.5]
        if len(factors) < len(one.arguments) and one.kind is Kind.PRODUCT:
            roots[one] = one.graph.product(factors)
    return {one: one for one in roots}, roots
