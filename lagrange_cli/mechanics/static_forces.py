"""Forces that cancel one another where nothing moves: what is left of them is rounding."""

from __future__ import annotations

from lagrange_cli.expression.node import Kind, Node, reachable, union
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.rounding import size_of
from lagrange_cli.mechanics.substitution import rewritten

EVERYWHERE = frozenset({"sin", "cos", "exp", "sinh", "cosh", "tanh", "atan"})
"""Functions that have a value, and slopes that are finite, for any argument."""


def static_forces(residual: Residual) -> tuple[Node, ...]:
    """What is left of the equations of motion at rest, where all velocities, accelerations and multipliers
    are 0, in q and t; nothing where a denominator, or a root, may be 0 with these."""
    graph, model = residual.graph, residual.model
    contacts = (one.multiplier for one in residual.contacts)
    still = {*residual.state_v, *model.v, *residual.multipliers, *contacts}
    rows, gone = residual.residual[: len(model.q)], union(still)
    if any(is_singular(node, gone, zero=True) for node in reachable(rows)):
        return ()

    def change(node: Node, arguments: list[Node]) -> Node | None:
        if node in still:
            return graph.zero
        return graph.diff(arguments[0], model.time) if node.kind is Kind.DDT else None

    return rewritten(graph, rows, change)


def rounding_at_rest(residual: Residual) -> tuple[Node, ...]:
    """The rounding errors of the forces at rest in units of the last place, an expression for each equation;
    none at all if these are 0 only where coordinates are, or are known to that part of these. Nor where they
    have roots or poles of sums that may be 0: errors there have no bound."""
    forces, graph = static_forces(residual), residual.graph
    moving = union((*residual.model.q, residual.model.time))
    places, nodes = union(residual.model.q), reachable(forces)
    if not any(may_cancel(node, moving, places) for node in nodes):
        return ()
    if any(is_singular(node, moving) for node in nodes):
        return ()
    return tuple(size_of(graph, force) for force in forces)


def may_cancel(node: Node, moving: int, places: int) -> bool:
    """Whether it is a sum that may be 0 where no coordinate is: that of something that moves, and of what
    contains no coordinates."""
    if node.kind is not Kind.SUM or not node.symbols & moving:
        return False
    constant, _ = node.data
    fixed = any(not one.symbols & places for one in node.arguments)
    return bool(constant) or (fixed and len(node.arguments) > 1)


def is_singular(node: Node, moving: int, *, zero: bool = False) -> bool:
    """Whether it is a power, not whole or of a sum in a denominator, of anything that is not positive for
    certain; or a function that has no value somewhere. Also a power of a symbol, if symbols are ``zero``;
    but not where value and slope are 0 with these, as those of v |v|^0.5."""
    if not node.symbols & moving:
        return False
    if node.kind is Kind.PRODUCT:
        powers = [*zip(node.arguments, node.data)]
        if zero:
            orders = {a: exponent * _order(a, moving) for a, exponent in powers}
            if min(orders.values()) >= 0 and sum(orders.values()) > 1:
                powers = [(a, exponent) for a, exponent in powers if not orders[a]]
        steep = [
            a
            for a, exponent in powers
            if exponent != int(exponent) or (exponent < 0 and (a.arguments or zero))
        ]
        return any(one.symbols & moving and not _is_positive(one, moving) for one in steep)
    return is_steep(node, moving)


def _order(node: Node, gone: int) -> float:
    """The power of small numbers as which it vanishes where these symbols do; 0 where that is unknown."""
    if not node.symbols & gone:
        return 0.0
    if node.kind is Kind.SUM:
        return 0.0 if node.data[0] else min(_order(one, gone) for one in node.arguments)
    if node.kind is Kind.PRODUCT:
        orders = [exponent * _order(one, gone) for one, exponent in zip(node.arguments, node.data)]
        return sum(orders) if min(orders) >= 0 else 0.0
    return 0.0 if node.arguments else 1.0


def is_steep(node: Node, moving: int) -> bool:
    """Whether it is a power with any exponent, or a function that has no value somewhere."""
    if not node.symbols & moving:
        return False
    if node.kind is not Kind.FUNCTION or node.data in EVERYWHERE:
        return node.kind is Kind.POWER
    return node.data != "log" or not _is_positive(node.arguments[0], moving)


def _is_positive(node: Node, moving: int) -> bool:
    """Whether it is a sum of squares and of something constant."""
    if node.kind is not Kind.SUM:
        return False
    constant, coefficients = node.data
    fixed = constant > 0 or any(not one.symbols & moving for one in node.arguments)
    return fixed and all(
        scale > 0 and (not one.symbols & moving or _is_square(one, moving))
        for one, scale in zip(node.arguments, coefficients)
    )


def _is_square(node: Node, moving: int) -> bool:
    return node.kind is Kind.PRODUCT and all(
        exponent % 2 == 0 for base, exponent in zip(node.arguments, node.data) if base.symbols & moving
    )
