"""Forces of constraint while a force that jumps holds the motion, as dry friction does: at one state.

Where the argument of a switch is 0, its multiplier m follows from the condition that it stays 0 (see
``guards``). If |m| <= 1 the motion is held, else it leaves to the side of m. So accelerations, multipliers of
constraints and the force that holds are functions of the state, too. Of several switches the one whose m is
largest is let go first, as in ``integrate.guards.settling``.
"""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.expression.node import Node, union
from lagrange_cli.mechanics.explicit import Holder, Unknowns, at_rates, unknowns
from lagrange_cli.mechanics.guards.equations import guarded_values
from lagrange_cli.mechanics.guards.guard import Guard, Guarded
from lagrange_cli.mechanics.guards.vectors import split, vectors
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.switching.lengths import Vector
from lagrange_cli.mechanics.switching.switches import has_rates, switches, vanishes_with
from lagrange_cli.mechanics.variables import rate
from lagrange_cli.records import replace


def at_a_held_state(residual: Residual, nodes: Sequence[Node]) -> tuple[Unknowns, tuple[Node, ...]] | None:
    """What ``explicit.at_a_state`` gives, where a force that jumps may hold the motion, and some of the
    ``nodes`` depend on that; None elsewhere."""
    if residual.contacts or residual.bent:
        return None
    holding = vectors(residual)
    if not (holding or switches(residual.residual, residual.variables)):
        return None
    if not any(may_depend_on_modes(residual, node, holding) for node in nodes):
        return None
    smooth, frozen, multipliers = guarded_values(residual, nodes)
    if not smooth.auxiliary:
        return None
    accelerations, plain = at_rates(smooth.residual.model, frozen)
    solved_for = (*accelerations, *smooth.residual.multipliers, *multipliers)
    bits = union(solved_for)
    needed = [bool(node.symbols & bits) for node in plain]
    if not any(needed):
        return None
    found = replace(unknowns(smooth.residual), holders=holders_of(smooth, multipliers))
    of_state = [at_rates(residual.model, [node])[1][0] if has_rates(node) else node for node in nodes]
    return found, tuple(new if held else old for new, old, held in zip(plain, of_state, needed))


def may_depend_on_modes(residual: Residual, node: Node, holding: Sequence[Vector]) -> bool:
    """Whether a node has accelerations or multipliers, or jumps itself, as where vectors are 0 that are
    ``holding`` the motion. Continuous nodes do not depend on what holds it."""
    if has_rates(node) or any(node.symbols & one.symbols for one in residual.multipliers):
        return True
    graph = residual.graph
    for one in switches([node], residual.variables):
        u, above, below = one.arguments
        if not vanishes_with(graph, above - below, u):
            return True
    return any(not split(graph, node, vector)[1].is_zero for vector in holding)


def holders_of(smooth: Guarded, multipliers: Sequence[Node]) -> tuple[Holder, ...]:
    """The switches of equations with modes; ``multipliers`` are those of auxiliary coordinates."""
    residual = smooth.residual
    model, graph = residual.model, residual.graph
    own = len(model.q) - smooth.auxiliary
    limits = iter(smooth.limits)
    found = []
    for guard in smooth.guards:
        if guard.cut or guard.broken is not None:
            continue
        if guard.auxiliary is None:
            found.append(Holder(guard.mode, (guard.original,)))
            continue
        force, limit = graph.ddt(model.v[own + guard.auxiliary]), graph.one
        if guard.limit is not None:
            above, below = next(limits), next(limits)
            force, limit = (above - below) / 2.0, (above + below) / 2.0
        if guard.vector is not None:
            arguments = at_rates(model, guard.vector.parts)[1]
            bound = graph.one if guard.limit is None else guard.limit
            forces = [graph.ddt(model.v[own + i]) / bound for i in guard.holding]
            _, (force, limit, *values) = at_rates(model, [force, limit, *forces])
            parts = tuple((multipliers[i], value) for i, value in zip(guard.holding, values))
            found.append(Holder(guard.mode, arguments, parts[0][0], force, limit, parts=parts))
            continue
        arguments = at_rates(model, arguments_of(residual, guard))[1]
        last = rate(graph, arguments[-1], residual.variables)
        _, (force, limit, last) = at_rates(model, [force, limit, last])
        found.append(Holder(guard.mode, arguments, multipliers[guard.auxiliary], force, limit, last))
    return tuple(found)


def arguments_of(residual: Residual, guard: Guard) -> list[Node]:
    """u, and du/dt where u does not depend on velocities: what is 0 where the motion is held."""
    u = guard.original
    if any(u.symbols & v.symbols for v in residual.model.v):
        return [u]
    return [u, rate(residual.graph, u, residual.variables)]
