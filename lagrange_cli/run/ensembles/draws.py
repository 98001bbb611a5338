"""``Draws``: how the members of an ensemble are chosen, and from that to ``Members``."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.decimals import decimal, scientific
from lagrange_cli.errors import UsageError
from lagrange_cli.limits import way_out
from lagrange_cli.records import dataclass
from lagrange_cli.run.ensembles.members import (
    LOGNORMAL,
    LOGUNIFORM,
    MOST,
    NORMAL,
    UNIFORM,
    Array,
    Axis,
    Distribution,
    Members,
    combine,
)
from lagrange_cli.run.ensembles.numbers import Numbers
from lagrange_cli.run.ensembles.table import read_table
from lagrange_cli.run.source import STANDARD_INPUT, display_name
from lagrange_cli.spec.settable import settable

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec

GRID = "write START:STOP:COUNT, log:START:STOP:COUNT or a list such as 1,2,5"
LONGEST = 15
"""Digits of a number of values."""
KINDS = {
    NORMAL: "(mean,deviation)",
    UNIFORM: "(low,high)",
    LOGNORMAL: "(median,sigma)",
    LOGUNIFORM: "(low,high)",
}
"""The distributions, with what they are given."""
DISTRIBUTION = re.compile(r"\s*(\w+)\s*\(([^,]*),([^,]*)\)\s*")


MOST_WRITTEN = 100
"""Values of an array that the output lists."""


@dataclass(frozen=True)
class Draws:
    """What chooses the members: options with names and texts as they were typed, or arrays (count,) in place
    of the grids and of the table's file."""

    over: tuple[tuple[str, str | Array], ...] = ()
    random: tuple[tuple[str, str], ...] = ()
    table: str | Mapping[str, Array] | None = None
    members: int | None = None
    seed: int = 0

    @property
    def any(self) -> bool:
        """Whether there is one of them; the seed and the number of members choose none."""
        return bool(self.over or self.random or self.table or self.members)

    def check_input(self, system: str) -> None:
        """Raise ``UsageError`` where the ``system`` and the table would both come from standard input."""
        if system == STANDARD_INPUT and isinstance(self.table, str) and self.table == system:
            raise UsageError("the system and the table cannot both come from standard input")

    def as_data(self) -> dict[str, Any]:
        """Its description in the output, in terms of JSON."""
        seed = self.seed if self.random else None
        over = {name: given if isinstance(given, str) else in_words(given) for name, given in self.over}
        table = self.table if isinstance(self.table, str) or self.table is None else ",".join(self.table)
        return {"over": over, "random": dict(self.random), "table": table, "seed": seed}

    def options_given(self) -> dict[str, str]:
        """The options as they were given, by what they set."""
        single = {"table": self.table, "members": self.members, "seed": self.seed or None}
        shown = {name: f"--{name} {value}" for name, value in single.items() if value is not None}
        for option, pairs in (("over", self.over), ("random", self.random)):
            shown |= {f"{option} {name}": f"--{option} {name}={text}" for name, text in pairs}
        return shown


def draw_members(spec: Spec, draws: Draws, overrides: Mapping[str, str]) -> Members:
    """The members: every row of the table with every point of the grid, so many times as there are draws.

    Raises ``UsageError`` for what makes no sense, ``FileError`` where the table cannot be read.
    """
    if not (draws.over or draws.random or draws.table):
        raise UsageError(
            "no members given: add --over NAME=START:STOP:COUNT, --random 'NAME=normal(0,0.1)' or "
            "--table FILE.csv, where NAME is a parameter or an initial value"
        )
    if draws.members is not None and not draws.random:
        raise UsageError("--members is the number of draws of --random: add --random, or leave it out")
    axes: list[Axis] = []
    if draws.table is not None:
        columns = named_table(spec, draws.table)
        shown = display_name(draws.table) if isinstance(draws.table, str) else "the table"
        axes.append(Axis(f"rows of {shown}", "row", len(next(iter(columns.values()))), columns))
    swept = [*(name for axis in axes for name in axis.columns), *(x for x, _ in (*draws.over, *draws.random))]
    numbers = Numbers(spec, overrides, swept)
    for name, given in draws.over:
        label = f"--over {name}={given}" if isinstance(given, str) else f"over {name}"
        known = name_of(spec, name, label)
        values = grid(given, label, numbers) if isinstance(given, str) else finite(given, label)
        axes.append(Axis(name, known, values, {known: values}))
    random = [
        (
            name_of(spec, name, f"--random {name}={text}"),
            distribution(text, f"--random {name}={text}", numbers),
        )
        for name, text in draws.random
    ]
    refuse_repeated(
        [
            *(settable(spec, name, f"--set {name}={text}") for name, text in overrides.items()),
            *(name for axis in axes for name in axis.columns),
            *(name for name, _ in random),
        ]
    )
    if draws.random and draws.members is None and not axes:
        raise UsageError("--random needs the number of draws: add --members 1000")
    return combine(axes, dict(random), draws.members, draws.seed, draws.as_data())


