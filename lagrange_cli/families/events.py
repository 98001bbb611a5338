"""Events of families: what becomes 0 is one array for all events, and so is what actions set.

An event of a member is written once, as forces are. What follows from actions is in
``families.impacts.actions``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.signs import unbroken
from lagrange_cli.families.arrays import Chain, Domain, Term, Total, total_of
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.contacts import Impacts
from lagrange_cli.families.groups import Group
from lagrange_cli.families.jumps import refuse_angles
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.families.written_events import arguments_of, assigned_by, directions_of
from lagrange_cli.mechanics.defect import hides
from lagrange_cli.mechanics.rounding import size_of
from lagrange_cli.mechanics.switching.multiple_zeros import with_simple_zero
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.spec import Spec

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.expression.index_arrays import Places

    Values = np.ndarray[tuple[int, ...], np.dtype[np.float64]]

SEEDS = 1, 2
ROUNDED = 1e-10
"""Numbers that differ by less are equal, in terms of what they are made of."""


@dataclass(frozen=True, eq=False)
class Events:
    """The events of a system, by number: their ``directions``, and where the motion ``stops``. ``arguments``
    are what becomes 0; ``sizes`` has two numbers of each: the sizes of the terms of its argument and of its
    rate. ``values`` is what actions set, each at the place that ``changed`` has for it (among coordinates,
    velocities and parameters) behind the number of its event (2, values).
    ``simple`` says whose actions are (see ``native.stepping.actions``), and ``affected`` pairs of these
    and those whose arguments they change. After some simple ones constraints have impulses: ``pushing``.
    ``impacts`` are those that reduce the speed.
    """

    directions: Places
    stops: Places
    arguments: Total
    sizes: Total
    values: Total
    changed: Places
    simple: NDArray[np.bool_]
    affected: tuple[tuple[int, int], ...]
    keeps_energy: bool
    """Whether no action changes it."""
    jumping: bool = False
    """Whether arguments may come to their other side without being 0."""
    impacts: Impacts | None = None
    pushing: NDArray[np.bool_] | None = None

    def simple_in(self, parts: int, scheme: str) -> Events:
        """The same where numbers have so many ``parts``, or a ``scheme`` takes steps: simple actions set
        doubles, and impulses follow where there are series."""
        if parts == 1 and not (scheme and self.pushing is not None):
            return self
        return self.without_simple(self.simple if parts > 1 or self.pushing is None else self.pushing)

    def without_simple(self, some: NDArray[np.bool_]) -> Events:
        """The same where the caller carries out ``some`` of the simple actions, among them all after which
        constraints have impulses."""
        simple = self.simple & ~some
        affected = tuple(one for one in self.affected if simple[one[0]])
        return replace(self, simple=simple, affected=affected, pushing=None)

    @property
    def count(self) -> int:
        """The number of events."""
        return self.arguments.count


def events_of(builder: FamilyBuilder, spec: Spec) -> Events | None:
    """The events of the file; None if there are none.

    Raises ``Unsuited`` for events whose arguments may jump or hide their zeros.
    """
    if not spec.events:
        return None
    known = [*builder.totals]
    written = built(builder, arguments_of(spec))
    terms = [replace(one, node=with_simple_zero(builder.graph, one.node)) for one in written.terms]
    arguments = replace(written, terms=tuple(terms))
    builder.totals[builder.totals.index(written)] = arguments
    inner = [one for one in builder.totals if one not in known]
    moving = refuse_others(builder, inner)
    sets = assigned_by(spec)
    values, changed = built(builder, sets.values), np.stack([sets.events, sets.places])
    found = Events(
        *directions_of(spec), arguments, sizes_of(builder, arguments), values, changed,
        np.zeros(arguments.count, dtype=bool), (), keeps_energy=True,
        jumping=may_jump(builder, inner, moving),
    )  # fmt: skip
    refuse_unchanging(builder, arguments)
    return found


def built(builder: FamilyBuilder, group: Group) -> Total:
    """The values of the members of a group, which are numbers."""
    if not group.count:
        return builder.added(0, [])
    arrays = builder.computed(group, np.arange(group.count))
    if len(arrays) != 1:
        raise Unsuited
    return arrays[0]


def refuse_others(builder: FamilyBuilder, totals: Sequence[Total]) -> int:
    """The symbols of what moves. Raises ``Unsuited`` where an argument may have a cut, or hide a zero within
    a step."""
    nodes = reachable([term.node for one in totals for term in one.terms])
    refuse_angles(builder.slots, nodes)
    if any(node.kind is Kind.DDT for node in nodes):
        raise Unsuited
    speeds = builder.slots.symbols_of(builder.v, *builder.totals)
    moving: int = builder.time.symbols | builder.slots.symbols_of(builder.q) | speeds
    if hides(nodes, moving, speeds, large=False):
        raise Unsuited
    return moving


def may_jump(builder: FamilyBuilder, totals: Sequence[Total], moving: int) -> bool:
    """Whether an argument may come to its other side without being 0."""
    known = moving | builder.slots.symbols_of(builder.given, builder.whole)
    return not all(unbroken(term.node, known, moving) for one in totals for term in one.terms)


def random_state(builder: FamilyBuilder, seed: int) -> tuple[float, Values, Values, Values]:
    """A time, q, v, and parameters, which are the same for all seeds."""
    chance, count = np.random.default_rng(seed), builder.q.count
    q, v = chance.uniform(0.2, 1.2, count), chance.uniform(-1.0, 1.0, count)
    parameters = np.random.default_rng(SEEDS).uniform(0.7, 1.1, builder.given.count)
    return float(chance.uniform(0.2, 1.2)), q, v, parameters


def refuse_unchanging(builder: FamilyBuilder, arguments: Total) -> None:
    """Raise ``Unsuited`` where an argument is the same at all states: its members say so."""
    with np.errstate(all="ignore"):
        one, other = (FamilyValues(builder, *random_state(builder, seed)).of(arguments) for seed in SEEDS)
    if np.any(np.abs(one - other) <= ROUNDED * np.abs(one)):
        raise Unsuited


# sizes


def sizes_of(builder: FamilyBuilder, arguments: Total) -> Total:
    """Two numbers of each argument: the size of its terms, and of those of its rate without accelerations."""
    graph, slots = builder.graph, builder.slots

    def own_size(node: Node, domain: Domain) -> Node:
        return size_of(slots.graph, node, slots.symbols_of(builder.whole))

    def own_rate(node: Node, domain: Domain) -> Node:
        parts = [graph.diff(node, builder.time)]
        for symbol, slot in slots.inside(node):
            if slot.array is builder.q:
                parts.append(graph.diff(node, symbol) * slots.symbol(domain, builder.v, slot.table))
        found: Node = graph.sum([(graph.absolute(one), 1.0) for one in parts])
        return found

    terms = [
        Term(one.domain, node, 2 * one.targets + k)
        for k, own in enumerate((own_size, own_rate))
        for one, node in zip(arguments.terms, of_terms(builder, arguments, {}, own))
    ]
    return builder.added(2 * arguments.count, terms)


def of_terms(
    builder: FamilyBuilder, total: Total, known: dict[Total, Total], own: Callable[[Node, Domain], Node]
) -> list[Node]:
    """What is carried through the terms of a total: their ``own``, and that of the sums in them by slopes."""
    graph, slots, found = builder.graph, builder.slots, []
    for term in total.terms:
        parts = [own(term.node, term.domain)]
        for symbol, slot in slots.inside(term.node):
            if isinstance(slot.array, Total):
                inner = carried(builder, slot.array, known, own)
                slope = graph.absolute(graph.diff(term.node, symbol))
                parts.append(slope * slots.symbol(term.domain, inner, slot.table))
        found.append(graph.sum([(one, 1.0) for one in parts]))
    return found


def carried(
    builder: FamilyBuilder, total: Total, known: dict[Total, Total], own: Callable[[Node, Domain], Node]
) -> Total:
    """The same of every number of a total, added up as this is."""
    if total not in known:
        nodes = of_terms(builder, total, known, own)
        terms = [Term(one.domain, node, one.targets) for one, node in zip(total.terms, nodes)]
        tree, back = (total.tree, total.back) if isinstance(total, Chain) else (None, False)
        known[total] = total_of(total.count, terms, builder.graph, tree, back=back)
        builder.totals.append(known[total])
    return known[total]
