"""The potential, of a system of particles."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """U."""
    potential = planner.energetics.potential
    if potential is not None:
        planner.add("diagnostics/U", "potential", planner.observe("U", potential))
