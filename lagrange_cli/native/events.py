"""Events and guards of a model in the numbers of ``Interface``, and what ``@act`` computes for them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import reduce
from operator import or_

from lagrange_cli.expression.node import Node, union
from lagrange_cli.expression.signs import proportional, unbroken
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.mechanics.guards.guard import Guard, Guarded
from lagrange_cli.mechanics.rounding import size_of
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of, numbered, state_symbols
from lagrange_cli.model.model import Model
from lagrange_cli.native.guards import BREAK, CUT, EDGE, SIMPLE, Role, rooted_kind

FEW_EVENTS = 256
"""Events of the largest system whose actions compiled code does."""


def number_of(guard: Guard) -> int:
    """A switch's guard as ``Interface`` has it."""
    if guard.auxiliary is not None:
        return guard.auxiliary
    if guard.edge:
        return EDGE
    if guard.broken is not None:
        return BREAK
    if guard.cut:
        return CUT
    return SIMPLE if guard.roots is None else rooted_kind(guard.roots.steep, guard.roots.side)


def events_of(
    model: Model[Node], smooth: Guarded, parts: int
) -> tuple[tuple[tuple[int, int, int], ...], tuple[tuple[int, int], ...]]:
    """The model's events as ``Interface`` has them, and which arguments simple actions change.

    An action is simple if it can change the side of other events only, affects no mass, and does not violate
    constraints. Where the motion may come to rest at an event, no action may set more than velocities. Where
    others have the same zeros, the caller does what happens at once. Where there are switches, whose sides it
    does not change either, it is that of an event with contact: friction may hold arguments of others at 0.
    """
    rests = {one.event: one.auxiliary for one in smooth.rests}
    few = _apart(smooth) and parts == 1 and len(model.events) <= FEW_EVENTS
    few = few and not model.constraints
    switched = union(one.argument for one in smooth.guards)
    masses, speeds = union(one.mass for one in model.particles), union(model.v)
    changed, alone = _changed(model), _alone(model)
    found, affected = list[tuple[int, int, int]](), list[tuple[int, int]]()
    for i, (event, bits) in enumerate(zip(model.events, changed)):
        simple = bool(event.changes) and few and not event.argument.symbols & bits
        simple = simple and alone[i] and not masses & bits and not (rests and bits & ~speeds)
        simple = simple and (not smooth.guards or (i in rests and not switched & bits))
        acts = Role.CHANGE if simple else Role.ACTION
        role = acts if event.stops or event.changes else Role.RECORD
        found.append((event.direction, int(role), rests.get(i, -1)))
        if simple:
            affected += [(i, k) for k, one in enumerate(model.events) if one.argument.symbols & bits]
    return tuple(found), tuple(affected)


def jumping_of(model: Model[Node]) -> tuple[int, ...]:
    """The events whose arguments may come to their other side without being 0. (After actions sides are
    chosen.)"""
    moving = state_symbols(model)
    known = moving | union(model.parameters.values())
    arguments = enumerate(event.argument for event in model.events)
    return tuple(i for i, argument in arguments if not unbroken(argument, known, moving))


def _alone(model: Model[Node]) -> Sequence[bool]:
    """Whether no other event has an argument in proportion to that of each."""
    graph, alike = graph_of(model), dict[int, list[Node]]()
    plain = [graph.split_coefficient(event.argument)[1] for event in model.events]
    for one in plain:
        alike.setdefault(one.symbols, []).append(one)
    return [sum(proportional(one, other) for other in alike[one.symbols]) == 1 for one in plain]


def _apart(smooth: Guarded) -> bool:
    """Whether each switch has a series on either side, and its argument depends on no other one."""
    modes = union(one.mode for one in smooth.guards)
    return not any(
        one.cut or one.roots or one.broken or one.edge or one.vector or one.argument.symbols & modes
        for one in smooth.guards
    )


def reached_by(model: Model[Node], events: Iterable[tuple[int, int, int]]) -> tuple[tuple[int, int], ...]:
    """The coordinates on which impacts depend at which the motion may rest, if compiled code does the action
    of one, and others act, too."""
    acting = [(i, role, kind) for i, (_, role, kind) in enumerate(events) if role != Role.RECORD]
    if len(acting) == 1 or not any(role == Role.CHANGE for _, role, _ in acting):
        return ()
    own = [(i, model.events[i].argument.symbols) for i, _, kind in acting if kind >= 0]
    return tuple((i, k) for i, symbols in own for k, q in enumerate(model.q) if symbols & q.symbols)


def _changed(model: Model[Node]) -> Sequence[int]:
    """The symbols that each event changes."""
    symbols = dict(zip(model.coordinates, model.q))
    symbols |= {velocity_name(name): v for name, v in zip(model.coordinates, model.v)}
    symbols |= dict(model.parameters)
    return [union(symbols[name] for name in event.changes) for event in model.events]


def masses_of(model: Model[Node]) -> dict[str, Node]:
    """The masses that events change, by particle; particles with the same mass stand for each other."""
    bits = reduce(or_, _changed(model), 0)
    found = {one.mass: one.name for one in reversed(model.particles) if one.mass.symbols & bits}
    return {name: mass for mass, name in reversed(found.items())}


def changes_of(model: Model[Node]) -> tuple[tuple[tuple[int, int], ...], list[Node]]:
    """What events change: each event with the place of a name among coordinates, velocities and parameters;
    and the new values."""
    names = [*model.coordinates, *map(velocity_name, model.coordinates), *model.parameters]
    places = {name: i for i, name in enumerate(names)}
    found = [(i, name, node) for i, event in enumerate(model.events) for name, node in event.changes.items()]
    return tuple((i, places[name]) for i, name, _ in found), [node for *_, node in found]


def sizes_of(model: Model[Node]) -> list[Node]:
    """The size of the terms of each event's argument, and of its rate without accelerations: what their
    rounding is measured by. (Multipliers of constraints are not known there, and count as 0.)"""
    graph, found = graph_of(model), list[Node]()
    known = {*model.q, *model.v, model.time, *model.parameters.values()}
    for event in model.events:
        unknown = {one: graph.zero for one in graph.symbols_of(event.argument) if one not in known}
        (argument,) = substituted(graph, [event.argument], unknown)
        rates = map(graph.absolute, _rates(model, argument))
        found += [size_of(graph, argument), graph.sum([(one, 1.0) for one in rates])]
    return found


def left_by(model: Model[Node], events: Iterable[int]) -> list[Node]:
    """The rates of the arguments of some events after their own actions."""
    graph, found = graph_of(model), list[Node]()
    speeds = dict(zip(map(velocity_name, model.coordinates), model.v))
    for event in events:
        after = {speeds[name]: node for name, node in model.events[event].changes.items() if name in speeds}
        found += substituted(graph, rates_of(model, [event]), after)
    return found


def rates_of(model: Model[Node], events: Iterable[int]) -> list[Node]:
    """The rates of the arguments of some events without accelerations."""
    arguments = [model.events[event].argument for event in events]
    return [graph_of(model).sum([(one, 1.0) for one in _rates(model, each)]) for each in arguments]


def _rates(model: Model[Node], argument: Node) -> list[Node]:
    """The terms of the rate of an argument without accelerations."""
    graph = graph_of(model)
    places, speeds = numbered((*model.q, model.time)), (*model.v, graph.one)
    return [slope * speeds[k] for k, slope in sorted(graph.gradient(argument, places).items())]
