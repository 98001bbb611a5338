"""Resting contact: the limit of a law of impact for zero speed of approach.

The action of an event g(q, t) = 0 may change velocities, v+ = v + D(q, v, t), such that the motion turns
back, as a ball does on a floor. If it comes back with less speed each time, infinitely many impacts take a
finite time. After that the motion rests at g = 0. The impulses of slow impacts have the direction

    d = -(dD/dv) grad g,

and so has the force that keeps g = 0 from then on: N M d, with the mass matrix M, and N >= 0 on the side
where g >= 0 (unilateral contact: B. Brogliato, Nonsmooth Mechanics, 3rd ed. 2016, ch. 2). N is an unknown
beside the accelerations, found from d2g/dt2 = 0. Where it would have to pull, contact ends.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conservation import Conserved, conservation
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.derive import derive
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.residual import Contact, Residual
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.switching.multiple_zeros import with_simple_zeros
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Event, Model
from lagrange_cli.records import replace


def derive_with_contacts(model: Model[Node]) -> Residual:
    """The equations of motion with the unknown forces of resting contact, which are generalized forces."""
    model = with_simple_zeros(model)
    contacts = contacts_of(model)
    if not contacts:
        return derive(model)
    graph = graph_of(model)
    forces = [
        graph.sum([(given, 1.0), *((_while_resting(graph, one, k), 1.0) for one in contacts)])
        for k, given in enumerate(model.generalized_forces)
    ]
    _, conserved = conservation(model)
    residual = derive(replace(model, generalized_forces=tuple(forces)))
    kept = tuple(one for one in conserved if all(_keeps(graph, model, one, contact) for contact in contacts))
    return replace(residual, conserved=kept, contacts=contacts)


def _while_resting(graph: Graph, contact: Contact, k: int) -> Node:
    """The generalized force, and 0 where the motion does not rest: it may be infinite there."""
    return graph.switch(contact.rest**2, contact.multiplier * contact.force[k], graph.zero, -1)


def contacts_of(model: Model[Node]) -> tuple[Contact, ...]:
    """The contact of each event at which the motion may come to rest."""
    if not any(event.changes for event in model.events):
        return ()
    graph, momenta = graph_of(model), Energetics(model).momenta
    found = []
    for number, event in enumerate(model.events):
        direction = _direction(model, graph, event)
        if direction is None:
            continue
        pairs = [(k, one) for k, one in enumerate(direction) if not one.is_zero]
        force = tuple(
            graph.sum([(graph.diff(p, model.v[k]) * one, 1.0) for k, one in pairs]) for p in momenta
        )
        multiplier, rest = (graph.symbol(f"{word} {number}") for word in ("contact", "rest"))
        found.append(Contact(number, multiplier, rest, force, tuple(direction)))
    return tuple(found)


def _direction(model: Model[Node], graph: Graph, event: Event[Node]) -> list[Node] | None:
    """The direction of slow impacts; None if it is not an impact, or one that does not reduce the speed."""
    velocities = {velocity_name(name): v for name, v in zip(model.coordinates, model.v)}
    g = event.argument
    if not event.changes or not event.changes.keys() <= velocities.keys():
        return None
    if any(g.symbols & v.symbols for v in model.v) or not any(g.symbols & q.symbols for q in model.q):
        return None
    after = {velocities[name]: node for name, node in event.changes.items()}
    slopes = [graph.diff(g, q) for q in model.q]
    approach = graph.sum([(slope * v, 1.0) for slope, v in zip(slopes, model.v)])
    drift = graph.diff(g, model.time)
    (left,) = substituted(graph, [approach], after)
    if is_zero(left + approach + 2.0 * drift):
        return None
    direction = []
    for v in model.v:
        change = after.get(v, v) - v
        terms = [(graph.diff(change, other) * slope, -1.0) for other, slope in zip(model.v, slopes)]
        direction.append(graph.sum(terms))
    return None if all(map(is_zero, direction)) else direction


def _keeps(graph: Graph, model: Model[Node], one: Conserved, contact: Contact) -> bool:
    """Whether a quantity is conserved while the motion rests, too."""
    forces: Mapping[str, Node] = {f"p_{name}": q for name, q in zip(model.coordinates, contact.force)}
    if one.quantity in forces:
        return is_zero(forces[one.quantity])
    g = model.events[contact.event].argument
    slopes = [graph.diff(g, q) for q in model.q]
    steady = is_zero(graph.diff(g, model.time))
    pairs = [*zip(contact.force, slopes)]
    parallel = (is_zero(a * t - b * s) for i, (a, s) in enumerate(pairs) for b, t in pairs[:i])
    return steady and all(parallel)


def pressing(residual: Residual, contacts: Sequence[Contact]) -> list[Contact]:
    """The contacts whose forces change multipliers: along their directions d a constraint with the slopes a
    would change, as a d is not 0 where the motion rests."""
    model, graph = residual.model, graph_of(residual.model)
    found = []
    for one in contacts:
        g, d = model.events[one.event].argument, one.direction
        sums = (graph.sum([(a * d[k], 1.0) for k, a in row.items()]) for row in Constraints(model).slopes)
        if not all(_vanishes_at(graph, model, rate, g) for rate in sums):
            found.append(one)
    return found


def _vanishes_at(graph: Graph, model: Model[Node], node: Node, g: Node) -> bool:
    """Whether a node is 0 wherever g is 0: identically, or with the coordinate that g = 0 gives linearly."""
    if is_zero(node):
        return True
    for q in model.q:
        slope = graph.diff(g, q)
        if not is_zero(slope) and not any(slope.symbols & one.symbols for one in (*model.q, *model.v)):
            return is_zero(substituted(graph, [node], {q: q - g / slope})[0])
    return False
