"""What keeps a system from being one of families."""

from __future__ import annotations

from collections.abc import Iterable

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.families.arrays import Total
from lagrange_cli.families.builder import FamilyBuilder
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.mechanics.switching.cuts import cuts_of
from lagrange_cli.mechanics.switching.saturation import saturated_each

CUTS = (
    "an energy or a constraint that jumps with the angle atan2(y, x)",
    "write it with sin, cos or the square of the angle, which do not",
)
"""What members are written out for, and how to do without."""
RELATIVE = (
    "constraints or impacts that reduce the speed, on links whose angles are sums of coordinates",
    "make these angles the coordinates, and write the others as their differences",
)


def refuse_speeds(builder: FamilyBuilder, potential: Node, totals: Iterable[Total]) -> None:
    """Raise ``Unsuited`` where an energy depends on velocities beyond the masses."""
    for node in (potential, *(one.node for total in totals for one in total.terms)):
        if any(slot.array is builder.v for _, slot in builder.slots.inside(node)):
            raise Unsuited


def refuse_others(system: FamilySystem) -> None:
    """Raise ``Unsuited`` where energies and constraints jump with angles, and where forces have exponentials
    that have to be bounded."""
    roots = [*system.force_nodes, system.potential]
    moving = system.time.symbols | system.slots.symbols_of(system.q, system.v, *system.totals)
    for node in reachable(roots):
        if node.kind is Kind.DDT:
            raise Unsuited
    bound = system.bonds.nodes if system.bonds else ()
    places = [one.node for axes in system.positions.values() for total in axes for one in total.terms]
    if cuts_of(system.slots.graph, system.slots.made_of([system.potential, *bound, *places]), moving):
        raise Unsuited(*CUTS)
    if saturated_each(system.slots.graph, roots, moving) != tuple(roots):
        raise Unsuited


def refuse_holding(system: FamilySystem) -> None:
    """Raise ``Unsuited`` where something may hold coordinates, and M is not diagonal or the coordinates of
    joints are sums of these; or where actions set some with such an M, or constraints are on such joints."""
    relative = system.joints is not None and system.joints.relative is not None
    if system.coupled_masses is None and not relative:
        return
    modes = None if system.smooth is None else system.smooth.modes
    if relative:
        if system.bonds is not None or (modes is not None and modes.sticking is not None):
            raise Unsuited(*RELATIVE)
        return
    holding = modes is not None and (modes.limits is not None or modes.sticking is not None)
    if holding or (system.events is not None and system.events.changed.size):
        raise Unsuited
