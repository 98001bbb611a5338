"""Modes in place of switches that move: +1, -1, or 0 while the motion stays where the argument is 0."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable, union
from lagrange_cli.mechanics.guards.guard import Guard, Rest, Rooted
from lagrange_cli.mechanics.guards.unbounded import unbounded
from lagrange_cli.mechanics.guards.vectors import held, split, vectors
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.substitution import rewritten
from lagrange_cli.mechanics.switching.switches import Merging, switches, vanishes_with, where_zero
from lagrange_cli.records import replace

RIDES, RIDDEN = 1.5, 3.0
"""Modes beyond the first one are ``RIDDEN`` and a part of the limit between -1 and 1: friction that
constraints bind to what others hold takes this part (see ``integrate.guards.bound``)."""


class Modes:
    """Modes, and what has been written with them so far. Guards whose arguments are ``free`` hold nothing. If
    motions are ``followed``, guards may be silent for a time."""

    def __init__(
        self, residual: Residual, free: frozenset[Node] = frozenset(), *, followed: bool = True
    ) -> None:
        self.residual, self.graph, self.followed = residual, residual.graph, followed
        self.moving = residual.variables
        self.free = free
        self.guards: dict[Node, Guard] = {}
        self.multipliers = [contact.multiplier for contact in residual.contacts]
        self.holding = union(self.multipliers)
        """Bit set of the multipliers."""
        self.coefficients = 0
        """Those in the branches of friction: the equations must stay linear in all multipliers."""
        self.rests = tuple(
            Rest(contact.event, contact.rest, i) for i, contact in enumerate(residual.contacts)
        )
        self.made: dict[Node, Node] = {}
        self.merged = Merging(self.graph, self.moving).merged
        self.closed = False
        """Whether the equations are written: switches with other arguments than theirs have no modes then."""
        self.holds = True
        """Whether a motion may stay on a switch: not on those of which no force consists."""
        rows = self.merged(residual.residual)
        speeds = union(residual.model.v)
        self.unbounded = {one for one in unbounded(self.graph, rows, self.moving) if not one.symbols & speeds}
        """Places that nothing holds at 0, as forces are unbounded there. Of velocities a pole may be an end
        that motions reach."""
        self.rows = rows
        self.inertial = self._inertial(rows)
        """Switches that no multiplier may stand for: the equations are to stay linear in accelerations."""
        for vector in vectors(residual):
            length = self.graph.power(vector.square, self.graph.constant(0.5))
            if length in free:
                continue
            mode, zero = self.graph.symbol(f"mode {len(self.guards)}"), self.graph.zero
            if not vector.holds:
                passed = three_ways(self.graph, mode, length, length, vector.square)
                self.guards[length] = Guard(passed, length, mode, vector=vector)
                continue
            argument, first = three_ways(self.graph, mode, length, length, zero), len(self.multipliers)
            kept = Guard(argument, length, mode, first, reverses=True, limit=self.graph.one, vector=vector)
            self.guards[length] = kept
            self.multipliers += [
                self.graph.symbol(f"multiplier {first + i}") for i in range(len(vector.parts))
            ]
        self.holding = union(self.multipliers)

    @cached_property
    def pushed(self) -> dict[Node, set[int]]:
        """By argument of switches, the rows of the equations that contain such switches."""
        found: dict[Node, set[int]] = {}
        for k, row in enumerate(self.rows):
            for node in reachable([row]):
                if node.kind is Kind.SWITCH:
                    found.setdefault(node.arguments[0], set()).add(k)
        return found

    def _inertial(self, rows: Sequence[Node]) -> set[Node]:
        """Switches in masses, in momenta, and in factors of accelerations."""
        residual, found = self.residual, set[Node]()
        entries = [entry for row in residual.unpushed.entries for entry in row.values()]
        entries += residual.inertias
        entries += [node for one in residual.cyclic_momenta for node in (one.momentum, one.speed)]
        inside, accelerated = [*self.merged(entries)], set[Node]()
        for node in reachable(rows):
            if node.kind is Kind.DDT or not accelerated.isdisjoint(node.arguments):
                accelerated.add(node)
                if node.kind is Kind.SWITCH:
                    found.add(node)
                if node.kind is not Kind.SUM:
                    inside += [a for a in node.arguments if node.kind is Kind.DDT or a not in accelerated]
        found.update(switches(inside, self.moving))
        return found

    def frozen(self, nodes: Sequence[Node]) -> tuple[Node, ...]:
        """``nodes`` with modes."""

        def change(node: Node, arguments: list[Node]) -> Node | None:
            if self._has_mode(node):
                return self._by_mode(node, *arguments)
            if node.kind is Kind.DDT and arguments[0] is not node.arguments[0]:
                moves = arguments[0].symbols & self.moving  # a mode does not
                return self.graph.ddt(arguments[0]) if moves else self.graph.zero
            return None

        nodes = [self._by_length(node) for node in self.merged(nodes)]
        return rewritten(self.graph, nodes, change, self.made if self.holds else {})

    def _by_length(self, node: Node) -> Node:
        """A node that contains u/|u| for vectors u, with unknowns in its place while the motion is held, and
        without it where the mode is -1, as friction is 0."""
        for guard in self.guards.values():
            if guard.vector is None or guard.vector.square.symbols & ~node.symbols:
                continue
            plain, others = split(self.graph, node, guard.vector)
            at_rest = None if others.is_zero else held(self.graph, others, guard.vector)
            if at_rest is not None:
                unknown = zip(at_rest[1], (self.multipliers[i] for i in guard.holding))
                resting = self.graph.sum([(at_rest[0], 1.0), *((a * b, 1.0) for a, b in unknown)])
                without = at_rest[0] if guard.holding else others
                node = plain + three_ways(self.graph, guard.mode, others, without, resting)
        return node

    def _has_mode(self, node: Node) -> bool:
        """Whether it is a switch that a mode stands for."""
        if node.kind is not Kind.SWITCH or not node.arguments[0].symbols & self.moving:
            return False
        return not self.closed or node.arguments[0] in self.guards

    def _by_mode(self, node: Node, argument: Node, above: Node, below: Node) -> Node:
        """A switch by its mode."""
        graph, original = self.graph, node.arguments[0]
        if original not in self.guards:
            mode = graph.symbol(f"mode {len(self.guards)}")
            self.guards[original] = Guard(argument, original, mode)
        guard = self.guards[original]
        inside = (above - below).symbols & self.holding
        if inside and self._reverses(node) and original not in self.free:
            self.coefficients |= inside
        if node in self.inertial or not self.holds:
            return graph.switch(guard.mode, above, below, -1)
        if inside or not self._jumps(node):
            resting = self._resting(original, above, below)
            roots = rooted(original, above, below)
            if roots is not None:
                self.guards[original] = replace(guard, roots=roots.joined(guard.roots))
            if resting is None:
                return graph.switch(guard.mode, above, below, -1)
            return three_ways(graph, guard.mode, above, below, resting[1])
        able = self._moves(original) and original not in self.free | self.unbounded and not self.closed
        if guard.auxiliary is None and able and self._is_moved(original):
            guard = self.guards[original] = replace(guard, auxiliary=len(self.multipliers))
            self.multipliers.append(graph.symbol(f"multiplier {guard.auxiliary}"))
            self.holding |= self.multipliers[-1].symbols
        if guard.auxiliary is None:
            return graph.switch(guard.mode, above, below, node.data)
        if self._reverses(node):
            self.guards[original] = replace(guard, reverses=True)
        multiplier = self.multipliers[guard.auxiliary]
        first, second = self._resting(original, above, below) or (above, below)
        mean, half = (first + second) / 2.0, (first - second) / 2.0
        if self.followed and self.residual.multipliers:
            ridden = mean + (guard.mode - RIDDEN) * half
            above = graph.switch(guard.mode - RIDES, ridden, above, -1)
        return three_ways(graph, guard.mode, above, below, mean + multiplier * half)

    def _resting(self, argument: Node, above: Node, below: Node) -> tuple[Node, Node] | None:
        """The values of both branches where the argument is 0, if they contain a root of it: it has no series
        there. They are equal, as velocities become 0 in a finite time and bodies touch without force, but on
        sides of other switches, which may never be met there."""
        if rooted(argument, above, below) is None:
            return None
        return where_zero(self.graph, above, argument), where_zero(self.graph, below, argument)

    def _reverses(self, node: Node) -> bool:
        """Whether a switch has opposite values on both sides of 0, as friction has, by a velocity."""
        argument, above, below = node.arguments
        if not any(argument.symbols & v.symbols for v in self.residual.model.v):
            return False
        return vanishes_with(self.graph, above + below, argument)

    def _jumps(self, node: Node) -> bool:
        """Whether a switch may have two values where its argument is 0."""
        argument, above, below = node.arguments
        return not vanishes_with(self.graph, above - below, argument)

    def _is_moved(self, argument: Node) -> bool:
        """Whether forces with switches by an argument may change its accelerations. Where they act on others
        alone, they cannot hold it at 0."""
        residual, model = self.residual, self.residual.model
        if residual.cyclic_momenta or residual.dependent or argument.symbols & self.holding:
            return True
        moved = {k for k, one in enumerate(zip(model.q, model.v)) if argument.symbols & union(one)}
        together = [set(block) for block in residual.blocks]
        for contact in residual.contacts:
            entries = zip(contact.force, contact.direction)
            together.append({k for k, pair in enumerate(entries) if not all(one.is_zero for one in pair)})
        found, before = set(self.pushed.get(argument, moved)), set[int]()
        while found != before:
            before = set(found)
            found.update(*(group for group in together if group & found))
        return not found.isdisjoint(moved)

    def _moves(self, argument: Node) -> bool:
        """Whether it depends on more than the time."""
        model = self.residual.model
        return any(argument.symbols & symbol.symbols for symbol in (*model.q, *model.v))


def three_ways(graph: Graph, mode: Node, above: Node, below: Node, held: Node) -> Node:
    """One or the other, depending on a mode: +1, -1, or 0."""
    return graph.switch(mode, above, graph.switch(-mode, below, held, -1), -1)


def rooted(argument: Node, above: Node, below: Node) -> Rooted | None:
    """The roots in the branches of a switch, if there are any: of what its argument contains."""
    first, second = (_least_exponent(argument, one) for one in (above, below))
    if first == second == math.inf:
        return None
    side = 0 if max(first, second) < math.inf else 1 if first < math.inf else -1
    return Rooted(min(first, second) < 1.0, side)


def _least_exponent(argument: Node, branch: Node) -> float:
    """The least fractional exponent of what the argument contains; 0 where it is not known, and infinity
    where there is none."""
    least = math.inf
    for node in reachable([branch]):
        if node.kind is Kind.PRODUCT:
            for base, exponent in zip(node.arguments, node.data):
                if base.symbols & argument.symbols and exponent != int(exponent):
                    least = min(least, exponent)
        elif node.kind is Kind.POWER and node.arguments[0].symbols & argument.symbols:
            least = min(least, 0.0)
    return least
