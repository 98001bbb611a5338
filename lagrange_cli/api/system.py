"""Systems as arguments: the name of a file, its text, or a mapping."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, TypeAlias

from lagrange_cli.errors import UsageError
from lagrange_cli.run.source import read_file

System: TypeAlias = "str | os.PathLike[str] | Mapping[str, Any]"
"""The name of a system file; its content as text, with several lines, or a key and its value; or its content
as a mapping, as ``yaml.safe_load`` makes it."""

TEXT, MAPPING = "<text>", "<mapping>"
"""The name in messages of a system without a file."""


def content_of(system: System) -> tuple[bytes, str]:
    """The content of the system file, and what messages call it.

    Raises:
        FileError: it cannot be read.
        UsageError: this is no system.
    """
    if isinstance(system, Mapping):
        return as_yaml(as_json(system)), MAPPING
    if isinstance(system, str) and not system.strip():
        raise UsageError("the text of the system is empty: give the name of a file, or its content")
    if isinstance(system, str) and is_text(system):
        return system.encode("utf-8", "surrogatepass"), TEXT
    if isinstance(system, (str, os.PathLike)):
        name = os.fspath(system)
        if isinstance(name, str):
            return read_file(name), name
    raise UsageError(
        "a system is the name of a file, its content as text, or its content as a mapping, not "
        f"{type(system).__name__}"
    )


def is_text(system: str) -> bool:
    """Whether this is the content of a file and not its name."""
    written = "\n" in system or system.lstrip().startswith("{") or ": " in system
    return written and not ("\n" not in system and os.path.isfile(system))


def as_json(system: Mapping[str, Any]) -> str:
    """A mapping as JSON, by which it is recognized."""
    try:
        return json.dumps(system, default=plain)
    except (TypeError, ValueError, RecursionError) as error:
        raise UsageError(f"this mapping is not a system: {error}") from error


def plain(value: Any) -> Any:
    """A value that JSON does not know, as one that it knows: numpy's numbers and arrays, other mappings."""
    if isinstance(value, Mapping):
        return dict(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(
        f"it has a value of type {type(value).__name__}; write expressions as text, as in 'm*g*y' or str(...)"
    )


@lru_cache(maxsize=64)
def as_yaml(written: str) -> bytes:
    """JSON as a system file that is pleasant to read where a message shows a line of it."""
    import yaml

    content = json.loads(written)
    return bytes(yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=10**6, encoding="utf-8"))
