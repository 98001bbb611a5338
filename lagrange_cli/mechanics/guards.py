"""Equations with switches, made smooth for a time: each switch has a mode that says which branch it takes.

A switch is ``above`` where its argument u(q, q_dot, t) > 0 and ``below`` where u < 0 (see ``Kind.SWITCH``).
Its mode is a constant, +1 or -1, until u changes its sign. Then it is the other one, and the motion goes on
with other equations. Every distinct u has one *guard*.

Where the forces jump at u = 0, both branches may lead back to it: the motion stays there (dry friction that
holds). The mode is then 0 and the switch has the value of A. F. Filippov (Differential Equations with
Discontinuous Righthand Sides, 1988, sec. 4)

    (above + below)/2 + m (above - below)/2,    -1 <= m <= 1,

with the multiplier m for which u stays 0. It is found as the acceleration of an auxiliary coordinate y, m =
y'', whose equation is du/dt = 0, or d2u/dt2 = 0 where u does not contain velocities, and y'' = 0 while the
mode is not 0.

Friction by a normal force, as in mu N sign(v), jumps by a multiplier of a constraint. With the limit D = mu N
there is an unknown force f = m D then: the equations stay linear in it and in N. It is found as y'', and
D + f and D - f have the sign of D as long as -1 <= m <= 1.

The forces of resting contact (see ``mechanics.contacts``) are such multipliers, too; the mode of a contact is
1 or -1, the side that the motion came from, while it rests, and else 0."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import reduce
from operator import or_

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.cuts import Cut, cuts
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.rows import mapped
from lagrange_cli.mechanics.substitution import rebuilt, substituted
from lagrange_cli.mechanics.switches import Merging, has_rates, switches, vanishes_with, where_zero
from lagrange_cli.mechanics.variables import nonzero, rate
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass, replace

HEAVY = 2.0**40
"""What the equation that holds the motion is multiplied with: elimination begins with it, so that u stays 0
to the last bit."""


@dataclass(frozen=True)
class Guard:
    """What a mode is the sign of: ``argument``, in which other modes may stand.

    ``original`` is the argument as it stands in the system's own equations. ``auxiliary`` is the place, among
    auxiliary coordinates, of the one whose acceleration is the multiplier; None where the motion cannot be
    held. With a ``limit`` the multiplier is a force, which may be that large. A ``cut`` is where an argument
    of another guard may jump; no equation contains its mode."""

    argument: Node
    original: Node
    mode: Node
    auxiliary: int | None = None
    cut: bool = False
    limit: Node | None = None
    broken: Cut | None = None
    """What jumps where the argument is 0, so that the motion ends there."""


@dataclass(frozen=True)
class Rest:
    """Whether the motion rests at the ``event`` of that number is said by ``mode``; ``auxiliary`` as of a
    guard."""

    event: int
    mode: Node
    auxiliary: int


@dataclass(frozen=True)
class Guarded:
    """Equations and integrands with modes in place of what moves in switches, and so the arguments of the
    model's ``events``.

    The model of ``residual`` has the ``auxiliary`` coordinates behind its own.
    """

    residual: Residual
    integrands: Mapping[str, Node]
    guards: tuple[Guard, ...] = ()
    auxiliary: int = 0
    events: tuple[Node, ...] = ()
    rests: tuple[Rest, ...] = ()
    limits: tuple[Node, ...] = ()
    """Of each guard with a limit the sum of limit and force, and the difference."""
    breaks: tuple[Node, ...] = ()
    """Of each guard where something jumps x, which is negative there, and the squares of a ``Cut``."""


def guarded(residual: Residual, integrands: Mapping[str, Node]) -> Guarded:
    """The equations and integrands for steps, in each of which no switch changes."""
    found = cuts(residual.model)
    if not (
        found
        or residual.model.events
        or switches([*residual.residual, *integrands.values()], residual.variables)
    ):
        return Guarded(residual, integrands)
    free: frozenset[Node] = frozenset()
    while True:
        made = _Freezing(residual, free)
        whole = made.guarded(integrands, found)
        if whole is not None:
            return whole
        free |= made.entangled


def guarded_values(
    residual: Residual, nodes: Sequence[Node]
) -> tuple[Guarded, tuple[Node, ...], tuple[Node, ...]]:
    """The equations; ``nodes`` with their modes and multipliers, whose switches may have other arguments; and
    the symbols of these multipliers, in the order of the auxiliary coordinates."""
    free: frozenset[Node] = frozenset()
    while True:
        made = _Freezing(residual, free)
        whole = made.guarded({})
        if whole is not None:
            made.closed = True
            return whole, made.frozen(nodes), tuple(made.multipliers)
        free |= made.entangled


class _Freezing:
    """Modes, and what has been written with them so far."""

    def __init__(self, residual: Residual, free: frozenset[Node] = frozenset()) -> None:
        self.residual, self.graph = residual, residual.graph
        self.moving = residual.variables
        self.free = free
        self.guards: dict[Node, Guard] = {}
        self.multipliers = [contact.multiplier for contact in residual.contacts]
        self.holding = reduce(or_, (one.symbols for one in self.multipliers), 0)
        """Bit set of the multipliers."""
        self.rests = tuple(
            Rest(contact.event, contact.rest, i) for i, contact in enumerate(residual.contacts)
        )
        self.made: dict[Node, Node] = {}
        self.merged = Merging(self.graph, self.moving).merged
        self.closed = False
        """Whether the equations are written: switches with other arguments than theirs have no modes then."""
        self.entangled: frozenset[Node] = frozenset()
        """Guards whose multipliers the equations are not linear in."""
        self.inertial = self._inertial()
        """Switches that no multiplier may stand for: the equations are to stay linear in accelerations."""

    def _inertial(self) -> set[Node]:
        """Switches in masses, in momenta, and in factors of accelerations."""
        residual, found = self.residual, set[Node]()
        entries = [entry for row in residual.unpushed.entries for entry in row.values()]
        entries += residual.inertias
        entries += [node for one in residual.cyclic_momenta for node in (one.momentum, one.speed)]
        inside, accelerated = [*self.merged(entries)], set[Node]()
        for node in reachable(self.merged(residual.residual)):
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
        nodes = self.merged(nodes)
        for node in reachable(nodes, lambda node: node not in self.made):
            arguments = [self.made[argument] for argument in node.arguments]
            if self._has_mode(node):
                self.made[node] = self._by_mode(node, *arguments)
            elif all(a is b for a, b in zip(arguments, node.arguments)):
                self.made[node] = node
            elif node.kind is Kind.DDT:
                moves = arguments[0].symbols & self.moving  # a mode does not
                self.made[node] = self.graph.ddt(arguments[0]) if moves else self.graph.zero
            else:
                self.made[node] = rebuilt(self.graph, node, arguments)
        return tuple(self.made[node] for node in nodes)

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
        if node in self.inertial or self._held_inside(above - below):
            return graph.switch(guard.mode, above, below, -1)
        if not self._jumps(node):
            resting = self._resting(original, above, below)
            if resting is None:
                return graph.switch(guard.mode, above, below, -1)
            return self._three_ways(guard.mode, above, below, resting[0])
        able = self._moves(original) and original not in self.free and not self.closed
        if guard.auxiliary is None and able:
            guard = self.guards[original] = replace(guard, auxiliary=len(self.multipliers))
            self.multipliers.append(graph.symbol(f"multiplier {guard.auxiliary}"))
            self.holding |= self.multipliers[-1].symbols
        if guard.auxiliary is None:
            return graph.switch(guard.mode, above, below, -1)
        multiplier = self.multipliers[guard.auxiliary]
        first, second = self._resting(original, above, below) or (above, below)
        held = (first + second) / 2.0 + multiplier * (first - second) / 2.0
        return self._three_ways(guard.mode, above, below, held)

    def _resting(self, argument: Node, above: Node, below: Node) -> tuple[Node, Node] | None:
        """What both branches are where a velocity is 0, if they have a root of it: this has no series there,
        and may bring to rest in a finite time."""
        if argument not in self.residual.model.v:
            return None
        rooted = any(
            node.kind is Kind.PRODUCT
            and any(
                base.symbols & argument.symbols and e != int(e) for base, e in zip(node.arguments, node.data)
            )
            for node in reachable([above, below])
        )
        if not rooted:
            return None
        return where_zero(self.graph, above, argument), where_zero(self.graph, below, argument)

    def _held_inside(self, node: Node) -> bool:
        """Whether a multiplier stands in it: the equations must stay linear in all of them."""
        return bool(node.symbols & self.holding)

    def _three_ways(self, mode: Node, above: Node, below: Node, held: Node) -> Node:
        """One or the other by a mode: +1, -1, or 0."""
        return self.graph.switch(mode, above, self.graph.switch(-mode, below, held, -1), -1)

    def _jumps(self, node: Node) -> bool:
        """Whether a switch may have two values where its argument is 0."""
        argument, above, below = node.arguments
        return not vanishes_with(self.graph, above - below, argument)

    def _moves(self, argument: Node) -> bool:
        """Whether it depends on more than the time."""
        model = self.residual.model
        return any(argument.symbols & symbol.symbols for symbol in (*model.q, *model.v))

    def guarded(self, integrands: Mapping[str, Node], broken: Sequence[Cut] = ()) -> Guarded | None:
        """All of it with modes; equations that hold the motion are added. None if these are not linear in the
        multipliers: guards that are ``entangled`` must be without."""
        residual, graph = self.residual, self.graph
        rows = self.frozen(residual.residual)
        quadratures = self.frozen([*integrands.values()])
        events = self.frozen([event.argument for event in residual.model.events])
        places = self.frozen([one.y for one in broken])
        breaks = self.frozen([node for one in broken for node in (one.x, one.jump, one.usual)])
        rows, quadratures = self._by_forces(rows, quadratures)
        matrix = [mapped(row, self.frozen) for row in residual.unpushed.mass_matrix]
        if residual.pushed:
            first = len(residual.model.q)
            for k, row in enumerate(rows[:first]):
                matrix[k] = (*matrix[k][:first], *(graph.diff(row, one) for one in residual.multipliers))
        inertias = self.frozen(residual.inertias)
        momenta = []
        for one in residual.cyclic_momenta:
            momentum, speed = self.frozen([one.momentum, one.speed])
            momenta.append(replace(one, momentum=momentum, speed=speed))
        model = with_auxiliary(residual.model, graph, len(self.multipliers))
        wider = replace(
            residual, model=model, residual=rows, mass_matrix=tuple(matrix), inertias=inertias,
            cyclic_momenta=tuple(momenta),
        )  # fmt: skip
        linear = [*rows, *quadratures]
        alone = [
            *(row[k] for j, row in enumerate(matrix) for k in nonzero(row, graph.zero, j)),
            *inertias,
            *(one.speed for one in momenta),
        ]
        alone += [*events, *(guard.argument for guard in self.guards.values())]
        slopes = [self.graph.diff(x, m) for m in self.multipliers for x in linear if not has_rates(x, m)]
        mixed = [*slopes, *alone, *(x for m in self.multipliers for x in linear if has_rates(x, m))]
        used = 0
        for x in mixed:
            used |= x.symbols
        entangled = [
            guard
            for guard in self.guards.values()
            if guard.auxiliary is not None
            and (used & (m := self.multipliers[guard.auxiliary]).symbols or self._mixes(linear, m))
        ]
        # friction holds more often than a force that depends on the place
        of_place = [one for one in entangled if not any(one.argument.symbols & v.symbols for v in model.v)]
        self.entangled = frozenset(one.original for one in of_place or entangled)
        if self.entangled:
            return None
        limits = [
            limit + sign * self.multipliers[guard.auxiliary]
            for guard in self.guards.values()
            if guard.auxiliary is not None and (limit := guard.limit) is not None
            for sign in (1.0, -1.0)
        ]
        if self.multipliers:
            wider, both = self._held(wider, [*quadratures, *limits], events)
            quadratures, limits = both[: len(quadratures)], [*both[len(quadratures) :]]
        modes = (self.graph.symbol(f"break {i}") for i in range(len(broken)))
        ending = [Guard(y, y, mode, broken=one) for y, mode, one in zip(places, modes, broken)]
        guards = (*self.guards.values(), *self._cuts(events), *ending)
        named = dict(zip(integrands, quadratures))
        return Guarded(wider, named, guards, len(self.multipliers), events, self.rests, tuple(limits), breaks)

    def _by_forces(
        self, rows: Sequence[Node], quadratures: Sequence[Node]
    ) -> tuple[tuple[Node, ...], tuple[Node, ...]]:
        """``rows`` and ``quadratures`` with forces in place of multipliers of switches, where multipliers of
        constraints are their factors."""
        bound = reduce(or_, (one.symbols for one in self.residual.multipliers), 0)
        graph, nodes = self.graph, [*rows, *quadratures]
        for original, guard in self.guards.items():
            if guard.auxiliary is None or not bound:
                continue
            m = self.multipliers[guard.auxiliary]
            slopes = {i: graph.diff(x, m) for i, x in enumerate(nodes) if not has_rates(x, m)}
            held = {i: self._where_held(one, guard.mode) for i, one in slopes.items() if not one.is_zero}
            if not any(one.symbols & bound for one in held.values()):
                continue
            shares = self._shares(held)
            if shares is None:
                continue
            limit, factors = shares
            nodes = [*substituted(graph, nodes, {m: graph.zero})]
            for i, factor in factors.items():
                nodes[i] = nodes[i] + self._three_ways(guard.mode, graph.zero, graph.zero, factor * m)
            self.guards[original] = replace(guard, limit=limit)
        return tuple(nodes[: len(rows)]), tuple(nodes[len(rows) :])

    def _mixes(self, nodes: Sequence[Node], m: Node) -> bool:
        """Whether a multiplier is multiplied with one of a constraint."""
        bound = reduce(or_, (one.symbols for one in self.residual.multipliers), 0)
        rates = (self.graph.diff(x, m) for x in nodes if x.symbols & bound and not has_rates(x, m))
        return any(rate.symbols & bound for rate in rates)

    def _where_held(self, node: Node, mode: Node) -> Node:
        """``node`` where a mode is 0."""
        made: dict[Node, Node] = {}
        for one in reachable([node]):
            arguments = [made[a] for a in one.arguments]
            if one.kind is Kind.SWITCH and one.arguments[0].symbols & mode.symbols:
                made[one] = arguments[1 if one.data > 0 else 2]
            else:
                made[one] = rebuilt(self.graph, one, arguments)
        return made[node]

    def _shares(self, held: Mapping[int, Node]) -> tuple[Node, dict[int, Node]] | None:
        """A limit, and factors without multipliers of constraints that give ``held`` when multiplied with it;
        None where there are none."""
        graph, multipliers = self.graph, self.residual.multipliers
        first = next(iter(held.values()))
        one = next((one for one in multipliers if first.symbols & one.symbols), None)
        if one is None:
            return None
        slopes = {i: graph.diff(each, one) for i, each in held.items()}
        alone = all(is_zero(each - slopes[i] * one) for i, each in held.items())
        limit = one if alone else first
        factors = slopes if alone else {i: slope / graph.diff(first, one) for i, slope in slopes.items()}
        bound = reduce(or_, (other.symbols for other in multipliers), 0)
        shared = all(
            not factors[i].symbols & bound and is_zero(each - factors[i] * limit) for i, each in held.items()
        )
        return (limit, factors) if shared else None

    def _cuts(self, events: Sequence[Node]) -> list[Guard]:
        """Guards where atan2(y, x) jumps by 2 pi, which stands in other arguments: at y = 0, as x may be
        negative."""
        arguments = [*events, *(guard.argument for guard in self.guards.values())]
        angles = (
            node for node in reachable(arguments) if node.kind is Kind.FUNCTION and node.data == "atan2"
        )
        places = dict.fromkeys(node.arguments[0] for node in angles if node.symbols & self.moving)
        symbols = (self.graph.symbol(f"cut {i}") for i in range(len(places)))
        return [Guard(y, y, mode, cut=True) for y, mode in zip(places, symbols)]

    def _held(
        self, residual: Residual, integrands: Sequence[Node], events: Sequence[Node]
    ) -> tuple[Residual, tuple[Node, ...]]:
        """The equations with multipliers as accelerations of auxiliary coordinates, and theirs; those of
        constraints are the last ones."""
        graph, model, own = self.graph, residual.model, len(self.residual.model.q)
        symbols = model.v[own:]
        graph.work.charge(len(model.q) ** 2, f"a matrix of {own} coordinates and {len(symbols)} multipliers")
        accelerations = dict(zip(self.multipliers, map(graph.ddt, symbols)))
        columns = [[graph.diff(row, m) for m in self.multipliers] for row in residual.residual]
        rows = substituted(graph, residual.residual, accelerations)
        matrix = [[*row[:own], *column, *row[own:]] for row, column in zip(residual.mass_matrix, columns)]
        constraints = [graph.zero] * len(residual.multipliers)
        added, slopes = [], []
        holding = [guard for guard in self.guards.values() if guard.auxiliary is not None]
        resting = [(one.auxiliary, events[one.event], one.mode, True) for one in self.rests]
        resting += [(one.auxiliary or 0, one.argument, one.mode, False) for one in holding]
        for (_, u, mode, rests), symbol in zip(sorted(resting, key=lambda one: one[0]), symbols):
            free, zero = graph.ddt(symbol), graph.zero
            by = model.v if any(u.symbols & v.symbols for v in model.v) else model.q
            kept = rate(graph, u, residual.variables)
            if by is model.q:
                kept = graph.ddt(kept)

            def chosen(held: Node, otherwise: Node, mode: Node = mode, rests: bool = rests) -> Node:
                sides = (held, otherwise) if rests else (otherwise, held)
                return self._three_ways(mode, sides[0], sides[0], sides[1])

            added.append(chosen(HEAVY * kept, free))
            row = [chosen(HEAVY * graph.diff(u, x), zero) for x in by[:own]]
            one = chosen(zero, graph.one)
            slopes.append([*row, *(one if other is symbol else zero for other in symbols), *constraints])
        wider = replace(
            residual,
            residual=(*rows[:own], *added, *rows[own:]),
            mass_matrix=tuple(map(tuple, (*matrix[:own], *slopes, *matrix[own:]))),
            definite=False,
        )
        return wider, substituted(graph, integrands, accelerations)


def with_auxiliary(model: Model[Node], graph: Graph, count: int) -> Model[Node]:
    """The model with so many auxiliary coordinates behind its own."""
    names = [f"hold {i}" for i in range(count)]
    return replace(
        model,
        coordinates=(*model.coordinates, *names),
        q=(*model.q, *(graph.symbol(name) for name in names)),
        v=(*model.v, *(graph.symbol(f"{name} dot") for name in names)),
        generalized_forces=(*model.generalized_forces, *[graph.zero] * count),
    )
