"""The forces of constraint on the particles."""

from __future__ import annotations

from lagrange_cli.errors import NotDefined
from lagrange_cli.expression.vocabulary import COMPONENTS
from lagrange_cli.outputs.planner import Planner


def plan(planner: Planner) -> None:
    """R = m a - F, a dataset for each family of particles, its components as the last axis.

    Raises ``NotDefined`` where F is not known of some of them.
    """
    planner.need_forces("reactions")
    found, unknown = planner.reactions()
    for family in planner.families("embedding", found):
        if all(name in found for name in family.members):
            names = tuple(
                planner.observe(f"reaction on {name} along {axis}", x)
                for name in family.members
                for axis, x in zip(COMPONENTS, found[name])
            )
            components = len(found[family.members[0]])
            planner.add_family("reactions/", f"reaction on {family.label}", family, names, components)
    for reason in unknown.values():
        raise NotDefined(f"no output 'reactions': {reason}")
