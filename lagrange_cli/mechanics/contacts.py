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
from lagrange_cli.expression.node import Kind, Node, union
from lagrange_cli.expression.signs import Sign, signs
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.expression.zero import is_rounding, is_zero
from lagrange_cli.mechanics.conservation import Conserved, conservation
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.derive import derive
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.matrices import matrix_of
from lagrange_cli.mechanics.residual import Contact, Residual
from lagrange_cli.mechanics.rows import Row
from lagrange_cli.mechanics.substitution import rewritten, substituted
from lagrange_cli.mechanics.switching.multiple_zeros import with_simple_zeros
from lagrange_cli.mechanics.switching.switches import switches, vanishes_with, where_it_vanishes
from lagrange_cli.mechanics.variables import graph_of, numbered
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace


def derive_with_contacts(model: Model[Node]) -> Residual:
    """The equations of motion with the unknown forces of resting contact, which are generalized forces."""
    model = with_simple_zeros(model)
    contacts = contacts_of(model)
    if not contacts:
        return derive(model)
    graph = graph_of(model)
    terms = [[(given, 1.0)] for given in model.generalized_forces]
    for one in contacts:
        for k in one.force.places:
            terms[k].append((_while_resting(graph, one, k), 1.0))
    forces = map(graph.sum, terms)
    _, conserved = conservation(model)
    residual = derive(replace(model, generalized_forces=tuple(forces)))
    kept = tuple(one for one in conserved if all(_keeps(graph, model, one, contact) for contact in contacts))
    return replace(residual, conserved=kept, contacts=contacts)


def _while_resting(graph: Graph, contact: Contact, k: int) -> Node:
    """The generalized force, and 0 where the motion does not rest: it may be infinite there."""
    return graph.switch(contact.rest**2, contact.multiplier * contact.force[k], graph.zero, -1)


def foresee_contacts(model: Model[Node]) -> None:
    """Raise ``TooLarge`` where the forces of resting contact are too many: each is an unknown of steps."""
    work, own = graph_of(model).work, len(model.q)
    if (own + len(model.events)) ** 2 > work.most:
        count = len(contacts_of(with_simple_zeros(model)))
        if count:
            work.foresee((own + count) ** 2, matrix_of(own, count))


def contacts_of(model: Model[Node]) -> tuple[Contact, ...]:
    """The contact of each event at which the motion may come to rest."""
    if not any(event.changes for event in model.events):
        return ()
    graph, momenta = graph_of(model), Energetics(model).momenta
    n, speeds = len(model.q), numbered(model.v)
    inertia: dict[int, dict[int, Node]] = {}
    """dp_j/dv_k, by k and j: what is not 0."""
    for j, p in enumerate(momenta):
        for k, slope in graph.gradient(p, speeds).items():
            inertia.setdefault(k, {})[j] = slope
    names = {velocity_name(name): k for k, name in enumerate(model.coordinates)}
    places = numbered(model.q)
    found = []
    for number, event in enumerate(model.events):
        if not event.changes or not event.changes.keys() <= names.keys():
            continue
        after = {names[name]: event.changes[name] for name in sorted(event.changes, key=names.__getitem__)}
        multiplier, rest = (graph.symbol(f"{word} {number}") for word in ("contact", "rest"))
        side = -event.direction if event.direction else rest
        direction = _direction(model, event.argument, after, places, speeds, side)
        if direction is None:
            continue
        terms: dict[int, list[tuple[Node, float]]] = {}
        for k in direction.places:
            for j, slope in inertia.get(k, {}).items():
                terms.setdefault(j, []).append((slope * direction[k], 1.0))
        force = Row({j: graph.sum(each) for j, each in terms.items()}, n, graph.zero)
        found.append(Contact(number, multiplier, rest, force, direction))
    return tuple(found)


