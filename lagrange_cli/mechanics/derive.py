"""From a model to its equations of motion, in the formulation that takes the fewest convolutions."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from lagrange_cli.errors import SingularCoordinate
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.zero import independent, is_zero
from lagrange_cli.mechanics.conservation import conservation
from lagrange_cli.mechanics.constrained.pushed import (
    refuse_undetermined,
    uses_multipliers,
    without_multipliers,
)
from lagrange_cli.mechanics.constrained.weightless import entangled, weightless
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.formulations import formulations, if_affordable, lowered
from lagrange_cli.mechanics.multiplied_out import along_moving_axes
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.switching.jumps import refuse_jumps
from lagrange_cli.mechanics.switching.saturation import saturated, saturated_rows
from lagrange_cli.mechanics.switching.unchanging import refuse_unchanging
from lagrange_cli.mechanics.variables import graph_of, nonzero, numbered, variables
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace


def derive(model: Model[Node]) -> Residual:
    """The equations of motion of ``model``; raises ``SingularCoordinate`` where M has a row of zeros,
    ``InfiniteForce`` where an energy jumps, ``SpecError`` for an event that is the same at all states."""
    refuse_jumps(model)
    turning = model.spec is not None and model.spec.bodies
    if turning:
        from lagrange_cli.mechanics.constrained.thin import refuse_idle, refuse_spinning
        from lagrange_cli.mechanics.rigidity import refuse_strain

        refuse_strain(model)
    refuse_undetermined(model)
    refuse_unchanging(model)
    found = equations_of(along_moving_axes(model))
    if turning:
        refuse_idle(model)
        refuse_spinning(found)
    return found


def equations_of(model: Model[Node]) -> Residual:
    """The equations of motion of a model that has been checked; raises ``SingularCoordinate``."""
    graph = graph_of(model)
    cyclic, conserved = conservation(model)
    surplus: frozenset[int] = frozenset()
    if model.redundant:
        from lagrange_cli.mechanics.constrained.redundancy import with_those_in_turn

        model, surplus = with_those_in_turn(model)
    forms = formulations(model, graph, conserved)
    first, *others = forms
    constraints = Constraints(model)
    bound = {k for slopes in constraints.slopes for k in slopes}
    rows = enumerate(zip(model.coordinates, forms[first].mass_matrix))
    idle = [
        name
        for k, (name, row) in rows
        if k not in bound and all(is_zero(row[j]) for j in nonzero(row, graph.zero, k))
    ]
    if idle:
        raise SingularCoordinate(idle)
    together = [] if model.constraints else entangled(forms[first].mass_matrix)
    if together:
        raise SingularCoordinate([model.coordinates[k] for k in together], together=True)
    programs = {first: lowered(model, graph, forms[first])}
    for name in others:
        program = if_affordable(graph, partial(lowered, model, graph, forms[name]))
        if program is not None:
            programs[name] = program
    costs = {name: program.convolutions for name, program in programs.items()}
    chosen = min(costs, key=lambda name: costs[name])
    velocities = numbered(model.v)
    slopes = graph.gradient(model.potential, velocities).values()
    masses = forms[chosen].mass_matrix
    pushed = uses_multipliers(model)
    written = {
        "residual": saturated_rows(
            graph, [*forms[chosen].residual, *constraints.equations], variables(model)
        ),
        "mass_matrix": constraints.bordered(masses, Energetics(model).applied if pushed else ()),
    }
    found = Residual(
        model=saturated(model),
        graph=graph,
        **{**vars(forms[chosen]), **written},
        definite=model.lagrangian is None
        and not any(graph.gradient(p, velocities) for p in slopes)
        and symmetric(masses)
        and not pushed,
        pushed=pushed,
        weightless=weightless(masses) if model.constraints else frozenset(),
        formulation=chosen,
        costs=costs,
        lowered=((*forms[chosen].residual, *constraints.equations, *model.q), programs[chosen]),
        scleronomic=scleronomic(model),
        cyclic=cyclic,
        conserved=conserved,
        surplus=surplus,
    )
    return replace(found, quiet=equations_of(without_multipliers(model))) if found.bent else found


def symmetric(matrix: Sequence[Sequence[Node]]) -> bool:
    """Whether a matrix is its own transpose; where a coordinate has been eliminated it may not be."""
    places = ((j, k) for j, row in enumerate(matrix) for k in nonzero(row, row[j].graph.zero, j))
    return all(matrix[j][k] is matrix[k][j] for j, k in places)


def scleronomic(model: Model[Node]) -> bool:
    """Whether the embedding (or the given L) and the constraints are free of explicit time."""
    return not depending_on_time(model)


def depending_on_time(model: Model[Node]) -> tuple[str, ...]:
    """Which of ``L``, ``positions``, ``orientations`` and ``constraints`` depend on time explicitly."""
    given = {
        "L": [model.lagrangian] if model.lagrangian is not None else [],
        "positions": [x for particle in model.particles for x in particle.position if not particle.body],
        "orientations": [x for particle in model.particles for x in particle.position if particle.body],
        "constraints": [one.expression for one in model.constraints],
    }
    graph = graph_of(model)
    return tuple(name for name, nodes in given.items() if not independent(graph, nodes, model.time))
