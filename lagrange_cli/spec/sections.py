"""Nodes to a ``Draft``: each section is read on its own, with one table of keys per section.

A key of the system file is one entry here and one field of ``Draft``. Only the form is judged: what names
mean, and whether they exist, is ``spec.check``'s business.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from lagrange_cli.expression.confusions import STATE, meant_key
from lagrange_cli.expression.near import known_hint, near_match, shown
from lagrange_cli.expression.parse import read
from lagrange_cli.expression.syntax import Key, Span, Vector
from lagrange_cli.expression.vocabulary import VELOCITY_SUFFIX
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.spec import nodes
from lagrange_cli.spec.fields import (
    Reader,
    read_count,
    read_key,
    read_list,
    read_number,
    read_scalar,
    read_text,
    read_vector,
    read_words,
    unreadable,
    words_of,
)
from lagrange_cli.spec.nodes import Node, Scalar
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.source import Passage, Place
from lagrange_cli.spec.spec import Expression, Family


@dataclass(frozen=True)
class Written:
    """Something of a section that has a name: ``key`` is what was written, in ``passage``.

    Before families are written out ``name`` is that of the family, then that of the member.
    """

    name: str
    place: Place
    key: Key
    passage: Passage | None

    def at(self, span: Span) -> Place:
        """The place of a piece of the key."""
        return self.place if self.passage is None else self.passage.place(span)


@dataclass(frozen=True)
class Entry(Written):
    """``name: expression`` of a section; ``value`` is None where the expression could not be read."""

    value: Expression | None = None

    def member(self, name: str, indices: Mapping[str, int]) -> Entry:
        """The entry of one member."""
        return replace(self, name=name, value=_with(self.value, indices))


@dataclass(frozen=True)
class Declared(Written):
    """A parameter or a coordinate: its name, and the fields given for it."""

    fields: Mapping[str, Any] = field(default_factory=dict)

    def member(self, name: str, indices: Mapping[str, int]) -> Declared:
        """The declaration of one member."""
        return replace(self, name=name, fields={key: _with(x, indices) for key, x in self.fields.items()})


def _with(value: Any, indices: Mapping[str, int]) -> Any:
    return replace(value, indices=indices) if isinstance(value, Expression) else value


@dataclass(frozen=True)
class Draft:
    """A system file's sections as written, before any name has been looked up.

    ``places`` has the place of each section's key; ``families`` and ``indices`` (of keys, with their places)
    are known once families are written out.
    """

    places: Mapping[str, Place]
    positions: str = "positions"
    """The word that the file has for ``embedding``."""
    strange: bool = False
    """Whether there are unknown sections, which may be meant to be those that are missing."""
    name: str = ""
    description: str = ""
    sizes: tuple[Entry, ...] = ()
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
    time: str = ""
    solve: Mapping[str, Any] = field(default_factory=dict)
    solve_places: Mapping[str, Place] = field(default_factory=dict)
    families: Mapping[str, Mapping[str, Family]] = field(default_factory=dict)
    indices: tuple[tuple[str, Place], ...] = ()


def read_draft(root: Node, problems: Problems) -> Draft:
    """The sections of the file; whatever is wrong with their form is added to ``problems``."""
    if not isinstance(root, nodes.Mapping):
        problems.add(
            root.place, "a system file is a list of sections, 'key: value'", known_hint(SECTIONS, limit=8)
        )
        problems.stop_if_any()
        raise AssertionError("unreachable")
    sections = _read_table(root, SECTIONS, "", problems)
    places = {ALIASES.get(key.text, key.text): key.place for key, _ in root.entries}
    if any(meant_key("", key.text)[1] == STATE for key, _ in root.entries if key.text not in SECTIONS):
        sections["coordinates"] = tuple(  # their initial values are not missing
            replace(one, fields={"initial": unreadable(one.place, problems), **one.fields})
            for one in sections.get("coordinates", ())
        )
    solve = next((node for key, node in root.entries if key.text == "solve"), None)
    inner = solve.entries if isinstance(solve, nodes.Mapping) else ()
    meant = [(meant_key("solve", key.text)[0] or key.text, key, node) for key, node in inner]
    solve_places = {name if key.text not in SOLVE else key.text: node.place for name, key, node in meant}
    for name, _, node in meant:
        if name == "outputs":
            solve_places |= {f"outputs {word}": place for word, place in words_of(node)}
    word = next((key.text for key, _ in root.entries if key.text in ("embedding", *ALIASES)), "positions")
    strange = any(key.text not in (*SECTIONS, *ALIASES) for key, _ in root.entries)
    return Draft(places=places, positions=word, strange=strange, **sections, solve_places=solve_places)


def _entries(
    reader: Reader, what: str, free: bool = False, families: bool = True
) -> Callable[[Node, str, Problems], tuple[Entry, ...]]:
    """A section of ``name: expression``; the names may be ``free`` texts, and stand for ``families``."""

    def read(node: Node, where: str, problems: Problems) -> tuple[Entry, ...]:
        if isinstance(node, Scalar) and node.empty:
            return ()
        if not isinstance(node, nodes.Mapping):
            hint = f"write '{where}: {{{EXAMPLES.get(where, 'NAME: ...')}}}'"
            problems.add(node.place, f"{where} must be a mapping with a name for each {what}", hint)
            return ()
        found = []
        for key, value in node.entries:
            name = Key(key.text, key.text) if free else read_key(key, problems, what, families)
            if name is not None:
                expression = reader(value, f"{PHRASES.get(what, what)} '{name.label}'", problems)
                found.append(Entry(name.name, key.place, name, key.passage, expression))
        return tuple(found)

    return read


def _read_potential(node: Node, where: str, problems: Problems) -> tuple[Entry, ...]:
    if isinstance(node, nodes.Mapping):
        return _entries(read_scalar, "potential", free=True)(node, where, problems)
    key = Key("potential", "potential")
    return (Entry(key.name, node.place, key, None, read_scalar(node, where, problems)),)


def _read_parameters(node: Node, where: str, problems: Problems) -> tuple[Declared, ...]:
    if isinstance(node, Scalar) and node.empty:
        return ()
    if not isinstance(node, nodes.Mapping):
        hint = "write 'parameters: {m: 1.0}', or one 'name: value' on each line"
        problems.add(node.place, "parameters must be a mapping with names", hint)
        return ()
    found = []
    for key, value in node.entries:
        name = read_key(key, problems, "parameter")
        if name is None:
            continue
        where = f"parameter '{name.label}'"
        if isinstance(value, nodes.Mapping):
            fields = _read_table(value, PARAMETER, where, problems)
            if all(inner.text != "value" for inner, _ in value.entries):
                problems.add(key.place, f"{where} has no value", "write {value: 1.0}")
        else:
            fields = {"value": read_list(value, where, problems)}
        found.append(Declared(name.name, key.place, name, key.passage, fields))
    return tuple(found)


def _initial_of(node: Node) -> str:
    """What stands where ``{initial: ...}`` should, if it is an initial value, or an example of one."""
    text = node.text if isinstance(node, Scalar) else ""
    value, mistakes = read(text)
    return "0.1" if mistakes or isinstance(value, Vector) or len(text) > _SHORT else text


_SHORT = 30


def _read_coordinates(node: Node, where: str, problems: Problems) -> tuple[Declared, ...]:
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
                fields = _read_table(value, COORDINATE, f"coordinate '{label}'", problems)
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
    return tuple(found)


def _read_solve(node: Node, where: str, problems: Problems) -> Mapping[str, Any]:
    if isinstance(node, Scalar) and node.empty:
        return {}
    if not isinstance(node, nodes.Mapping):
        problems.add(node.place, "solve must be 'key: value'", known_hint(SOLVE))
        return {}
    return _read_table(node, SOLVE, "solve", problems)


def _read_time(node: Node, where: str, problems: Problems) -> str:
    """The unit of t: ``time: d`` or ``time: {unit: d}``."""
    if isinstance(node, nodes.Mapping):
        return str(_read_table(node, TIME, where, problems).get("unit", ""))
    return read_text(node, where, problems)


def _read_table(
    node: nodes.Mapping, table: Mapping[str, Reader], where: str, problems: Problems
) -> dict[str, Any]:
    """Each key by the reader its table has for it; an unknown one as the key that was probably meant."""
    found: dict[str, Any] = {}
    written = {ALIASES.get(key.text, key.text) for key, _ in node.entries}
    for key, value in node.entries:
        name = ALIASES.get(key.text, key.text) if table is SECTIONS else key.text
        if name not in table:
            name = _unknown_key(key, value, table, where, problems)
            if name in written:
                name = ""
            if not name and isinstance(value, nodes.Mapping):  # what it declares may be used elsewhere
                problems.broken |= {inner.text.partition("[")[0].strip() for inner, _ in value.entries}
        elif name in found:
            message = "'embedding' and 'positions' are two words for the same section"
            problems.add(key.place, message, "leave one of them out")
            found[name] += table[name](value, key.text, problems)
            name = ""
        if name:
            label = key.text if key.text in ALIASES else name
            found[name] = table[name](value, f"{label} of {where}" if where else label, problems)
    return found


def _unknown_key(
    key: Scalar, value: Node, table: Mapping[str, Reader], where: str, problems: Problems
) -> str:
    """Note an unknown key; the key that was meant, or nothing."""
    text = key.text
    if table is SECTIONS and text in LATER:
        problems.add(key.place, f"'{text}' is not supported yet", LATER[text])
        return ""
    if text.isdecimal() and isinstance(value, Scalar) and value.text == "":
        meant, hint = "", "a decimal point is a point: write 0.5, not 0,5"
    elif table is COORDINATE and text.endswith(VELOCITY_SUFFIX):
        meant, hint = "velocity", "write 'velocity'"
    else:
        meant, hint = meant_key("" if table is SECTIONS else where.partition(" ")[0], text)
    if not hint:
        meant = near_match(text, [*table, *(ALIASES if table is SECTIONS else ())])
        meant = ALIASES.get(meant, meant)
        hint = f"did you mean '{meant}'?" if meant else known_hint(table)
    problems.add(key.place, f"unknown key {shown(text)}{f' in {where}' if where else ''}", hint)
    return meant


ALIASES = {"positions": "embedding"}
"""Other words for sections."""
EXAMPLES = {
    "masses": "bob: m", "embedding": "bob: [x, y]", "positions": "bob: [x, y]", "forces": "bob: [0, -m*g]",
    "generalized_forces": "theta: -c*theta_dot", "definitions": "omega: sqrt(g/l)", "sizes": "N: 10",
    "observables": "height: bob.y",
}  # fmt: skip
"""What a section may look like."""
PHRASES = {"mass": "mass of", "position": "position of", "force": "force on"}
"""What is said before the name of something, where it is more than what it is."""
PARAMETER: dict[str, Reader] = {"value": read_list, "unit": read_text, "description": read_text}
COORDINATE: dict[str, Reader] = {
    "initial": read_scalar,
    "velocity": read_scalar,
    "unit": read_text,
    "description": read_text,
}
TIME: dict[str, Reader] = {"unit": read_text}
SOLVE: dict[str, Reader] = {
    "start": read_number,
    "stop": read_number,
    "samples": read_count,
    "step": read_number,
    "method": read_text,
    "tolerance": read_number,
    "outputs": read_words,
    "unit": read_text,
}
SECTIONS: dict[str, Reader] = {
    "name": read_text,
    "description": read_text,
    "parameters": _read_parameters,
    "sizes": _entries(read_scalar, "size", families=False),
    "coordinates": _read_coordinates,
    "definitions": _entries(read_vector, "definition"),
    "masses": _entries(read_scalar, "mass"),
    "embedding": _entries(read_vector, "position"),
    "potential": _read_potential,
    "lagrangian": read_scalar,
    "forces": _entries(read_vector, "force"),
    "generalized_forces": _entries(read_scalar, "generalized force"),
    "dissipation": read_scalar,
    "observables": _entries(read_scalar, "observable"),
    "time": _read_time,
    "solve": _read_solve,
}
LATER: dict[str, str] = {
    "bodies": "describe a rigid body by point masses, or give 'lagrangian' instead",
    "constraints": "choose coordinates that satisfy the constraint",
    "nonholonomic": "only unconstrained and holonomic systems in their own coordinates are solved for now",
    "events": "write the quantity under 'observables' and look for its zeros in the output",
}
"""Sections that are not supported yet, and what can be done instead."""
