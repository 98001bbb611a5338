"""Sums that are squares: sqrt(1 - sin(u)) has a kink where cos(u/2) = sin(u/2), and no other singularity.

A sum is written as a polynomial (``polynomial_nodes``). It is a square if it has a square root there. Roots
of higher order are found in the same way.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lagrange_cli.expression.node import Kind, Node, Table
from lagrange_cli.expression.polynomial_nodes import ATOM, TURN, PolynomialNodes
from lagrange_cli.expression.polynomials import (
    Complex,
    Polynomial,
    TooLarge,
    multiplied,
    over,
    power_of,
    root_of,
    times,
)
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Power:
    """``factor`` times the product of ``denominators``, with their exponents, which are multiples of
    ``order``, times ``root`` to that power."""

    order: int
    factor: Node
    root: Node
    denominators: Sequence[tuple[Node, int]] = ()


def square(graph: Table, node: Node) -> Power | None:
    """A sum as a square and what else is its factor, if it is one."""
    found = power(graph, node, 2)
    if found is None or (found.factor.kind is Kind.NUMBER and found.factor.data < 0):
        return None
    return found


def power(graph: Table, node: Node, *orders: int) -> Power | None:
    """A sum as the power of one of these ``orders``, the first that is right, and what else is its factor, if
    it is one."""
    if _apart(node):
        return None
    try:
        made = PolynomialNodes(graph, node)
        polynomial = made.of(node)
        tried = (_root(made, polynomial, order) for order in orders)
        return next((found for found in tried if found is not None), None)
    except TooLarge:
        return None


def _apart(node: Node) -> bool:
    """Whether no two of its terms have a symbol in common, as those of the square of a sum have."""
    seen = 0
    for argument in node.arguments:
        if argument.symbols & seen:
            return False
        seen |= argument.symbols
    return len(node.arguments) > 1


def _root(made: PolynomialNodes, given: Polynomial, order: int) -> Power | None:
    """A polynomial as a power and other factors."""
    nodes = [*made.numbers]
    denominators = []
    for number, below in made.below.items():
        least = min((dict(one).get(number, 0) for one in given), default=0)
        if least < 0:
            shift = -least + least % order
            denominators.append((nodes[number][1], -shift))
            given = _over_one(made, given, number, shift, below)
    if not given:
        return None
    outside: list[tuple[Node, int]] = []
    for (kind, node), number in made.numbers.items():
        least = min(dict(one).get(number, 0) for one in given)
        if kind == ATOM and least:
            outside.append((node, least))
            given = {multiplied(one, frozenset({(number, -least)})): x for one, x in given.items()}
    names = sorted({number for monomial in given for number, _ in monomial})
    dense = {tuple(dict(one).get(name, 0) for name in names): value for one, value in given.items()}
    found = root_of(dense, made.ring.noise, order)
    if found is None:
        return None
    scale, root = found
    turn = _turn(made, root, [nodes[name][0] == TURN for name in names])
    if turn is None:
        return None
    factor, rest = over(scale, power_of(turn, order))
    if not abs(rest) <= made.ring.noise * abs(factor):
        return None
    root = {monomial: times(value, turn) for monomial, value in root.items()}
    size, inner = made.graph.split_coefficient(made.node(root, [nodes[name] for name in names]))
    if inner.kind is Kind.SUM and inner.data[0] == 0 and len(inner.arguments) == 1:
        size, inner = size * inner.data[1][0], inner.arguments[0]
    factor = factor * size**order
    odd = [(node, least % order) for node, least in outside if least % order]
    even = [(node, least // order) for node, least in outside]
    whole = made.graph.product([(inner, 1), *even])
    if whole is made.graph.one and not denominators:
        return None
    return Power(order, factor * made.graph.product(odd), whole, denominators)


def _over_one(
    made: PolynomialNodes, given: Polynomial, number: int, shift: int, below: Polynomial
) -> Polynomial:
    """A polynomial times ``below``, which has this number, to the power ``shift``."""
    total: Polynomial = {}
    for monomial, value in given.items():
        exponents = dict(monomial)
        exponent = exponents.pop(number, 0) + shift
        rest: Polynomial = {frozenset(exponents.items()): value}
        total = made.ring.plus(total, made.ring.times(rest, made.ring.raised(below, exponent)), (1, 0))
    return total


def _turn(
    made: PolynomialNodes, root: Mapping[tuple[int, ...], Complex], turns: Sequence[bool]
) -> Complex | None:
    """A number that makes a root real when multiplied with it: e^(iu) of real u is the reciprocal of its
    conjugate."""
    if not any(turns):
        return (1, 0)
    lead = max(root)
    opposite = tuple(-e if turned else e for e, turned in zip(lead, turns))
    if opposite not in root:
        return None
    re, im = root[opposite]
    re, im = over((re, -im), root[lead])
    return (0, 1) if abs(re + 1) + abs(im) <= made.ring.noise else (1 + re, im)
