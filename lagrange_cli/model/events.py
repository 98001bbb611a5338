"""The effect of events on the conserved quantities of a system."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from lagrange_cli.expression.algebra import E
from lagrange_cli.expression.vocabulary import member_name, velocity_name
from lagrange_cli.model.model import Model

MOST_NAMES = 3
"""Events that are named in one sentence."""


DIRECTIONS = {0: "either", 1: "rising", -1: "falling"}
"""The words of the system file."""


HOW = {0: "in either direction", 1: "rising", -1: "falling"}
"""The direction of a crossing, as in a sentence."""


def action_of(stops: bool, changes: Mapping[str, object]) -> str:
    """The word for what an event does."""
    return "stop" if stops else "set" if changes else "record"


def changes_of(model: Model[E]) -> dict[str, dict[E, E]]:
    """What each event sets: the new values by the symbols that they replace.

    Where it sets something that is a function of other coordinates, the change of these is not solved for. It
    is replaced by x -> 2 x + 1, which leaves no relevant function of x unchanged. The same stands for what
    forces of constraint change, where the values set may violate constraints (``_moved``).
    """
    symbols = dict(zip(model.coordinates, model.q)) | dict(model.parameters)
    symbols |= {velocity_name(name): v for name, v in zip(model.coordinates, model.v)}
    found, total = {}, model.algebra.total
    for event in model.events:
        known = {symbols[name]: value for name, value in event.changes.items() if name in symbols}
        others = event.changes.keys() - symbols.keys()
        moved = (*model.q, *model.v) if others & model.replaced.keys() else model.v if others else ()
        unknown = [*moved, *_moved(model, known)]
        found[event.name] = known | {x: total([x, x, model.algebra.number("1")]) for x in unknown}
    return found


def _moved(model: Model[E], known: Mapping[E, E]) -> list[E]:
    """The symbols of which it is not ``known`` what they become, since constraints act on what an event sets.

    Where a holonomic constraint contains a coordinate or a parameter that is set, all coordinates and
    velocities that hang together with it may move. Otherwise impulses along the velocities that are set
    restore the constraints on velocities. They keep the momentum of every displacement that the constraints
    allow and that leaves these velocities alone, and the energy where they are only reversed.
    """
    symbols, total, zero = model.algebra.symbols, model.algebra.total, model.algebra.number("0")
    partner = dict(zip(model.v, model.q))
    contents = [{partner.get(one, one) for one in symbols(each.expression)} for each in model.constraints]
    off = [each.holonomic and not here.isdisjoint(known) for each, here in zip(model.constraints, contents)]
    if any(off):
        together = set().union(*(here for here, one in zip(contents, off) if one))
        places = [{one for x in each.position for one in symbols(x)} for each in model.particles]
        grown = _joined(together & {*model.q}, [one & {*model.q} for one in [*contents, *places]])
        return [x for q, v in zip(model.q, model.v) if q in grown for x in (q, v)]
    acting = set().union(*contents)
    set_here = [v for v in known if partner.get(v) in acting]
    only = len(set_here) == len(known) and all(zero == total([known[v], v]) for v in set_here)
    return [] if only else set_here


def _joined(some: set[E], groups: Sequence[Collection[E]]) -> set[E]:
    """What hangs together with ``some``, where all of a group do."""
    grown = some
    while True:
        more = grown.union(*(one for one in groups if not grown.isdisjoint(one)))
        if more == grown:
            return grown
        grown = more


def between_events(breaks: Sequence[str]) -> str:
    """The limits of a conservation law that these events may break, as the end of a sentence."""
    named = _by_family(breaks)
    shown = named[: MOST_NAMES if len(named) > MOST_NAMES + 1 else None]
    if left := len(named) - len(shown):
        shown.append(f"{left} other events")
    last = shown.pop()
    listed = f"{', '.join(shown)} and {last}" if shown else last
    return f"only between events, as {listed} may change it"


def _by_family(names: Sequence[str]) -> list[str]:
    """Names in quotes, with several members of a family as one."""
    members: dict[str, list[str]] = {}
    for name in names:
        members.setdefault(name.partition("[")[0], []).append(name)
    found = []
    for base, own in members.items():
        label = member_name(base, "ijklmn"[: own[0].count(",") + 1])
        found.append(f"'{own[0]}'" if len(own) == 1 else f"some '{label}'")
    return found
