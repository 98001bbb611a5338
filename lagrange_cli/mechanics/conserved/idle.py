"""Momenta of cyclic coordinates, and h, whose forces of constraint might act, but are 0 along every motion.

A carriage on two wheels whose centre of mass is on the axle runs in a circle at a constant speed: rolling
constrains the angles of the wheels, but takes no forces. This does not follow from where the constraints act,
but from their multipliers, which are computed at random states modulo a prime (``residue_states``).
"""

from __future__ import annotations

from lagrange_cli.expression.node import Node
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conservation import Conserved, energy_kept, kept_momentum
from lagrange_cli.mechanics.conserved.ansatz import has_smooth_forces
from lagrange_cli.mechanics.conserved.found import Found
from lagrange_cli.mechanics.conserved.residue_states import States

MOST_COORDINATES = 12
"""The largest number of coordinates for which multipliers are computed."""


def undisturbed(found: Found) -> None:
    """Add those that are not known to be conserved yet, unless the constraints alone say what they are."""
    model, noether = found.model, found.noether
    energetics, free = noether.energetics, is_zero
    if not model.constraints or len(model.q) > MOST_COORDINATES:
        return
    given = list[tuple[Conserved, Node]]()
    pairs = zip(model.coordinates, model.q, energetics.applied, energetics.momenta)
    for name, q, force, momentum in pairs:
        if f"p_{name}" not in found.names and free(energetics.lagrangian_rate(q)) and free(force):
            given.append((kept_momentum(name, constrained=True, idle=True), momentum))
    steady = free(energetics.lagrangian_rate(model.time)) and all(map(free, energetics.applied))
    if "h" not in found.names and steady:
        given.append((energy_kept(model, energetics, idle=True), noether.energy))
    if not given or not has_smooth_forces(model, noether):
        return
    graph, states = found.graph, States(model, noether)
    bound = [[row.get(k, graph.zero) for k in range(len(model.q))] for row in noether.constraints.slopes]
    for each, node in given:
        own = [graph.diff(node, v) for v in model.v]
        if not found.relations.may_combine(bound, own) and states.conserves(node):
            found.kept.append(node)
            found.store(each, node)
            found.names.add(each.quantity)
