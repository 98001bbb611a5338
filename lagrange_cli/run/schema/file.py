"""A JSON Schema of system files, made of the tables by which they are read.

Editors complete and check keys with it. It knows the structure of a file, not the meaning of its expressions:
``check`` refuses everything that the schema refuses, and finds more mistakes. It uses draft 7, which editors
know best.
"""

from __future__ import annotations

import re
from functools import partial
from typing import Any

from lagrange_cli.integrate.methods.table import AUTO, METHODS
from lagrange_cli.outputs.catalog import OUTPUTS
from lagrange_cli.run.schema.forms import NAME, NOTHING, SCALAR, Schema, any_of, named
from lagrange_cli.run.schema.readers import READERS, TABLES, WITH_KEYS
from lagrange_cli.run.settings.outputs import ALL
from lagrange_cli.spec.fields import Reader
from lagrange_cli.spec.readers import Entries, Single, Terms
from lagrange_cli.spec.sections import SECTIONS
from lagrange_cli.spec.table import Rare, Row, Table

UNKNOWN: Schema = {}
"""The schema for a reader without one here."""


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
    properties = {
        word: {"description": plain(row.meaning), **enriched(row, of_reader(row.read))}
        for word, row in table.by_word.items()
    }
    twice = [{"required": [row.key, row.alias]} for row in table.rows if row.alias]
    return {
        "type": "object",
        "properties": properties,
        "additionalProperties": False,
        **({"not": {"anyOf": twice}} if twice else {}),
    }


def enriched(row: Row, found: Schema) -> Schema:
    """Further knowledge of a value: the names of methods and of outputs."""
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
    if isinstance(reader, Entries):
        return any_of(entries(of_reader(reader.value), reader), NOTHING)
    if isinstance(reader, Terms):
        return any_of(SCALAR, {"type": "object", "additionalProperties": SCALAR})
    if isinstance(reader, Single):
        return SCALAR
    read, table = reader, TABLES.get(reader)
    if isinstance(reader, partial):
        read, table = reader.func, reader.args[0]
    if table is None:
        return READERS.get(read, UNKNOWN)
    return WITH_KEYS[read](of_table(table)) if read in WITH_KEYS else UNKNOWN


def entries(value: Schema, reader: Entries) -> dict[str, Any]:
    """A mapping of names to values."""
    return named(value) if not reader.free and reader.families else named(value, NAME)
