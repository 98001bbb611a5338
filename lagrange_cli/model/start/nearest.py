"""The nearest point of a surface f(x) = 0, in the metric of the masses.

First Newton's method leads to the surface by steps of least length; then the whole displacement is made the
shortest, M (x - x0) = A^T mu (E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, 1996, sec.
VII.2). f is evaluated with all digits, so that these corrections converge to all of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from lagrange_cli.model.start.equations import Matter, Row
from lagrange_cli.model.start.linear import steepness
from lagrange_cli.model.start.shortest import Shortest
from lagrange_cli.records import dataclass

Values = tuple[Sequence[Any], Sequence[Row]]
"""f, and its slopes."""
ROUNDS = 80
FAR = 0.5
"""A step is at most this part of the scale."""
ROUND = 2.0**-52
"""The rounding error of values, relative to their scale, in doubles."""
LONG_ROUND = 2.0**-106
"""The same of two doubles."""
CONTRACTING = 0.5
"""Steps that become shorter by this factor converge."""
SOLVED = 2.0**-46
"""Steps that are no longer are rounding errors of ones in doubles, and need not become shorter at once."""
DESCENTS, LONGEST = 400, 100.0
"""Steps along the surface, and the longest one, as a part of the slope."""
NEAR = 1e-9
"""Newton's method has converged if its steps are no longer than this, and do not become shorter."""


@dataclass(frozen=True)
class Surface:
    """Where the functions ``at`` are 0 that have the numbers ``kept``, for changes of the ``unknown``
    coordinates; ``scale`` is that of each coordinate, and ``unit`` what rounding makes of 1. The nearest
    point is found by so many ``descents`` at most, and Newton's method ends after so many rounds,
    its ``patience``, in which no values became smaller."""

    at: Callable[[Sequence[Any]], Values]
    kept: Sequence[int]
    unknown: Sequence[int]
    masses: Matter
    scale: Sequence[float]
    unit: float
    descents: int = DESCENTS
    patience: int = ROUNDS

    def reach(self, x: Sequence[Any]) -> list[Any] | None:
        """A point of it, by Newton's method from ``x``; None where there is none."""
        found, last, halved = list(x), math.inf, 0
        if not self.kept:
            return found
        sizes, least, waited = [1.0 for _ in self.kept], math.inf, 0
        for number in range(ROUNDS):
            values, rows = self.at(found)
            if not number:
                sizes = [x or 1.0 for x in steepness([rows[i] for i in self.kept], self.scale)]
            off = max(abs(float(values[i])) / x for i, x in zip(self.kept, sizes))
            least, waited = min(off, least), 0 if off < least else waited + 1
            if waited > self.patience:
                return None
            step, _mu = self._shortest(rows).solve({}, [-float(values[i]) for i in self.kept])
            size = self.size(step)
            if not math.isfinite(size):
                return None
            halved = halved + 1 if 0.4 < size / last < 0.6 else 0
            factor = 2.0 if halved > 2 else min(1.0, FAR / size) if size else 1.0  # 2: at a double root
            found = self.moved(found, step, factor)
            if size <= self.unit or (size >= last / 2 and last <= self.unit * 2**12):
                return found
            last = size
        return found if last <= NEAR else None

    def shorten(self, start: Sequence[Any], x: Sequence[Any]) -> list[Any]:
        """The point nearest to ``start``, from another one.

        All of it at once, if that converges: it does where the way is short beside the radii of curvature.
        """
        found, mu, last = list(x), [0.0 * one for one in self.kept], math.inf
        for _ in range(ROUNDS):
            values, rows = self.at(found)
            pull = self.pull(start, found)
            for i, one in zip(self.kept, mu):
                for k, a in rows[i].items():
                    if k in pull:
                        pull[k] += a * one
            step, more = self._shortest(rows).solve(
                {k: float(one) for k, one in pull.items()}, [-float(values[i]) for i in self.kept]
            )
            size = self.size(step)
            if not size < CONTRACTING * last and last > self.unit * 2**12 and size > SOLVED:
                break
            found, mu = self.moved(found, step, 1.0), [a + b for a, b in zip(mu, more)]
            if size <= self.unit or last <= self.unit * 2**12:
                return found
            last = size
        return self.descend(start, x)

    def descend(self, start: Sequence[Any], x: Sequence[Any]) -> list[Any]:
        """The same along the surface, by steps that reduce the distance. Their lengths follow from how the
        slope has changed (J. Barzilai and J. M. Borwein, IMA J. Numer. Anal. 8, 141, 1988)."""
        found, part = list(x), 1.0
        slide, length = self.slide(start, found)
        for _ in range(self.descents):
            if length <= NEAR**1.5 or part < NEAR:
                break
            trial = self.reach(self.moved(found, slide, part))
            if trial is None:
                part /= 2
                continue
            other, rest = self.slide(start, trial)
            if rest < length or self.gap(start, trial) < self.gap(start, found) * (1 - NEAR):
                change = {k: slide[k] - other.get(k, 0.0) for k in slide}
                bent = sum(
                    float(one) * change[k] for k, one in self.pull(trial, found).items() if k in change
                )
                part = min(LONGEST, self.gap(trial, found) / bent) if bent > 0 else min(LONGEST, 2 * part)
                found, slide, length = trial, other, rest
            else:
                part /= 2
        return found

    def slide(self, start: Sequence[Any], x: Sequence[Any]) -> tuple[Mapping[int, float], float]:
        """The displacement towards ``start`` along the surface, and its size."""
        pull = {k: float(one) for k, one in self.pull(start, x).items()}
        step, _ = self._shortest(self.at(x)[1]).solve(pull, [0.0] * len(self.kept))
        return step, self.size(step)

    def pull(self, start: Sequence[Any], x: Sequence[Any]) -> dict[int, Any]:
        """M (start - x)."""
        return self.masses.times([one - other for one, other in zip(start, x)], self.unknown)

    def gap(self, start: Sequence[Any], x: Sequence[Any]) -> float:
        """The square of the distance from ``start``."""
        return float(sum(one * (start[k] - x[k]) for k, one in self.pull(start, x).items()))

    def _shortest(self, rows: Sequence[Row]) -> Shortest:
        return Shortest(self.masses, [rows[i] for i in self.kept], self.unknown)

    def size(self, step: Mapping[int, Any]) -> float:
        """The largest part of its scale that a coordinate moves by."""
        return max((abs(float(x)) / self.scale[k] for k, x in step.items()), default=0.0)

    def moved(self, x: Sequence[Any], step: Mapping[int, float], factor: float) -> list[Any]:
        """The point after a step."""
        found = list(x)
        for k, dx in step.items():
            found[k] = found[k] + factor * dx
        return found

    def nearest(self, start: Sequence[Any], begin: Sequence[Any] | None = None) -> list[Any] | None:
        """The nearest point, found from where the search is to ``begin``; ``start`` itself where it is one to
        rounding, and None where there is none."""
        found = self.reach(start if begin is None else begin)
        if found is None:
            return None
        shortest = self.shorten(start, found)
        found = self.reach(shortest) or shortest  # the rounding errors of the long way
        way = {k: found[k] - start[k] for k in self.unknown}
        return list(start) if self.size(way) <= 4 * self.unit else found
