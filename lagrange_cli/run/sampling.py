"""``Samples``: the coordinates of an output, read in part, and between the samples by interpolation."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence

import numpy as np

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import UsageError
from lagrange_cli.records import dataclass
from lagrange_cli.spec.spec import Spec, grouped
from lagrange_cli.store.result import Result

Array = np.ndarray
MOST_NUMBERS = 2**23
"""Numbers that are read of an output: of a longer one every so many samples."""


@dataclass(frozen=True)
class Samples:
    """A motion between t[0] and t[-1]: t (n,), q and v (n, degrees)."""

    t: Array
    q: Array
    v: Array

    def at(self, times: Array) -> Array:
        """q (k, degrees) at other times, by Hermite's cubic polynomial between two samples."""
        if len(self.t) == 1:
            return np.repeat(self.q, len(times), axis=0)
        backward = self.t[-1] < self.t[0]
        order = -self.t if backward else self.t
        k = np.clip(np.searchsorted(order, -times if backward else times, "right") - 1, 0, len(self.t) - 2)
        width = self.t[k + 1] - self.t[k]
        s = ((times - self.t[k]) / np.where(width == 0, 1.0, width))[:, None]
        change, width = self.q[k + 1] - self.q[k], width[:, None]
        first, last = width * self.v[k] - change, change - width * self.v[k + 1]
        found: Array = self.q[k] + s * change + s * (1 - s) * ((1 - s) * first + s * last)
        return found


def read_samples(
    result: Result, spec: Spec, begin: float | None, end: float | None
) -> tuple[Samples, tuple[float, float]]:
    """The samples between ``begin`` and ``end`` and those next to them, and these two times.

    Of more than ``MOST_NUMBERS``, every so many are read. None stands for an end of the motion.

    Raises ``UsageError`` where the output has no such samples.
    """
    families = spec.coordinate_families
    names = [one.name for one in grouped((one.name for one in spec.coordinates), families)]
    if "t" not in result.held or not all(f"q/{name}" in result.held for name in names):
        raise UsageError(f"{result.name} has no coordinates: solve again with --outputs q,v")
    count = result.held["t"].shape[0]
    if not count:
        raise UsageError(f"{result.name} has no samples: {result.attributes.get('message', '')}")
    ends = float(result.read("t", 0)), float(result.read("t", count - 1))
    first_time, last_time = within(ends, begin, end, result.name)
    sign = -1.0 if ends[1] < ends[0] else 1.0
    times = Ordered(lambda k: sign * float(result.read("t", k)), count)
    first = max(0, bisect_right(times, sign * first_time) - 1)
    last = min(count - 1, bisect_left(times, sign * last_time))
    width = 1 + 2 * len(spec.coordinates)
    each = max(1, math.ceil((last - first + 1) * width / MOST_NUMBERS))
    rows = slice(first, last + 1, each)

    def columns(path: str) -> Array:
        found = result.read(path, rows).astype(np.float64)
        found = found.reshape(len(found), -1)
        if (last - first) % each:
            found = np.concatenate([found, result.read(path, last).astype(np.float64).reshape(1, -1)])
        return found

    t = columns("t")[:, 0]
    q = np.concatenate([columns(f"q/{name}") for name in names], axis=1)
    if all(f"v/{name}" in result.held for name in names):
        v = np.concatenate([columns(f"v/{name}") for name in names], axis=1)
    else:
        v = np.gradient(q, t, axis=0) if len(t) > 1 else np.zeros_like(q)
    known = np.isfinite(q).all(axis=1) & np.isfinite(v).all(axis=1)
    if not known.any():
        raise UsageError(f"{result.name} has no finite coordinates")
    samples = Samples(t[known], q[known], v[known])
    low, high = sorted((float(samples.t[0]), float(samples.t[-1])))
    return samples, (min(max(first_time, low), high), min(max(last_time, low), high))


def within(
    ends: tuple[float, float], begin: float | None, end: float | None, name: str
) -> tuple[float, float]:
    """From when to when the film goes; raises ``UsageError`` for a time outside of the motion."""
    begin = ends[0] if begin is None else begin
    end = ends[1] if end is None else end
    for option, t in (("from", begin), ("to", end)):
        if not min(ends) <= t <= max(ends):
            raise UsageError(
                f"--{option} {decimal(t)}: the motion of {name} goes from t = {decimal(ends[0])} "
                f"to {decimal(ends[1])}"
            )
    if (end - begin) * (ends[1] - ends[0]) < 0:
        message = f"the motion goes from t = {decimal(ends[0])} to {decimal(ends[1])}: exchange the two times"
        raise UsageError(f"--from {decimal(begin)} --to {decimal(end)}: {message}")
    return begin, end


class Ordered(Sequence[float]):
    """A sequence of which only a few numbers are read, for ``bisect``."""

    def __init__(self, number: Callable[[int], float], count: int) -> None:
        self._number, self._count = number, count

    def __getitem__(self, k: int) -> float:  # type: ignore[override]
        return self._number(k)

    def __len__(self) -> int:
        return self._count
