"""Switches of families: expressions whose sides agree where they change, as those of springs that only push.

A switch between two sides becomes one by a *mode*, which is +1 or -1 until its argument changes its sign (see
``mechanics.guards``). All modes are one array, and all arguments another one. A switch stands in a term once;
it has as many modes as its argument has different values among the members.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.index_arrays import distinct
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node, reachable
from lagrange_cli.families.arrays import Array, Domain, Source, Term, Total, placed, total_of
from lagrange_cli.families.description import FamilySystem, Modes
from lagrange_cli.families.jumps import is_root
from lagrange_cli.families.switching.friction import Decision, FrictionModes, Held, Rest, linear_in
from lagrange_cli.families.switching.held_vectors import Acting, Rubbing, held_along
from lagrange_cli.families.switching.holding import held
from lagrange_cli.families.switching.rooted import roots_of
from lagrange_cli.families.switching.silencing import Silencing, Use, sides_along, sides_of
from lagrange_cli.families.switching.switched import Switched
from lagrange_cli.families.switching.vector_friction import DIRECTIONS, with_lengths
from lagrange_cli.mechanics.guards.modes import three_ways
from lagrange_cli.mechanics.substitution import rewritten, substituted
from lagrange_cli.mechanics.switching.switches import vanishes_with, where_zero
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.expression.index_arrays import Places


class Switching(Switched):
    """The totals of a system with modes in place of switches."""

    def __init__(self, system: FamilySystem, listed: Sequence[Total] = ()) -> None:
        super().__init__(system, listed)
        self._changed: dict[Total, Total] = {}
        self.turned: dict[Use, NDArray[np.bool_]] = {}
        """Which members have the opposite of what decides their mode."""

    @cached_property
    def uses(self) -> list[dict[Use, Places]]:
        """Where each argument is used, and the places of its numbers there, (members, numbers). Those that
        differ in their members alone are one; what decides others is before them."""
        found: dict[tuple[Node, tuple[Array, ...]], dict[Use, Places]] = {}
        for domain, argument in [*self._switched_by, *self._silencing.changing.values()]:
            inside = [(node, slot) for node in reachable([argument]) if (slot := self.slots.of.get(node))]
            given = {node: self.graph.symbol(f"argument {i}") for i, (node, _) in enumerate(inside)}
            alike = substituted(self.graph, [argument], given)[0]
            places = np.array([slot.table for _, slot in inside], dtype=np.int64)
            use, places = (domain, argument), places.reshape(-1, domain.count).T
            arrays = tuple(slot.array for _, slot in inside)
            if arrays == (self.system.v, self.system.v):
                alike, places, self.turned[use] = self._in_order(alike, places, {*found})
            found.setdefault((alike, arrays), {})[use] = places
        return [*found.values(), *self._lengths()]

    @property
    def _switched_by(self) -> Iterator[Use]:
        """The arguments of switches, and the members that have them."""
        for total in self.totals:
            for term in self.merged(total):
                for one in self.followed([term.node]):
                    yield term.domain, one.arguments[0]

    @cached_property
    def _silencing(self) -> Silencing:
        """Which friction may be 0, whatever moves."""
        terms = [term for total in self.totals for term in self.merged(total)]
        nodes = [one.node for one in terms]
        held = {(one.term.domain, one.argument): sides_of(nodes, one.argument) for one in self.friction}
        held |= {
            (one.domain, one.length): sides_along(nodes, square) for (_, square), one in self.along.items()
        }
        rubbing = {one.argument for one in self.friction}
        known = {argument for _, argument in self._switched_by if argument not in rubbing}
        return Silencing(self.system, held, terms, known)

    def _lengths(self) -> Iterator[dict[Use, Places]]:
        """The lengths of vectors along which friction acts, each with the coordinates that are held."""
        for one in self.along.values():
            yield {(one.domain, one.length): np.stack(one.rows, axis=1)}

    def _in_order(
        self, alike: Node, places: Places, known: Collection[tuple[Node, tuple[Array, ...]]]
    ) -> tuple[Node, Places, NDArray[np.bool_]]:
        """An argument of two velocities, or its opposite with these in the other order, if that is ``known``;
        and which members have the opposite."""
        first, second = (self.graph.symbol(f"argument {i}") for i in range(2))
        other = -substituted(self.graph, [alike], {first: second, second: first})[0]
        if other is alike:
            turned = places[:, 0] > places[:, 1]
        else:
            turned = np.full(len(places), (other, (self.system.v,) * 2) in known)
            alike = other if turned.all() else alike
        return alike, np.where(turned[:, None], places[:, ::-1], places), turned

    @cached_property
    def numbers(self) -> tuple[int, dict[Use, Places], list[tuple[Use, Places, Places]]]:
        """How many modes there are; which of them the members of a use have; and by which of its members, in
        which use, each mode is decided: members, and their modes."""
        count = 0
        numbers: dict[Use, Places] = {}
        chosen: list[tuple[Use, Places, Places]] = []
        for uses in self.uses:
            _, index, inverse = np.unique(
                np.concatenate([*uses.values()]), axis=0, return_index=True, return_inverse=True
            )
            first = 0
            for use, places in uses.items():
                last = first + len(places)
                numbers[use] = count + inverse.reshape(-1)[first:last]
                own = np.flatnonzero((first <= index) & (index < last))
                if len(own):
                    chosen.append((use, index[own] - first, count + own))
                first = last
            count += len(index)
        return count, numbers, chosen

    @cached_property
    def arguments(self) -> Total:
        """The arguments of all modes, which may depend on other modes."""
        terms = [
            Term(one.domain, self.graph.switch(one.loud, one.argument, self.graph.one, -1), one.modes)
            for one in self.decisions
        ]
        return total_of(self.modes.count, terms, self.graph)

    @cached_property
    def silent(self) -> list[tuple[int, int]]:
        """Modes that may change nothing, each with one that is -1 then."""
        numbers, found = self.numbers[1], list[tuple[int, int]]()
        for use, other in self._silencing.changing.items():
            alone = self._alone[numbers[use]]
            found += zip(numbers[use][alone].tolist(), numbers[other][alone].tolist())
        return found

    @cached_property
    def _alone(self) -> NDArray[np.bool_]:
        """Which modes are of one use."""
        each = [np.bincount(distinct(one), minlength=self.numbers[0]) for one in self.numbers[1].values()]
        found: NDArray[np.bool_] = np.sum(each, axis=0) == 1
        return found

    def _loud(self, domain: Domain, argument: Node) -> Node:
        """What is 0, or less, while the modes that members have for an argument change nothing."""
        use = domain, argument
        if use in self._silencing.changing:
            return self.mode_of(*self._silencing.changing[use])
        return self._silencing.lasting.get(use, self.graph.one)

    @cached_property
    def decisions(self) -> list[Decision]:
        """Which members decide modes, and by what."""
        found = []
        for (domain, argument), members, modes in self.numbers[2]:
            node = self._frozen(argument, domain)
            if any(one.domain is domain and one.length is argument for one in self.along.values()):
                mode = self.mode_of(domain, argument)
                node = mode * mode * node
            turned = self.turned.get((domain, argument), np.zeros(domain.count, dtype=bool))[members]
            alone = self._alone[modes]
            for sign, single in product((1.0, -1.0), (True, False)):
                which = (turned == (sign < 0.0)) & (alone == single)
                if which.any():
                    own = Domain(int(which.sum()))
                    decides = sign * placed(self.slots, node, own, members[which])
                    loud = self._loud(domain, argument) if single else self.graph.one
                    loud = placed(self.slots, loud, own, members[which])
                    found.append(Decision(own, decides, modes[which], loud))
        return found

    def smooth(self) -> FamilySystem:
        """The system with modes."""
        system, events = self.system, self.system.events
        if events is not None:  # modes may have to be chosen after an action
            events = replace(events.without_simple(events.simple), arguments=self.of(events.arguments))
        roots = roots_of(self, self.numbers[1], self.turned)
        needed, modes = [*map(self.of, system.needed)], Modes(self.arguments, self.modes, roots=roots)
        if self.held is not None:
            held = self.held
            needed += [*held.before, held.other]
            modes = replace(
                modes, holding=held.modes, limits=held.limits, sticking=held.sticking, loose=held.loose,
                placed=self.placed, locks=held.locks, halts=held.halts, vectors=held.vectors,
                beside=held.beside, errors=held.errors, silent=self.silent,
            )  # fmt: skip
        return replace(
            system, forces=self.of(system.forces), needed=needed, slopes=self.of(system.slopes),
            gradient=self.of(system.gradient), vector=system.vector and self.of(system.vector),
            applied=self.of(system.applied), loads=[*map(self.of, system.loads)], events=events, modes=modes,
        )  # fmt: skip

    @property
    def placed(self) -> Places:
        """The modes of forces that jump with places."""
        found = [
            self.numbers[1][one.term.domain, one.argument]
            for one in self.friction
            if not self.slots.moving(one.argument, {self.system.v})
        ]
        return distinct(np.concatenate([*found, np.zeros(0, dtype=np.int64)]))

    @cached_property
    def held(self) -> Held | None:
        """The forces where friction may hold coordinates; None where it may not."""
        found = self._held_by_numbers() if self.friction else None
        return self._held_along(found) if self.along else found

    def _held_along(self, found: Held | None) -> Held:
        """The same, where friction along vectors holds others besides."""
        system = self.system
        listed = [
            Rubbing(one, self.numbers[1][place], self.mode_of(*place), self._loud(*place))
            for one in self.along.values()
            if (place := (one.domain, one.length))
        ]
        rows = np.concatenate([row for one in self.along.values() for row in one.rows])
        if any(np.isin(one.term.targets, rows).any() for one in self.friction):
            raise Unsuited(*DIRECTIONS)
        forces, applied = (self.by_terms(one) for one in (system.forces, system.applied))
        if found is not None:
            forces, applied = found.forces, found.applied
        acting = Acting(forces, applied, self.of(system.slopes))
        return held_along(system, listed, acting, found, self.frozen)

    def _held_by_numbers(self) -> Held:
        """The same, of velocities and places one by one."""
        system, rubbing = self.system, {one.term for one in self.friction}
        others = [one for one in self.merged(system.forces) if one not in rubbing]
        if any(len(linear_in(system, one.argument, self.moving)) > 1 for one in self.friction):
            return self._held_together()
        applied = self.by_terms(system.applied)
        if system.joints is not None:
            from lagrange_cli.families.switching.locked import locked

            return locked(self._rubbing, others, applied)
        return held(self._rubbing, Rest(others, applied, self.of(system.slopes)))

    @property
    def _rubbing(self) -> FrictionModes:
        """The friction and its modes."""
        given = self.modes, self.numbers[1], self.decisions, self.frozen
        return FrictionModes(self.system, self.friction, *given)

    def _held_together(self) -> Held:
        """The forces where friction may hold coordinates to each other."""
        from lagrange_cli.families.switching import relative_friction

        whole = self.by_terms(self.system.forces), self.by_terms(self.system.applied)
        return relative_friction.held(self._rubbing, whole, self.moving)

    @cached_property
    def modes(self) -> Array:
        """The modes."""
        return Array(Source.MODES, self.numbers[0])

    def of(self, total: Total) -> Total:
        """A total with modes; the same if it has no switches."""
        if not self.within(total):
            return total
        if total not in self._changed:
            acting = total in (self.system.forces, self.system.applied)
            if acting and self.held is not None:
                self._changed[self.system.forces] = self.held.forces
                self._changed[self.system.applied] = self.held.applied
            else:
                self._changed[total] = self.by_terms(total)
        return self._changed[total]

    def by_terms(self, total: Total) -> Total:
        """The same, term by term."""
        return replace(total, terms=tuple(map(self.frozen, self.merged(total))))

    def frozen(self, term: Term) -> Term:
        """A term with modes."""
        return replace(term, node=self._frozen(term.node, term.domain))

    def mode_of(self, domain: Domain, argument: Node) -> Node:
        """The mode that the members of a domain have for an argument."""
        use = domain, argument
        mode: Node = self.slots.symbol(domain, self.modes, self.numbers[1][use])
        turned = self.turned.get(use)
        if turned is None or not turned.any():
            return mode
        if turned.all():
            return -mode
        return mode * (1.0 - 2.0 * self.slots.symbol(domain, self.system.whole, turned.astype(np.int64)))

    def _felt(self, domain: Domain, length: Node) -> Node:
        """The mode of a vector; 0 where friction along it is."""
        return self.graph.switch(
            self._loud(domain, length), self.mode_of(domain, length), self.graph.zero, -1
        )

    def _has_value_at_zero(self, node: Node, domain: Domain) -> bool:
        """Whether a switch has a value of its own where its argument stays 0: one that jumps, and holds
        nothing there."""
        argument, above, below = node.arguments
        if any(one.term.domain is domain and one.argument is argument for one in self.friction):
            return False
        return not vanishes_with(self.graph, above - below, argument)

    def _frozen(self, root: Node, domain: Domain) -> Node:
        """An expression of the members of a domain, with modes."""
        passed = {*self.followed([root])}

        def change(node: Node, arguments: list[Node]) -> Node | None:
            slot = self.slots.of.get(node)
            if self.along:
                given = node, arguments, domain, self.along, self._felt
                if (changed := with_lengths(self.graph, *given)) is not None:
                    return changed
            if node in passed:
                mode, (argument, above, below) = self.mode_of(domain, node.arguments[0]), arguments
                if any(is_root(one, self.moving) for one in reachable([above, below])):  # no number there
                    at_zero = where_zero(self.graph, above, argument)
                    return three_ways(self.graph, mode, above, below, at_zero)
                at = node.data if self._has_value_at_zero(node, domain) else -1
                return self.graph.switch(mode, above, below, at)
            if slot is not None and isinstance(slot.array, Total):
                return self.slots.symbol(domain, self.of(slot.array), slot.table)
            return None

        return rewritten(self.graph, [root], change)[0]
