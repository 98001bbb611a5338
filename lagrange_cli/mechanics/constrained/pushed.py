"""Forces that depend on multipliers of constraints, as friction by a normal force does."""

from __future__ import annotations

from lagrange_cli.errors import Undetermined
from lagrange_cli.expression.node import Node, union
from lagrange_cli.mechanics.constrained.redundancy import coupled
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace


def refuse_undetermined(model: Model[Node]) -> None:
    """Raise ``Undetermined`` where forces or events use multipliers that are not unique."""
    if not model.redundant:
        return
    nodes = [*forces_of(model), *(event.argument for event in model.events)]
    constraints = [*model.constraints, *model.redundant]
    rows = Constraints(replace(model, constraints=tuple(constraints))).slopes
    count = len(model.constraints)
    for mine, others in coupled(rows[:count], rows[count:]):
        for one in (constraints[i] for i in (*mine, *(count + j for j in others))):
            if any(node.symbols & one.multiplier.symbols for node in nodes):
                raise Undetermined(one.name)


def forces_of(model: Model[Node]) -> list[Node]:
    """All that acts besides L."""
    return [*model.generalized_forces, model.dissipation, *(x for p in model.particles for x in p.force)]


def without_multipliers(model: Model[Node]) -> Model[Node]:
    """The model without forces that depend on multipliers of constraints."""
    zero = graph_of(model).zero
    bits = union(one.multiplier for one in model.constraints)

    def kept(force: Node) -> Node:
        return zero if force.symbols & bits else force

    return replace(
        model,
        generalized_forces=tuple(map(kept, model.generalized_forces)),
        dissipation=kept(model.dissipation),
        particles=tuple(replace(one, force=tuple(map(kept, one.force))) for one in model.particles),
    )


def uses_multipliers(model: Model[Node]) -> bool:
    """Whether forces depend on multipliers of constraints."""
    bits = union(one.multiplier for one in model.constraints)
    return any(force.symbols & bits for force in forces_of(model))
