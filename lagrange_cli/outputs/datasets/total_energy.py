"""T + U, of a system of particles."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """The sum of both, which is no constant of every motion that conserves h."""
    kinetic, potential = planner.energetics.kinetic, planner.energetics.potential
    if kinetic is not None and potential is not None:
        names = planner.observe("T", kinetic), planner.observe("U", potential)
        planner.add("diagnostics/energy", "T + U", *names)
