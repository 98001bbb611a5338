"""Which members an ensemble has: grids, random numbers and tables, from what the user types to columns."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.cli.options.table import read_table
from lagrange_cli.errors import UsageError
from lagrange_cli.expression.numbers import evaluate
from lagrange_cli.expression.parse import parse
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.limits import way_out, whole
from lagrange_cli.records import dataclass
from lagrange_cli.spec.values import settable

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.spec.spec import Spec

    Array = NDArray[np.float64]

MOST = whole("runs")
"""Members of an ensemble."""
GRID = "write START:STOP:COUNT, log:START:STOP:COUNT or a list such as 1,2,5"
LONGEST = 15
"""Digits of a number of values."""
KINDS = {
    "normal": "(mean,deviation)",
    "uniform": "(low,high)",
    "lognormal": "(median,sigma)",
    "loguniform": "(low,high)",
}
"""The distributions, with what they are given."""
DISTRIBUTION = re.compile(r"\s*(\w+)\s*\(([^,]*),([^,]*)\)\s*")


@dataclass(frozen=True)
class Draws:
    """What the command line says of the members: names and texts as they were typed."""

    over: tuple[tuple[str, str], ...] = ()
    random: tuple[tuple[str, str], ...] = ()
    table: str | None = None
    members: int | None = None
    seed: int = 0

    def options_given(self) -> dict[str, str]:
        """The options that say so, as ``Request`` has the others."""
        single = {"table": self.table, "members": self.members, "seed": self.seed or None}
        shown = {name: f"--{name} {value}" for name, value in single.items() if value is not None}
        for option, pairs in (("over", self.over), ("random", self.random)):
            shown |= {f"{option} {name}": f"--{option} {name}={text}" for name, text in pairs}
        return shown


@dataclass(frozen=True)
class Members:
    """The members of an ensemble.

    ``columns`` (members,) are what each is given, by name. ``shape`` has the lengths of what is combined, the
    first slowest, by the words that describe it. ``axes`` are the dimensions that this gives: a name that is
    swept with its values, ``row`` and ``draw`` with their numbers; none where the members are in no grid.
    """

    columns: Mapping[str, Array]
    shape: Mapping[str, int]
    axes: tuple[tuple[str, Array | int], ...] = ()


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
    given: list[dict[str, Array]] = []
    shape: dict[str, int] = {}
    axes: list[tuple[str, Array | int]] = []
    if draws.table is not None:
        given.append(named_table(spec, draws.table))
        shape[f"rows of {draws.table}"] = rows = len(next(iter(given[0].values())))
        axes.append(("row", rows))
    for name, text in draws.over:
        label = f"--over {name}={text}"
        known, values = name_of(spec, name, label), grid(text, label)
        given.append({known: values})
        shape[name] = len(values)
        axes.append((known, values))
    random = [
        (name_of(spec, name, f"--random {name}={text}"), distribution(text, f"--random {name}={text}"))
        for name, text in draws.random
    ]
    refuse_repeated(
        [
            *(settable(spec, name, f"--set {name}={text}") for name, text in overrides.items()),
            *(name for columns in given for name in columns),
            *(name for name, _ in random),
        ]
    )
    lengths = [*shape.values()]
    if draws.random:
        if draws.members is None and not given:
            raise UsageError("--random needs the number of draws: add --members 1000")
        shape["draws of --random"] = 1 if draws.members is None else draws.members
    if draws.members is not None:
        axes.append(("draw", draws.members))
    count = math.prod(shape.values())
    if count > MOST:
        raise UsageError(
            f"{count:.3g} members are more than the limit of {MOST:.0e}: ask for fewer, {way_out('runs')}"
        )
    columns = product(given, lengths, count)
    columns |= {name: draw(stream(draws.seed, name), count) for name, draw in random}
    gridded = bool(draws.over) or len(axes) > 1
    return Members(columns, shape, tuple(axes) if gridded else ())


def named_table(spec: Spec, file: str) -> dict[str, Array]:
    """The columns (rows,) of a table, by the names the spec has."""
    found: dict[str, Array] = {}
    for name, rows in read_table(file).items():
        label = f"{file}: column '{name}'"
        known = name_of(spec, name, label)
        if known in found:
            raise UsageError(f"{label}: an earlier column gives '{known}' already")
        found[known] = rows
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
    """Nothing may be given twice."""
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"'{name}' is given more than once among --set, --over, --random and --table")


def product(axes: Sequence[Mapping[str, Array]], lengths: Sequence[int], count: int) -> dict[str, Array]:
    """The columns (count,) of all combinations of the axes' rows, those of the first axis slowest."""
    found, repeats = {}, count
    for axis, length in zip(axes, lengths):
        repeats //= length
        for name, values in axis.items():
            found[name] = np.resize(np.repeat(values, repeats), count)
    return found


