"""Forces that jump by what changes itself: by the multipliers of constraints, as friction by a normal force
does, mu N sign(v), or by a force that is switched off, as that of a brake.

With the limit D = mu N there is an unknown force f = m D in place of the multiplier m (see ``held``): the
equations stay linear in it and in N, and determine it where D = 0. It is found as y'', and D + f and D - f
have the sign of D as long as -1 <= m <= 1. The force along a vector has a multiplier for each component, and
their common limit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, factors_of, terms_of, union
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.guards.modes import Modes, three_ways
from lagrange_cli.mechanics.substitution import rewritten, substituted
from lagrange_cli.mechanics.switching.switches import has_rates
from lagrange_cli.records import replace

Place = tuple[int, Node]
"""The number of an equation or integrand, and a multiplier in it."""


def by_forces(
    modes: Modes, rows: Sequence[Node], quadratures: Sequence[Node]
) -> tuple[tuple[Node, ...], tuple[Node, ...]]:
    """``rows`` and ``quadratures`` with forces in place of multipliers of switches, where multipliers of
    constraints are their factors; and of friction, where something is that may become 0."""
    bound = union(_reactions(modes))
    changing = modes.moving | union(guard.mode for guard in modes.guards.values())
    graph, nodes = modes.graph, [*rows, *quadratures]
    for original, guard in modes.guards.items():
        if not guard.holding:
            continue
        own = [modes.multipliers[i] for i in guard.holding]
        slopes = {
            (i, m): graph.diff(x, m)
            for i, x in enumerate(nodes)
            for m in own
            if x.symbols & m.symbols and not has_rates(x, m)
        }
        held = {i: _where_held(graph, one, guard.mode) for i, one in slopes.items() if not one.is_zero}
        if any(one.symbols & bound for one in held.values()):
            shares = _shares(modes, held)
        elif guard.vector is not None or (
            guard.reverses and any(one.symbols & changing for one in held.values())
        ):
            shares = _common(graph, [*held], [*held.values()])
        else:
            continue
        if shares is None:
            continue
        limit, factors = shares
        nodes = [*substituted(graph, nodes, dict.fromkeys(own, graph.zero))]
        for (i, m), factor in factors.items():
            nodes[i] = nodes[i] + three_ways(graph, guard.mode, graph.zero, graph.zero, factor * m)
        modes.guards[original] = replace(guard, limit=limit)
    return tuple(nodes[: len(rows)]), tuple(nodes[len(rows) :])


def _reactions(modes: Modes) -> list[Node]:
    """The multipliers of constraints, and those of resting contact."""
    residual = modes.residual
    return [*residual.multipliers, *(contact.multiplier for contact in residual.contacts)]


def mixes(modes: Modes, nodes: Sequence[Node], m: Node) -> bool:
    """Whether a multiplier is multiplied with one of a constraint."""
    bound = union(_reactions(modes))
    both = [x for x in nodes if x.symbols & bound and x.symbols & m.symbols] if bound else []
    rates = (modes.graph.diff(x, m) for x in both if not has_rates(x, m))
    return any(rate.symbols & bound for rate in rates)


def _where_held(graph: Graph, node: Node, mode: Node) -> Node:
    """``node`` where a mode is 0."""

    def change(one: Node, arguments: list[Node]) -> Node | None:
        switched = one.kind is Kind.SWITCH and one.arguments[0].symbols & mode.symbols
        return arguments[1 if one.data > 0 else 2] if switched else None

    return rewritten(graph, [node], change)[0]


def _shares(modes: Modes, held: Mapping[Place, Node]) -> tuple[Node, dict[Place, Node]] | None:
    """A limit, and factors without multipliers of constraints that give ``held`` when multiplied with it;
    None where there are none."""
    graph, multipliers = modes.graph, _reactions(modes)
    first = next(iter(held.values()))
    one = next((one for one in multipliers if first.symbols & one.symbols), None)
    if one is None:
        return None
    slopes = {i: graph.diff(each, one) for i, each in held.items()}
    alone = all(is_zero(each - slopes[i] * one) for i, each in held.items())
    bound = union(multipliers)
    # what else it is multiplied with, such as the cosine of an angle, may be 0 while others are not
    common = factors_of(graph.split_coefficient(first)[1])
    limit = one if alone else graph.product((a, e) for a, e in common if a.symbols & bound)
    factors = slopes if alone else _quotients(graph, slopes, graph.diff(limit, one))
    shared = all(
        not factors[i].symbols & bound and is_zero(each - factors[i] * limit) for i, each in held.items()
    )
    return (limit, factors) if shared else None


def _common(
    graph: Graph, places: Sequence[Place], nodes: Sequence[Node]
) -> tuple[Node, dict[Place, Node]] | None:
    """The product of the factors, but numbers, that all nodes have in common, and what they are multiplied
    with in each; None where there are none."""
    products = [factors_of(graph.split_coefficient(node)[1]) for node in nodes]
    shared = [one for one in products[0] if one[1] > 0 and all(one in others for others in products)]
    limit = graph.product(shared)
    if not limit.symbols:
        return None
    return limit, {place: node / limit for place, node in zip(places, nodes)}


def _quotients(graph: Graph, nodes: Mapping[Place, Node], divisor: Node) -> dict[Place, Node]:
    """``nodes`` divided term by term, so that what all terms have in common with the divisor cancels."""
    return {
        i: graph.sum((term / divisor, factor) for term, factor in terms_of(node)) for i, node in nodes.items()
    }
