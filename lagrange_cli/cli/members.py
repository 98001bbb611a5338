"""Which members an ensemble has: grids, random numbers and tables, from what the user types to columns."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.cli.tables import read_table
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
DISTRIBUTION = re.compile(r"\s*(\w+)\s*\(([^,]*),([^,]*)\)\s*")


@dataclass(frozen=True)
class Draws:
    """What the command line says of the members: names and texts as they were typed."""

    over: tuple[tuple[str, str], ...] = ()
    random: tuple[tuple[str, str], ...] = ()
    table: str | None = None
    members: int | None = None
    seed: int = 0


@dataclass(frozen=True)
class Members:
    """The members of an ensemble: what each is given, (members,) by name, and the lengths of what was
    combined, the first slowest."""

    columns: Mapping[str, Array]
    shape: Mapping[str, int]


def draw_members(spec: Spec, draws: Draws, overrides: Mapping[str, str]) -> Members:
    """The members: every row of the table with every point of the grid, so many times as there are draws.

    Raises ``UsageError`` for what makes no sense, ``FileError`` where the table cannot be read.
    """
    if not (draws.over or draws.random or draws.table):
        raise UsageError(
            "there is nothing to sweep over: add --over omega=0:10:101, --random theta=normal(0,0.1) or "
            "--table runs.csv"
        )
    if draws.members is not None and not draws.random:
        raise UsageError("--members says how often --random is drawn, and there is none")
    axes: list[tuple[str, dict[str, Array]]] = []
    if draws.table is not None:
        table = read_table(draws.table)
        named = {name_of(spec, name, f"{draws.table}: column '{name}'"): rows for name, rows in table.items()}
        axes.append((f"rows of {draws.table}", named))
    for name, text in draws.over:
        label = f"--over {name}={text}"
        axes.append((name, {name_of(spec, name, label): grid(text, label)}))
    random = [
        (name_of(spec, name, f"--random {name}={text}"), distribution(text, f"--random {name}={text}"))
        for name, text in draws.random
    ]
    refuse_repeated(
        [
            *(settable(spec, name, f"--set {name}={text}") for name, text in overrides.items()),
            *(name for _, axis in axes for name in axis),
            *(name for name, _ in random),
        ]
    )
    shape = {what: len(next(iter(axis.values()))) for what, axis in axes}
    if draws.random:
        if draws.members is None and not axes:
            raise UsageError("it is not said how many members to draw: add --members 1000")
        shape["draws of --random"] = 1 if draws.members is None else draws.members
    count = math.prod(shape.values())
    if count > MOST:
        raise UsageError(
            f"{count:.3g} members are more than the {MOST:.0e} that an ensemble can have: "
            f"ask for fewer, {way_out('runs')}"
        )
    columns = product([axis for _, axis in axes], [*shape.values()], count)
    columns |= {name: draw(stream(draws.seed, name), count) for name, draw in random}
    return Members(columns, shape)


def name_of(spec: Spec, name: str, asked: str) -> str:
    """What ``name`` is called in the spec, if members may differ in it."""
    if name in spec.sizes:
        raise UsageError(
            f"{asked}: '{name}' is a size, and members have one size: run a sweep for each --size {name}=..."
        )
    return settable(spec, name, asked)


def refuse_repeated(names: Sequence[str]) -> None:
    """Nothing may be given twice."""
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"'{name}' is given more than once: by --set, --over, --random or --table")


def product(axes: Sequence[Mapping[str, Array]], lengths: Sequence[int], count: int) -> dict[str, Array]:
    """The columns (count,) of all combinations of the axes' rows, those of the first axis slowest."""
    found, repeats = {}, count
    for axis, length in zip(axes, lengths):
        repeats //= length
        for name, values in axis.items():
            found[name] = np.resize(np.repeat(values, repeats), count)
    return found


def grid(text: str, asked: str) -> Array:
    """The values of ``START:STOP:COUNT``, ``log:START:STOP:COUNT`` or a comma list; ends are included."""
    parts = [part.strip() for part in text.split(":")]
    if len(parts) == 1:
        return np.array([number(part, asked) for part in text.split(",")])
    logarithmic = parts[0] == "log"
    if logarithmic:
        parts = parts[1:]
    if len(parts) != 3 or not parts[2].isdecimal():
        raise UsageError(f"{asked}: {text!r} is no grid; {GRID}")
    start, stop, count = number(parts[0], asked), number(parts[1], asked), int(parts[2])
    if count < 2:
        raise UsageError(f"{asked}: a grid has 2 values at least, its ends; for one value say --set")
    if count > MOST:
        raise UsageError(
            f"{asked}: {count} values are more than the {MOST:.0e} members that there can be: "
            f"ask for fewer, {way_out('runs')}"
        )
    if logarithmic and not (start > 0 and stop > 0):
        raise UsageError(f"{asked}: the ends of a logarithmic grid must be greater than 0")
    return np.geomspace(start, stop, count) if logarithmic else np.linspace(start, stop, count)


def distribution(text: str, asked: str) -> Callable[[np.random.Generator, int], Array]:
    """What draws so many numbers of ``normal(mean, deviation)``, ``uniform(low, high)``, ``lognormal(median,
    sigma)`` or ``loguniform(low, high)`` from a generator: the first ones are the same however many."""
    match = DISTRIBUTION.fullmatch(text)
    known = "normal(mean,deviation), uniform(low,high), lognormal(median,sigma), loguniform(low,high)"
    if match is None or match[1] not in ("normal", "uniform", "lognormal", "loguniform"):
        raise UsageError(f"{asked}: {text!r} is no distribution; known: {known}")
    kind, a, b = match[1], number(match[2], asked), number(match[3], asked)
    if kind.startswith("log") and a <= 0:
        raise UsageError(f"{asked}: what is distributed so is greater than 0, and {a:g} is not")
    if kind.endswith("normal"):
        if b <= 0:
            raise UsageError(f"{asked}: the width of a distribution must be greater than 0, not {b:g}")
        if kind == "normal":
            return lambda source, count: a + b * source.standard_normal(count)
        return lambda source, count: a * np.exp(b * source.standard_normal(count))
    if b <= a:
        raise UsageError(f"{asked}: the upper end must be greater than the lower one")
    if kind == "uniform":
        return lambda source, count: a + (b - a) * source.random(count)
    return lambda source, count: a * np.exp(math.log(b / a) * source.random(count))


def stream(seed: int, name: str) -> np.random.Generator:
    """The random numbers of one name, by ``seed`` and name alone: other names and the number of members
    change nothing."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=tuple(name.encode()))))


def number(text: str, asked: str) -> float:
    """A finite number, or an expression of numbers such as ``-pi/2``."""
    try:
        value = float(text)
    except ValueError:
        try:
            value = evaluate(parse(text), refuse_name)
        except ExpressionError as error:
            hint = f"; {error.hint}" if error.hint else ""
            raise UsageError(f"{asked}: {error.message}{hint}") from error
        except LookupError as error:
            raise UsageError(f"{asked}: {text.strip()!r} is not a number") from error
    if not math.isfinite(value):
        raise UsageError(f"{asked}: {text.strip()} is not a finite number")
    return value


def refuse_name(name: str) -> float:
    """Numbers here are made of numbers and pi."""
    raise LookupError(name)
