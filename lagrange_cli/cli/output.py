"""Where the result of a command goes, and what is shown of it."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from lagrange_cli.cli.console import STANDARD_INPUT, stem
from lagrange_cli.errors import FileError, UsageError
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.records import dataclass, replace
from lagrange_cli.run.request import CSV, ENDINGS, HDF5, Request, format_of

if TYPE_CHECKING:
    from lagrange_cli.store.target import Target

STANDARD_OUTPUT = "-"


@dataclass(frozen=True)
class Invocation:
    """What the command line asks for: a run, the name of its output, if it has one, and what is shown."""

    request: Request
    output: str | None = None
    force: bool = False
    as_json: bool = False
    quiet: bool = False
    timings: bool = False

    @property
    def streams(self) -> bool:
        """Whether the result goes to standard output."""
        return self.output == STANDARD_OUTPUT


def options_given(request: Request) -> dict[str, str]:
    """The options that the result depends on as they were given, by what they set."""
    given: dict[str, object] = {**request.times}
    given |= {name: getattr(request.options, name) for name in ("samples", "method", "tolerance")}
    given["outputs"] = None if request.options.outputs is None else ",".join(request.options.outputs)
    given["precision"] = None if request.precision == DOUBLE else request.precision
    given["format"] = request.format
    shown = {name: f"--{name} {value}" for name, value in given.items() if value is not None}
    if request.portable:
        shown["portable"] = "--portable"
    if request.proven:
        shown["proven"] = "--proven"
    for option, pairs in (("set", request.overrides), ("size", request.sizes)):
        shown |= {f"{option} {name}": f"--{option} {name}={text}" for name, text in pairs.items()}
    return shown


def refuse_tables(asked: Invocation, what: str) -> None:
    """Raise ``UsageError`` unless the output is an HDF5 file, as that of a ``what`` must be."""
    if format_of(asked.output) != HDF5:
        raise UsageError(f"a {what} is written as HDF5: give --output a name that ends in .h5")
    if asked.streams:
        raise UsageError(f"a {what} cannot be written to standard output: give --output a name")


def with_format(asked: Invocation, form: str | None) -> Invocation:
    """What is asked for, written in the format of that name, or of the output's.

    Raises ``UsageError`` where a table cannot have what is asked.
    """
    form = format_of(asked.output, form)
    if form == CSV and asked.request.resume:
        raise UsageError("--resume needs an HDF5 output: a CSV file stores no checkpoint")
    if form == CSV and asked.streams and asked.as_json:
        raise UsageError("--json and the table would both go to standard output: give --output a name")
    return replace(asked, request=replace(asked.request, format=form))


def standard_output() -> BinaryIO:
    """Standard output for a table; raises ``FileError`` where there is none."""
    if sys.stdout is None or sys.stdout.closed:
        raise FileError("standard output is closed: give --output a name")
    return sys.stdout.buffer


def output_name(system: str, output: str | None, suffix: str = "", format: str = HDF5) -> str:
    """The file a system is written to."""
    return f"{stem(system)}{suffix}{ENDINGS[format]}" if output is None else output


def check_apart(name: str, *sources: object) -> None:
    """Raise ``UsageError`` where the output is one of the files that are read, under whatever name."""
    for one in sources:
        if (
            isinstance(one, str)
            and os.path.isfile(name)
            and os.path.isfile(one)
            and os.path.samefile(name, one)
        ):
            raise UsageError(f"{name} is read by this command: give --output another name")


def find_output(
    system: str, name: str, asked: Invocation, options: Mapping[str, str], table: object = None
) -> Target:
    """The output, checked before any work is done. ``options`` are the command's own, beyond the request's;
    ``table`` may name a file that it reads besides the system.

    Raises ``UsageError`` and ``FileError`` where nothing can, or may, be written.
    """
    from lagrange_cli.store.find_target import find_target
    from lagrange_cli.store.notes import Origin
    from lagrange_cli.store.target import Target

    request = asked.request
    if name == STANDARD_OUTPUT and request.format == HDF5:
        raise UsageError("HDF5 cannot go to standard output: add --format csv, or give --output a name")
    if name == STANDARD_OUTPUT:
        return Target("to standard output", Path(name), force=True)
    made_by = None
    if system != STANDARD_INPUT:
        given = {**options, **options_given(request)}
        made_by = Origin(os.path.realpath(system), given, time.monotonic(), request.cache)
    check_apart(name, system, table)
    return find_target(name, force=asked.force, resume=request.resume, origin=made_by)
