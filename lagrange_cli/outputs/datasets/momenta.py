"""The generalized momenta p_k = dL/dq_dot_k."""

from __future__ import annotations

from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """p_k, a dataset for each family of coordinates."""
    momenta = dict(zip(planner.model.coordinates, planner.energetics.momenta))
    for family in planner.coordinates:
        names = tuple(planner.observe(f"p_{name}", momenta[name]) for name in family.members)
        text = f"generalized momentum dL/d({velocity_name(family.label)})"
        planner.add_family("diagnostics/p/", text, family, names)
