"""The expressions that the file declares under ``observables``."""

from __future__ import annotations

from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """A dataset for each of them, or for a family.

    Raises ``NotDefined`` where multipliers stand in them that do not follow from the state.
    """
    nodes = planner.observables()
    for family in planner.families("observables", nodes):
        names = tuple(planner.observe(f"observable {name}", nodes[name]) for name in family.members)
        planner.add_family("observables/", f"observable {family.label}", family, names)
