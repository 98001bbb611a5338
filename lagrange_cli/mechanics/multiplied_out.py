"""Energies multiplied out, so that identities are used: along axes that turn, cos^2 + sin^2 = 1."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations_with_replacement

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, factors_of, reachable, terms_of
from lagrange_cli.expression.normal_forms import added
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace

LONGEST, EACH = 400, 40
"""Products that may arise, or so many for each coordinate; with more, the embedding is the better form
anyway."""
PARTNERS = {"cos": "sin", "sin": "cos"}


def reduced_kinetic_energy(model: Model[Node]) -> Node | None:
    """T = sum m v^2/2 as a sum of monomials in which identities have been used, or None where multiplying out
    would make too many. Where the embedding's squares add up (cos^2 + sin^2 = 1: polar coordinates, rotating
    frames), T is far shorter than the embedding, and d/dt dT/dq_dot - dT/dq costs fewer convolutions than
    d'Alembert's form.
    """
    parts = [(one.mass, component) for one in model.particles for component in one.velocity]
    return halved_squares(graph_of(model), parts, max(LONGEST, EACH * len(model.q)))


def halved_squares(graph: Graph, parts: Iterable[tuple[Node, Node]], longest: int = LONGEST) -> Node | None:
    """The sum of m v^2/2 for some (m, v), likewise. Masses that are sums, as (2*I1 - I3)/2 of one that stands
    for a body, are multiplied out, too, unless that makes more terms: they may add up with others."""
    products: list[tuple[Node, Node, float]] = []
    for mass, component in parts:
        terms = monomials(graph, component)
        if terms is None or len(products) + len(terms) ** 2 > longest:
            return None
        collected: dict[Node, float] = {}  # as in (R + h)*v - R*v: a square takes each monomial once
        for one, coefficient in terms:
            collected[one] = collected.get(one, 0.0) + coefficient
        for (a, x), (b, y) in combinations_with_replacement(collected.items(), 2):
            weight = x * y * (0.5 if a is b else 1.0)
            products.append((mass, a * b, weight))
    whole = graph.sum([(mass * square, weight) for mass, square, weight in products])
    masses = {mass: monomials(graph, mass) for mass, _, _ in products if mass.kind is Kind.SUM}
    if not masses:
        return whole
    terms = [
        (m * square, weight * c)
        for mass, square, weight in products
        for m, c in masses.get(mass) or [(mass, 1.0)]
    ]
    return min(graph.sum(terms), whole, key=lambda one: len(terms_of(one)))


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


def folded(graph: Graph, node: Node) -> Node:
    """A sum with R sin^2 in place of R - R cos^2, and likewise: where it vanishes, nothing cancels."""
    terms = dict(terms_of(node))
    for one in [*terms]:
        for factor, exponent in factors_of(one):
            if exponent != 2 or factor.kind is not Kind.FUNCTION or factor.data not in PARTNERS:
                continue
            scale, rest = graph.split_coefficient(graph.product([(one, 1), (factor, -2)]))
            if one in terms and rest in terms and not added(terms[rest], scale * terms[one]):
                partner = graph.function(PARTNERS[factor.data], factor.arguments)
                square = graph.product([(rest, 1), (partner, 2)])
                terms[square] = terms.get(square, 0.0) + terms.pop(rest)
                del terms[one]
    return graph.sum(terms.items())


def beside(graph: Graph, masses: Sequence[Sequence[Node]], spin: int) -> tuple[int, list[list[Node]]]:
    """The masses M_bd - M_bs M_sd/M_ss beside the coordinate number ``spin``, and by how many terms they are
    shorter."""
    row, made, shorter = masses[spin], [[*own] for own in masses], 0
    others = [b for b, _ in enumerate(row) if b != spin]
    for b, d in ((b, d) for b in others for d in others):
        left = masses[b][d] - row[b] * row[d] / row[spin]
        terms = monomials(graph, left)
        made[b][d] = left if terms is None else folded(graph, graph.sum(terms))
        shorter += length(masses[b][d]) - length(made[b][d])
    return shorter, made


def length(node: Node) -> int:
    """The number of terms."""
    return 0 if node.is_zero else len(terms_of(node))


def without_time(graph: Graph, node: Node, time: Node) -> Node:
    """An expression whose sums are multiplied out where t vanishes from them, as from distances between what
    turns with the same axes."""
    values: dict[Node, Node] = {}
    for one in reachable([node], lambda inner: bool(inner.symbols & time.symbols)):
        if one.kind is Kind.SUM and one.symbols & time.symbols:
            terms = monomials(graph, one)
            if terms is not None:
                whole = graph.sum(terms)
                if not whole.symbols & time.symbols:
                    values[one] = whole
    return substituted(graph, [node], values)[0] if values else node


def along_moving_axes(model: Model[Node]) -> Model[Node]:
    """A model whose potential does not depend on t where only the axes do."""
    potential = without_time(graph_of(model), model.potential, model.time)
    return model if potential is model.potential else replace(model, potential=potential)
