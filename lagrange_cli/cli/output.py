"""Where the result of a command goes, and what is shown of it."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from lagrange_cli.cli.console import STANDARD_INPUT, stem
from lagrange_cli.errors import UsageError
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.records import dataclass
from lagrange_cli.run.request import CSV, HDF5, Request

if TYPE_CHECKING:
    from lagrange_cli.store.target import Target

STANDARD_OUTPUT = "-"

ENDINGS = {HDF5: ".h5", CSV: ".csv"}
OTHERS = frozenset(
    (
        ".txt", ".tsv", ".json", ".jsonl", ".yaml", ".yml", ".npy", ".npz", ".mat", ".xls", ".xlsx", ".ods",
        ".parquet", ".feather", ".pkl", ".pickle", ".zarr", ".fits", ".sqlite", ".db", ".png", ".svg", ".pdf",
        ".gif", ".mp4", ".gz", ".bz2", ".xz", ".zst", ".zip", ".tar",
    )
)  # fmt: skip
"""Endings of formats that are not written. Any other ending is taken to be that of an HDF5 file."""


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


def format_of(output: str | None, asked: str | None = None) -> str:
    """The format of an output: the one ``asked`` for with ``--format``, or the one of its name.

    Raises ``UsageError`` if the name ends like that of another format.
    """
    if asked is not None or output is None:
        return asked or HDF5
    stem, ending = os.path.splitext(output)
    if ending.lower() == ENDINGS[CSV]:
        return CSV
    if ending.lower() in OTHERS:
        stem = os.path.splitext(stem)[0] or stem
        raise UsageError(
            f"outputs are HDF5 or CSV, not {ending[1:]}: name the file {stem}.h5 or {stem}.csv "
            "(or say --format, to have it under this name)"
        )
    return HDF5


def output_name(system: str, output: str | None, suffix: str = "", format: str = HDF5) -> str:
    """The file a system is written to."""
    return f"{stem(system)}{suffix}{ENDINGS[format]}" if output is None else output


def find_output(system: str, name: str, asked: Invocation, options: Mapping[str, str]) -> Target:
    """The output, checked before any work is done. ``options`` are the command's own, beyond the request's.

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
    if os.path.isfile(name) and os.path.isfile(system) and os.path.samefile(name, system):
        raise UsageError(f"{name} is the system file itself: give --output another name")
    return find_target(name, force=asked.force, resume=request.resume, origin=made_by)
