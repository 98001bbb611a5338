"""Mappings of the system file to what a ``Draft`` holds: entries by name, parameters, coordinates, ``solve``.

Only the form is checked here. ``spec.check`` looks up the names.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from lagrange_cli.expression.near import known_hint
from lagrange_cli.expression.parse import read as read_expression
from lagrange_cli.expression.syntax import Key, Vector
from lagrange_cli.records import dataclass
from lagrange_cli.spec import nodes
from lagrange_cli.spec.draft import Declared, Entry
from lagrange_cli.spec.fields import (
    Reader,
    read_key,
    read_list,
    read_named,
    read_scalar,
    read_text,
    unreadable,
)
from lagrange_cli.spec.nodes import Node, Scalar
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.table import Table, read_table


@dataclass(frozen=True)
class Entries:
    """The reader of a section ``name: expression``, each expression read by ``value``.

    In messages an entry is a ``what``, and its expression ``label`` and the name; ``example`` is an entry.
    The names may be ``free`` texts, and stand for ``families``.
    """

    value: Reader
    what: str
    example: str
    label: str
    free: bool = False
    families: bool = True

    def __call__(self, node: Node, where: str, problems: Problems) -> tuple[Entry, ...]:
        if isinstance(node, Scalar) and node.empty:
            return ()
        if not isinstance(node, nodes.Mapping):
            hint = f"write '{where}: {{{self.example}}}'"
            problems.add(node.place, f"{where} must be a mapping with a name for each {self.what}", hint)
            return ()
        found = []
        for key, inner in node.entries:
            name = Key(key.text, key.text) if self.free else read_key(key, problems, self.what, self.families)
            if name is not None:
                expression = self.value(inner, f"{self.label} '{name.label}'", problems)
                found.append(Entry(name.name, key.place, name, key.passage, expression))
        return tuple(found)


@dataclass(frozen=True)
class Single:
    """The reader of a section that is one expression: an entry with the section's own name."""

    what: str

    def __call__(self, node: Node, where: str, problems: Problems) -> tuple[Entry, ...]:
        name, value = Key(self.what, self.what), read_scalar(node, where, problems)
        return (Entry(self.what, node.place, name, None, value),)


@dataclass(frozen=True)
class Terms:
    """The reader of a section that is one expression, or a mapping of terms to be summed."""

    what: str

    def __call__(self, node: Node, where: str, problems: Problems) -> tuple[Entry, ...]:
        if isinstance(node, nodes.Mapping):
            several = Entries(read_scalar, self.what, f"{self.what}: ...", self.what, free=True)
            return several(node, where, problems)
        return Single(self.what)(node, where, problems)


def read_parameters(table: Table, node: Node, where: str, problems: Problems) -> tuple[Declared, ...]:
    """Parameters: a number, a list or a mapping with the keys of ``table`` for each name."""
    hint, found = "write 'parameters: {m: 1.0}', or one 'name: value' on each line", []
    for name, key, value in read_named(node, "parameter", "parameters", hint, problems):
        where = f"parameter '{name.label}'"
        if isinstance(value, nodes.Mapping):
            fields = read_table(value, table, where, problems)
            if all(inner.text != "value" for inner, _ in value.entries):
                problems.add(key.place, f"{where} has no value", "write {value: 1.0}")
        else:
            fields = {"value": read_list(value, where, problems)}
        found.append(Declared(name.name, key.place, name, key.passage, fields))
    return tuple(found)


def _initial_of(node: Node) -> str:
    """What stands where ``{initial: ...}`` should, if it is an initial value, or an example of one."""
    text = node.text if isinstance(node, Scalar) else ""
    value, mistakes = read_expression(text)
    return "0.1" if mistakes or isinstance(value, Vector) or len(text) > _SHORT else text


_SHORT = 30


def read_coordinates(table: Table, node: Node, where: str, problems: Problems) -> tuple[Declared, ...]:
    """Coordinates: a list of names, or a mapping with the keys of ``table`` for each name."""
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
                fields = read_table(value, table, f"coordinate '{label}'", problems)
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
                problems.add(item.place, "a list of coordinates has only names", example)
                if isinstance(item, nodes.Mapping):
                    problems.broken |= {key.text for key, _ in item.entries}
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


def read_solve(table: Table, node: Node, where: str, problems: Problems) -> Mapping[str, Any]:
    """The ``solve`` section, with the keys of ``table``."""
    if isinstance(node, Scalar) and node.empty:
        return {}
    if not isinstance(node, nodes.Mapping):
        problems.add(node.place, "solve must be 'key: value'", known_hint(table.keys))
        return {}
    return read_table(node, table, "solve", problems)


def read_time(table: Table, node: Node, where: str, problems: Problems) -> str:
    """The unit of t: ``time: d`` or ``time: {unit: d}``."""
    if isinstance(node, nodes.Mapping):
        return str(read_table(node, table, where, problems).get("unit", ""))
    return read_text(node, where, problems)


def read_draw(node: Node, where: str, problems: Problems) -> Mapping[str, Any]:
    """The ``draw`` section. Its table is loaded for files that have it."""
    from lagrange_cli.spec.draw_table import DRAW

    if isinstance(node, Scalar) and node.empty:
        return {}
    if not isinstance(node, nodes.Mapping):
        problems.add(node.place, f"{where} must be a mapping", "write 'draw: {rods: [[0, bob]]}'")
        return {}
    return read_table(node, DRAW, where, problems)
