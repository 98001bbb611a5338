"""The orientations of rigid bodies."""

from __future__ import annotations

from lagrange_cli.expression.vocabulary import AXES_COMPONENTS
from lagrange_cli.outputs.planner import Planner
from lagrange_cli.records import replace


def plan(planner: Planner) -> None:
    """R, whose columns are the axes of the body in space: a dataset for each family of bodies."""
    orientations = planner.bodies.orientations
    for family in planner.families("bodies", orientations):
        names = tuple(
            planner.observe(f"{name}.{component}", entry)
            for name in family.members
            for component, entry in zip(AXES_COMPONENTS, orientations[name])
        )
        axes = (*family.axes, "row", "column")
        matrix = replace(family, shape=(*family.shape, 3, 3), axes=axes)
        planner.add_family("orientations/", f"orientation of {family.label}", matrix, names)
