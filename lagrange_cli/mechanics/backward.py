"""The equations of motion in reversed time s = -t, with which a motion is followed backward.

With q(t) = x(s), dx/ds = -dq/dt and d2x/ds2 = d2q/dt2. So x obeys

    R(x, -dx/ds, d2x/ds2, -s) = 0,

where each d/dt is -d/ds. This holds for any forces, dissipative and explicitly time-dependent ones too. The
mass matrix dR/dq_ddot is the same function of the state, and int f dt = -int f ds for every quadrature. The
symbols of q_dot and t stand for dx/ds and s from then on.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.rows import mapped
from lagrange_cli.mechanics.substitution import rebuilt, rewritten
from lagrange_cli.records import replace


def reversed_equations(residual: Residual) -> Residual:
    """The equations of the same motions in reversed time; ``model`` stays that of the system, except for its
    events and constraints."""

    def each(nodes: Iterable[Node]) -> tuple[Node, ...]:
        return reversed_nodes(residual, nodes)

    momenta = []
    for one in residual.cyclic_momenta:
        momentum, speed = each([one.momentum, one.speed])
        momenta.append(replace(one, momentum=momentum, speed=-speed))
    events = [
        replace(one, argument=argument, direction=-one.direction)
        for one, argument in zip(residual.model.events, each(one.argument for one in residual.model.events))
    ]
    constraints = []
    for bound in residual.model.constraints:
        (node,) = each([bound.expression])
        constraints.append(replace(bound, expression=node if bound.holonomic else -node))
    followed = []
    for given in residual.dependent:
        (speed,), place = each([given.speed]), None if given.place is None else each([given.place])[0]
        followed.append(replace(given, place=place, speed=-speed))
    return replace(
        residual,
        dependent=tuple(followed),
        model=replace(
            residual.model,
            events=tuple(events),
            edges=each(residual.model.edges),
            constraints=tuple(constraints),
        ),
        residual=each(residual.residual),
        mass_matrix=tuple(mapped(row, each) for row in residual.mass_matrix),
        cyclic_momenta=tuple(momenta),
        inertias=each(residual.inertias),
    )


def reversed_integrands(residual: Residual, integrands: Mapping[str, Node]) -> dict[str, Node]:
    """The integrands over s that give the integrals of ``integrands`` over t."""
    return {name: -node for name, node in zip(integrands, reversed_nodes(residual, integrands.values()))}


def reversed_nodes(residual: Residual, nodes: Iterable[Node]) -> tuple[Node, ...]:
    """Functions of q, q_dot, t and time derivatives as functions of x, dx/ds, s and d/ds."""
    graph, model = residual.graph, residual.model

    def change(node: Node, arguments: list[Node]) -> Node:
        return reversed_rate(graph, *arguments) if node.kind is Kind.DDT else rebuilt(graph, node, arguments)

    return rewritten(graph, nodes, change, {symbol: -symbol for symbol in (*model.v, model.time)})


def reversed_rate(graph: Graph, node: Node) -> Node:
    """-d/ds of a node; signs and the like stand in front of the derivative, as they do where it is
    derived."""
    scale, rest = graph.split_coefficient(node)
    return graph.sum([(graph.ddt(rest), -scale)])
