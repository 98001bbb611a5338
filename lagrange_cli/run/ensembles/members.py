"""``Members``: the members of an ensemble, from grids, random numbers and tables to columns of values."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from lagrange_cli.decimals import decimal, scientific
from lagrange_cli.errors import UsageError
from lagrange_cli.limits import way_out, whole
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from numpy.typing import NDArray

Array: TypeAlias = "NDArray[np.float64]"

MOST = whole("runs")
"""Members of an ensemble."""
NORMAL, UNIFORM, LOGNORMAL, LOGUNIFORM = "normal", "uniform", "lognormal", "loguniform"


@dataclass(frozen=True)
class Members:
    """The members of an ensemble.

    ``columns`` (members,) are what each is given, by name. ``shape`` has the lengths of what is combined, the
    first slowest, by the words that describe it. ``axes`` are the dimensions that this gives: a name that is
    swept with its values, ``row`` and ``draw`` with their numbers; none where the members are in no grid.
    ``described`` says in terms of JSON how they were chosen, and ``seed`` is that of the random numbers, if
    there are any.
    """

    columns: Mapping[str, Array]
    shape: Mapping[str, int]
    axes: tuple[tuple[str, Array | int], ...] = ()
    described: Mapping[str, Any] = {}
    seed: int | None = None

    @property
    def in_words(self) -> str:
        """What is combined: ``11 omega x 5 theta``, ``1 row of runs.csv``."""
        single = {name: re.sub(r"^(row|draw)s of ", r"\1 of ", name) for name in self.shape}
        return " x ".join(f"{n} {single[name] if n == 1 else name}" for name, n in self.shape.items())


@dataclass(frozen=True)
class Axis:
    """Values to be combined with those of other axes.

    ``columns`` (length,) are the values by name: of one name that is swept, or of all columns of a table.
    ``label`` describes the axis to the user. ``dimension`` is its name in the file, and ``values`` are those
    along it: numbers, or the number of a table's rows.
    """

    label: str
    dimension: str
    values: Array | int
    columns: Mapping[str, Array]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))


@dataclass(frozen=True)
class Distribution:
    """``normal`` (mean, deviation), ``uniform`` (low, high), ``lognormal`` (median, sigma) or ``loguniform``
    (low, high): its ``kind``, and these two numbers."""

    kind: str
    a: float
    b: float

    def draw(self, source: np.random.Generator, count: int) -> Array:
        """So many random numbers (count,); the first ones are the same however many."""
        if self.kind == NORMAL:
            return self.a + self.b * source.standard_normal(count)
        if self.kind == LOGNORMAL:
            return self.a * np.exp(self.b * source.standard_normal(count))
        if self.kind == UNIFORM:
            return self.a + (self.b - self.a) * source.random(count)
        return self.a * np.exp(math.log(self.b / self.a) * source.random(count))


def combine(
    axes: Sequence[Axis],
    random: Mapping[str, Distribution],
    draws: int | None,
    seed: int,
    described: Mapping[str, Any],
) -> Members:
    """The members: every combination of the axes' rows, so many times as there are ``draws`` of what is
    ``random``, by name (None: once, and draws are no dimension).

    Raises ``UsageError`` where there are too many.
    """
    shape = {axis.label: len(axis) for axis in axes}
    lengths = [*shape.values()]
    dimensions = [(axis.dimension, axis.values) for axis in axes]
    if random:
        shape["draws of --random"] = 1 if draws is None else draws
    if draws is not None:
        dimensions.append(("draw", draws))
    count = math.prod(shape.values())
    if count > MOST:
        raise UsageError(
            f"{decimal(count, 3)} members are more than the limit of {scientific(MOST, 0)}: ask "
            f"for fewer, {way_out('runs')}"
        )
    columns = product([axis.columns for axis in axes], lengths, count)
    columns |= {name: each.draw(stream(seed, name), count) for name, each in random.items()}
    gridded = len(dimensions) > 1 or any(not isinstance(axis.values, int) for axis in axes)
    return Members(columns, shape, tuple(dimensions) if gridded else (), described, seed if random else None)


def product(axes: Sequence[Mapping[str, Array]], lengths: Sequence[int], count: int) -> dict[str, Array]:
    """The columns (count,) of all combinations of the axes' rows, those of the first axis slowest."""
    found, repeats = {}, count
    for axis, length in zip(axes, lengths):
        repeats //= length
        for name, values in axis.items():
            found[name] = np.resize(np.repeat(values, repeats), count)
    return found


def stream(seed: int, name: str) -> np.random.Generator:
    """The random numbers of one name, by ``seed`` and name alone: other names and the number of members
    change nothing."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=tuple(name.encode()))))
