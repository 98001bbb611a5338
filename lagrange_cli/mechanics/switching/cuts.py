"""The cut of atan2(y, x), at y = 0 where x < 0: the angle jumps by 2 pi there, and other quantities with
it."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence

from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.signs import Sign, signs
from lagrange_cli.mechanics.substitution import rewritten
from lagrange_cli.mechanics.switching.switches import where_zero
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass

ORDINARY = (-2.0, 1.0), (0.5, 2.5), (-1.0, 2.0)
"""Angles between which the changes of an expression are compared with its jump."""
ROUNDED = 1e-16
"""A jump whose square is this fraction of the squares of such changes is a rounding error, as for
sin(angle)."""
POINTS = 5
"""Random states at which an expression may jump."""


@dataclass(frozen=True)
class Cut:
    """An angle atan2(y, x) with which something jumps: the squares of ``jump`` and of its usual changes."""

    y: Node
    x: Node
    jump: Node
    usual: Node


def cuts(model: Model[Node]) -> list[Cut]:
    """The angles with which an energy, a velocity or a constraint may jump. (Jumps in conditions of switches
    are found here, too; a force may jump.)"""
    energy = model.potential if model.lagrangian is None else model.lagrangian
    nodes = [energy, model.dissipation]
    nodes += [x for one in model.particles for x in one.velocity]
    nodes += [one.expression for one in model.constraints]
    return cuts_of(graph_of(model), nodes, variables(model))


def cuts_of(graph: Graph, nodes: Sequence[Node], moving: int) -> list[Cut]:
    """The angles of what is ``moving``, a bit set of symbols, with which one of the ``nodes`` may jump."""
    angles = [
        one
        for one in reachable(nodes)
        if one.kind is Kind.FUNCTION and one.data == "atan2" and _may_be_cut(one, moving)
    ]
    found = []
    for angle in angles:
        y, x = angle.arguments
        jumps, changes = list[Node](), list[Node]()
        for node in nodes:
            if angle not in reachable([node]):
                continue
            jump = _change(graph, node, angle, -math.pi, math.pi, everywhere=True)  # not |angle|
            usual = [_change(graph, node, angle, *ends) for ends in ORDINARY]
            there, *others = (where_zero(graph, one, y) for one in (jump, *usual))
            if _may_jump(_squares(graph, [there]), _squares(graph, others)):
                jumps.append(jump)
                changes += usual
        if jumps:
            found.append(Cut(y, x, _squares(graph, jumps), _squares(graph, changes)))
    return found


def _may_be_cut(angle: Node, moving: int) -> bool:
    """Whether y may change its sign where x < 0."""
    known: dict[Node, Sign] = {}
    return bool(angle.arguments[0].symbols & moving) and not any(signs(a, known) for a in angle.arguments)


def _squares(graph: Graph, nodes: Sequence[Node]) -> Node:
    return graph.sum([(one * one, 1.0) for one in nodes])


def _change(
    graph: Graph, node: Node, angle: Node, first: float, last: float, everywhere: bool = False
) -> Node:
    """How ``node`` changes with the angle; y, which is 0 at the cut, stays in it: other angles may have no
    series where it is 0."""
    start, end = (_at(graph, node, angle, value, everywhere) for value in (first, last))
    return end - start


def _at(graph: Graph, node: Node, angle: Node, value: float, everywhere: bool) -> Node:
    """``node`` with that angle, in conditions of switches only if it is to be ``everywhere``."""

    def change(one: Node, arguments: list[Node]) -> Node | None:
        if one.kind is not Kind.SWITCH or everywhere:
            return None
        _, above, below = arguments
        return graph.switch(one.arguments[0], above, below, one.data)

    return rewritten(graph, [node], change, {angle: graph.constant(value)})[0]


def _may_jump(jump: Node, usual: Node) -> bool:
    """Whether something does at a random state: by its squares, as of a ``Cut``."""
    if jump.is_zero:
        return False
    source = random.Random(0)
    names = sorted({str(one.data) for one in reachable([jump, usual]) if one.kind is Kind.SYMBOL})
    for _ in range(POINTS):
        values = {name: source.uniform(0.2, 1.3) * source.choice((-1, 1)) for name in names}
        value, _ = evaluate([jump, usual], values)
        if not value[jump] <= ROUNDED * value[usual]:
            return True
    return False
