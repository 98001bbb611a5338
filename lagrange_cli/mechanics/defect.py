"""The defect, term by term: the residual of the equations of motion when series are put into them.

And whether it has to be bounded, since something may hide between the places that a step's series shows."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import TYPE_CHECKING

from lagrange_cli.expression.node import Kind, Node, reachable, union
from lagrange_cli.mechanics.approach import core, linear_in, moving_factors, revealed
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.mechanics.residual import Residual

SINGULAR = frozenset({"exp", "tanh", "sinh", "cosh", "tan", "atan", "asin", "acos", "log", "atan2"})
"""Functions that change by orders of magnitude where their argument does, or that have singularities, which
may lie arbitrarily close to the real line. (Sine and cosine look alike everywhere.)"""
ROUND = frozenset({"sin", "cos"})
"""Functions that become 0 as their arguments do: half a chord of a circle is the sine of half an angle."""
MANY = 1000
"""Terms and factors of a system from which on softened distances count as distances: to enclose all of them
would take more time than their motion."""
STEEP, HIGH = 4, 8
"""Powers of large coordinates: terms that fall faster than the first one, or grow faster than the second one,
may be 0 to the last bit where a step begins. Gravity and rotation are below."""


@dataclass(frozen=True)
class Defect:
    """The equations as sums of ``terms``, a row for each coordinate, in q, q_dot, t and ``accelerations``.

    Terms that are linear in accelerations alone are left out: of a polynomial nothing is left.
    """

    accelerations: tuple[Node, ...]
    terms: tuple[tuple[Node, ...], ...]


def defect(residual: Residual) -> Defect:
    """The terms of the equations."""
    from lagrange_cli.mechanics.explicit import expanded

    accelerations, rows = expanded(residual)
    return Defect(accelerations, terms_of(rows, residual, (*accelerations, *residual.multipliers)))


def terms_of(
    rows: Iterable[Node], residual: Residual, accelerations: Sequence[Node] = ()
) -> tuple[tuple[Node, ...], ...]:
    """The terms of each row that are not linear in time and ``accelerations``, nor constant."""
    found = union(accelerations)
    moving, exact = residual.variables | found, residual.model.time.symbols | found
    return tuple(tuple(terms(row, moving, exact)) for row in rows)


def terms(node: Node, moving: int, exact: int, factor: Node | None = None) -> list[Node]:
    """The terms of an expression, times a ``factor``, that contain ``moving`` symbols, except those that are
    linear in ``exact`` ones alone."""
    if not node.symbols & moving or (node.kind is Kind.SYMBOL and node.symbols & exact):
        return []
    factor = node.graph.one if factor is None else factor
    if node.kind is Kind.SUM:
        listed = zip(node.arguments, node.data[1])
        return [one for argument, scale in listed for one in terms(argument, moving, exact, factor * scale)]
    if node.kind is Kind.PRODUCT:
        changing = [(a, e) for a, e in zip(node.arguments, node.data) if a.symbols & moving]
        if len(changing) == 1 and changing[0][1] == 1:
            fixed = [(a, e) for a, e in zip(node.arguments, node.data) if a is not changing[0][0]]
            return terms(changing[0][0], moving, exact, factor * node.graph.product(fixed))
    return [factor * node]


def may_hide(residual: Residual, roots: Iterable[Node] | None = None) -> bool:
    """Whether something in the equations, or in other expressions, may hide from the series of a step."""
    roots = residual.residual if roots is None else roots
    nodes = reachable(roots)
    speeds = union(residual.state_v)
    return hides(nodes, residual.variables, speeds, large=len(nodes) > MANY)


def shown_slowly(residual: Residual, roots: Iterable[Node] | None = None) -> list[Node]:
    """What steps have to approach slowly, in the space of coordinates and velocities, so that nothing hides
    from them; nothing if nothing does, or if that does not help (``mechanics.approach``)."""
    if residual.cyclic_momenta or not may_hide(residual, roots):
        return []
    nodes = reachable(residual.residual if roots is None else roots)
    speeds = union(residual.state_v)
    seen = union(residual.state_q) | speeds | residual.model.time.symbols
    listed, slow, bounded = revealed(nodes, residual.variables, seen)
    large = len(nodes) > MANY
    if hides(nodes, residual.variables, speeds, large=large, bounded=bounded, slow=slow):
        return []
    return listed


def hides(
    nodes: list[Node],
    variables: int,
    speeds: int,
    *,
    large: bool,
    bounded: Collection[Node] = (),
    slow: Collection[Node] = (),
) -> bool:
    """The same of expressions whose ``nodes`` are given, arguments before their users, in ``variables``, some
    of which are ``speeds``. In a ``large`` system no sum hides that something softens, and no chord of a
    circle. Nor do poles hide where what is ``bounded`` becomes 0, powers of this, or functions that are
    ``slow`` (``mechanics.approach``)."""
    degrees = growth(nodes, variables, bounded)
    for node in nodes:
        if not node.symbols & variables:
            continue
        if node.kind is Kind.FUNCTION and node.data in SINGULAR and node not in slow:
            return True
        if node.kind is Kind.POWER and not shows(node, variables, speeds):
            return True
        if node.kind is Kind.PRODUCT:
            for base, exponent in zip(node.arguments, node.data):
                near = core(base, variables) in bounded
                if not base.symbols & variables or (exponent < 0 and near):
                    continue
                steepness = abs(exponent) * degrees[base]
                if steepness >= (HIGH if exponent > 0 else STEEP):
                    return True
                softened = large and (base.kind is Kind.SUM or base.data in ROUND)
                singular = exponent < 0 or exponent != int(exponent)
                shown = is_distance(base, variables) or (exponent > 0 and is_depth(base, variables, speeds))
                if singular and not (softened or shown or near):
                    return True
    return False


def shows(node: Node, variables: int, speeds: int) -> bool:
    """Whether a power, or a product of powers, shows where it has no series."""
    if node.kind is Kind.POWER:
        base, exponent = node.arguments
        return not exponent.symbols & variables and is_depth(base, variables, speeds)
    broken = (one for one, exponent in zip(node.arguments, node.data) if exponent != int(exponent))
    return all(is_depth(one, variables, speeds) or is_distance(one, variables) for one in broken)


def is_distance(base: Node, variables: int) -> bool:
    """Whether it is a coordinate, or a sum of squares, without a constant that could soften it: it shows its
    singularity to a motion that comes near; or one of these or a constant, as a mode says."""
    if base.kind is Kind.SWITCH and not base.arguments[0].symbols & variables:
        branches = (one for one in base.arguments[1:] if one.symbols & variables)
        return all(is_distance(one, variables) for one in branches)
    if base.kind is Kind.SUM:
        constant, coefficients = base.data
        return constant == 0 and all(
            scale > 0 and is_square(one, variables) for one, scale in zip(base.arguments, coefficients)
        )
    return base.kind is Kind.SYMBOL or is_square(base, variables)


def is_depth(base: Node, variables: int, speeds: int) -> bool:
    """Whether it is a coordinate of another frame, as the depth of a contact is: a coordinate plus what does
    not contain it, or a distance plus a constant; or one of these or a constant, as a condition says. It
    shows where it is 0, as a coordinate does. (Velocities do not: where a resistance brings to rest, they are
    0 and do not change.)"""
    if base.symbols & speeds:
        return False
    if base.kind is Kind.SWITCH:
        branches = (one for one in base.arguments[1:] if one.symbols & variables)
        return all(is_depth(one, variables, speeds) for one in branches)
    if base.kind is not Kind.SUM:
        return base.kind is Kind.SYMBOL
    terms = [one for one in base.arguments if one.symbols & variables]
    if len(terms) == 1 and is_root_of_distance(terms[0], variables):
        return True
    linear = [(one, linear_in(one, variables)) for one in terms]
    return any(
        symbol is not None and not any(other.symbols & symbol.symbols for other in terms if other is not one)
        for one, symbol in linear
    )


def is_root_of_distance(node: Node, variables: int) -> bool:
    """Whether it is the root of a sum of squares, with a constant factor."""
    moving = moving_factors(node, variables)
    return len(moving) == 1 and moving[0][1] == 0.5 and is_distance(moving[0][0], variables)


def is_square(node: Node, variables: int) -> bool:
    """Whether it is a power of an expression that is linear in moving quantities."""
    if node.kind is not Kind.PRODUCT:
        return False
    return all(
        exponent == 2 and base.kind in (Kind.SUM, Kind.SYMBOL)
        for base, exponent in zip(node.arguments, node.data)
        if base.symbols & variables
    ) and bool(node.symbols & variables)


def growth(nodes: list[Node], variables: int, bounded: Collection[Node] = ()) -> dict[Node, float]:
    """For each node, the power of large coordinates with which it grows at most; these are among the
    ``variables``. Poles of what is ``bounded`` do not count. Arguments come first."""
    found: dict[Node, float] = {}
    for node in nodes:
        each = [found[argument] for argument in node.arguments]
        if not node.symbols & variables:
            found[node] = 0.0
        elif node.kind is Kind.SUM:
            found[node] = max(each)
        elif node.kind is Kind.PRODUCT:
            powers = zip(node.arguments, node.data, each)
            found[node] = sum(
                abs(e) * degree for base, e, degree in powers if e > 0 or core(base, variables) not in bounded
            )
        else:
            found[node] = 1.0
    return found