def _direction(
    model: Model[Node],
    g: Node,
    after: Mapping[int, Node],
    places: Mapping[Node, int],
    speeds: Mapping[Node, int],
    side: Node | float,
) -> Row | None:
    """The direction of slow impacts at g = 0, which change velocities of these numbers, from a ``side``; None
    if it is not an impact, or one that does not reduce the speed."""
    graph = graph_of(model)
    symbols = graph.symbols_of(g)
    if any(one in speeds for one in symbols) or not any(one in places for one in symbols):
        return None
    slopes = graph.gradient(g, places)
    approach = graph.sum([(slope * model.v[k], 1.0) for k, slope in slopes.items()])
    drift = graph.diff(g, model.time)
    (left,) = substituted(graph, [approach], {model.v[k]: node for k, node in after.items()})
    if is_zero(left + approach + 2.0 * drift):
        return None
    direction = {}
    for k, node in after.items():
        rates = graph.gradient(node - model.v[k], speeds)
        direction[k] = graph.sum([(rate * slopes[j], -1.0) for j, rate in rates.items() if j in slopes])
    # what depends on the sign of dg/dt, as abs(y_dot), is as it is before g = 0; and what compares it with a
    # size, as min(abs(x_dot), f*abs(y_dot)), as it is where dg/dt is small
    decided, known = dict[Node, Node](), dict[Node, Sign]()
    for one in switches(direction.values(), union(model.v)):
        u, above, below = substituted(graph, one.arguments, decided)
        rates = graph.gradient(u, speeds)
        rise = graph.sum([(rate * slopes[j], 1.0) for j, rate in rates.items() if j in slopes])
        still = _where_still(model, u, approach + drift, slopes)
        if not is_zero(rise) and (still.is_zero or vanishes_with(graph, u, approach + drift)):
            decided[one] = graph.switch(-(rise * side), above, below)
            continue
        slow = [still, *where_it_vanishes(graph, u, approach + drift)]
        for branch, sign in ((above, 1.0), (below, -1.0)):
            if any(not x.is_zero and signs(sign * x, known) is not Sign.ANY for x in slow):
                decided[one] = branch
    direction = dict(zip(direction, substituted(graph, direction.values(), decided)))
    if all(map(is_zero, direction.values())):
        return None
    return Row(direction, len(model.q), graph.zero)


def _where_still(model: Model[Node], node: Node, rate: Node, slopes: Mapping[int, Node]) -> Node:
    """What a function of velocities is where dg/dt = 0, a ``rate`` that is linear in them with these
    ``slopes``. What vanishes then is recognized however it is written, as in curved coordinates."""
    graph, velocities = graph_of(model), union(model.v)
    k, slope = next((k, a) for k, a in slopes.items() if not is_zero(a))
    given = {model.v[k]: model.v[k] - rate / slope}

    def vanishes(one: Node) -> bool:
        return bool(one.symbols & velocities) and is_rounding(substituted(graph, [one], given)[0], one)

    def change(one: Node, arguments: list[Node]) -> Node | None:
        if one.kind is not Kind.SUM or not one.symbols & velocities:
            return None
        if vanishes(one):
            return graph.zero
        terms = [*zip(one.arguments, arguments, one.data[1])]
        jumping = [(new, c) for old, new, c in terms if switches([old], velocities)]
        rest = one - graph.sum([(old, c) for old, _, c in terms if switches([old], velocities)])
        return graph.sum(jumping) if jumping and vanishes(rest) else None

    return rewritten(graph, [node], change)[0]


def _keeps(graph: Graph, model: Model[Node], one: Conserved, contact: Contact) -> bool:
    """Whether a quantity is conserved while the motion rests, too."""
    momenta: Mapping[str, int] = {f"p_{name}": k for k, name in enumerate(model.coordinates)}
    if one.quantity in momenta:
        return is_zero(contact.force[momenta[one.quantity]])
    g = model.events[contact.event].argument
    slopes = graph.gradient(g, numbered(model.q))
    steady = is_zero(graph.diff(g, model.time))
    pairs = [(contact.force[k], slopes.get(k, graph.zero)) for k in sorted({*contact.force.places, *slopes})]
    parallel = (is_zero(a * t - b * s) for i, (a, s) in enumerate(pairs) for b, t in pairs[:i])
    return steady and all(parallel)


def without_contacts(residual: Residual) -> Model[Node]:
    """The model without the forces of resting contact."""
    model, graph = residual.independent, residual.graph
    free = dict.fromkeys((x for one in residual.contacts for x in (one.rest, one.multiplier)), graph.zero)
    return replace(model, generalized_forces=tuple(substituted(graph, model.generalized_forces, free)))


def without_contact_forces(residual: Residual) -> tuple[Node, ...]:
    """The equations of a motion that rests at no event."""
    resting = dict.fromkeys((one.rest for one in residual.contacts), residual.graph.zero)
    return substituted(residual.graph, residual.residual, resting)


def lasts_in_contact(residual: Residual, each: Conserved, node: Node) -> bool:
    """Whether no force of resting contact changes a conserved function of the state: no impact does, however
    slow, or it is constant along the direction of slow impacts."""
    graph, model = residual.graph, residual.model
    for one in residual.contacts:
        event = model.events[one.event]
        if event.name in each.breaks:
            pushed = [(one.direction[k] * graph.diff(node, model.v[k]), 1.0) for k in one.direction.places]
            if not _vanishes_at(graph, model, graph.sum(pushed), event.argument):
                return False
    return True


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
