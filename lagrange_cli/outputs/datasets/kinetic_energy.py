"""The kinetic energy, of a system of particles."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """T."""
    kinetic = planner.energetics.kinetic
    if kinetic is not None:
        planner.add("diagnostics/T", "kinetic energy", planner.observe("T", kinetic))
