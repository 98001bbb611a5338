"""Which coordinates are cyclic and what every motion conserves, decided without a computer algebra system.

dp_k/dt = dL/dq_k + Q_k and dh/dt = -dL/dt + sum Q_k q_dot_k (Goldstein, 3rd ed., secs. 2.6 and 2.7). Where
such a rate is not 0 by its structure alone (a sum may need an identity to vanish), it has to be proven to be
(``expression.zero``). What cannot be proven to vanish does not. Nor does a derivative tell of a jump from one
branch of a function to another: no branch may depend on such a coordinate, or on t.

Events that set something may change what the equations of motion conserve. An event keeps a quantity if it is
proven to be the same after as before, in whatever state; else the quantity is conserved only between events.
"""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, union
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.expression.zero import branches_on, deciding, independent, is_zero, zeros
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.substitution import root_of, substituted
from lagrange_cli.mechanics.variables import graph_of, numbered, state_symbols
from lagrange_cli.model.constraints import without_force, without_work
from lagrange_cli.model.events import between_events, changes_of
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass, replace

ROUNDED = 2.0**-48
"""Numbers that cancel up to rounding leave at most this part of them."""


@dataclass(frozen=True)
class Conserved:
    """A constant of the motion: ``quantity`` ("h" or "p_theta"), what it is, and why it is kept.

    It is one only between events if ``breaks`` are events that may change it.
    """

    quantity: str
    expression: str
    because: str
    breaks: tuple[str, ...] = ()


def conservation(model: Model[Node]) -> tuple[tuple[str, ...], tuple[Conserved, ...]]:
    """Names of the cyclic coordinates, and the conserved quantities."""
    energetics, graph = Energetics(model), graph_of(model)
    conserved: list[Conserved] = []
    cyclic: list[str] = []
    constrained = any(not one.of for one in model.constraints)
    terms = [model.potential, *(u for p in model.particles for u in p.velocity)]
    given = terms if model.lagrangian is None else [model.lagrangian]
    rates = [energetics.lagrangian_rate(q) for q in model.q]
    absent = zeros([*rates, *energetics.forces])
    coordinates, moving = numbered(model.q), union(model.q)
    slopes = [graph.gradient(u, coordinates) for u in deciding(given, moving)]
    branching = {k for one in slopes for k, slope in one.items() if not is_zero(slope)}
    for k, (name, rate, force) in enumerate(zip(model.coordinates, rates, energetics.forces)):
        if rate not in absent or k in branching:
            continue
        cyclic.append(name)
        if force in absent:
            conserved.append(kept_momentum(name, constrained=constrained))
    steady = is_zero(energetics.lagrangian_rate(model.time)) and not branches_on(graph, given, model.time)
    if steady and is_zero(energetics.power):
        conserved.append(energy_kept(model, energetics))
    if any(event.changes for event in model.events):
        momenta = {f"p_{name}": p for name, p in zip(model.coordinates, energetics.momenta)}
        known = {**momenta, "h": energetics.energy_function}
        changes, surfaces = changes_of(model), surfaces_of_events(model)
        conserved = [broken(graph, each, known[each.quantity], changes, surfaces) for each in conserved]
    return tuple(cyclic), tuple(conserved)


def surfaces_of_events(model: Model[Node]) -> dict[str, dict[Node, Node]]:
    """By event, a coordinate that its argument is linear in, or of second degree, with the value at which it
    happens."""
    graph, moving, found = graph_of(model), state_symbols(model), dict[str, dict[Node, Node]]()
    for event in model.events:
        slopes = {q: graph.diff(event.argument, q) for q in model.q if event.changes}
        linear = [q for q, slope in slopes.items() if not slope.is_zero and not slope.symbols & moving]
        square = [q for q, slope in slopes.items() if not graph.diff(slope, q).symbols & moving]
        for q in (*linear, *square):
            root = root_of(graph, event.argument, q)
            if root is not None:
                found[event.name] = {q: root}
                break
    return found


