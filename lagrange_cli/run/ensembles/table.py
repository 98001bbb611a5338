"""Tables of members: comma-separated values, a name over each column and a row for each member."""

from __future__ import annotations

import csv
import math
import re
import sys
from array import array
from collections.abc import Iterator
from typing import TYPE_CHECKING, TextIO

import numpy as np

from lagrange_cli.errors import FileError, UsageError
from lagrange_cli.expression.reals import SMALLEST, TOO_SMALL, underflows
from lagrange_cli.limits import way_out, whole
from lagrange_cli.run.source import STANDARD_INPUT, count_of, display_name

if TYPE_CHECKING:
    from numpy.typing import NDArray

LONGEST = 1_000_000
"""Characters of a line."""


def read_table(name: str) -> dict[str, NDArray[np.float64]]:
    """The columns (rows,) of a table, by the names in its first line.

    Empty lines, and lines that begin with ``#``, are left out.

    Raises:
        FileError: it cannot be read.
        UsageError: it is no such table; the message gives the line.
    """
    shown = display_name(name)
    try:
        if name == STANDARD_INPUT:
            return read_columns(sys.stdin, shown)
        with open(name, encoding="utf-8-sig", newline="") as file:
            return read_columns(file, shown)
    except UnicodeDecodeError as error:
        raise UsageError(f"{shown} is not a table: it is not UTF-8 text") from error
    except OSError as error:
        raise FileError(f"{shown} could not be read: {error.strerror or error}") from error
    except ValueError as error:  # a NUL in the name
        raise FileError(f"{shown!r} could not be read: {error}") from error


def read_columns(file: TextIO, shown: str) -> dict[str, NDArray[np.float64]]:
    """The columns of an open table, which messages call ``shown``."""
    reader = csv.reader(lines_of(file, shown), skipinitialspace=True, strict=True)
    lines = rows_of(reader, shown)
    first, header = next(lines, (0, []))
    names = [cell.strip() for cell in header]
    if not names:
        raise UsageError(f"{shown} is empty: the first line must name the columns, as in 'omega,theta'")
    if len(names) == 1 and len(re.split(r"[;\s]", names[0])) > 1:
        raise UsageError(f"{shown}:{first}: separate the columns by commas, as in 'omega,theta'")
    seen = set[str]()
    for name in names:
        if not name:
            raise UsageError(f"{shown}:{first}: a column has no name")
        if name in seen:
            raise UsageError(f"{shown}:{first}: two columns are called '{name[:100]}'")
        seen.add(name)
    most = whole("runs")
    columns = [array("d") for _ in names]
    for line, row in lines:
        if len(columns[0]) == most:
            raise UsageError(f"{shown}:{line}: more than {most} rows: use fewer, {way_out('runs')}")
        if len(row) != len(names):
            raise UsageError(f"{shown}:{line}: expected {count_of(len(names), 'value')}, found {len(row)}")
        for name, column, cell in zip(names, columns, row):
            column.append(number(cell, f"{shown}:{line}: {name}"))
    if not columns[0]:
        raise UsageError(f"{shown} has no rows: each line after the first is a member")
    return {name: np.array(column) for name, column in zip(names, columns)}


def lines_of(file: TextIO, shown: str) -> Iterator[str]:
    """The lines, of bounded length."""
    while line := file.readline(LONGEST + 1):
        if len(line) > LONGEST:
            raise UsageError(f"{shown} is not a table: a line has more than {LONGEST} characters")
        yield line


def rows_of(reader: Iterator[list[str]], shown: str) -> Iterator[tuple[int, list[str]]]:
    """The rows that hold something, each with the number of its line."""
    while True:
        try:
            row = next(reader)
        except StopIteration:
            return
        except csv.Error as error:
            raise UsageError(f"{shown}:{reader.line_num}: {error}") from error  # type: ignore[attr-defined]
        if any(cell.strip() for cell in row) and not row[0].startswith("#"):
            yield reader.line_num, row  # type: ignore[attr-defined]


def number(cell: str, where: str) -> float:
    """The finite number of a cell."""
    try:
        value = float(cell)
    except ValueError as error:
        raise UsageError(f"{where}: expected a number, not {cell.strip()!r}") from error
    if not math.isfinite(value):
        raise UsageError(f"{where}: {cell.strip()} is not a finite number")
    if underflows(cell):
        raise UsageError(f"{where}: {TOO_SMALL}: {cell.strip()}; {SMALLEST}")
    return value
