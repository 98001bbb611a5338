"""The formulations that a model has, each with all forces, and the convolutions that they take.

d'Alembert's; or Euler and Lagrange's with the kinetic energy multiplied out, d/dt dT/dq_dot_k - dT/dq_k in
place of the masses' accelerations, or with a given L; and for these two Routh's reduction of the cyclic
coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node, union
from lagrange_cli.expression.node_table import MAX_NODES
from lagrange_cli.mechanics.conservation import Conserved
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.dalembert import from_embedding
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.formulation import Formulation, euler_lagrange, gyroscopic, normalized
from lagrange_cli.mechanics.gauge import acting
from lagrange_cli.mechanics.multiplied_out import reduced_kinetic_energy
from lagrange_cli.mechanics.routh import routh
from lagrange_cli.mechanics.variables import variables
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
    pairs = zip(Energetics(model).applied, Constraints(model).forces)
    forces = tuple(given + force for given, force in pairs)
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
