"""Nodes to a ``Draft``: each section is read on its own, with one table of keys per section.

A key of the system file is one entry here and one field of ``Draft``. Only the form is judged: what names
mean, and whether they exist, is ``spec.check``'s business.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from lagrange_cli.expression.near import known_hint, near_hint
from lagrange_cli.expression.numbers import evaluate
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.syntax import ExpressionError, Span, Tree, Vector, names
from lagrange_cli.spec import nodes
from lagrange_cli.spec.nodes import Node, Scalar
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import Passage, Place
from lagrange_cli.spec.spec import Expression


@dataclass(frozen=True)
class Entry:
    """``name: expression`` of a section; ``value`` is None where the expression could not be read."""

    name: str
    place: Place
    value: Expression | None


@dataclass(frozen=True)
class Declared:
    """A parameter or a coordinate: its name, and the fields given for it."""

    name: str
    place: Place
    fields: Mapping[str, Any]


@dataclass(frozen=True)
class Draft:
    """A system file's sections as written, before any name has been looked up.

    ``places`` has the place of each section's key.
    """

    places: Mapping[str, Place]
    name: str = ""
    description: str = ""
    parameters: tuple[Declared, ...] = ()
    coordinates: tuple[Declared, ...] = ()
    definitions: tuple[Entry, ...] = ()
    masses: tuple[Entry, ...] = ()
    embedding: tuple[Entry, ...] = ()
    potential: tuple[Entry, ...] = ()
    lagrangian: Expression | None = None
    forces: tuple[Entry, ...] = ()
    generalized_forces: tuple[Entry, ...] = ()
    dissipation: Expression | None = None
    observables: tuple[Entry, ...] = ()
    solve: Mapping[str, Any] = field(default_factory=dict)
    solve_places: Mapping[str, Place] = field(default_factory=dict)


Reader = Callable[[Node, str, Problems], Any]
"""Reads the value of a key: the node, what to call it in messages, and where to put problems."""


def read_draft(root: Node, problems: Problems) -> Draft:
    """The sections of the file; whatever is wrong with their form is added to ``problems``."""
    if not isinstance(root, nodes.Mapping):
        problems.add(
            root.place, "a system file is a list of sections, 'key: value'", known_hint(SECTIONS, limit=8)
        )
        problems.stop_if_any()
        raise AssertionError("unreachable")
    sections = _read_table(root, SECTIONS, "", problems)
    places = {key.text: key.place for key, _ in root.entries}
    solve = next((node for key, node in root.entries if key.text == "solve"), None)
    inner = solve.entries if isinstance(solve, nodes.Mapping) else ()
    return Draft(places=places, **sections, solve_places={key.text: node.place for key, node in inner})


def read_text(node: Node, where: str, problems: Problems) -> str:
    """A text, taken as it is written."""
    if not isinstance(node, Scalar):
        problems.add(node.place, f"{where} must be a text", "put it in quotes if it has [ ] { } or ': '")
        return ""
    return "" if node.empty else node.text.strip()


def read_scalar(node: Node, where: str, problems: Problems) -> Expression | None:
    """One expression; that its value is a scalar is checked later."""
    if isinstance(node, nodes.Mapping):
        problems.add(node.place, f"{where} must be an expression, not a mapping", "write it on one line")
        return None
    if isinstance(node, nodes.Sequence):
        if where.startswith("parameter"):
            problems.add(
                node.place, f"{where} is a list: list parameters are not supported yet", "name each number"
            )
        else:
            problems.add(node.place, f"{where} must be a scalar, not a vector", "write one expression")
        return None
    return _parsed((node,), where, problems)


def read_vector(node: Node, where: str, problems: Problems) -> Expression | None:
    """An expression, or a list of the one to three components of a vector."""
    if not isinstance(node, nodes.Sequence):
        return read_scalar(node, where, problems)
    if not 1 <= len(node.items) <= 3:
        problems.add(
            node.place, f"{where} must have one to three components, not {len(node.items)}", "write [x, y, z]"
        )
        return None
    scalars = [item for item in node.items if isinstance(item, Scalar)]
    for item in node.items:
        if not isinstance(item, Scalar):
            problems.add(item.place, f"a component of {where} must be an expression", "write [x, y, z]")
    return _parsed(scalars, where, problems, vector=True) if len(scalars) == len(node.items) else None


def _parsed(
    scalars: tuple[Scalar, ...] | list[Scalar], where: str, problems: Problems, vector: bool = False
) -> Expression | None:
    """The expression of one scalar, or the vector whose components are the scalars."""
    text = "(" if vector else ""
    passages: list[tuple[int, Passage]] = []
    trees: list[Tree] = []
    whole = True
    for scalar in scalars:
        if passages:
            text += ", "
        passages.append((len(text), scalar.passage))
        draft = Expression(scalar.text, Vector((), Span(0, 0)), scalar.place, ((len(text), scalar.passage),))
        try:
            if scalar.empty:
                raise ExpressionError(
                    Span(len(text), len(text) + 1), "a value is missing", "write an expression"
                )
            trees.append(parse(scalar.text, len(text)))
        except ExpressionError as error:
            problems.add_expression(draft, error, where)
            whole = False
        text += scalar.text
    if not whole:
        return None
    text += (",)" if len(scalars) == 1 else ")") if vector else ""
    tree = Vector(tuple(trees), Span(0, len(text))) if vector else trees[0]
    return Expression(text, tree, scalars[0].place, tuple(passages))


def read_number(node: Node, where: str, problems: Problems) -> float | None:
    """A number, or an expression of numbers."""
    expression = read_scalar(node, where, problems)
    if expression is None:
        return None
    try:
        for name in names(expression.tree):
            if name.identifier != "pi":
                special = name.identifier.lower() in ("nan", "inf")
                raise ExpressionError(
                    name.span,
                    f"'{name.identifier}' is not a finite number"
                    if special
                    else f"a number is due, not '{name.identifier}'",
                    "write a number",
                )
        return evaluate(expression.tree)
    except ExpressionError as error:
        problems.add_expression(expression, error, where)
        return None


def read_count(node: Node, where: str, problems: Problems) -> int | None:
    """A whole number."""
    value = read_number(node, where, problems)
    if value is None:
        return None
    if value != int(value):
        problems.add(node.place, f"{where} must be a whole number", f"write {max(2, round(value))}")
        return None
    return int(value)


def read_words(node: Node, where: str, problems: Problems) -> tuple[str, ...] | None:
    """A list of words, or one text with commas between them."""
    if isinstance(node, nodes.Sequence):
        return tuple(read_text(item, where, problems) for item in node.items)
    text = read_text(node, where, problems)
    return tuple(word.strip() for word in text.split(",") if word.strip())


def identifier(key: Scalar, problems: Problems, what: str) -> str | None:
    """The key as a name of the expression language; None where it cannot be one."""
    name = unicodedata.normalize("NFKC", key.text)  # as Python's parser does with names in expressions
    if "[" in name:
        problems.add(
            key.place,
            f"'{key.text}': indexed families are not supported yet",
            "give each member a name of its own, such as theta1",
        )
        return None
    try:
        tree_names = list(names(parse(key.text)))
        if len(tree_names) == 1 and tree_names[0].identifier == name and "." not in name:
            return name
    except ExpressionError:
        pass
    problems.add(
        key.place,
        f"'{key.text}' cannot be the name of a {what}",
        "a name is letters, digits and _, begins with a letter, and is no word of Python",
    )
    return None


def _entries(
    reader: Reader, section: str, what: str, plain_names: bool = False
) -> Callable[[Node, str, Problems], tuple[Entry, ...]]:
    """A section of ``name: expression``."""

    def read(node: Node, where: str, problems: Problems) -> tuple[Entry, ...]:
        if isinstance(node, Scalar) and node.empty:
            return ()
        if not isinstance(node, nodes.Mapping):
            problems.add(node.place, f"{section} must be 'name: expression' for each {what}", "one a line")
            return ()
        found = []
        for key, value in node.entries:
            name = key.text if plain_names else identifier(key, problems, what)
            if name is not None:
                found.append(Entry(name, key.place, reader(value, f"{what} '{name}'", problems)))
        return tuple(found)

    return read


def _read_potential(node: Node, where: str, problems: Problems) -> tuple[Entry, ...]:
    if isinstance(node, nodes.Mapping):
        return _entries(read_scalar, where, "potential", plain_names=True)(node, where, problems)
    return (Entry("potential", node.place, read_scalar(node, where, problems)),)


def _read_parameters(node: Node, where: str, problems: Problems) -> tuple[Declared, ...]:
    if isinstance(node, Scalar) and node.empty:
        return ()
    if not isinstance(node, nodes.Mapping):
        problems.add(node.place, "parameters must be 'name: value' for each", "one a line")
        return ()
    found = []
    for key, value in node.entries:
        name = identifier(key, problems, "parameter")
        if name is None:
            continue
        where = f"parameter '{name}'"
        if isinstance(value, nodes.Mapping):
            fields = _read_table(value, PARAMETER, where, problems)
            if all(inner.text != "value" for inner, _ in value.entries):
                problems.add(key.place, f"{where} has no value", "write {value: 1.0}")
        else:
            fields = {"value": read_scalar(value, where, problems)}
        found.append(Declared(name, key.place, fields))
    return tuple(found)


def _read_coordinates(node: Node, where: str, problems: Problems) -> tuple[Declared, ...]:
    example = "write 'theta: {initial: 0.1, velocity: 0}', or a list of names"
    found = []
    if isinstance(node, nodes.Mapping):
        for key, value in node.entries:
            name = identifier(key, problems, "coordinate")
            if name is None:
                continue
            fields: Mapping[str, Any] = {}
            if isinstance(value, nodes.Mapping):
                fields = _read_table(value, COORDINATE, f"coordinate '{name}'", problems)
            elif not (isinstance(value, Scalar) and value.empty):
                problems.add(
                    value.place, f"coordinate '{name}' must be a mapping", f"write {name}: {{initial: 0.1}}"
                )
            found.append(Declared(name, key.place, fields))
    elif isinstance(node, nodes.Sequence):
        seen: set[str] = set()
        for item in node.items:
            if not isinstance(item, Scalar):
                problems.add(item.place, "a list of coordinates has only names", example)
                continue
            name = identifier(item, problems, "coordinate")
            if name in seen:
                problems.add(item.place, f"the coordinate '{name}' comes twice", "leave one out")
            elif name is not None:
                seen.add(name)
                found.append(Declared(name, item.place, {}))
    elif not node.empty:
        problems.add(node.place, "coordinates must be a mapping or a list", example)
    return tuple(found)


def _read_solve(node: Node, where: str, problems: Problems) -> Mapping[str, Any]:
    if isinstance(node, Scalar) and node.empty:
        return {}
    if not isinstance(node, nodes.Mapping):
        problems.add(node.place, "solve must be 'key: value'", known_hint(SOLVE))
        return {}
    return _read_table(node, SOLVE, "solve", problems)


def _read_table(
    node: nodes.Mapping, table: Mapping[str, Reader], where: str, problems: Problems
) -> dict[str, Any]:
    """Each key by the reader its table has for it."""
    found: dict[str, Any] = {}
    within = f" in {where}" if where else ""
    for key, value in node.entries:
        if table is SECTIONS and key.text in LATER:
            problems.add(key.place, f"'{key.text}' is not supported yet", LATER[key.text])
        elif key.text not in table:
            hint = near_hint(key.text, table) or known_hint(table)
            problems.add(key.place, f"unknown key '{key.text}'{within}", hint)
        else:
            name = f"{key.text} of {where}" if where else key.text
            found[key.text] = table[key.text](value, name, problems)
    return found


PARAMETER: dict[str, Reader] = {"value": read_scalar, "unit": read_text, "description": read_text}
COORDINATE: dict[str, Reader] = {
    "initial": read_scalar,
    "velocity": read_scalar,
    "unit": read_text,
    "description": read_text,
}
SOLVE: dict[str, Reader] = {
    "start": read_number,
    "stop": read_number,
    "samples": read_count,
    "step": read_number,
    "method": read_text,
    "tolerance": read_number,
    "outputs": read_words,
}
SECTIONS: dict[str, Reader] = {
    "name": read_text,
    "description": read_text,
    "parameters": _read_parameters,
    "coordinates": _read_coordinates,
    "definitions": _entries(read_vector, "definitions", "definition"),
    "masses": _entries(read_scalar, "masses", "mass"),
    "embedding": _entries(read_vector, "embedding", "embedding"),
    "potential": _read_potential,
    "lagrangian": read_scalar,
    "forces": _entries(read_vector, "forces", "force"),
    "generalized_forces": _entries(read_scalar, "generalized_forces", "generalized force"),
    "dissipation": read_scalar,
    "observables": _entries(read_scalar, "observables", "observable"),
    "solve": _read_solve,
}
LATER: dict[str, str] = {
    "sizes": "write indexed families out, one name for each member",
    "bodies": "describe a rigid body by point masses, or give 'lagrangian' instead",
    "constraints": "choose coordinates that satisfy the constraint",
    "nonholonomic": "only unconstrained and holonomic systems in their own coordinates are solved for now",
    "events": "write the quantity under 'observables' and look for its zeros in the output",
}
"""Sections that are not supported yet, and what can be done instead."""
