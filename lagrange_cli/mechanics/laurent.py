"""Sums of products of powers, multiplied out: of parameters, and of functions of these.

They are Laurent polynomials with numbers as coefficients. What is shared by several is divided out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from fractions import Fraction

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable

MOST_TERMS, HIGHEST = 80, 4
"""Terms of a sum that is multiplied out, and powers of sums."""
LARGEST = 1e30
"""Numbers up to this, and down to its reciprocal, are raised to powers."""
NEGLIGIBLE = 1e-9
"""A number that is smaller, relative to the others in a sum, is 0."""

Monomial = tuple[tuple[Node, float], ...]
"""Factors with their exponents, in the order in which the factors were made."""
Sum = dict[Monomial, float]
"""Monomials with the numbers in front of them."""
Known = dict[Node, "Sum | None"]
"""What is multiplied out already: an expression has many parts in common."""


def monomial(powers: Iterable[tuple[Node, float]]) -> Monomial:
    """The product of these powers."""
    return tuple(sorted(((base, n) for base, n in powers if n), key=lambda one: one[0].number))


def multiplied_out(graph: Graph, node: Node) -> Node:
    """A sum of products over a common denominator, if that is shorter."""
    known: Known = {}
    terms = monomials(node, known)
    above = None if terms is None else over_denominator([terms], known)
    if above is None:
        return node
    ((total,), below) = above
    total = cleaned(total)
    if not all(map(math.isfinite, total.values())):
        return node
    for base in below:
        inner = monomials(base, known)
        while inner and total and below[base]:
            rest = quotient(total, inner)
            if rest is None:
                break
            total, below[base] = rest, below[base] - 1
    found = written(graph, total) * graph.product((base, -n) for base, n in below.items() if n)
    return found if len(reachable([found])) < len(reachable([node])) else node


def over_denominator(sums: Sequence[Sum], known: Known) -> tuple[list[Sum], dict[Node, int]] | None:
    """Sums that are multiplied by powers of their denominators, as far as these are sums themselves; None if
    that is too long."""
    below: dict[Node, int] = {}
    for base, exponent in (factor for terms in sums for one in terms for factor in one):
        if base.kind is Kind.SUM and exponent < 0 and exponent == int(exponent):
            below[base] = max(-int(exponent), below.get(base, 0))
    found = []
    for terms in sums:
        total = Sum()
        for one, c in terms.items():
            powers = dict(one)
            factors = {base: n + int(powers.pop(base, 0)) for base, n in below.items()}
            product: Sum = {monomial(powers.items()): c}
            for base, n in factors.items():
                inner = monomials(base, known)
                if inner is None or n > HIGHEST:
                    return None
                for _ in range(n):
                    product = times(product, inner)
            for key, x in product.items():
                total[key] = total.get(key, 0.0) + x
        if len(total) > MOST_TERMS:
            return None
        found.append(total)
    return found, below


def monomials(node: Node, known: Known) -> Sum | None:
    """The terms of an expression that is multiplied out, with numbers in front of them; None if there are too
    many."""
    if node not in known:
        known[node] = terms_of(node, known)
    return known[node]


def terms_of(node: Node, known: Known) -> Sum | None:
    """The same, from the terms of its arguments."""
    if node.kind is Kind.NUMBER:
        return {(): float(node.data)}
    if node.kind is Kind.SUM:
        constant, factors = node.data
        found: Sum = {(): float(constant)} if constant else {}
        for one, c in zip(node.arguments, factors):
            inner = monomials(one, known)
            if inner is None:
                return None
            for key, x in inner.items():
                found[key] = found.get(key, 0.0) + float(c) * x
        return found if len(found) <= MOST_TERMS else None
    if node.kind is not Kind.PRODUCT:
        return {((node, 1),): 1.0}
    total: Sum = {(): 1.0}
    for one, exponent in zip(node.arguments, node.data):
        inner = monomials(one, known)
        if inner is None:
            return None
        if len(inner) > 1 and exponent in range(1, HIGHEST + 1):
            for _ in range(int(exponent)):
                total = times(total, inner)
        elif len(inner) == 1 and exponent == int(exponent):
            ((key, x),) = inner.items()
            if not 1 / LARGEST < abs(x) < LARGEST or abs(exponent) > HIGHEST:
                return None
            total = times(total, {monomial((base, n * exponent) for base, n in key): x**exponent})
        else:
            total = times(total, {((one, exponent),): 1.0})
        if len(total) > MOST_TERMS:
            return None
    return total


def times(one: Sum, other: Sum) -> Sum:
    """The product of two sums."""
    found: Sum = {}
    for a, x in one.items():
        for b, y in other.items():
            key = together(a, b)
            found[key] = found.get(key, 0.0) + x * y
    return found


def together(a: Monomial, b: Monomial) -> Monomial:
    """The product of two monomials."""
    if not a or not b or a[-1][0].number < b[0][0].number:
        return a + b
    powers = dict(a)
    for base, exponent in b:
        powers[base] = powers.get(base, 0) + exponent
    return monomial(powers.items())


def cleaned(terms: Sum) -> Sum:
    """Without what is rounding."""
    largest = max(map(abs, terms.values()), default=0.0)
    return {one: c for one, c in terms.items() if abs(c) > NEGLIGIBLE * largest}


def written(graph: Graph, terms: Sum) -> Node:
    """The expression."""
    return graph.sum([(graph.product(one), c) for one, c in terms.items()])


def primitive(graph: Graph, nodes: Sequence[Node]) -> list[Node]:
    """The same ratio, without factors that all have in common, if that is shorter."""
    known: Known = {}
    sums = [monomials(node, known) for node in nodes]
    whole = over_denominator([one for one in sums if one is not None], known)
    if None in sums or whole is None:
        return [*nodes]
    every = [cleaned(one) for one in whole[0]]
    left = [one for one in every if one]
    if not left or not all(math.isfinite(c) for one in left for c in one.values()):
        return [*nodes]
    left = without_powers(left)
    for _ in range(HIGHEST):
        for least in sorted(left, key=len):
            divisor = without_powers([least])[0]
            quotients = [quotient(one, divisor) for one in left] if len(divisor) > 1 else []
            exact = [one for one in quotients if one is not None]
            if exact and len(exact) == len(quotients):
                left = without_powers(exact)
                break
        else:
            break
    others = iter(left)
    found = [written(graph, next(others)) if one else graph.zero for one in every]
    return found if len(reachable(found)) <= len(reachable(nodes)) else [*nodes]


def without_powers(sums: Sequence[Sum]) -> list[Sum]:
    """Divided by the powers and the numbers that all terms have in common."""
    every = [dict(one) for terms in sums for one in terms]
    bases = dict.fromkeys(base for powers in every for base in powers)
    least = {base: min(powers.get(base, 0) for powers in every) for base in bases}
    inverse: Sum = {monomial((base, -n) for base, n in least.items() if n): 1.0}
    given = [c for terms in sums for c in terms.values()]
    unit = abs(given[0])
    numbers = [Fraction(c / unit).limit_denominator(1000) for c in given]
    exact = all(abs(n - c / unit) < NEGLIGIBLE * abs(n) for n, c in zip(numbers, given))
    scale = 1.0
    if exact:
        whole = math.lcm(*(n.denominator for n in numbers))
        scale = whole / math.gcd(*(int(n * whole) for n in numbers)) / unit
    return [
        {one: round(scale * c, 9) if exact else c for one, c in times(terms, inverse).items()}
        for terms in sums
    ]


def quotient(above: Sum, below: Sum) -> Sum | None:
    """The sum that gives ``above``, times ``below``; None where there is none."""
    below = cleaned(below)
    if not below:
        return None
    bases = [*dict.fromkeys(base for terms in (below, above) for one in terms for base, _ in one)]

    def rank(one: Monomial) -> tuple[float, ...]:
        powers = dict(one)
        return tuple(powers.get(base, 0) for base in bases)

    lead, found, left = max(below, key=rank), Sum(), dict(above)
    inverse = {monomial((base, -n) for base, n in lead): 1.0 / below[lead]}
    while left:
        first = max(left, key=rank)
        factor = times({first: left[first]}, inverse)
        if any(n < 0 for one in factor for _, n in one) or len(found) > MOST_TERMS:
            return None
        found |= factor
        size = max(map(abs, left.values()))
        for one, c in times(factor, below).items():
            left[one] = left.get(one, 0.0) - c
        left = {one: c for one, c in left.items() if abs(c) > NEGLIGIBLE * size and one != first}
    return found
