"""The multipliers of constraints."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """lambda, a dataset for each constraint or family of them; of least norm where they are not unique.

    Raises ``NotDefined`` where they do not follow from the state.
    """
    if planner.model.constraints:
        planner.need_forces("multipliers", multipliers=True)
    nodes = {one.name: one.multiplier for one in planner.model.constraints}
    if planner.model.redundant:
        from lagrange_cli.mechanics.constrained.redundancy import multipliers_of_least_norm

        nodes = multipliers_of_least_norm(planner.model)
    for family in planner.constraints:
        names = tuple(planner.observe(f"multiplier {name}", nodes[name]) for name in family.members)
        planner.add_family("multipliers/", f"multiplier of {family.label}", family, names)