def grid(text: str, asked: str) -> Array:
    """The values of ``START:STOP:COUNT`` (both ends included), ``log:START:STOP:COUNT`` or a comma list."""
    match = DISTRIBUTION.fullmatch(text)
    if match is not None and match[1] in KINDS:
        raise UsageError(f"{asked}: {text} is a distribution: write it with --random")
    parts = [part.strip() for part in text.split(":")]
    if len(parts) == 1:
        return np.array([number(part, asked, f"; {GRID}") for part in text.split(",")])
    logarithmic = parts[0] == "log"
    if logarithmic:
        parts = parts[1:]
    if len(parts) != 3:
        raise UsageError(f"{asked}: {text!r} is not a grid; {GRID}")
    start, stop = (number(part, asked, f"; {GRID}") for part in parts[:2])
    if not parts[2].isdecimal() or len(parts[2]) > LONGEST:
        raise UsageError(f"{asked}: COUNT is the number of values, an integer, not {parts[2]!r}; {GRID}")
    count = int(parts[2])
    if count < 2:
        raise UsageError(f"{asked}: a grid has at least 2 values, its ends; give a single value with --set")
    if count > MOST:
        raise UsageError(
            f"{asked}: {count} values are more than the limit of {MOST:.0e} members: "
            f"ask for fewer, {way_out('runs')}"
        )
    if logarithmic and not (start > 0 and stop > 0):
        raise UsageError(f"{asked}: both ends of a logarithmic grid must be positive")
    if not math.isfinite(stop - start):
        raise UsageError(f"{asked}: the ends are too far apart for double precision")
    return np.geomspace(start, stop, count) if logarithmic else np.linspace(start, stop, count)


def distribution(text: str, asked: str) -> Callable[[np.random.Generator, int], Array]:
    """What draws so many numbers of ``normal(mean, deviation)``, ``uniform(low, high)``, ``lognormal(median,
    sigma)`` or ``loguniform(low, high)`` from a generator: the first ones are the same however many."""
    match = DISTRIBUTION.fullmatch(text)
    if match is None or match[1] not in KINDS:
        known = ", ".join(kind + arguments for kind, arguments in KINDS.items())
        over = "" if "(" in text else " (and a list or a grid with --over)"
        raise UsageError(f"{asked}: {text!r} is not a distribution; write one of {known}{over}")
    kind, a, b = match[1], number(match[2], asked), number(match[3], asked)
    if kind.startswith("log") and a <= 0:
        raise UsageError(f"{asked}: the first number of {kind} must be positive, not {a:g}")
    if kind.endswith("normal"):
        if b <= 0:
            raise UsageError(f"{asked}: the width of {kind} must be positive, not {b:g}")
        if kind == "normal":
            return lambda source, count: a + b * source.standard_normal(count)
        return lambda source, count: a * np.exp(b * source.standard_normal(count))
    if b <= a:
        raise UsageError(f"{asked}: the upper limit must be greater than the lower one")
    if kind == "uniform":
        return lambda source, count: a + (b - a) * source.random(count)
    return lambda source, count: a * np.exp(math.log(b / a) * source.random(count))


def stream(seed: int, name: str) -> np.random.Generator:
    """The random numbers of one name, by ``seed`` and name alone: other names and the number of members
    change nothing."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=tuple(name.encode()))))


def number(text: str, asked: str, hint: str = "") -> float:
    """A finite number, or an expression of numbers such as ``-pi/2``; else a message ends with ``hint``."""
    try:
        value = float(text)
    except ValueError:
        try:
            tree = parse(text)
        except ExpressionError as error:
            raise UsageError(f"{asked}: expected a number, not {text.strip()[:50]!r}{hint}") from error
        try:
            value = evaluate(tree, refuse_name)
        except ExpressionError as error:
            raise UsageError(f"{asked}: {error.message}") from error
        except LookupError as error:
            raise UsageError(f"{asked}: expected a number, not {text.strip()[:50]!r}{hint}") from error
    if not math.isfinite(value):
        raise UsageError(f"{asked}: {text.strip()} is not a finite number")
    return value


def refuse_name(name: str) -> float:
    """Numbers here are made of numbers and pi."""
    raise LookupError(name)
