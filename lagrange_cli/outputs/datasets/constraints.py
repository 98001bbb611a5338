"""The values of the constraints, which should be 0."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """f or g, a dataset for each constraint or family of them."""
    nodes = {one.name: one.expression for one in (*planner.model.constraints, *planner.model.redundant)}
    for family in planner.constraints:
        names = tuple(planner.observe(f"constraint {name}", nodes[name]) for name in family.members)
        planner.add_family("diagnostics/constraints/", f"constraint {family.label}", family, names)
