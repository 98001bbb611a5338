"""Systems by their names, as users write them, and words about them in messages."""

from __future__ import annotations

import os

from lagrange_cli.errors import FileError, UsageError
from lagrange_cli.limits import whole

STANDARD_INPUT = "-"
MOST_FILES = 1000
"""The files of a folder that are looked through for one that was meant."""
ENDINGS = (".yaml", ".yml")
ALIKE = 0.8
"""The part of its letters that a name has in common with the file that was meant."""


def display_name(system: str) -> str:
    """The name under which messages speak of a system, or of a table."""
    return "<stdin>" if system == STANDARD_INPUT else system


def count_of(number: int, noun: str) -> str:
    """``1 step``, ``2 steps``."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def read_file(system: str) -> bytes:
    """The content of the file, up to one byte more than the reader accepts.

    Raises ``FileError`` where it cannot be read, ``UsageError`` where this is not the name of a file.
    """
    try:
        with open(system, "rb") as file:
            return file.read(whole("bytes") + 1)
    except FileNotFoundError as error:
        hint = shipped_hint(system) or neighbour_hint(system)
        raise FileError(f"{system}: no such file{hint}") from error
    except OSError as error:
        if os.path.isdir(system):  # no permission to read it is what Windows says
            raise FileError(f"{system} is a directory, not a system file") from error
        raise FileError(f"{system} could not be read: {error.strerror or error}") from error
    except ValueError as error:  # a NUL in the name
        raise UsageError(f"{system!r} is not the name of a file: {error}") from error


def neighbour_hint(system: str) -> str:
    """The file of its folder that was meant, as ``a.yaml`` for ``a.yml`` or ``a``, or an empty text."""
    from itertools import islice

    from lagrange_cli.expression.near import near_match

    folder, name = os.path.split(system)
    try:
        with os.scandir(folder or os.curdir) as entries:
            files = [entry.name for entry in islice(entries, MOST_FILES) if entry.is_file()]
    except OSError:
        return ""
    whole = next((one for one in files if os.path.splitext(one)[0] == name and one.endswith(ENDINGS)), "")
    near = whole or near_match(name, files, ALIKE)
    return f"\n  did you mean {os.path.join(folder, near)}?" if near else ""


def shipped_hint(system: str) -> str:
    """How to get the shipped system that was perhaps meant, or an empty text."""
    from lagrange_cli.run import shipped

    name = os.path.splitext(os.path.basename(system))[0]
    if name not in shipped.names():
        return ""
    return f"\n  there is an example system of that name: lagrange systems {name} > {name}.yaml"
