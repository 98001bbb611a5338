"""How rigid bodies stand, turn, and what that amounts to."""

from __future__ import annotations

from lagrange_cli.expression.vocabulary import AXES_COMPONENTS
from lagrange_cli.outputs.planner import Planner
from lagrange_cli.records import replace


def orientations(planner: Planner) -> None:
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


def velocities(planner: Planner) -> None:
    """omega, a dataset for each family of bodies, its components as the last axis."""
    planner.add_vectors("angular_velocities/", "angular velocity of", "bodies", planner.bodies.spins)


def momenta(planner: Planner) -> None:
    """R I R^T omega, a dataset for each family of bodies, its components as the last axis."""
    planner.add_vectors("angular_momenta/", "angular momentum of", "bodies", planner.bodies.momenta)


def energies(planner: Planner) -> None:
    """omega . I omega/2, a dataset for each family of bodies."""
    energies = planner.bodies.energies
    for family in planner.families("bodies", energies):
        names = tuple(
            planner.observe(f"rotational energy of {name}", energies[name][0]) for name in family.members
        )
        text = f"kinetic energy of the rotation of {family.label}"
        planner.add_family("rotational_energies/", text, family, names)
