"""Declarations of parameters and coordinates: their keys, a row each, and their sections."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from lagrange_cli.expression.confusions import SWITCHES
from lagrange_cli.expression.parse import read as read_expression
from lagrange_cli.expression.syntax import Vector
from lagrange_cli.spec import nodes
from lagrange_cli.spec.draft import Declared
from lagrange_cli.spec.fields import read_key, read_list, read_named, read_scalar, read_text, unreadable
from lagrange_cli.spec.nodes import Node, Scalar
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.table import Row, Table, read_table

PARAMETER = Table(
    "parameter",
    (
        Row(
            "value",
            read_list,
            "a number, an expression in other parameters, or a list of either",
            also="val default number is initial",
        ),
        Row("unit", read_text, "its [unit](#units)", also="units"),
        Row("description", read_text, "text", also="comment"),
    ),
)
COORDINATE = Table(
    "coordinate",
    (
        Row(
            "initial",
            read_scalar,
            "its value at the start, in parameters",
            also="value start init initial_value initial_position position x0 q0 at initially",
        ),
        Row(
            "velocity",
            read_scalar,
            "its velocity at the start, in parameters [0]",
            also="v0 speed initial_velocity initial_speed dot rate v vel qdot q_dot velocity0",
        ),
        Row("unit", read_text, "its [unit](#units)", also="units"),
        Row("description", read_text, "text", also="comment"),
    ),
)


def read_parameters(node: Node, where: str, problems: Problems) -> tuple[Declared, ...]:
    """Parameters: a number, a list or a mapping with the keys of ``PARAMETER`` for each name."""
    hint, found = "write 'parameters: {m: 1.0}', or one 'name: value' on each line", []
    for name, key, value in read_named(node, "parameter", "parameters", hint, problems):
        where = f"parameter '{name.label}'"
        if isinstance(value, nodes.Mapping):
            fields = read_table(value, PARAMETER, where, problems)
            if all(inner.text != "value" for inner, _ in value.entries):
                problems.add(key.place, f"{where} has no value", "write {value: 1.0}")
        else:
            fields = {"value": read_list(value, where, problems)}
        found.append(Declared(name.name, key.place, name, key.passage, fields))
    return tuple(found)


def _initial_of(node: Node) -> str:
    """An initial value written in place of ``{initial: ...}``, or an example of one; also with a velocity."""
    if isinstance(node, nodes.Sequence) and len(node.items) == 2:
        return ", velocity: ".join(map(_initial_of, node.items))
    text = node.text if isinstance(node, Scalar) else ""
    value, mistakes = read_expression(text)
    unfit = mistakes or isinstance(value, Vector) or len(text) > _SHORT or text.lower() in SWITCHES
    return "0.1" if unfit else text


_SHORT = 30


def _unlisted(item: nodes.Mapping) -> str:
    """How a coordinate is written that stands in a list with its initial value."""
    key, value = item.entries[0]
    if isinstance(value, nodes.Mapping):
        return f"write '{key.text}: {{initial: ...}}' without the '- ' before it"
    if key.text == "name" and isinstance(value, Scalar):
        return f"write '{value.text}: {{initial: ...}}' without the '- ' before it"
    initial = _initial_of(value)
    return f"write '{key.text}: {{initial: {initial}}}' without the '- ' before it"


def read_coordinates(node: Node, where: str, problems: Problems) -> tuple[Declared, ...]:
    """Coordinates: a list of names, or a mapping with the keys of ``COORDINATE`` for each name."""
    example = "write 'theta: {initial: 0.1, velocity: 0}', or a list of names"
    found = []
    if isinstance(node, nodes.Mapping):
        for key, value in node.entries:
            name = read_key(key, problems, "coordinate")
            if name is None:
                continue
            label = name.label
            fields: Mapping[str, Any] = {}
            before = len(problems.found)
            if isinstance(value, nodes.Mapping):
                fields = read_table(value, COORDINATE, f"coordinate '{label}'", problems)
            elif not (isinstance(value, Scalar) and value.empty):
                problems.add(
                    value.place,
                    f"coordinate '{label}' must be a mapping",
                    f"write {name.text}: {{initial: {_initial_of(value)}}}",
                )
            if len(problems.found) > before and fields.get("initial") is None:
                fields = {**fields, "initial": unreadable(key.place, problems)}
            found.append(Declared(name.name, key.place, name, key.passage, fields))
    elif isinstance(node, nodes.Sequence):
        seen: set[str] = set()
        for item in node.items:
            if not isinstance(item, Scalar):
                hint = example
                if isinstance(item, nodes.Mapping) and item.entries:
                    problems.broken |= {key.text for key, _ in item.entries}
                    hint = _unlisted(item)
                problems.add(item.place, "a list of coordinates has only names", hint)
                continue
            name = read_key(item, problems, "coordinate")
            if name is None:
                continue
            if name.label in seen:
                problems.add(item.place, f"the coordinate '{name.label}' is given twice", "leave one out")
            else:
                seen.add(name.label)
                found.append(Declared(name.name, item.place, name, item.passage))
    elif not node.empty:
        problems.add(node.place, "coordinates must be a mapping or a list", example)
        problems.broken |= {*re.findall(r"[^\W\d]\w*", node.text)}
    return tuple(found)
