"""The effect of events on the conserved quantities of a system."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lagrange_cli.expression.algebra import E
from lagrange_cli.expression.vocabulary import velocity_name
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
    is replaced by x -> 2 x + 1, which leaves no relevant function of x unchanged.
    """
    symbols = dict(zip(model.coordinates, model.q)) | dict(model.parameters)
    symbols |= {velocity_name(name): v for name, v in zip(model.coordinates, model.v)}
    found, total = {}, model.algebra.total
    for event in model.events:
        known = {symbols[name]: value for name, value in event.changes.items() if name in symbols}
        others = event.changes.keys() - symbols.keys()
        moved = (*model.q, *model.v) if others & model.replaced.keys() else model.v if others else ()
        found[event.name] = known | {x: total([x, x, model.algebra.number("1")]) for x in moved}
    return found


def between_events(breaks: Sequence[str]) -> str:
    """The limits of a conservation law that these events may break, as the end of a sentence."""
    shown = ", ".join(f"'{name}'" for name in breaks[:MOST_NAMES])
    more = f" and {len(breaks) - MOST_NAMES} other events" if len(breaks) > MOST_NAMES else ""
    return f"only between events, as {shown}{more} may change it"
