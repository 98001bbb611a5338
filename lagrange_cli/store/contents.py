"""What a checkpoint or a record may contain: the type and the range of every part.

Anyone who can write to the folder can write a checkpoint with a valid digest. The worst that a checkpoint
can do after these checks is to lead to a wrong output: no value has an unexpected type, and no number is too
large for what is done with it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from typing import Any

from lagrange_cli.spec.fields import control_character
from lagrange_cli.store.target import PARTS

Check = Callable[[Any], bool]

MOST = 2**53
"""The largest count."""
STATUSES = ("complete", "stopped", "failed", "interrupted")
"""How a run may have ended."""


def text(value: Any) -> bool:
    return type(value) is str


def flag(value: Any) -> bool:
    return type(value) is bool


def count(value: Any) -> bool:
    return type(value) is int and 0 <= value < MOST


def number(value: Any) -> bool:
    """A double, nan and infinities among them."""
    return type(value) is float or (type(value) is int and abs(value) < MOST)


def finite(value: Any) -> bool:
    return number(value) and math.isfinite(value)


def nothing(value: Any) -> bool:
    return value is None


def either(*checks: Check) -> Check:
    """A value that one of these checks accepts."""
    return lambda value: any(check(value) for check in checks)


def row(*checks: Check) -> Check:
    """A list of as many as there are checks."""

    def each(value: Any) -> bool:
        fits = type(value) is list and len(value) == len(checks)
        return fits and all(check(one) for check, one in zip(checks, value))

    return each


def sequence(check: Check) -> Check:
    """A list of any number."""
    return lambda value: type(value) is list and all(map(check, value))


def table(check: Check) -> Check:
    """Anything by name, which may go to a terminal."""
    return lambda value: type(value) is dict and all(map(shown, value)) and all(map(check, value.values()))


def fields(required: Mapping[str, Check], optional: Mapping[str, Check] | None = None) -> Check:
    """Exactly these, by name."""
    optional = optional or {}

    def check(value: Any) -> bool:
        if type(value) is not dict or not required.keys() <= value.keys():
            return False
        known = {**required, **optional}
        return all(name in known and known[name](one) for name, one in value.items())

    return check


def written(check: Check) -> Check:
    """JSON, as a text."""

    def parsed(value: Any) -> bool:
        try:
            return text(value) and check(json.loads(value))
        except (ValueError, RecursionError):
            return False

    return parsed


def shown(value: Any) -> bool:
    """A text that goes to a terminal: without control characters, except line ends and tabs."""
    return text(value) and not control_character(value)


def state_of(check: Check) -> Check:
    """A state: t, q and v by coordinate."""
    both = fields({"t": number, "q": table(check), "v": table(check)})
    return lambda value: both(value) and value["q"].keys() == value["v"].keys()


numbers = table(either(number, nothing))
instant = either(nothing, finite)
attribute = either(text, number)
happened = fields(
    {"count": count, "last": instant, "grazing": count, "accumulates": instant, "error": finite}
)
happened_in_all = fields({"count": count})
told: dict[str, Check] = {
    "generator": text, "name": shown, "spec": text, "method": shown, "message": shown,
    "status": lambda value: value in STATUSES, "p_drift": written(numbers),
    "final": either(nothing, written(either(nothing, state_of(either(number, nothing))))),
    "events": either(nothing, written(either(table(happened), table(happened_in_all)))),
}  # fmt: skip
"""The status and messages of a run that has ended."""
made_by = table(either(text, number, lambda value: type(value) is list and all(map(text, value))))
"""The attributes that identify a run; that of the machine is a list."""

event = count, instant, count, instant, count, instant, finite, instant
"""What happened at an event, in the order of ``integrate.events.Happened``."""
change = {
    "t": finite, "steps": count, "method": text, "tolerance": finite, "replaces": number, "beyond": count,
}  # fmt: skip
"""A change of the method (``integrate.method.MethodChange``)."""
progress = fields(
    {
        "t": finite, "steps": count, "samples": count, "size": number, "limited": flag,
        "first": table(number), "drift": table(number), "final": either(nothing, state_of(number)),
    },
    {
        "base": table(number), "events": sequence(row(*event)), "actions": sequence(number),
        "unknown": table(finite), "singular": sequence(finite), "extent": number,
        "changes": sequence(fields(change)),
    },
)  # fmt: skip
outcome = fields(
    {
        "failed": either(nothing, row(count, text)), "steps": count,
        "h_drift": either(nothing, number), "p_drift": table(number),
    },
    {"unknown": table(row(count, finite)), "doubtful": table(row(count, *event))},
)  # fmt: skip
common: dict[str, Check] = {
    "run": made_by, "part": lambda value: type(value) is int and -1 <= value < PARTS,
    "replace": flag, "reached": finite,
}  # fmt: skip
motion = fields({**common, "progress": progress})
"""The head of the checkpoint of a motion,"""
sweep = fields({**common, "outcome": outcome, "regions": table(row(count, count))})
"""of a sweep's,"""

section = fields({**common, "crossings": count})
"""of the only motion of a section,"""


def ending(value: Any) -> bool:
    """and of the record of a run that has ended."""
    if not fields({"attributes": table(attribute), "t": number}, {"further": motion})(value):
        return False
    said = value["attributes"]
    return all(check(said.get(name)) for name, check in told.items())


sound = either(motion, sweep, section, ending)
"""Any of these."""
