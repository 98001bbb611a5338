"""The coordinates, the velocities and the generalized momenta."""

from __future__ import annotations

from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.outputs.planner import Planner


def coordinates(planner: Planner) -> None:
    """q, a dataset for each family."""
    for family in planner.coordinates:
        planner.add_state("q/", f"coordinate {family.label}", family)


def velocities(planner: Planner) -> None:
    """q_dot, a dataset for each family of coordinates."""
    for family in planner.coordinates:
        planner.add_state("v/", f"velocity d{family.label}/dt", family)


def momenta(planner: Planner) -> None:
    """p_k, a dataset for each family of coordinates."""
    momenta = dict(zip(planner.model.coordinates, planner.energetics.momenta))
    for family in planner.coordinates:
        names = tuple(planner.observe(f"p_{name}", momenta[name]) for name in family.members)
        text = f"generalized momentum dL/d({velocity_name(family.label)})"
        planner.add_family("diagnostics/p/", text, family, names)
