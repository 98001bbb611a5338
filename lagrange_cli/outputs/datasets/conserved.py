"""Everything that is conserved, also where no coordinate is cyclic."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner

GROUP = "diagnostics/conserved/"


def plan(planner: Planner) -> None:
    """A dataset for each conserved quantity, also for those conserved only between events."""
    known, model = planner.residual.conserved, planner.model
    nodes = {f"p_{name}": p for name, p in zip(model.coordinates, planner.energetics.momenta)}
    nodes["h"] = planner.energetics.energy_function
    for each in known:
        text = f"{each.quantity} = {each.expression}"
        planner.add(f"{GROUP}{each.quantity}", text, planner.observe(each.quantity, nodes[each.quantity]))
    for each, node in (*planner.further(), *planner.kept_by_constraints()):
        name = planner.observe(f"conserved/{each.quantity}", node)
        if not each.breaks:
            planner.kept.append(name)
        planner.add(f"{GROUP}{each.quantity}", f"{each.quantity} = {each.expression}", name)
