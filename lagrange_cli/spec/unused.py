"""Parameters, definitions and sizes that nothing uses."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from lagrange_cli.expression.syntax import Axis, Name, parts
from lagrange_cli.expression.vocabulary import family_name
from lagrange_cli.records import fields_of
from lagrange_cli.spec.draft import Draft, WrittenEvent
from lagrange_cli.spec.draw.ranges import WrittenRange
from lagrange_cli.spec.nodes import compose
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.read import read_draft
from lagrange_cli.spec.source import Place, Source
from lagrange_cli.spec.spec import Expression, Spec

DECLARING = {"parameters": "parameter", "definitions": "definition", "sizes": "size"}
"""The sections whose names do nothing by themselves, and what each is called."""


def unused(spec: Spec) -> Iterator[tuple[Place, str, str]]:
    """The places of names that are declared and have no part in anything, with a message and a hint for each.

    Families are not told apart by their members. What an event sets, or a slider of the drawing, is used.
    """
    source = Source(spec.filename, spec.text)
    problems = Problems(source)
    draft = read_draft(compose(source, problems), problems)
    declared = declared_names(draft)
    inside = {name: {*mentioned(given)} - {name} for name, (_, given) in declared.items()}
    pending = [*mentioned([given for key, given in draft.sections.items() if key not in DECLARING])]
    used = set[str]()
    while pending:
        name = pending.pop()
        if name not in used:
            used.add(name)
            pending += inside.get(name, ())
    user = {name: other for other, names in inside.items() for name in names}
    for name, (what, given) in declared.items():
        if name in used:
            continue
        by = user.get(name)
        if by is None:
            yield given[0].place, f"{what} '{name}' is not used", "use it in an expression, or delete it"
        else:
            message = f"{what} '{name}' is used only in what is not used itself, such as '{by}'"
            yield given[0].place, message, f"use '{by}' in an expression, or delete both"


def declared_names(draft: Draft) -> dict[str, tuple[str, list[Any]]]:
    """The names of these sections: what each is, and all that declares it."""
    found: dict[str, tuple[str, list[Any]]] = {}
    for section, what in DECLARING.items():
        for one in draft.sections.get(section, ()):
            found.setdefault(family_name(one.name), (what, []))[1].append(one)
    return found


def mentioned(given: Any) -> Iterator[str]:
    """Every name in what has been read of a file, wherever it stands, and those that events set or that have
    sliders."""
    trees = (given.tree,) if isinstance(given, Expression) else given.trees if isinstance(given, Axis) else ()
    yield from (one.base for tree in trees for one in parts(tree) if isinstance(one, Name))
    if isinstance(given, WrittenEvent):
        yield from (one.name for one in given.changes)
    elif isinstance(given, WrittenRange):
        yield given.name
    inner: Iterable[Any] = ()
    if isinstance(given, Mapping):
        inner = given.values()
    elif isinstance(given, tuple | list):
        inner = given
    elif not trees and hasattr(given, "__record_fields__"):
        inner = (getattr(given, name) for name in fields_of(given))
    for one in inner:
        yield from mentioned(one)
