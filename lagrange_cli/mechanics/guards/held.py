"""Equations that hold a motion where the argument u of a switch is 0, as dry friction does.

Where the forces jump at u = 0, both branches may lead back to it: the motion stays there. The mode is then 0
and the switch has the value of A. F. Filippov (Differential Equations with Discontinuous Righthand Sides,
1988, sec. 4)

    (above + below)/2 + m (above - below)/2,    -1 <= m <= 1,

with the multiplier m for which u stays 0. It is found as the acceleration of an auxiliary coordinate y, m =
y'', whose equation is du/dt = 0, or d2u/dt2 = 0 where u does not contain velocities, and y'' = 0 while the
mode is not 0.

The forces of resting contact (see ``mechanics.contacts``) are such multipliers, too; the mode of a contact is
1 or -1, the side that the motion came from, while it rests, and else 0."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.guards.guard import Guard
from lagrange_cli.mechanics.guards.modes import Modes, three_ways
from lagrange_cli.mechanics.guards.vectors import constrained, made_of
from lagrange_cli.mechanics.matrices import matrix_of
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import numbered, rate
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace

HEAVY = 2.0**40
"""What the equation that holds the motion is multiplied with: elimination begins with it, so that u stays 0
to the last bit."""


def foresee_multipliers(modes: Modes) -> None:
    """Raise ``TooLarge`` where there are too many multipliers."""
    own, count = len(modes.residual.model.q), len(modes.multipliers)
    if count:
        modes.graph.work.foresee((own + count) ** 2, matrix_of(own, count))


def held_by_multipliers(
    modes: Modes, residual: Residual, integrands: Sequence[Node], events: Sequence[Node]
) -> tuple[Residual, tuple[Node, ...]]:
    """The equations with multipliers as accelerations of auxiliary coordinates, and theirs; those of
    constraints are the last ones."""
    graph, model, own = modes.graph, residual.model, len(modes.residual.model.q)
    symbols = model.v[own:]
    graph.work.charge(len(model.q) ** 2, matrix_of(own, len(symbols)))
    accelerations = dict(zip(modes.multipliers, map(graph.ddt, symbols)))
    rows = determined(modes, residual)
    columns = [[graph.diff(row, m) for m in modes.multipliers] for row in rows]
    rows = substituted(graph, rows, accelerations)
    matrix = [[*row[:own], *column, *row[own:]] for row, column in zip(residual.mass_matrix, columns)]
    constraints = [graph.zero] * len(residual.multipliers)
    added, slopes = [], []
    holding = [guard for guard in modes.guards.values() if guard.auxiliary is not None]
    resting = [(one.auxiliary, events[one.event], one.mode, True) for one in modes.rests]
    for guard in holding:
        parts = (guard.argument,) if guard.vector is None else guard.vector.parts
        resting += [(i, u, guard.holds(graph), False) for i, u in zip(guard.holding, parts)]
    resting.sort(key=lambda one: one[0])
    vectors = {i for guard in holding if guard.vector is not None for i in guard.holding}
    apart = [n for n, one in enumerate(resting) if not one[3] and (one[0] in vectors or not modes.followed)]
    shares = shared(modes, residual, {n: resting[n][1] for n in apart})
    for number, ((_, u, mode, rests), symbol) in enumerate(zip(resting, symbols)):
        free, zero = graph.ddt(symbol), graph.zero
        by = model.v if any(u.symbols & v.symbols for v in model.v) else model.q
        kept = rate(graph, u, residual.variables)
        if by is model.q:
            kept = graph.ddt(kept)
        others = shares.get(number, {})
        together = {*(resting[i][2] for i in others)}
        against = held_on(modes, u) if rests else []

        def chosen(
            held: Node,
            otherwise: Node,
            share: Node = graph.zero,
            mode: Node = mode,
            rests: bool = rests,
            together: Collection[Node] = together,
        ) -> Node:
            found = share if together else held
            for other in together:
                found = three_ways(graph, other, held, held, found)
            sides = (found, otherwise) if rests else (otherwise, found)
            return three_ways(graph, mode, sides[0], sides[0], sides[1])

        least = graph.sum([(free, 1.0), *((graph.ddt(symbols[i]), -a) for i, a in others.items())])
        row, kept = [HEAVY * graph.diff(u, x) for x in by[:own]], HEAVY * kept
        for mode_of, factors in against:
            force = graph.sum([(b * graph.ddt(symbols[i]), 1.0) for i, b in factors.items()])
            kept = three_ways(graph, mode_of, kept, kept, force)
            row = [three_ways(graph, mode_of, a, a, zero) for a in row]
        added.append(chosen(kept, free, least))
        row = [chosen(a, zero) for a in row]
        one = chosen(zero, graph.one, graph.one)
        shares_of = {symbols[i]: chosen(zero, zero, graph.constant(-a)) for i, a in others.items()}
        for mode_of, factors in against:
            part = {i: three_ways(graph, mode_of, zero, zero, b) for i, b in factors.items()}
            shares_of |= {symbols[i]: chosen(b, zero) for i, b in part.items()}
        shares_of[symbol] = one
        slopes.append([*row, *(shares_of.get(other, zero) for other in symbols), *constraints])
    wider = replace(
        residual,
        residual=(*rows[:own], *added, *rows[own:]),
        mass_matrix=tuple(map(tuple, (*matrix[:own], *slopes, *matrix[own:]))),
        definite=False,
    )
    return wider, substituted(graph, integrands, accelerations)


def shared(modes: Modes, residual: Residual, holding: Mapping[int, Node]) -> dict[int, dict[int, float]]:
    """Those of ``holding`` arguments, by number, that hold what others do, and how these make them up (see
    ``guards.shared``)."""
    if len(holding) < 2:
        return {}
    from lagrange_cli.mechanics.guards.shared import dependent

    graph, model, places = modes.graph, residual.model, numbered(residual.model.q)

    def speed(u: Node) -> Node:
        if any(u.symbols & v.symbols for v in model.v):
            return u
        slopes = [(slope * model.v[k], 1.0) for k, slope in graph.gradient(u, places).items()]
        return graph.sum([*slopes, (graph.diff(u, model.time), 1.0)])

    speeds = [*map(speed, holding.values())]
    numbers, found = [*holding], dependent(graph, speeds, numbered(model.v))
    return {numbers[n]: {numbers[i]: a for i, a in made_of.items()} for n, made_of in found.items()}


def determined(modes: Modes, residual: Residual) -> Sequence[Node]:
    """The equations, where they determine all multipliers: what holds a vector holds its constraints, too.
    While it does, these say instead that the force is along a velocity they allow (see ``held_back``)."""
    graph, rows = modes.graph, [*residual.residual]
    for guard in modes.guards.values():
        for j, force, _ in held_back(modes, residual, guard):
            rows[j] = rows[j] + three_ways(graph, guard.holds(graph), graph.zero, graph.zero, -force)
    return rows


def held_back(modes: Modes, residual: Residual, guard: Guard) -> list[tuple[int, Node, bool]]:
    """The constraints on velocities that are some on a vector alone: the numbers of their equations, the part
    of the force against them, and whether they are driven. Such a part is 0 while the vector can be held: not
    where a constraint that is driven moves it on."""
    if guard.vector is None or not guard.holding:
        return []
    multipliers = [modes.multipliers[i] for i in guard.holding]
    return [
        (j, modes.graph.sum([(b * force, 1.0) for b, force in zip(factors, multipliers)]), driven)
        for j, factors, driven in constrained(residual, guard.vector)
    ]


def held_on(modes: Modes, place: Node) -> list[tuple[Node, dict[int, Node]]]:
    """What holds a vector whose parts make up the velocity of a contact's ``place``: it holds this, too, and
    the contact takes the force against it. Its mode, and the factors of the parts of that force. Where there
    are several vectors, more than one force may hold the contact, and nothing is changed."""
    graph, model = modes.graph, modes.residual.model
    holding = [one for one in modes.guards.values() if one.vector is not None and one.holding]
    if len(holding) != 1 or not is_zero(graph.diff(place, model.time)):
        return []
    (guard,) = holding
    assert guard.vector is not None
    slopes = graph.gradient(place, numbered(model.q))
    row = [slopes.get(k, graph.zero) for k in range(len(model.q))]
    factors = made_of(graph, model.v, guard.vector, row)
    if factors is None or all(map(is_zero, factors)):
        return []
    return [(guard.holds(graph), dict(zip(guard.holding, factors)))]


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
