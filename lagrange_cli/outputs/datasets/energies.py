"""The energies of a system, and the action."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner


def kinetic(planner: Planner) -> None:
    """T."""
    kinetic = planner.energetics.kinetic
    if kinetic is not None:
        planner.add("diagnostics/T", "kinetic energy", planner.observe("T", kinetic))


def potential(planner: Planner) -> None:
    """U."""
    potential = planner.energetics.potential
    if potential is not None:
        planner.add("diagnostics/U", "potential", planner.observe("U", potential))


def total(planner: Planner) -> None:
    """The sum of both, which is no constant of every motion that conserves h."""
    kinetic, potential = planner.energetics.kinetic, planner.energetics.potential
    if kinetic is not None and potential is not None:
        names = planner.observe("T", kinetic), planner.observe("U", potential)
        planner.add("diagnostics/energy", "T + U", *names)


def energy_function(planner: Planner) -> None:
    """h."""
    text = "energy function sum q_dot_k p_k - L"
    planner.add("diagnostics/h", text, planner.observe("h", planner.energetics.energy_function))


def action(planner: Planner) -> None:
    """int L dt from the start."""
    planner.add_integral("diagnostics/action", "action int L dt", planner.energetics.lagrangian)
