"""The expressions that the file declares under ``observables``."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model
from lagrange_cli.outputs.planner import Planner


def with_least_norm(model: Model[Node]) -> Mapping[str, Node]:
    """The observables, with the multipliers of least norm where these are not unique."""
    if not model.redundant:
        return model.observables
    from lagrange_cli.mechanics.constrained.redundancy import multipliers_of_least_norm

    least = multipliers_of_least_norm(model)
    values = {one.multiplier: least[one.name] for one in (*model.constraints, *model.redundant)}
    found = substituted(graph_of(model), [*model.observables.values()], values)
    return dict(zip(model.observables, found))


def plan(planner: Planner) -> None:
    """A dataset for each of them, or for a family.

    Raises ``NotDefined`` where multipliers stand in them that do not follow from the state.
    """
    nodes = planner.model.observables
    constraints = (*planner.model.constraints, *planner.model.redundant)
    if any(node.symbols & one.multiplier.symbols for node in nodes.values() for one in constraints):
        planner.need_forces("observables")
        nodes = with_least_norm(planner.model)
    for family in planner.families("observables", nodes):
        names = tuple(planner.observe(f"observable {name}", nodes[name]) for name in family.members)
        planner.add_family("observables/", f"observable {family.label}", family, names)