def in_words(values: Array) -> str:
    """An array for the output: its values, or of many how many there are."""
    if len(values) <= MOST_WRITTEN:
        return ",".join(map(repr, values.tolist()))
    return f"{len(values)} values from {float(values[0])!r} to {float(values[-1])!r}"


def finite(values: Array, asked: str) -> Array:
    """Numbers (count,) that members can have."""
    if values.ndim != 1 or not len(values):
        raise UsageError(f"{asked}: values along one dimension are needed, at least one")
    if not np.all(np.isfinite(values)):
        raise UsageError(f"{asked}: {values[~np.isfinite(values)][0]} is not a finite number")
    return values


def named_table(spec: Spec, table: str | Mapping[str, Array]) -> dict[str, Array]:
    """The columns (rows,) of a table, by the names the spec has."""
    found: dict[str, Array] = {}
    shown = table if isinstance(table, str) else "the table"
    columns = read_table(table) if isinstance(table, str) else table
    if len({len(rows) for rows in columns.values()}) != 1:
        raise UsageError(f"{shown}: its columns must have the same length")
    for name, rows in columns.items():
        label = f"{shown}: column '{name}'"
        known = name_of(spec, name, label)
        if known in found:
            raise UsageError(f"{label}: an earlier column gives '{known}' already")
        found[known] = rows if isinstance(table, str) else finite(rows, label)
    return found


def name_of(spec: Spec, name: str, asked: str) -> str:
    """What ``name`` is called in the spec, if members may differ in it."""
    if name in spec.sizes:
        raise UsageError(
            f"{asked}: '{name}' is a size, and all members have the same sizes: run one sweep for each, "
            f"with --size {name}=..."
        )
    return settable(spec, name, asked)


def refuse_repeated(names: Sequence[str]) -> None:
    """Refuse a name that is given twice."""
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"'{name}' is given more than once among --set, --over, --random and --table")


def grid(text: str, asked: str, numbers: Numbers) -> Array:
    """The values of ``START:STOP:COUNT`` (both ends included), ``log:START:STOP:COUNT`` or a comma list."""
    match = DISTRIBUTION.fullmatch(text)
    if match is not None and match[1] in KINDS:
        raise UsageError(f"{asked}: {text} is a distribution: write it with --random")
    parts = [part.strip() for part in text.split(":")]
    if len(parts) == 1:
        return np.array([numbers.number(part, asked, f"; {GRID}") for part in text.split(",")])
    logarithmic = parts[0] == "log"
    if logarithmic:
        parts = parts[1:]
    if len(parts) != 3:
        raise UsageError(f"{asked}: {text!r} is not a grid; {GRID}")
    start, stop = (numbers.number(part, asked, f"; {GRID}") for part in parts[:2])
    if not parts[2].isdecimal() or len(parts[2]) > LONGEST:
        raise UsageError(f"{asked}: COUNT is the number of values, an integer, not {parts[2]!r}; {GRID}")
    count = int(parts[2])
    if count < 2:
        raise UsageError(f"{asked}: a grid has at least 2 values, its ends; give a single value with --set")
    if count > MOST:
        raise UsageError(
            f"{asked}: {count} values are more than the limit of {scientific(MOST, 0)} members: "
            f"ask for fewer, {way_out('runs')}"
        )
    if logarithmic and not (start > 0 and stop > 0):
        raise UsageError(f"{asked}: both ends of a logarithmic grid must be positive")
    if not math.isfinite(stop - start):
        raise UsageError(f"{asked}: the ends are too far apart for double precision")
    return np.geomspace(start, stop, count) if logarithmic else np.linspace(start, stop, count)


def distribution(text: str, asked: str, numbers: Numbers) -> Distribution:
    """What ``normal(mean, deviation)``, ``uniform(low, high)``, ``lognormal(median, sigma)`` or
    ``loguniform(low, high)`` says."""
    match = DISTRIBUTION.fullmatch(text)
    if match is None or match[1] not in KINDS:
        known = ", ".join(kind + arguments for kind, arguments in KINDS.items())
        over = "" if "(" in text else " (and a list or a grid with --over)"
        raise UsageError(f"{asked}: {text!r} is not a distribution; write one of {known}{over}")
    kind, a, b = match[1], numbers.number(match[2], asked), numbers.number(match[3], asked)
    if kind in (LOGNORMAL, LOGUNIFORM) and a <= 0:
        raise UsageError(f"{asked}: the first number of {kind} must be positive, not {decimal(a)}")
    if kind in (NORMAL, LOGNORMAL) and b <= 0:
        raise UsageError(f"{asked}: the width of {kind} must be positive, not {decimal(b)}")
    if kind in (UNIFORM, LOGUNIFORM) and b <= a:
        raise UsageError(f"{asked}: the upper limit must be greater than the lower one")
    return Distribution(kind, a, b)
