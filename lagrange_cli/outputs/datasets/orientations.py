"""The orientations of rigid bodies."""

from __future__ import annotations

from lagrange_cli.model.scope import Scope
from lagrange_cli.outputs.planner import Planner
from lagrange_cli.records import replace


def plan(planner: Planner) -> None:
    """R, whose columns are the axes of the body in space: a dataset for each family of bodies."""
    assert planner.model.spec is not None
    scope = Scope(planner.model.spec, planner.model.algebra)
    for family in planner.families("bodies", planner.model.spec.bodies):
        names = tuple(
            planner.observe(f"{name}.R{row + 1}{column + 1}", scope.turning(name).axes[column][row])
            for name in family.members
            for row in range(3)
            for column in range(3)
        )
        axes = (*family.axes, "row", "column")
        matrix = replace(family, shape=(*family.shape, 3, 3), axes=axes)
        planner.add_family("orientations/", f"orientation of {family.label}", matrix, names)
