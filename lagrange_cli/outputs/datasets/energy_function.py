"""The energy function h = sum q_dot_k p_k - L (Goldstein, 3rd ed., eq. 2.53)."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """h."""
    text = "energy function sum q_dot_k p_k - L"
    planner.add("diagnostics/h", text, planner.observe("h", planner.energetics.energy_function))
