"""What the readers of the section ``draw`` take."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from lagrange_cli.run.schema.forms import (
    NAME,
    NOTHING,
    SCALAR,
    VECTOR,
    Schema,
    any_of,
    listed,
    named,
    text_of,
)
from lagrange_cli.spec.draw.colours import HEXADECIMAL, NAMES
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
