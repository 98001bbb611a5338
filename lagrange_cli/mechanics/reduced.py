"""The kinetic energy multiplied out: T = sum m v^2/2 as a sum of monomials in which identities have been
used.

Where the embedding's squares add up (cos^2 + sin^2 = 1: polar coordinates, rotating frames), T is far
shorter than the embedding, and d/dt dT/dq_dot - dT/dq costs fewer convolutions than d'Alembert's form.
"""

from __future__ import annotations

from itertools import combinations_with_replacement

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model

LONGEST = 400
"""Products that may arise; beyond, the embedding is the better form anyway."""


def reduced_kinetic_energy(model: Model[Node]) -> Node | None:
    """T as a sum of monomials, or None where multiplying out would make too many."""
    graph = graph_of(model)
    products: list[tuple[Node, float]] = []
    for particle in model.particles:
        for component in particle.velocity:
            terms = monomials(graph, component)
            if terms is None or len(products) + len(terms) ** 2 > LONGEST:
                return None
            for (a, x), (b, y) in combinations_with_replacement(terms, 2):
                weight = x * y * (0.5 if a is b else 1.0)
                products.append((graph.product([(particle.mass, 1), (a, 1), (b, 1)]), weight))
    return graph.sum(products)


def monomials(graph: Graph, node: Node) -> list[tuple[Node, float]] | None:
    """``node`` as coefficients times products that hold no sum to a positive whole power; None if too many.

    A sum under any other power or inside a function stays one factor.
    """
    if node.kind is Kind.SUM:
        constant, coefficients = node.data
        collected: list[tuple[Node, float]] = [(graph.one, constant)] if constant else []
        for argument, coefficient in zip(node.arguments, coefficients):
            inner = monomials(graph, argument)
            if inner is None or len(collected) + len(inner) > LONGEST:
                return None
            collected += [(x, coefficient * c) for x, c in inner]
        return collected
    if node.kind is not Kind.PRODUCT:
        return [(node, 1.0)]
    if not any(one.kind is Kind.SUM for one in node.arguments):
        return [(node, 1.0)]
    terms: list[tuple[Node, float]] = [(graph.one, 1.0)]
    for argument, exponent in zip(node.arguments, node.data):
        whole = isinstance(exponent, int) and 0 < exponent <= 4 and argument.kind is Kind.SUM
        factors = monomials(graph, argument) if whole else [(graph.product([(argument, exponent)]), 1.0)]
        for _ in range(exponent if whole else 1):
            if factors is None or len(terms) * len(factors) > LONGEST:
                return None
            terms = [(x * y, c * d) for x, c in terms for y, d in factors]
    return terms
