"""Impacts on chains, trees and rigid bodies that reduce the speed: what they are at, and what velocities they
give."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.families.arrays import NONE, Domain, Slot, Term, Total, placed
from lagrange_cli.families.bonds import Bound, bounds_of, moves
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.contacts import Push, Reach
from lagrange_cli.families.events import ROUNDED, Events
from lagrange_cli.families.impacts.impacts import part_of
from lagrange_cli.families.joints.joints import Articulation
from lagrange_cli.families.refusals import REACHING
from lagrange_cli.families.tables import found_in
from lagrange_cli.families.values import FamilyValues

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.expression.index_arrays import Places

    Bits = NDArray[np.bool_]
    Values = NDArray[np.float64]

SUMMED = (
    "impacts on chains and trees that reduce the speed, and set velocities by sums, or by those of particles",
    "let them reflect without loss, or set each velocity by a multiple of itself",
    "events",
)
"""What members are written out for, how to do without, and the section of the file that has it."""


class Slowing:
    """The ``impacts`` at events of these numbers, in order, of joints."""

    def __init__(self, builder: FamilyBuilder, events: Events, impacts: Places, joints: Articulation) -> None:
        self.builder, self.slots, self.graph = builder, builder.slots, builder.graph
        self.impacts, self.joints, self.degrees = impacts, joints, builder.q.count
        order = np.full(events.count, NONE)
        order[impacts] = np.arange(len(impacts))
        self.contacts, self.coordinates = order[events.changed[0]], events.changed[1] - self.degrees
        """The contact of what each action sets, or ``NONE``, and the coordinate."""
        self.bounds: list[Bound] = []
        """What they are at, as constraints."""
        for term in events.arguments.terms:
            own = part_of(self.slots, term, order[term.targets])
            if own is not None:
                self._refuse(own.node, (builder.q, *joints.nodes))
                self.bounds += bounds_of(builder, own.domain, own.node, own.targets, joints, True)
        if not all(one.whole for one in self.bounds):
            raise Unsuited(*SUMMED)
        if joints.relative is not None and any(one.holds for one in self.bounds):
            raise Unsuited(*REACHING)
        self.values: list[Term] = []
        """What they set, at the numbers of values."""
        for term in events.values.terms:
            of_impacts = np.where(self.contacts[term.targets] >= 0, term.targets, NONE)
            value = part_of(self.slots, term, of_impacts)
            if value is not None:
                self._refuse(value.node, (builder.q, builder.v))
                self.values.append(value)
        fresh = self.contacts >= 0
        for one in self.values:
            fresh[one.targets] = False
        stopped = np.flatnonzero(fresh)
        if len(stopped):  # what is set to 0 has no terms
            self.values.append(Term(Domain(len(stopped)), self.graph.zero, stopped))
        self.pushes = [*self._pushes()]
        self.reaches = [*self._reaches()]

    def _refuse(self, node: Node, moving: Sequence[object]) -> None:
        builder = self.builder
        known = (*moving, builder.given, builder.whole)
        others = [slot.array for _, slot in self.slots.inside(node) if slot.array not in known]
        if any(not isinstance(one, Total) or moves(builder, one) for one in others):
            raise Unsuited(*SUMMED)
        if any(one.kind is Kind.SWITCH for one in reachable([node])):
            raise Unsuited

    # d = -(dD/dv) grad g with D = v+ - v

    def _pushes(self) -> Iterator[Push]:
        """What follows from slopes by coordinates."""
        fresh = np.ones(len(self.contacts), dtype=bool)
        for value in self.values:
            own = fresh[value.targets]
            fresh[value.targets] = False
            for bound in self.bounds:
                yield from self._pushes_by(bound, value, own)

    def _pushes_by(self, bound: Bound, value: Term, own: Bits) -> Iterator[Push]:
        """Those of some contacts, by some of the velocities that impacts give: by v itself for their ``own``
        members."""
        slots, graph = self.slots, self.graph
        contacts, coordinates = (one[value.targets] for one in (self.contacts, self.coordinates))
        member = np.full(len(self.impacts), NONE)
        member[bound.numbers] = np.arange(bound.domain.count)
        of_bound = member[contacts]
        sets: list[tuple[Node | None, Places]] = [(None, np.where(own, coordinates, NONE))]
        sets += [(s, slot.table) for s, slot in self._speeds(value)]
        made: dict[bytes, tuple[Domain, Places, list[Node]]] = {}
        for slope, places in zip(bound.slopes, bound.rows):
            for speed, rows in sets:
                mine = np.flatnonzero((of_bound >= 0) & (places[of_bound] == rows))
                if not len(mine):
                    continue
                domain, _, nodes = made.setdefault(mine.tobytes(), (Domain(len(mine)), mine, []))
                node = placed(slots, slope, domain, of_bound[mine])
                if speed is not None:
                    node = -node * placed(slots, graph.diff(value.node, speed), domain, mine)
                nodes.append(node)
        for domain, mine, nodes in made.values():
            node = graph.sum([(one, 1.0) for one in nodes])
            if not node.is_zero:
                yield Push(domain, node, contacts[mine], coordinates[mine])

    def _speeds(self, value: Term) -> list[tuple[Node, Slot]]:
        return [one for one in self.slots.inside(value.node) if one[1].array is self.builder.v]

    def _reaches(self) -> Iterator[Reach]:
        """What follows from slopes by places of nodes."""
        for b, bound in enumerate(self.bounds):
            for h, hold in enumerate(bound.holds):
                members, rows = self.joints.movers(hold.places)
                for value in self.values:
                    yield from self._reaches_by(b, h, bound, members, rows, value)

    def _reaches_by(
        self, b: int, h: int, bound: Bound, members: Places, rows: Places, value: Term
    ) -> Iterator[Reach]:
        """Those by some velocities, which impacts set in proportion to what they were."""
        graph, builder = self.graph, self.builder
        contacts, coordinates = self.contacts[value.targets], self.coordinates[value.targets]
        keys = contacts * self.degrees + coordinates
        order = np.argsort(keys, kind="stable")
        wanted = bound.numbers[members] * self.degrees + rows
        for _, slot in self._speeds(value):
            others = np.flatnonzero(slot.table != coordinates)
            if np.isin(contacts[others] * self.degrees + slot.table[others], wanted).any():
                raise Unsuited(*SUMMED)
        at, known = found_in(keys[order], wanted)
        which = np.flatnonzero(known)
        if not len(which):
            return
        mine = order[at[which]]
        node = graph.one
        for speed, slot in self._speeds(value):
            if np.array_equal(slot.table[mine], coordinates[mine]):
                node = node - graph.diff(value.node, speed)
            elif np.any(slot.table[mine] == coordinates[mine]):
                raise Unsuited(*SUMMED)
        moving = builder.time.symbols | self.slots.symbols_of(builder.q, builder.v)
        if node.symbols & moving:
            raise Unsuited(*SUMMED)
        if not node.is_zero:
            domain = Domain(len(which))
            node = placed(self.slots, node, domain, mine)
            yield Reach(domain, node, b, h, members[which], rows[which])

    # at a state

    def pushing(self, state: FamilyValues) -> tuple[Bits, Bits]:
        """Which contacts have directions that are not 0, and which of these change what they are at."""
        count, n = len(self.impacts), self.degrees
        slopes = self._slopes(state)
        keys, gradient = [np.zeros(1, dtype=np.int64)], [np.zeros(1)]
        for bound in self.bounds:
            for slope, rows in zip(bound.slopes, bound.rows):
                keys.append(bound.numbers * n + rows)
                gradient.append(np.broadcast_to(state.node(slope), len(rows)))
            for hold in bound.holds:
                members, rows = self.joints.movers(hold.places)
                keys.append(bound.numbers[members] * n + rows)
                own = np.broadcast_to(state.node(hold.slope), bound.domain.count)
                gradient.append(own[members] * slopes[hold.component][rows])
        places, which = np.unique(np.concatenate(keys), return_inverse=True)
        whole = np.bincount(which, np.concatenate(gradient))
        size, total, range_ = np.zeros(count), np.zeros(count), np.zeros(count)

        def add(contacts: Places, rows: Places, values: Values) -> None:
            at, known = found_in(places, contacts * n + rows)
            product = values * np.where(known, whole[at], 0.0)
            size[:] += np.bincount(contacts, np.abs(values), count)
            total[:] += np.bincount(contacts, product, count)
            range_[:] += np.bincount(contacts, np.abs(product), count)

        for push in self.pushes:
            add(push.contacts, push.rows, np.broadcast_to(state.node(push.node), push.domain.count))
        for one in self.reaches:
            bound = self.bounds[one.bound]
            hold = bound.holds[one.hold]
            own = np.broadcast_to(state.node(hold.slope), bound.domain.count)[one.members]
            values = state.node(one.node) * own * slopes[hold.component][one.rows]
            add(bound.numbers[one.members], one.rows, values)
        return size > ROUNDED, np.abs(total) > ROUNDED * range_

    def _slopes(self, state: FamilyValues) -> list[Values]:
        """dx/dq of each coordinate's own node, along each axis."""
        found = [np.zeros(self.degrees) for _ in self.joints.nodes]
        for kind in self.joints.joints:
            if kind.nodes is not None:
                for made, move in zip(found, kind.moves):
                    for q, rows in zip(kind.coordinates, kind.rows):
                        made[rows] = state.node(self.graph.diff(move, q))
        return found
