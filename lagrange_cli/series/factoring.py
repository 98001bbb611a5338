"""The order of multiplication: products of many factors are built from pairs that occur more than once.

Each product of two series is a convolution, and so is a reciprocal; any other power takes two.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from heapq import heapify, heappop, heappush

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node

REPEATED = 4
"""Whole powers up to this one are factors one by one; higher ones are squared up by themselves."""

MOST_COMPARISONS = 2_000_000
"""Comparisons of pairs of factors that looking for the best order may take, about a second."""

TwoFactors = tuple[Node, Node]


def associate(graph: Graph, products: Iterable[Node]) -> dict[Node, TwoFactors]:
    """Products, and parts of them, as products of two. Each time, the pair is multiplied first that most of
    the products have in common. The work of that grows with the cube of the number of factors: products of
    very many are halved instead.
    """
    factors = {product: factors_of(graph, product) for product in products}
    comparisons, long = 0, []
    for product in sorted(factors, key=lambda one: len(factors[one])):
        comparisons += len(factors[product]) ** 3
        if comparisons > MOST_COMPARISONS:
            long.append(product)
    plan = halved(graph, {product: factors.pop(product) for product in long})
    graph.work.charge(min(comparisons, MOST_COMPARISONS) // 2)
    users: dict[TwoFactors, dict[Node, None]] = {}
    made: set[TwoFactors] = set()
    heap: list[tuple[int, int, int, TwoFactors]] = []

    def priority(pair: TwoFactors) -> tuple[int, int, int, TwoFactors]:
        return -len(users[pair]) - (pair in made), pair[1].number, pair[0].number, pair

    def enter(product: Node) -> Iterable[TwoFactors]:
        """Note which pairs a product has; one of two factors is made in any case."""
        found = pairs(factors[product])
        if factors[product].total() == 2:
            plan[product] = found[0]
            made.update(found)
        else:
            for pair in found:
                users.setdefault(pair, {})[product] = None
        return [pair for pair in found if pair in users]

    for product, found in factors.items():
        if found.total() > 1:
            enter(product)
    heap = [priority(pair) for pair in users]
    heapify(heap)
    while heap:
        entry = heappop(heap)
        best = entry[-1]
        if not users[best] or entry != priority(best):
            if users[best]:
                heappush(heap, priority(best))
            continue
        both = graph.product([(best[0], 1), (best[1], 1)])
        plan.setdefault(both, best)
        changed: dict[TwoFactors, None] = {}
        for product in list(users[best]):
            for pair in pairs(factors[product]):
                users[pair].pop(product)
            factors[product] = factors[product] - Counter(best) + Counter([both])
            changed |= dict.fromkeys(enter(product))
        for pair in changed:
            heappush(heap, priority(pair))
    return plan


def halved(graph: Graph, products: Mapping[Node, Counter[Node]]) -> dict[Node, TwoFactors]:
    """Products of many factors, each from two halves, and these from their halves.

    All are cut at the same factors, so that products that differ in a few factors share most of their parts:
    the derivative of a product of n factors, n products of n - 1, takes about n log2 n products of two.
    """
    plan: dict[Node, TwoFactors] = {}
    order = sorted({factor for own in products.values() for factor in own}, key=lambda node: node.number)
    ranks = {factor: rank for rank, factor in enumerate(order)}

    def part(own: Sequence[Node], counts: Counter[Node], start: int, stop: int) -> Node:
        while len(own) > 1:
            middle = (start + stop) // 2
            cut = bisect_left(own, middle, key=ranks.__getitem__)
            if 0 < cut < len(own):
                break
            start, stop = (middle, stop) if cut == 0 else (start, middle)
        both = graph.product([(factor, counts[factor]) for factor in own])
        if len(own) > 1 and both not in plan:
            plan[both] = part(own[:cut], counts, start, middle), part(own[cut:], counts, middle, stop)
        return both

    for counts in products.values():
        part(sorted(counts, key=ranks.__getitem__), counts, 0, len(order))
    return plan


def factors_of(graph: Graph, product: Node) -> Counter[Node]:
    """The factors with how often each of them occurs; powers that are not repeated are factors as such."""
    found: Counter[Node] = Counter()
    for argument, exponent in zip(product.arguments, product.data):
        if isinstance(exponent, int) and 0 < exponent <= REPEATED:
            found[argument] += exponent
        else:
            found[graph.product([(argument, exponent)])] += 1
    return found


def pairs(factors: Counter[Node]) -> list[TwoFactors]:
    """Every two of the factors, in order; a factor with itself if it occurs twice."""
    ordered = sorted(factors, key=lambda node: node.number)
    return [
        (a, b) for place, a in enumerate(ordered) for b in ordered[place:] if a is not b or factors[a] > 1
    ]


def reciprocals(products: Iterable[Node]) -> set[Node]:
    """The denominators, in powers that cost least as products of the reciprocal."""
    exponents: dict[Node, set[int]] = {}
    for product in products:
        for argument, exponent in zip(product.arguments, product.data):
            if isinstance(exponent, int) and exponent < 0:
                exponents.setdefault(argument, set()).add(-exponent)
    return {
        base for base, some in exponents.items() if len(steps(some)) < sum(1 if e == 1 else 2 for e in some)
    }


def steps(exponents: Iterable[int]) -> set[int]:
    """All powers that are made on the way to these, each from two halves."""
    found: set[int] = set()
    pending = list(exponents)
    while pending:
        exponent = pending.pop()
        if exponent not in found:
            found.add(exponent)
            pending += [exponent // 2, exponent - exponent // 2] if exponent > 1 else []
    return found
