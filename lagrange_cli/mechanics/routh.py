"""Routh's reduction: cyclic coordinates by their constant momenta, the others by the Routhian.

Where L contains the velocity of a cyclic coordinate as M v^2/2 + b v + L_0, its momentum p = M v + b gives
v = (p - b)/M, and with p constant the Routhian

    R = L - p v = L_0 - (p - b)^2/(2 M)

takes the place of L for the others (Routh, Stability of a Given State of Motion, 1877; Goldstein, 3rd ed.,
sec. 8.3). The products with v are gone, and the powers of M are often those of the potential.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.mechanics.formulation import Formulation, divided, euler_lagrange, normalized
from lagrange_cli.mechanics.matrices import connected
from lagrange_cli.mechanics.multiplied_out import folded
from lagrange_cli.mechanics.residual import CyclicMomentum
from lagrange_cli.mechanics.rows import Row
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import numbered, rate, variables
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass, replace


@dataclass(frozen=True)
class Eliminated:
    """A coordinate by its index: its velocity ``speed`` = (p - b)/``inertia``, p = ``unit`` * ``symbol``."""

    index: int
    symbol: Node
    unit: Node
    inertia: Node
    speed: Node


def routh(
    model: Model[Node],
    graph: Graph,
    lagrangian: Node,
    forces: tuple[Node, ...],
    matrix: Sequence[Sequence[Node]],
    steady: Collection[int],
) -> Formulation | None:
    """The equations with coordinates eliminated whose momenta are ``steady``; None if there are none to be.

    ``matrix`` is the mass matrix.
    These are coupled to no others by it, or their inertia is constant; and eliminating them divides by
    nothing that L does not divide by already: it might vanish where the motion goes on.
    """
    moving = variables(model)
    routhian, gone = lagrangian, list[Eliminated]()
    for block in connected(matrix) if steady else ():
        whole = [block] if all(k in steady for k in block) else []
        constant = [(k,) for k in block if k in steady and not matrix[k][k].symbols & moving]
        for part in (*whole, *constant):
            after, found = eliminate(model, graph, routhian, part)
            speeds = [one.speed for one in found]
            if found and divisors([after, *speeds], moving) <= divisors([lagrangian], moving):
                routhian, gone = after, gone + found
                if part == block:
                    break
    if not gone:
        return None
    residual, rows = euler_lagrange(model, graph, routhian, forces)
    momenta = []
    for one in gone:
        v = model.v[one.index]
        momentum = divided(graph, graph.diff(lagrangian, v), one.unit)
        momenta.append(CyclicMomentum(one.symbol, momentum, v, one.speed))
        residual[one.index] = graph.ddt(v) - rate(graph, one.speed, moving)
        slopes = graph.gradient(one.speed, numbered(model.v))
        own = {k: -slope for k, slope in slopes.items()} | {one.index: graph.one}
        rows[one.index] = Row(own, len(model.v), graph.zero)
    inertias = tuple(one.inertia for one in gone if one.inertia.symbols & moving)
    return replace(normalized(model, residual, rows), cyclic_momenta=tuple(momenta), inertias=inertias)


def eliminate(
    model: Model[Node], graph: Graph, routhian: Node, block: Sequence[int]
) -> tuple[Node, list[Eliminated]]:
    """The Routhian without the velocities of ``block``, and what they are; none where it is not quadratic."""
    moving, found = variables(model), list[Eliminated]()
    for k in block:
        v = model.v[k]
        momentum = graph.diff(routhian, v)
        inertia = gathered(graph, graph.diff(momentum, v), moving)
        rest, without = substituted(graph, [momentum, routhian], {v: graph.zero})
        if inertia.is_zero or any(inertia.symbols & velocity.symbols for velocity in model.v):
            return routhian, []
        symbol = graph.symbol(f"p {model.coordinates[k]}")
        unit, _ = graph.split_parameters(inertia, moving)
        if inertia.symbols & moving:
            speed = (unit * symbol - rest) / inertia
            routhian = without - inertia * speed**2 / 2.0
        else:  # multiplied out, L_0 cancels against b^2/(2 M); p^2/(2 M) is a constant
            speed = divided(graph, unit * symbol - rest, inertia)
            routhian = folded(graph, without + unit * symbol * rest / inertia - rest**2 / (2.0 * inertia))
        found.append(Eliminated(k, symbol, unit, inertia, speed))
    speeds: dict[Node, Node] = {}
    for place in reversed(range(len(found))):  # the last one's contains no other
        one = found[place]
        (speed,) = substituted(graph, [one.speed], speeds)
        found[place], speeds[model.v[one.index]] = replace(one, speed=speed), speed
    return routhian, found


def gathered(graph: Graph, node: Node, moving: int) -> Node:
    """A sum with the constants in front of each moving factor added up: a power of one factor stays one."""
    if node.kind is not Kind.SUM:
        return node
    constant, coefficients = node.data
    fixed: dict[Node, list[tuple[Node, float]]] = {graph.one: [(graph.one, constant)]}
    for argument, coefficient in zip(node.arguments, coefficients):
        scale, rest = graph.split_parameters(argument, moving)
        fixed.setdefault(rest, []).append((scale, coefficient))
    return graph.sum([(graph.sum(scales) * rest, 1.0) for rest, scales in fixed.items()])


def divisors(nodes: Sequence[Node], moving: int) -> set[Node]:
    """The denominators in ``nodes`` that change along the motion."""
    found: set[Node] = set()
    for node in reachable(nodes):
        if node.kind is Kind.PRODUCT:
            below = [a for a, exponent in zip(node.arguments, node.data) if exponent < 0]
            found.update(*(a.arguments if a.kind is Kind.PRODUCT else (a,) for a in below))
    return {node for node in found if node.symbols & moving}
