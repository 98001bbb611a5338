"""The kinetic energies of rigid bodies' rotation."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """omega . I omega/2, a dataset for each family of bodies."""
    energies = planner.bodies.energies
    for family in planner.families("bodies", energies):
        names = tuple(
            planner.observe(f"rotational energy of {name}", energies[name][0]) for name in family.members
        )
        text = f"kinetic energy of the rotation of {family.label}"
        planner.add_family("rotational_energies/", text, family, names)
