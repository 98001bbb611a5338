"""Equations and integrands with modes in place of the changing parts of switches: smooth until a guard
changes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from lagrange_cli.expression.node import Kind, Node, reachable, union
from lagrange_cli.mechanics.guards.forces import by_forces, mixes
from lagrange_cli.mechanics.guards.guard import Guard, Guarded
from lagrange_cli.mechanics.guards.held import (
    foresee_multipliers,
    held_back,
    held_by_multipliers,
    with_auxiliary,
)
from lagrange_cli.mechanics.guards.modes import RIDES, Modes
from lagrange_cli.mechanics.guards.vectors import vectors
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.rows import mapped
from lagrange_cli.mechanics.switching.cuts import Cut, cuts
from lagrange_cli.mechanics.switching.switches import has_rates, switches
from lagrange_cli.mechanics.variables import nonzero
from lagrange_cli.records import replace

DRIVEN = 2.0**40
"""The factor of its square: rounding errors times 2^20 are still nothing."""


def guarded(residual: Residual, integrands: Mapping[str, Node]) -> Guarded:
    """The equations and integrands for steps, in each of which no switch changes."""
    found, edges, variables = cuts(residual.model), edges_of(residual), residual.variables
    if not (
        found
        or edges
        or residual.model.events
        or switches([*residual.residual, *followed(residual), *integrands.values()], variables)
        or inner_poles([*integrands.values()], residual.residual, variables)
        or vectors(residual)
    ):
        return Guarded(residual, integrands)
    return with_multipliers(residual, integrands, found, edges)[1]


def edges_of(residual: Residual) -> list[Node]:
    """What is positive until a motion is at the edge of a domain that steps may pass."""
    if not residual.model.edges:
        return []
    from lagrange_cli.mechanics.switching.edges import watched_edges

    return watched_edges(residual)


def followed(residual: Residual) -> list[Node]:
    """The coordinates and velocities that are not among the unknowns, as functions of those that are."""
    return [node for one in residual.dependent for node in (one.place, one.speed) if node is not None]


def guarded_values(
    residual: Residual, nodes: Sequence[Node]
) -> tuple[Guarded, tuple[Node, ...], tuple[Node, ...]]:
    """The equations; ``nodes`` with their modes and multipliers, whose switches may have other arguments; and
    the symbols of these multipliers, in the order of the auxiliary coordinates."""
    modes, whole = with_multipliers(residual, {}, followed=False)
    modes.closed = True
    return whole, modes.frozen(nodes), tuple(modes.multipliers)


def with_multipliers(
    residual: Residual,
    integrands: Mapping[str, Node],
    broken: Sequence[Cut] = (),
    edges: Sequence[Node] = (),
    *,
    followed: bool = True,
) -> tuple[Modes, Guarded]:
    """The equations with all multipliers that they are linear in, and the modes in them: of motions that are
    ``followed``, or else at single states."""
    free: frozenset[Node] = frozenset()
    while True:
        modes = Modes(residual, free, followed=followed)
        made = assembled(modes, integrands, broken, edges)
        if isinstance(made, Guarded):
            return modes, made
        free |= made


def assembled(
    modes: Modes, integrands: Mapping[str, Node], broken: Sequence[Cut] = (), edges: Sequence[Node] = ()
) -> Guarded | frozenset[Node]:
    """All of it with modes; equations that hold the motion are added. Or, if these are not linear in the
    multipliers, the arguments of guards that must be without."""
    from lagrange_cli.mechanics.guards.silence import hushed, silence, without_silent_vectors

    residual, graph = modes.residual, modes.graph
    rows = modes.frozen(residual.residual)
    foresee_multipliers(modes)
    quadratures = modes.frozen([*integrands.values()])
    events = modes.frozen([event.argument for event in residual.model.events])
    modes.holds = False
    places = modes.frozen([one.y for one in broken])
    ends = modes.frozen(edges)
    breaks = modes.frozen([node for one in broken for node in (one.x, one.jump, one.usual)])
    modes.holds = True
    inner = frozenset(
        guard.original
        for guard in modes.guards.values()
        if guard.auxiliary is not None
        and not guard.reverses
        and modes.multipliers[guard.auxiliary].symbols & modes.coefficients
    )
    if inner:
        return inner
    rows, quadratures = by_forces(modes, rows, quadratures)
    matrix = [mapped(row, modes.frozen) for row in residual.unpushed.mass_matrix]
    if residual.pushed:
        first = len(residual.model.q)
        for k, row in enumerate(rows[:first]):
            matrix[k] = (*matrix[k][:first], *(graph.diff(row, one) for one in residual.multipliers))
    model = with_auxiliary(residual.model, graph, len(modes.multipliers))
    beside = beside_rows(residual, modes.frozen)
    wider = replace(beside, model=model, residual=rows, mass_matrix=tuple(matrix))
    linear = [*rows, *quadratures]
    multipliers = union(modes.multipliers)
    alone = [
        *(row[k] for j, row in enumerate(matrix) for k in nonzero(row, graph.zero, j)),
        *wider.inertias,
        *(one.speed for one in wider.cyclic_momenta),
        *followed(wider),
    ]
    alone += events
    mixed = [*alone, *(guard.argument for guard in modes.guards.values())]
    for x in linear:
        for m in graph.symbols_of(x, multipliers):
            mixed.append(x if has_rates(x, m) else graph.diff(x, m))
    used = union(mixed)
    entangled = [
        guard
        for guard in modes.guards.values()
        if guard.auxiliary is not None
        and (used & (m := modes.multipliers[guard.auxiliary]).symbols or mixes(modes, linear, m))
    ]
    if entangled:
        # friction holds more often than a force that depends on the place, or than its own coefficient
        of_place = [one for one in entangled if not any(one.argument.symbols & v.symbols for v in model.v)]
        coefficients = [one for one in entangled if not one.reverses]
        return frozenset(one.original for one in of_place or coefficients or entangled)
    limits = tuple(node for guard in modes.guards.values() for node in _limits(modes, guard))
    momenta = [one.momentum for one in wider.cyclic_momenta]
    felt = [*linear, *alone, *momenta, *places, *ends, *breaks]
    silencers = silence(modes, felt, _limits) if modes.followed else []
    if modes.multipliers:
        wider, both = held_by_multipliers(modes, wider, [*quadratures, *limits], events)
        quadratures, limits = both[: len(quadratures)], both[len(quadratures) :]
    heard = without_silent_vectors(modes)
    matrix = [mapped(row, heard) for row in wider.mass_matrix]
    wider = replace(beside_rows(wider, heard), residual=heard(wider.residual), mass_matrix=tuple(matrix))
    quadratures, limits, events, breaks = map(heard, (quadratures, limits, events, breaks))
    symbols = (graph.symbol(f"break {i}") for i in range(len(broken)))
    ending = [Guard(y, y, mode, broken=one) for y, mode, one in zip(places, symbols, broken)]
    symbols = (graph.symbol(f"edge {i}") for i in range(len(ends)))
    ending += [Guard(u, u, mode, edge=True) for u, mode in zip(ends, symbols)]
    watched = [*riding(modes, [hushed(graph, one) for one in modes.guards.values()])]
    watched += [*_cuts(modes, events), *ending]
    poles = inner_poles(quadratures, rows, modes.moving, [one.argument for one in watched])
    symbols = (graph.symbol(f"pole {i}") for i in range(len(poles)))
    guards = (*watched, *(Guard(u, u, mode) for u, mode in zip(poles, symbols)), *silencers)
    named = dict(zip(integrands, quadratures))
    parts = tuple(u for guard in guards if guard.vector is not None for u in guard.vector.parts)
    return Guarded(wider, named, guards, len(modes.multipliers), events, modes.rests, limits, breaks, parts)


def riding(modes: Modes, guards: Sequence[Guard]) -> Sequence[Guard]:
    """Guards of friction that constraints may bind together: the arguments of those that ride are their
    modes, as they would be rounding."""
    if not (modes.followed and modes.residual.multipliers):
        return guards
    graph = modes.graph
    return [
        replace(one, argument=graph.switch(one.mode - RIDES, one.mode, one.argument, -1))
        if one.auxiliary is not None and one.vector is None
        else one
        for one in guards
    ]


def beside_rows(residual: Residual, change: Callable[[Sequence[Node]], tuple[Node, ...]]) -> Residual:
    """The equations with all that is beside their rows and their matrix changed."""
    momenta, dependent = [], []
    for one in residual.cyclic_momenta:
        momentum, speed = change([one.momentum, one.speed])
        momenta.append(replace(one, momentum=momentum, speed=speed))
    for given in residual.dependent:
        place, speed = given.place, change([given.speed])[0]
        if place is not None:
            (place,) = change([place])
        dependent.append(replace(given, place=place, speed=speed))
    inertias = change(residual.inertias)
    return replace(residual, inertias=inertias, cyclic_momenta=tuple(momenta), dependent=tuple(dependent))


def _limits(modes: Modes, guard: Guard) -> list[Node]:
    """Limit plus force and limit minus force; of a vector, their squares. A force against a constraint that
    is driven is as much as one far beyond the limit."""
    if guard.limit is None:
        return []
    limit, forces = guard.limit, [modes.multipliers[i] for i in guard.holding]
    force = forces[0]
    if guard.vector is not None:
        squares = [(d * f * f, 1.0) for d, f in zip(guard.vector.weights, forces)]
        against = [force for _, force, driven in held_back(modes, modes.residual, guard) if driven]
        force = modes.graph.sum([*squares, *((f * f, DRIVEN) for f in against)])
        limit = limit * limit
    return [limit + force, limit - force]


def _cuts(modes: Modes, events: Sequence[Node]) -> list[Guard]:
    """Guards where atan2(y, x) jumps by 2 pi, which stands in other arguments: at y = 0, as x may be
    negative."""
    arguments = [*events, *(guard.argument for guard in modes.guards.values())]
    angles = (node for node in reachable(arguments) if node.kind is Kind.FUNCTION and node.data == "atan2")
    places = dict.fromkeys(node.arguments[0] for node in angles if node.symbols & modes.moving)
    symbols = (modes.graph.symbol(f"cut {i}") for i in range(len(places)))
    return [Guard(y, y, mode, cut=True) for y, mode in zip(places, symbols)]


def inner_poles(
    integrands: Sequence[Node], rows: Sequence[Node], moving: int, watched: Sequence[Node] = ()
) -> list[Node]:
    """Denominators within arguments of functions in integrands alone, as that of exp(-1/x**2): where they are
    0 there is no series, but the integrand may be finite on both sides, so that steps end there. Those of the
    ``rows`` of the equations end the motion."""
    known = {*reachable(rows), *watched}
    functions = (node for node in reachable(integrands) if node.kind is Kind.FUNCTION)
    within = [argument for node in functions if node.symbols & moving for argument in node.arguments]
    powers = (node for node in reachable(within) if node.kind is Kind.PRODUCT)
    found = (base for node in powers for base, e in zip(node.arguments, node.data) if e < 0)
    return [u for u in dict.fromkeys(found) if u.symbols & moving and u not in known]
