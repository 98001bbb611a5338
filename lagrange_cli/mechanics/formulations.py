"""The formulations that a model has, each with all forces, and the convolutions that they take.

d'Alembert's; or Euler and Lagrange's with the kinetic energy multiplied out, d/dt dT/dq_dot_k - dT/dq_k in
place of the masses' accelerations, or with a given L; and for these two Routh's reduction of the cyclic
coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import combinations_with_replacement
from typing import TypeVar

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, union
from lagrange_cli.expression.node_table import MAX_NODES
from lagrange_cli.mechanics.conservation import Conserved
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.dalembert import from_embedding
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.formulation import Formulation, euler_lagrange, gyroscopic, normalized
from lagrange_cli.mechanics.gauge import acting
from lagrange_cli.mechanics.routh import routh
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model
from lagrange_cli.series.lowering import lower
from lagrange_cli.series.program import SeriesProgram

T = TypeVar("T")

PATIENCE, LEAST_ATTEMPT = 2, 1_000_000
"""A further formulation may take this multiple of all steps before it, plus this number."""
MANY = 30
"""Coordinates from which on no formulation is derived that is known to be the same as another."""
STEPS_A_NODE = 4
"""The least work for a new node, so that a formulation that is given up leaves nodes for the others."""


def formulations(model: Model[Node], graph: Graph, conserved: Iterable[Conserved]) -> dict[str, Formulation]:
    """The candidates by name, each with all forces; of two that cost the same the earlier one is simpler.

    The first one is always there. Another is left out if it takes far more work, for example when products of
    sums are multiplied out.
    """
    forms: dict[str, Formulation] = {}
    if model.lagrangian is not None:
        add_energetic(forms, model, graph, "lagrangian", model.lagrangian, conserved)
    else:
        forms["embedding"] = from_embedding(model, graph)

        def add() -> None:
            kinetic = reduced_kinetic_energy(model)
            if kinetic is not None:
                name = "kinetic energy"
                add_energetic(forms, model, graph, name, kinetic - model.potential, conserved)

        routh = any(each.quantity.startswith("p_") for each in conserved)
        if len(model.q) <= MANY or routh or not is_cartesian(model):
            if_affordable(graph, add)
    return forms


def is_cartesian(model: Model[Node]) -> bool:
    """Whether the coordinates are the masses' places, and U does not depend on velocities: T is as short as
    can be, and Euler and Lagrange's equations are the embedding's."""
    velocities = union(model.v)
    positions = {x for particle in model.particles for x in particle.position}
    return positions <= {*model.q} and not model.potential.symbols & velocities


def add_energetic(
    forms: dict[str, Formulation],
    model: Model[Node],
    graph: Graph,
    base: str,
    lagrangian: Node,
    conserved: Iterable[Conserved],
) -> None:
    """Add to ``forms`` those that follow from L: Euler and Lagrange's, called ``base``, and its variants."""
    forces = Energetics(model).forces
    lagrangian = acting(model, graph, lagrangian)
    residual, matrix = euler_lagrange(model, graph, lagrangian, forces)
    forms[base] = normalized(model, residual, matrix)
    other = if_affordable(graph, lambda: gyroscopic(model, graph, lagrangian, residual))
    if other is not None:
        forms["gyroscopic forces"] = normalized(model, other, matrix)
    if model.constraints:
        return
    names = {each.quantity for each in conserved}
    steady = {k for k, name in enumerate(model.coordinates) if f"p_{name}" in names}
    reduced = if_affordable(graph, lambda: routh(model, graph, lagrangian, forces, matrix, steady))
    if reduced is not None:
        forms["Routh"] = reduced


def if_affordable(graph: Graph, function: Callable[[], T]) -> T | None:
    """The result of ``function``, or None if it takes far more work than everything before it."""
    room = STEPS_A_NODE * (MAX_NODES - len(graph.nodes))
    return graph.work.attempt(min(PATIENCE * graph.work.spent + LEAST_ATTEMPT, room), function)


def lowered(model: Model[Node], graph: Graph, form: Formulation) -> SeriesProgram:
    """The series that a formulation takes."""
    constraints = Constraints(model)
    rows = (*form.residual, *constraints.equations)
    given = variables(model), model.q, model.v, model.time, rows, (), constraints.multipliers
    return lower(graph, *given)


LONGEST = 400
"""Products that may arise; beyond, the embedding is the better form anyway."""


def reduced_kinetic_energy(model: Model[Node]) -> Node | None:
    """T = sum m v^2/2 as a sum of monomials in which identities have been used, or None where multiplying out
    would make too many. Where the embedding's squares add up (cos^2 + sin^2 = 1: polar coordinates, rotating
    frames), T is far shorter than the embedding, and d/dt dT/dq_dot - dT/dq costs fewer convolutions than
    d'Alembert's form.
    """
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
