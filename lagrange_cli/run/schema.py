"""A JSON Schema of system files, made of the tables by which they are read.

Editors complete and check keys with it. It knows the structure of a file, not what its expressions mean: what
it refuses is refused by ``check``, which finds more. It is of draft 7, which editors know best.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

from lagrange_cli.expression.scan import WORDS
from lagrange_cli.integrate.methods.table import AUTO, METHODS
from lagrange_cli.outputs.catalog import OUTPUTS
from lagrange_cli.run.settings import ALL
from lagrange_cli.spec.body_readers import (
    FORMS,
    NEEDED,
    is_sequence,
    read_bodies,
    read_inertia,
    read_orientation,
    read_solid,
)
from lagrange_cli.spec.colours import HEXADECIMAL, NAMES
from lagrange_cli.spec.draw_readers import ALL as ALL_OF_THEM
from lagrange_cli.spec.draw_readers import (
    AXES,
    NONE,
    read_colours,
    read_degrees,
    read_lines,
    read_names,
    read_part,
    read_point,
    read_points,
    read_up,
)
from lagrange_cli.spec.draw_table import DRAW
from lagrange_cli.spec.event_readers import (
    DIRECTIONS,
    RECORD,
    STOP,
    read_action,
    read_changes,
    read_direction,
    read_events,
    read_when,
)
from lagrange_cli.spec.fields import (
    Reader,
    read_count,
    read_list,
    read_number,
    read_scalar,
    read_text,
    read_vector,
    read_words,
)
from lagrange_cli.spec.range_readers import AT, THROUGH, read_curves, read_range, read_sliders
from lagrange_cli.spec.readers import (
    Entries,
    Single,
    Terms,
    read_coordinates,
    read_draw,
    read_parameters,
    read_solve,
    read_time,
)
from lagrange_cli.spec.sections import SECTIONS
from lagrange_cli.spec.spec import SOLIDS
from lagrange_cli.spec.table import Rare, Row, Table
from lagrange_cli.spec.transformations import read_transformations
from lagrange_cli.spec.vanishing import read_vanishing

Schema = Mapping[str, Any]

SIGNS = r"\s!-/:-@\[-^`{-~"
"""What no name has in it, within brackets: white space, and ASCII's signs but the underscore. Letters are
those of any alphabet, which the ``\\w`` of editors are not."""
NAME = rf"^\s*[^0-9{SIGNS}][^{SIGNS}]*\s*$"
FAMILY = rf"^\s*[^0-9{SIGNS}][^{SIGNS}]*\s*(\[[\s\S]+\])?\s*$"
"""A name, or members of a family: ``theta[i in range(N)]``."""
UNKNOWN: Schema = {}
"""Of a reader of which nothing is said here."""

CONTROL_FREE = r"^[^\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]*$"
"""Text without characters that a terminal would obey."""
TEXT: Schema = {"type": ["string", "number", "boolean", "null"], "pattern": CONTROL_FREE}
SCALAR: Schema = {"type": ["number", "string"], "pattern": r"\S"}
NOTHING: Schema = {"type": "null"}


def schema() -> dict[str, Any]:
    """The schema, in terms of JSON."""
    whole = of_table(SECTIONS)
    particles = ("masses", "embedding", "positions", "bodies", "potential", "torques")
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "lagrange system file",
        "description": "A mechanical system: coordinates, parameters, masses and forces, or a Lagrangian.",
        **whole,
        "required": ["coordinates"],
        "anyOf": [{"required": [key]} for key in ("lagrangian", "masses", "bodies")],
        "dependencies": {"lagrangian": {"not": {"anyOf": [{"required": [key]} for key in particles]}}},
    }


def of_table(table: Table) -> dict[str, Any]:
    """A mapping with the keys of a table."""
    properties = {word: of_row(row) for word, row in table.by_word.items()}
    twice = [{"required": [row.key, row.alias]} for row in table.rows if row.alias]
    return {
        "type": "object",
        "properties": properties,
        "additionalProperties": False,
        **({"not": {"anyOf": twice}} if twice else {}),
    }


def of_row(row: Row) -> dict[str, Any]:
    """The value of a key, with its meaning."""
    return {"description": plain(row.meaning), **enriched(row, of_reader(row.read))}


def enriched(row: Row, found: Schema) -> Schema:
    """What is known of a value beyond its form: the methods and the outputs that there are."""
    if row.key == "method":
        methods = [AUTO, *METHODS]
        named = "|".join(map(any_case, methods))
        return any_of({"enum": methods}, {"type": "string", "pattern": rf"^\s*({named})\s*$"}, NOTHING)
    if row.key == "outputs":
        names = [*OUTPUTS, ALL, "t"]
        word = f"({'|'.join(names)})"
        several = {"type": "string", "pattern": rf"^[\s,]*{word}(\s*,\s*{word})*[\s,]*$"}
        one = any_of({"enum": names}, several)
        return any_of(one, {"type": "array", "items": one}, NOTHING)
    return found


def any_case(word: str) -> str:
    """A pattern for a word in any case of letters."""
    return "".join(f"[{x.lower()}{x.upper()}]" if x.isalpha() else x for x in word)


def plain(meaning: str) -> str:
    """Markdown without links."""
    return re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", meaning)


def of_reader(reader: Reader) -> Schema:
    """What a reader takes."""
    if isinstance(reader, Rare):
        return of_reader(reader.loaded())
    if isinstance(reader, partial):
        read = reader.func.loaded() if isinstance(reader.func, Rare) else reader.func
        return TABLES[read](reader.args[0]) if read in TABLES else UNKNOWN
    if isinstance(reader, Entries):
        return any_of(entries(of_reader(reader.value), reader), NOTHING)
    if isinstance(reader, Terms):
        return any_of(SCALAR, {"type": "object", "additionalProperties": SCALAR})
    if isinstance(reader, Single):
        return SCALAR
    return READERS.get(reader, UNKNOWN)


def any_of(*choices: Schema) -> dict[str, Any]:
    """One of them, or of those that they choose from."""
    flat = [one for each in choices for one in (each["anyOf"] if [*each] == ["anyOf"] else [each])]
    return {"anyOf": flat}


def entries(value: Schema, reader: Entries) -> dict[str, Any]:
    """A mapping of names to values."""
    return named(value) if not reader.free and reader.families else named(value, NAME)


def named(value: Schema, names: str = FAMILY) -> dict[str, Any]:
    """A mapping of names to values; words of sums and conditions are no names."""
    allowed = {"pattern": names, "not": {"enum": sorted(WORDS)}}
    return {"type": "object", "propertyNames": allowed, "additionalProperties": value}


def listed(item: Schema, *counts: int) -> dict[str, Any]:
    """A list of so many items."""
    return {"type": "array", "items": item, "minItems": min(counts), "maxItems": max(counts)}


def text_of(words: Iterable[str]) -> dict[str, Any]:
    """One of the words."""
    return {"enum": [*words]}


VECTOR = any_of(SCALAR, listed(SCALAR, 1, 3))
LIST = any_of(SCALAR, {"type": "array", "items": SCALAR, "minItems": 1})
MATRIX = listed(listed(SCALAR, 3), 3)
COUNT: Schema = {"type": ["integer", "string"], "pattern": r"\S"}
WORDS_LISTED = any_of(TEXT, {"type": "array", "items": TEXT})
CHANGES = {**named(SCALAR, r"\S"), "minProperties": 1}


def solid() -> Schema:
    """``{box: [a, b, c]}``."""
    sizes = {
        name: listed(SCALAR, given.count(",") + 1) if given.startswith("[") else SCALAR
        for name, given in SOLIDS.items()
    }
    known = {"type": "object", "properties": sizes, "additionalProperties": False}
    return {**known, "minProperties": 1, "maxProperties": 1}


def orientation() -> Schema:
    """One of its forms; only Euler angles have a sequence."""
    axes = [a + b + c for a in "xyz" for b in "xyz" for c in "xyz" if is_sequence(a + b + c)]
    given = {"euler": listed(SCALAR, 3), "quaternion": listed(SCALAR, 4), "matrix": MATRIX}
    assert given.keys() == FORMS.keys()
    return any_of(
        *(
            {
                "type": "object",
                "properties": {form: value, **({"sequence": text_of(axes)} if form == "euler" else {})},
                "required": [form],
                "additionalProperties": False,
            }
            for form, value in given.items()
        )
    )


def parameters(table: Table) -> Schema:
    """Values by name, each a number, a list or a mapping."""
    return any_of(named(any_of(LIST, {**of_table(table), "required": ["value"]})), NOTHING)


def coordinates(table: Table) -> Schema:
    """Names, or fields by name."""
    known = {**named(any_of(of_table(table), NOTHING)), "minProperties": 1}
    names = {"type": "string", "pattern": FAMILY, "not": {"enum": sorted(WORDS)}}
    return any_of(known, {"type": "array", "items": names, "minItems": 1, "uniqueItems": True})


def bodies(table: Table) -> Schema:
    """Fields by name; the inertia is given as such, or by a solid."""
    body = {
        **of_table(table),
        "required": [*NEEDED],
        "oneOf": [{"required": ["inertia"]}, {"required": ["solid"]}],
    }
    return any_of(named(body), NOTHING)


def events(table: Table) -> Schema:
    """An expression, or fields, by name."""
    return any_of(named(any_of(SCALAR, {**of_table(table), "required": ["when"]})), NOTHING)


def transformations(table: Table) -> Schema:
    """Both keys by name."""
    return any_of(named({**of_table(table), "required": [*table.keys]}, NAME), NOTHING)


def action(table: Table) -> Schema:
    """A word, or what is set."""
    return any_of(text_of((RECORD, STOP)), {**of_table(table), "minProperties": 1})


def times(table: Table) -> Schema:
    """A unit, or a mapping with one."""
    return any_of(TEXT, of_table(table))


def settings(table: Table) -> Schema:
    """The section ``solve``: samples are counted, or apart by a step."""
    return any_of({**of_table(table), "not": {"required": ["samples", "step"]}}, NOTHING)


def several(item: Schema, *words: str) -> dict[str, Any]:
    """A list, a text that is the only item of one, or a word that stands for a list."""
    return any_of(text_of(words), SCALAR, {"type": "array", "items": item}, NOTHING)


POINT = any_of(SCALAR, listed(SCALAR, 1, 3))
LINE = any_of({"type": "string", "pattern": r"\S"}, {"type": "array", "items": POINT, "minItems": 2})
RANGE = listed(SCALAR, 2)


def curves() -> Schema:
    """By name: a point, points, or a mapping with either."""
    path = any_of(
        {"type": "array", "items": POINT, "minItems": 2},
        {"type": "array", "items": {"type": "string", "pattern": " for "}, "minItems": 1, "maxItems": 1},
    )
    running = {**named(any_of(RANGE, NOTHING)), "properties": {AT: VECTOR}, "required": [AT]}
    joined = {"type": "object", "properties": {THROUGH: any_of(path, SCALAR, NOTHING)}, "required": [THROUGH]}
    at = {**running, "maxProperties": 3, "not": {"required": [THROUGH]}}
    return any_of(
        text_of((NONE,)),
        NOTHING,
        named(any_of(VECTOR, path, at, {**joined, "additionalProperties": False}), NAME),
    )


def part(table: Table) -> Schema:
    """A mapping with keys of its own."""
    return any_of(of_table(table), NOTHING)


COLOUR = any_of(text_of(sorted(NAMES)), {"type": "string", "pattern": rf"^\s*{HEXADECIMAL}\s*$"})
TABLES: dict[Callable[..., Any], Callable[[Table], Schema]] = {
    read_action: action,
    read_bodies: bodies,
    read_coordinates: coordinates,
    read_events: events,
    read_parameters: parameters,
    read_part: part,
    read_solve: settings,
    read_time: times,
    read_transformations: transformations,
}
READERS: dict[Callable[..., Any], Schema] = {
    read_changes: CHANGES,
    read_colours: any_of(named(COLOUR), NOTHING),
    read_count: COUNT,
    read_curves: curves(),
    read_degrees: SCALAR,
    read_direction: text_of(DIRECTIONS),
    read_inertia: any_of(listed(SCALAR, 3), MATRIX),
    read_lines: several(LINE, NONE),
    read_list: LIST,
    read_names: several(POINT, ALL_OF_THEM, NONE),
    read_number: SCALAR,
    read_orientation: orientation(),
    read_point: VECTOR,
    read_points: several(POINT, NONE),
    read_range: RANGE,
    read_scalar: SCALAR,
    read_sliders: any_of(named(RANGE), NOTHING),
    read_solid: solid(),
    read_text: TEXT,
    read_up: text_of(AXES),
    read_vanishing: SCALAR,
    read_vector: VECTOR,
    read_when: SCALAR,
    read_words: WORDS_LISTED,
}
"""What each reader takes; a test sees that none is missing."""
READERS[read_draw] = part(DRAW)  # its keys have readers of their own
