"""What steps approach slowly, so that no force hides from them: poles, and the tails of exponentials.

A step of ``ias15`` in families is so short that no function b that is listed here becomes less by more than
half (``families.poles``). Far away exp(-b) is 0 to the last bit. Where b is halved from step to step, and has
no narrower structure within one, it is seen before it matters. What is made of a b alone by powers changes
with it by a factor that is about as small. An exponential whose exponent u is linear in a distance, as in
Morse's potential, is approached from both sides like a pole at u = 0.

Steps of ``Radau`` do the same in the space of places and velocities, for exponentials and for functions made
of them, as in friction tanh(v/w), which is narrow and makes motions stiff: 1 + u^2 is halved at most.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import TYPE_CHECKING

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.expression.signs import Sign, signs

if TYPE_CHECKING:
    from lagrange_cli.expression.graph import Graph

TAIL = frozenset({"exp"})
SATURATED = TAIL | {"tanh", "atan", "sinh", "cosh"}
"""Functions that change as fast as their arguments near 0, and little by little elsewhere."""
OFFSET = 16.0
"""The largest c in exp(c - b) that does not hide: the force begins to matter not far from where b is 0."""


def approached(nodes: list[Node], variables: int, places: int) -> list[Node]:
    """What becomes 0 at poles, no earlier than its first derivatives tell (see ``families.poles``): what is
    linear in ``places``, or a sum of squares of that."""
    products = (node for node in nodes if node.kind is Kind.PRODUCT)
    bases = (one for node in products for one, e in zip(node.arguments, node.data) if e < 0)
    return [
        one
        for one in dict.fromkeys(core(one, variables) for one in bases)
        if is_approached(one, variables, places)
    ]


def is_approached(base: Node, variables: int, places: int) -> bool:
    """Whether it is linear in ``places``, or a sum of squares of that and of what is not negative."""
    if base.symbols & variables & ~places:
        return False
    if is_linear(base, variables):
        return bool(base.symbols & variables)
    if base.kind is Kind.PRODUCT:
        moving = moving_factors(base, variables)
        return (
            all(exponent == 2 and is_linear(one, variables) for one, exponent in moving) and len(moving) == 1
        )
    listed = base.arguments if base.kind is Kind.SUM and signs(base, {}) is not Sign.ANY else ()
    return bool(listed) and all(
        is_approached(one, variables, places) and not is_linear(one, variables)
        for one in listed
        if one.symbols & variables
    )


def core(node: Node, variables: int) -> Node:
    """The expression of a power of which it is a multiple."""
    while (inner := multiplied(node, variables)) is not None:
        node = inner
    return node


def multiplied(node: Node, variables: int) -> Node | None:
    """What it is a multiple of, or a power; None where it is neither."""
    moving = [one for one in node.arguments if one.symbols & variables]
    if node.kind is Kind.PRODUCT:
        return moving[0] if len(moving) == 1 else None
    single = node.kind is Kind.SUM and len(node.arguments) == 1 and node.data[0] == 0
    return moving[0] if single and moving else None


def tails(
    nodes: Iterable[Node],
    variables: int,
    places: int,
    bounded: Collection[Node],
    functions: Collection[str] = TAIL,
) -> dict[Node, Node | None]:
    """The exponentials, or other ``functions``, whose arguments change slowly, each with what is approached
    slowly besides what is ``bounded``, if anything is."""
    found = dict[Node, Node | None]()
    for node in nodes:
        if node.kind is not Kind.FUNCTION or node.data not in functions or not node.symbols & variables:
            continue
        u = node.arguments[0]
        if is_tail(u, variables, bounded):
            found[node] = None
        elif not u.symbols & variables & ~places and is_convex(u, variables):
            found[node] = 1 + u * u
    return found


def revealed(
    nodes: list[Node], variables: int, seen: int
) -> tuple[list[Node], frozenset[Node], frozenset[Node]]:
    """What is approached slowly, if that is possible for all that is ``seen``: coordinates, velocities and
    time. Besides, the functions that do not hide then, and what has no poles then (``defect.hides``).
    Arguments come first."""
    bounded = approached(nodes, variables, seen)
    ends = tails(nodes, variables, seen, bounded, SATURATED)
    listed = dict.fromkeys([*bounded, *(one for one in ends.values() if one is not None)])
    tame, known = frozenset(ends), dict[Node, Sign]()
    made = {*tame}
    for node in nodes:
        moving = [one for one in node.arguments if one.symbols & variables]
        if moving and made.issuperset(moving):
            made.add(node)
    plain = frozenset(one for one in made if signs(one, known) is Sign.POSITIVE)
    return [*listed], tame, plain.union(bounded)


def lost(
    graph: Graph,
    base: Node,
    variables: int,
    time: tuple[Node, Node],
    moved: Iterable[tuple[Node, Node, Node]],
) -> Node:
    """The part of what is ``revealed`` by which it may become less in a step, if ``moved`` has each
    coordinate and velocity x, how far it is at most from a straight line within the step, and the length of
    that line. ``time`` is t and the length of the step.

    With the distances d and the lengths s, a convex function b becomes less by max(0, -sum_k db/dx_k s_k) +
    (sum (db/dx_k)^2 sum d_k^2)^(1/2) at most.
    """
    half, b = graph.number(0.5), base * base if is_linear(base, variables) else base
    rise, slope, size = graph.diff(b, time[0]) * time[1], graph.zero, graph.zero
    for x, bound, shift in moved:
        if b.symbols & x.symbols:
            each = graph.diff(b, x)
            rise += each * shift
            slope, size = slope + each * each, size + bound * bound
    return ((slope * size) ** half + ((rise * rise) ** half - rise) * half) / b


def shells(nodes: Iterable[Node], variables: int, bounded: Collection[Node]) -> dict[Node, tuple[Node, Node]]:
    """The exponentials whose exponents are linear in a distance, each with its square, which is ``bounded``,
    and the slope."""
    found = dict[Node, tuple[Node, Node]]()
    for node in nodes:
        if node.kind is Kind.FUNCTION and node.data == "exp" and node.symbols & variables:
            one = radial(node.arguments[0], variables, bounded)
            if one is not None and not is_tail(node.arguments[0], variables, bounded):
                found[node] = one
    return found


def radial(u: Node, variables: int, bounded: Collection[Node]) -> tuple[Node, Node] | None:
    """The square of the distance that an expression is linear in, which is ``bounded``, and the slope."""
    slope = u.graph.one
    while u.kind in (Kind.SUM, Kind.PRODUCT):
        if u.kind is Kind.SUM:
            moving = [(one, scale) for one, scale in zip(u.arguments, u.data[1]) if one.symbols & variables]
            if len(moving) != 1:
                return None
            u, scale = moving[0]
            slope = slope * scale
            continue
        for base, exponent in fixed_factors(u, variables):
            slope = slope * base ** u.graph.lift(exponent)
        factors = moving_factors(u, variables)
        if len(factors) != 1:
            return None
        u, exponent = factors[0]
        if exponent != 1:
            return (u, slope) if exponent == 0.5 and u in bounded else None
    return None


def is_tail(u: Node, variables: int, bounded: Collection[Node]) -> bool:
    """Whether it is a multiple of a positive power of what is ``bounded``, plus a small number."""
    if u.kind is Kind.SUM and len(u.arguments) == 1 and abs(u.data[0]) <= OFFSET:
        u = u.arguments[0]
    while u not in bounded:
        inner = multiplied(u, variables)
        if inner is None or any(e < 0 for one, e in moving_factors(u, variables) if one is inner):
            return False
        u = inner
    return True


def is_convex(u: Node, variables: int) -> bool:
    """Whether its square is convex, as far as its form tells: it is linear, or a sum of squares, or of even
    powers of such, with a constant factor."""
    if is_linear(u, variables):
        return True
    if u.kind is Kind.PRODUCT:
        moving = moving_factors(u, variables)
        base, exponent = moving[0]
        return len(moving) == 1 and (exponent == 1 or is_even(exponent)) and is_convex(base, variables)
    if u.kind is not Kind.SUM:
        return False
    constant, scales = u.data
    one_sign = all(x * scales[0] > 0 for x in scales) and constant * scales[0] >= 0
    factors = {fixed_factors(one, variables) for one in u.arguments}
    alike = len(factors) == 1 and (constant == 0 or not any(factors))
    return one_sign and alike and all(is_of_squares(one, variables) for one in u.arguments)


def is_of_squares(node: Node, variables: int) -> bool:
    """Whether it is an even power of what is convex or linear, or a sum of such, with a constant factor."""
    moving = moving_factors(node, variables)
    base, exponent = moving[0]
    even = is_even(exponent) or (exponent == 1 and not is_linear(base, variables))
    return len(moving) == 1 and even and is_convex(base, variables)


def is_even(exponent: float) -> bool:
    """Whether it is 2, 4 and so on."""
    return exponent > 0 and exponent % 2 == 0


def fixed_factors(node: Node, variables: int) -> frozenset[tuple[Node, float]]:
    """Its factors that do not move, with their exponents."""
    if node.kind is not Kind.PRODUCT:
        return frozenset()
    return frozenset((base, e) for base, e in zip(node.arguments, node.data) if not base.symbols & variables)


def is_linear(node: Node, variables: int) -> bool:
    """Whether it is linear in ``variables``, or has none."""
    terms = node.arguments if node.kind is Kind.SUM else (node,)
    return all(linear_in(one, variables) is not None for one in terms if one.symbols & variables)


def linear_in(node: Node, variables: int) -> Node | None:
    """The coordinate that it is, up to a constant factor."""
    moving = moving_factors(node, variables)
    if len(moving) == 1 and moving[0][1] == 1 and moving[0][0].kind is Kind.SYMBOL:
        return moving[0][0]
    return None


def moving_factors(node: Node, variables: int) -> list[tuple[Node, float]]:
    """Its factors that move, with their exponents."""
    if node.kind is not Kind.PRODUCT:
        return [(node, 1)]
    return [(base, exponent) for base, exponent in zip(node.arguments, node.data) if base.symbols & variables]
