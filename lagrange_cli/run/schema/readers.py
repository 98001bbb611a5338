"""What each reader of ``spec`` takes, as a schema."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from lagrange_cli.expression.scan import WORDS
from lagrange_cli.run.schema.forms import (
    FAMILY,
    LIST,
    MATRIX,
    NAME,
    NOTHING,
    SCALAR,
    TEXT,
    VECTOR,
    Schema,
    any_of,
    listed,
    named,
    text_of,
)
from lagrange_cli.spec.bodies.keys import BODY, NEEDED, read_bodies
from lagrange_cli.spec.bodies.readers import FORMS, is_sequence, read_inertia, read_orientation, read_solid
from lagrange_cli.spec.body import SOLIDS
from lagrange_cli.spec.declarations import COORDINATE, PARAMETER, read_coordinates, read_parameters
from lagrange_cli.spec.draw.colours import HEXADECIMAL, NAMES
from lagrange_cli.spec.draw.keys import DRAW, read_draw
from lagrange_cli.spec.draw.ranges import AT, THROUGH, read_curves, read_range, read_sliders
from lagrange_cli.spec.draw.readers import (
    ALL,
    AXES,
    NONE,
    read_colours,
    read_degrees,
    read_lines,
    read_names,
    read_point,
    read_points,
    read_up,
)
from lagrange_cli.spec.events.keys import EVENT, read_events
from lagrange_cli.spec.events.readers import (
    DIRECTIONS,
    RECORD,
    STOP,
    read_action,
    read_changes,
    read_direction,
    read_when,
)
from lagrange_cli.spec.fields import (
    read_count,
    read_list,
    read_number,
    read_scalar,
    read_text,
    read_vector,
    read_words,
)
from lagrange_cli.spec.settings import SOLVE, TIME, read_solve, read_time
from lagrange_cli.spec.table import Table, read_part
from lagrange_cli.spec.transformations import TRANSFORMATION, read_transformations
from lagrange_cli.spec.vanishing import read_vanishing


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


COLOUR = any_of(text_of(sorted(NAMES)), {"type": "string", "pattern": rf"^\s*{HEXADECIMAL}\s*$"})
DRAWING: Mapping[Callable[..., Any], Schema] = {
    read_colours: any_of(named(COLOUR), NOTHING),
    read_curves: curves(),
    read_degrees: SCALAR,
    read_lines: several(LINE, NONE),
    read_names: several(POINT, ALL, NONE),
    read_point: VECTOR,
    read_points: several(POINT, NONE),
    read_range: RANGE,
    read_sliders: any_of(named(RANGE), NOTHING),
    read_up: text_of(AXES),
}

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


def parameters(keys: Schema) -> Schema:
    """Values by name, each a number, a list or a mapping."""
    return any_of(named(any_of(LIST, {**keys, "required": ["value"]})), NOTHING)


def coordinates(keys: Schema) -> Schema:
    """Names, or fields by name."""
    known = {**named(any_of(keys, NOTHING)), "minProperties": 1}
    names = {"type": "string", "pattern": FAMILY, "not": {"enum": sorted(WORDS)}}
    return any_of(known, {"type": "array", "items": names, "minItems": 1, "uniqueItems": True})


def bodies(keys: Schema) -> Schema:
    """Fields by name; the inertia is given as such, or by a solid."""
    body = {**keys, "required": [*NEEDED], "oneOf": [{"required": ["inertia"]}, {"required": ["solid"]}]}
    return any_of(named(body), NOTHING)


def events(keys: Schema) -> Schema:
    """An expression, or fields, by name."""
    return any_of(named(any_of(SCALAR, {**keys, "required": ["when"]})), NOTHING)


def transformations(keys: Schema) -> Schema:
    """Both keys by name."""
    return any_of(named({**keys, "required": [*keys["properties"]]}, NAME), NOTHING)


def action(keys: Schema) -> Schema:
    """A word, or what is set."""
    return any_of(text_of((RECORD, STOP)), {**keys, "minProperties": 1})


def times(keys: Schema) -> Schema:
    """A unit, or a mapping with one."""
    return any_of(TEXT, keys)


def settings(keys: Schema) -> Schema:
    """The section ``solve``: it has a number of samples or a step."""
    return any_of({**keys, "not": {"required": ["samples", "step"]}}, NOTHING)


def part(keys: Schema) -> Schema:
    """A mapping with keys of its own."""
    return any_of(keys, NOTHING)


TABLES: Mapping[Callable[..., Any], Table] = {
    read_bodies: BODY,
    read_coordinates: COORDINATE,
    read_draw: DRAW,
    read_events: EVENT,
    read_parameters: PARAMETER,
    read_solve: SOLVE,
    read_time: TIME,
    read_transformations: TRANSFORMATION,
}
"""The keys within what a reader takes."""
WITH_KEYS: Mapping[Callable[..., Any], Callable[[Schema], Schema]] = {
    read_action: action,
    read_bodies: bodies,
    read_coordinates: coordinates,
    read_draw: part,
    read_events: events,
    read_parameters: parameters,
    read_part: part,
    read_solve: settings,
    read_time: times,
    read_transformations: transformations,
}
"""What a reader takes, from the schema of the keys in it."""
READERS: Mapping[Callable[..., Any], Schema] = {
    **DRAWING,
    read_changes: CHANGES,
    read_count: COUNT,
    read_direction: text_of(DIRECTIONS),
    read_inertia: any_of(listed(SCALAR, 3), MATRIX),
    read_list: LIST,
    read_number: SCALAR,
    read_orientation: orientation(),
    read_scalar: SCALAR,
    read_solid: solid(),
    read_text: TEXT,
    read_vanishing: VECTOR,
    read_vector: VECTOR,
    read_when: SCALAR,
    read_words: WORDS_LISTED,
}
"""The schemas of the other readers; a test checks that none is missing."""
