"""The events of families in a Python module: what becomes 0, and the state after each that sets something."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import prod
from typing import Protocol

import sympy

from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.spec.family import Family
from lagrange_cli.symbolic.families.equations import Change, EventLine, FamilyEquations
from lagrange_cli.symbolic.families.lines import Line
from lagrange_cli.symbolic.indexed.conditions import Loop, holds
from lagrange_cli.symbolic.indexed.members import KNOWN
from lagrange_cli.symbolic.indexed.whole import Whole
from lagrange_cli.symbolic.notations import IndexedPython, python_index

PLACES = "EVENT_PLACES"
"""The places of the events, where members of their families are missing."""


class ModuleWriter(Protocol):
    """What writes a module (``symbolic.families.module_writer``)."""

    equations: FamilyEquations
    notation: IndexedPython

    def text(self, expression: sympy.Expr) -> str: ...
    def names(self, text: str) -> list[str]: ...
    def loops(self, loops: Sequence[Loop], indent: str = "    ") -> tuple[list[str], str]: ...
    def vector(
        self, name: str, purpose: str, lines: Sequence[Line], *, among: Sequence[Family], places: str
    ) -> str: ...


SIGNATURE = "t, q, v, parameters=PARAMETERS"


def families_of(equations: FamilyEquations) -> list[Family]:
    """The families of events, in order."""
    return [*{one.line.family.name: one.line.family for one in equations.events}.values()]


def constants(equations: FamilyEquations, places: Sequence[int]) -> list[str]:
    """The names of all events, their directions, and their ``places`` among all that there could be."""
    families = families_of(equations)
    directions: list[int] = []
    for family in families:
        lines = [one for one in equations.events if one.line.family is family]
        known = {place: one.direction for one in lines for place in placed_by(one, equations)}
        directions += [known[place] for place in (family.places if family.shape else [()])]
    found = [
        f"EVENTS = {tuple(name for one in families for name in one.members)!r}",
        f"DIRECTIONS = {tuple(directions)!r}",
    ]
    complete = all(one.complete for one in families)
    return found if complete else [*found, f"{PLACES} = {tuple(places)!r}"]


def placed_by(event: EventLine, equations: FamilyEquations) -> Iterator[tuple[int, ...]]:
    """The places of the events that a line stands for."""
    for own in rounds(event.line.loops, dict(equations.sizes)):
        yield tuple(int(one.value(own)) for one in event.line.indices)


def rounds(loops: Sequence[Loop], known: dict[str, int]) -> Iterator[dict[str, int]]:
    """The values of the indices of loops."""
    if not loops:
        yield known
        return
    loop = loops[0]
    for value in range(int(loop.start.value(known)), int(loop.stop.value(known)), loop.step):
        inner = {**known, loop.index: value}
        if all(holds(one, inner) for one in loop.conditions):
            yield from rounds(loops[1:], inner)


def functions(equations: FamilyEquations, writer: ModuleWriter) -> list[str]:
    """The expressions of the events, and for each family that sets something the state after one of them."""
    families = families_of(equations)
    purpose = "What becomes 0 at each of EVENTS, in one of DIRECTIONS."
    found = [
        writer.vector(
            "events", purpose, [one.line for one in equations.events], among=families, places=PLACES
        )
    ]
    for family in families:
        lines = [one for one in equations.events if one.line.family is family and one.changes]
        if lines:
            found.append(after(family, lines, writer))
    return found


def after(family: Family, lines: Sequence[EventLine], writer: ModuleWriter) -> str:
    """A function that returns q, v and parameters after an event of a family, whose indices are its place."""
    body: list[str] = []
    for one in lines:
        heads, indent = writer.loops(one.line.loops)
        if family.shape:
            own = ", ".join(python_index(index.text) for index in one.line.indices)
            heads.append(f"{indent}if ({own}{',' * (len(family.shape) == 1)}) == tuple(place):")
            indent += "    "
        body += heads
        for change in one.changes:
            body += assigned(change, indent, writer)
    place, label = ("place, ", f"{family.label} at a place") if family.shape else ("", family.name)
    named = writer.names("\n".join(body))
    return "\n".join(
        [
            f"def after_{writer.notation.symbol(family.name)}({place}{SIGNATURE}):",
            f'    """q, v and parameters after the event {label}, of those before."""',
            *named,
            "    q, v, parameters = [*q], [*v], {**parameters}",
            *body,
            "    return tuple(q), tuple(v), parameters",
        ]
    )


def assigned(change: Change, indent: str, writer: ModuleWriter) -> list[str]:
    """What sets a value, for all that the loops run through."""
    found, indent = writer.loops(change.loops, indent)
    base, indices = KNOWN.get(change.symbol.name, (change.symbol.name, ()))
    return [*found, f"{indent}{target(base, indices, writer)} = {writer.text(change.value)}"]


def target(base: str, indices: Sequence[Whole], writer: ModuleWriter) -> str:
    """Where a coordinate, a velocity or a parameter is."""
    first = 0
    for family in writer.equations.coordinates:
        for array, name in (("q", family.name), ("v", velocity_name(family.name))):
            if base == name:
                return f"{array}[{placed(first, family, indices)}]"
        first += prod(family.shape)
    inside = ",".join(f"{{{python_index(one.text)}}}" for one in indices)
    return f"parameters[f'{base}[{inside}]']" if indices else f"parameters[{base!r}]"


def placed(first: int, family: Family, indices: Sequence[Whole]) -> str:
    """Where a member of a family is, whose first member is at ``first``."""
    if not indices:
        return str(first)
    inside, *others = (python_index(one.text) for one in indices)
    for size, index in zip(family.shape[1:], others):
        inside = f"({inside})*{size} + {index}"
    return f"{first} + {inside}" if first else inside
