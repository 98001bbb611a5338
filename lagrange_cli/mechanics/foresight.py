"""How many convolutions the Taylor series of a system take at least, known before its equations are derived.

Whatever the formulation, the equations hold -dU/dq_k, or the part of dL/dq_k without velocities, and the
forces Q_k. Every product, power and function in these that differs from the others takes a convolution of its
own, as ``SeriesProgram.convolutions`` counts them.
"""

from __future__ import annotations

from collections.abc import Iterable

from lagrange_cli.expression.node import Kind, Node, reachable, terms_of, union
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model

GROWTH = 4
"""The slopes may take so many times what the potential takes: small systems are not examined."""


def least_convolutions(model: Model[Node], most: int) -> int:
    """Convolutions per order that every formulation takes; 0 where ``most`` is clearly not exceeded.

    Terms are left out that another formulation might do without: those with velocities, and all of a
    Lagrangian in which velocities stand beside t (it may contain a total time derivative).
    """
    graph = graph_of(model)
    rates = union(model.v)
    given = model.potential if model.lagrangian is None else model.lagrangian
    forces = [x for particle in model.particles for x in particle.force] + list(model.generalized_forces)
    beside = model.time.symbols
    if any(term.symbols & rates and term.symbols & beside for term, _ in terms_of(given)):
        return 0
    at_rest = [term for node in (given, *forces) for term, _ in terms_of(node) if not term.symbols & rates]
    if GROWTH * count(model, at_rest) <= most:
        return 0
    slopes = [graph.diff(given, q) for q in model.q]
    found = [*slopes, *Energetics(model).forces]
    return count(model, [term for node in found for term, _ in terms_of(node) if not term.symbols & rates])


def count(model: Model[Node], nodes: Iterable[Node]) -> int:
    """Convolutions that the series of ``nodes`` take at least.

    Parameters are constants. A product of many factors counts as one, powers of one denominator too; t times
    a coordinate needs none.
    """
    moving, coordinates = variables(model), union(model.q)
    products: set[tuple[tuple[Node, object], ...]] = set()
    reciprocals: set[Node] = set()
    powers: set[tuple[Node, object]] = set()
    functions = 0
    for node in reachable(nodes, lambda node: bool(node.symbols & coordinates)):
        if node.kind is Kind.PRODUCT:
            rest = [(a, e) for a, e in zip(node.arguments, node.data) if a.symbols & moving]
            factors = [(a, e) for a, e in rest if a.symbols & coordinates]
            if len(factors) > 1 or (isinstance(factors[0][1], int) and factors[0][1] > 1):
                products.add(tuple(rest))
            for base, exponent in factors:
                if not isinstance(exponent, int):
                    powers.add((base, exponent))
                elif exponent < 0:
                    reciprocals.add(base)
        elif node.kind is Kind.POWER:
            powers.add((node, None))
        elif node.kind is Kind.FUNCTION:
            functions += 1
    return len(products) + len(reciprocals) + 2 * len(powers) + functions