def broken(
    graph: Graph,
    each: Conserved,
    quantity: Node,
    changes: Mapping[str, Mapping[Node, Node]],
    surfaces: Mapping[str, Mapping[Node, Node]],
) -> Conserved:
    """A constant of the motion with the events that may change it; ``quantity`` is what it is, ``changes``
    are new values by event, then by symbol, and ``surfaces`` a coordinate's where it happens."""
    jumps = {}
    terms = [(quantity, 1.0)]
    if quantity.kind is Kind.SUM:
        terms = [*zip(quantity.arguments, quantity.data[1])]
    places: dict[Node, list[int]] = {}
    every = union(symbol for values in changes.values() for symbol in values)
    for place, (term, _) in enumerate(terms):
        for symbol in graph.symbols_of(term, every):
            places.setdefault(symbol, []).append(place)
    for event, values in changes.items():
        here = [terms[k] for k in sorted({k for symbol in values for k in places.get(symbol, ())})]
        if here:
            after = substituted(graph, [term for term, _ in here], values)
            jump = graph.sum([(new - old, c) for new, (old, c) in zip(after, here)])
            jumps[event] = without_rounding(graph, jump, max(abs(c) for _, c in here))
    kept = zeros([*jumps.values()])
    for name, values in surfaces.items():
        jump = jumps.get(name, graph.zero)
        if jump not in kept and any(jump.symbols & q.symbols for q in values):
            from lagrange_cli.mechanics.laurent import multiplied_out  # of few events

            plain = multiplied_out(graph, jump)  # with x**2, which is no root, in place of x*(x + ...)
            (jumps[name],) = substituted(graph, [plain], values)
            kept |= zeros([jumps[name]])
    breaks = tuple(name for name, jump in jumps.items() if jump not in kept)
    because = f"{each.because}; {between_events(breaks)}" if breaks else each.because
    return replace(each, because=because, breaks=breaks)


def without_rounding(graph: Graph, node: Node, size: float) -> Node:
    """A sum without terms that are left of terms as large as ``size`` by rounding of numbers such as 1/3."""
    if node.kind is not Kind.SUM:
        return node
    number, coefficients = node.data
    terms = [(one, c) for one, c in zip(node.arguments, coefficients) if abs(c) > ROUNDED * size]
    return graph.sum([*terms, (graph.constant(number if abs(number) > ROUNDED * size else 0.0), 1.0)])


def kept_momentum(name: str, *, constrained: bool, idle: bool = False) -> Conserved:
    """The momentum of a cyclic coordinate on which no force acts; forces of constraint are ``idle`` where
    they might act, but are 0."""
    because = f"{name} is cyclic (L does not depend on it), and {without_force(constrained, idle)}"
    return Conserved(f"p_{name}", f"dL/d{velocity_name(name)}", because)


def kept_energy(*, applied: bool, constrained: bool, fixed: str, idle: bool = False) -> Conserved:
    """h, where L does not depend on t and forces do no work. It is T + U where ``fixed`` says what does not
    depend on t. Forces of constraint are ``idle`` where they might do work."""
    because = "L does not depend on t explicitly" + without_work(applied, constrained, idle)
    if not fixed:
        return Conserved("h", "sum_k q_dot_k p_k - L", because)
    plainly = f"h is the energy T + U, since the {fixed} do not depend on t, nor U on velocities"
    return Conserved("h", "T + U", f"{because}; {plainly}")


def energy_kept(model: Model[Node], energetics: Energetics, *, idle: bool = False) -> Conserved:
    """The same of a model; forces of constraint are ``idle`` where they might do work."""
    applied, fixed = not all(map(is_zero, set(energetics.applied))), ""
    if model.lagrangian is None:
        graph = graph_of(model)
        positions = [x for p in model.particles for x in p.position]
        plain = all(independent(graph, [model.potential], v) for v in model.v)
        if plain and independent(graph, positions, model.time):
            fixed = "positions and orientations" if any(p.body for p in model.particles) else "positions"
    constrained = any(not one.of for one in model.constraints)
    return kept_energy(applied=applied, constrained=constrained, fixed=fixed, idle=idle)
