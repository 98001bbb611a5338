"""``Plan``: what a run must compute for the requested outputs, and how the datasets are made of it.

Only what an output needs is derived.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from importlib import import_module

from lagrange_cli.errors import NotDefined
from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.outputs.catalog import OUTPUTS
from lagrange_cli.outputs.planner import Planner
from lagrange_cli.outputs.recording import EventGroup, Recording
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Plan:
    """The names and expressions of what is computed, and the datasets made of it.

    ``observed`` quantities are evaluated at the samples, the ``integrands`` carried along as quadratures.
    """

    observed: Mapping[str, Node]
    integrands: Mapping[str, Node]
    recording: Recording


def make_plan(
    residual: Residual,
    outputs: frozenset[str],
    optional: frozenset[str] = frozenset(),
    *,
    loose: bool = False,
) -> Plan:
    """The plan for ``outputs``, which are names in the catalog. Of those that are ``optional`` it has what is
    defined. ``loose`` is as in ``Planner``.

    Raises ``NotDefined`` where another one is not.
    """
    conserved = frozenset(each.quantity for each in residual.conserved)
    constant = {each.quantity for each in residual.conserved if not each.breaks}
    energetics = Energetics(residual.model)
    planner = planned(Planner(residual, energetics, conserved, optional, loose=loose), outputs, optional)
    events = planner.families("events", (event.name for event in residual.model.events))
    at_events = planned(Planner(residual, energetics, conserved, optional), {"q", "v"} if events else ())
    recording = Recording(
        coordinates=residual.coordinates,
        states=tuple(planner.states),
        made=tuple(planner.made),
        conserved=tuple(name for name in planner.observed if name in constant.union(planner.kept)),
        events=tuple(EventGroup(one.name, one.shape, tuple(one.members)) for one in events),
        at_events=tuple(at_events.states),
        undefined=tuple(planner.undefined),
    )
    return Plan(planner.observed, planner.integrands, recording)


def planned(planner: Planner, outputs: Collection[str], optional: Collection[str] = ()) -> Planner:
    """The planner with what these outputs need."""
    for row in OUTPUTS.values():
        if row.name in outputs:
            # The module's name stands in the table, whatever a system file or an option says.
            module, _, function = row.module.partition(".")
            found = import_module(f"lagrange_cli.outputs.datasets.{module}")
            plan: Callable[[Planner], None] = getattr(found, function or "plan")
            try:
                plan(planner)
            except NotDefined:
                if row.name not in optional:
                    raise
    return planner
