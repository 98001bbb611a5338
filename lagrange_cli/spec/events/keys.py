"""The section ``events`` of the system file: the keys of an event, a row each, and how they are read."""

from __future__ import annotations

from functools import partial
from typing import Any

from lagrange_cli.expression.near import shown
from lagrange_cli.records import replace
from lagrange_cli.spec import nodes
from lagrange_cli.spec.draft import Entry, WrittenEvent
from lagrange_cli.spec.events.readers import (
    IMPACTS,
    SET,
    read_action,
    read_changes,
    read_direction,
    read_when,
)
from lagrange_cli.spec.fields import read_named
from lagrange_cli.spec.nodes import Node, Scalar
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.table import Row, Table, read_table

ACTION = Table(
    "action",
    (
        Row(
            "set",
            read_changes,
            "name of a coordinate, a velocity or a parameter -> its new value",
            also="assign update change changes sets apply put",
        ),
    ),
)
EVENT = Table(
    "event",
    (
        Row(
            "when",
            read_when,
            "the expression that becomes 0",
            also="condition event events trigger function zero zeros g root at if on where expression expr "
            "guard crossing crosses cross of equation value quantity watch at_zero test",
        ),
        Row(
            "direction",
            read_direction,
            "`rising`, `falling` or `either`: how it passes 0 [either]",
            also="sign dir slope way",
        ),
        Row(
            "action",
            partial(read_action, ACTION),
            "`record`, `stop`, or `{set: {NAME: expression}}` [record]",
            also="do then effect actions response result",
        ),
    ),
)
EXAMPLE = "{when: x, direction: falling}"
_STOPS = ["terminal", "terminate", "stop", "stops", "end", "halt"]
_FALSE = ["false", "no", "off", "0"]


def read_events(node: Node, where: str, problems: Problems) -> tuple[WrittenEvent, ...]:
    """Events: for each name an expression, or a mapping with the keys of ``EVENT``."""
    hint, found = f"write 'events: {{floor: {EXAMPLE}}}'", []
    for name, key, value in read_named(node, "event", "events", hint, problems):
        label = f"event '{name.label}'"
        event = WrittenEvent(name.name, key.place, name, key.passage)
        if isinstance(value, nodes.Mapping):
            fields = _fields(value, label, problems)
            if "when" not in fields:
                problems.add(key.place, f"{label} has no 'when'", f"write {name.text}: {EXAMPLE}")
            stops, changes = fields["action"]
            event = replace(
                event,
                when=fields.get("when"),
                direction=fields.get("direction", 0),
                stops=stops,
                changes=changes,
            )
        else:
            event = replace(event, when=read_when(value, label, problems))
        found.append(event)
    return tuple(found)


def _fields(node: nodes.Mapping, label: str, problems: Problems) -> dict[str, Any]:
    """The fields of an event; a message names the right field for entries of another one."""
    kept = []
    set_apart: tuple[Entry, ...] = ()
    for key, value in node.entries:
        word = key.text.lower()
        text = value.text.lower() if isinstance(value, Scalar) else ""
        if word in _STOPS:
            hint = "leave it out" if text in _FALSE else "write 'action: stop'"
            problems.add(key.place, f"unknown key {shown(key.text)} in {label}", hint)
        elif word == "set" or word in IMPACTS:
            hint = f"write '{SET}'"
            if word == "set" and isinstance(value, nodes.Mapping) and value.entries:
                hint = f"write 'action: {{set: {{{value.entries[0][0].text}: ...}}}}'"
            problems.add(key.place, f"unknown key {shown(key.text)} in {label}", hint)
            if word == "set" and isinstance(value, nodes.Mapping):
                set_apart = read_changes(value, f"set of {label}", problems)
        else:
            kept.append((key, value))
    fields = read_table(replace(node, entries=tuple(kept)), EVENT, label, problems)
    return {"action": (False, set_apart), **fields}
