"""Parts of JSON Schemas that are written again and again: names, numbers, lists, choices."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from lagrange_cli.expression.scan import WORDS

Schema = Mapping[str, Any]

SIGNS = r"\s!-/:-@\[-^`{-~"
"""What no name has in it, within brackets: white space, and ASCII's signs but the underscore. Letters are
those of any alphabet, which the ``\\w`` of editors are not."""
NAME = rf"^\s*[^0-9{SIGNS}][^{SIGNS}]*\s*$"
FAMILY = rf"^\s*[^0-9{SIGNS}][^{SIGNS}]*\s*(\[[\s\S]+\])?\s*$"
"""A name, or members of a family: ``theta[i in range(N)]``."""

CONTROL_FREE = r"^[^\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]*$"
"""Text without characters that a terminal would obey."""
TEXT: Schema = {"type": ["string", "number", "boolean", "null"], "pattern": CONTROL_FREE}
SCALAR: Schema = {"type": ["number", "string"], "pattern": r"\S"}
NOTHING: Schema = {"type": "null"}


def any_of(*choices: Schema) -> dict[str, Any]:
    """One of them, or of those that they choose from."""
    flat = [one for each in choices for one in (each["anyOf"] if [*each] == ["anyOf"] else [each])]
    return {"anyOf": flat}


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
