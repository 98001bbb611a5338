"""The nearest point of a surface f(x) = 0, in the metric of the masses.

First Newton's method leads to the surface by steps of least length; then the whole displacement is made the
shortest, M (x - x0) = A^T mu (E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, 1996, sec.
VII.2). f is evaluated with all digits, so that these corrections converge to all of them.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any, TypeAlias

import numpy as np

from lagrange_cli.model.start.equations import Masses, Matter, Row
from lagrange_cli.model.start.linear import Array, steepness
from lagrange_cli.model.start.shortest import Shortest
from lagrange_cli.portions import Portion, portion
from lagrange_cli.records import dataclass, replace

Pair: TypeAlias = tuple[Array, Array, Array, Array, float]
"""A step s, the change y of the slope along it, M s, M y, and s^T M y."""
CONVEX = 1e-8
"""The cosine of the angle between a step and the change of the slope is larger."""
REMEMBERED = 30
"""Steps that are remembered."""


class Curvature:
    """The limited-memory BFGS method in the metric of the masses, whose products with a vector
    (coordinates,) are ``weighted`` (J. Nocedal and S. J. Wright, Numerical Optimization, 2006, algorithm
    7.4)."""

    def __init__(self, weighted: Callable[[Array], Array]) -> None:
        self._weighted = weighted
        self._pairs: deque[Pair] = deque(maxlen=REMEMBERED)

    def __bool__(self) -> bool:
        return bool(self._pairs)

    def learn(self, step: Array, change: Array) -> None:
        """Remember a step and the change of the slope, unless the function is not clearly convex along it."""
        heavy, turned = self._weighted(step), self._weighted(change)
        bent, sizes = float(heavy @ change), [float(heavy @ step), float(turned @ change)]
        if min(sizes) > 0.0 and bent > CONVEX * math.sqrt(sizes[0]) * math.sqrt(sizes[1]):
            self._pairs.append((step, change, heavy, turned, bent))

    def forget(self) -> None:
        """Begin anew, as at another place."""
        self._pairs.clear()

    def direction(self, descent: Array) -> Array:
        """The step to where the slope is likely to be 0, from the direction of steepest ``descent``."""
        found, parts = descent, []
        for _, change, heavy, _, bent in reversed(self._pairs):
            parts.append(float(heavy @ found) / bent)
            found = found - parts[-1] * change
        if self._pairs:
            _, change, _, turned, bent = self._pairs[-1]
            found = found * (bent / float(turned @ change))
        for step, _, _, turned, bent in self._pairs:
            found = found + (parts.pop() - float(turned @ found) / bent) * step
        return found


Values = tuple[Sequence[Any], Sequence[Row]]
"""f, and its slopes."""
ROUNDS = 80
FAR = 0.5
"""A step is at most this part of the scale where functions are not linear."""
ROUND = 2.0**-52
"""The rounding error of values, relative to their scale, in doubles."""
LONG_ROUND = 2.0**-106
"""The same of two doubles."""
SHORTEST = 2.0**-20
"""Steps of Newton's method are halved down to this part of themselves."""
CONTRACTING = 0.5
"""Steps that become shorter by this factor converge."""
SOLVED = 2.0**-46
"""Steps that are no longer are rounding errors of ones in doubles, and need not become shorter at once."""
DESCENTS, TRIAL_ROUNDS = 400, 10
"""Steps along the surface, and rounds of Newton's method that lead back to it after each of them."""
SHORT, FORGET = 0.1, 1e-3
"""The parts of a step below which nothing but rounding errors is left, if slopes are near 0, and below which
what is known of its direction is forgotten."""
ROUGHLY, SMALLER = 1e-3, 0.1
"""Before the end of this way Newton's method ends with a step of this size, or this part of the slope."""
NEAR = 1e-9
"""Newton's method has converged if its steps are no longer than this, and do not become shorter."""


@dataclass(frozen=True)
class Surface:
    """Where the functions ``at`` are 0 that have the numbers ``kept``, for changes of the ``unknown``
    coordinates; ``scale`` is that of each coordinate, and ``unit`` what rounding makes of 1. The nearest
    point is found by so many ``descents`` at most, and Newton's method ends after so many rounds,
    its ``patience``, in which no values became smaller. A step is at most the part ``far`` of the scale.
    Distances are measured in the ``metric``, that of the masses by default."""

    at: Callable[[Sequence[Any]], Values]
    kept: Sequence[int]
    unknown: Sequence[int]
    masses: Matter
    scale: Sequence[float]
    unit: float
    descents: int = DESCENTS
    patience: int = ROUNDS
    far: float = FAR
    metric: Matter | None = None

    def reach(self, x: Sequence[Any], enough: float | None = None, rounds: int = ROUNDS) -> list[Any] | None:
        """A point of it, by Newton's method from ``x``; None where there is none. A step as small as is
        ``enough`` is the last one; by default, one of the size of rounding errors."""
        enough = self.unit if enough is None else enough
        found, last, halved = list(x), math.inf, 0
        if not self.kept:
            return found
        sizes, least, waited = [1.0 for _ in self.kept], math.inf, 0
        for number in range(rounds):
            values, rows = self.at(found)
            if not number:
                sizes = [x or 1.0 for x in steepness([rows[i] for i in self.kept], self.scale)]
            off = self.off(values, sizes)
            least, waited = min(off, least), 0 if off < least else waited + 1
            if waited > self.patience:
                return None
            step, _mu = self._shortest(rows).solve({}, [-float(values[i]) for i in self.kept])
            size = self.size(step)
            if not math.isfinite(size):
                return None
            halved = halved + 1 if 0.4 < size / last < 0.6 else 0
            factor = 2.0 if halved > 2 else min(1.0, self.far / size) if size else 1.0  # 2: at a double root
            found = self.moved(found, step, factor)
            if size <= enough or (size >= last / 2 and last <= self.unit * 2**12):
                return found
            last = size
        return found if last <= NEAR else None

    def onto(self, x: Sequence[Any]) -> list[Any] | None:
        """A point of it, by Newton's method from ``x``; None where there is none. Its steps are damped where
        it fails otherwise, unless the nearest point is not asked for."""
        found = None
        with suppress(ArithmeticError):
            found = self.reach(x)
        if found is None and self.descents:
            nearer = self.damped(x)
            found = None if nearer is None else self.reach(nearer)
        return found

    def damped(self, x: Sequence[Any]) -> list[Any] | None:
        """A place from which Newton's method converges, by steps that are halved until they make the values
        smaller, as they should (P. Deuflhard, Newton Methods for Nonlinear Problems, 2011, sec. 3.1); None
        where such steps become too small. All coordinates count alike: turns of links that are opposite to
        each other move little mass, so that in the metric of the masses they are far too large."""
        found = list(x)
        plain = replace(self, masses=Masses({k: {k: 1.0} for k in self.unknown}))
        values, rows = self.at(found)
        sizes = [x or 1.0 for x in steepness([rows[i] for i in self.kept], self.scale)]
        off, factor = self.off(values, sizes), 0.0
        for _ in range(ROUNDS):
            if off <= NEAR:
                break
            step, _mu = plain._shortest(rows).solve({}, [-float(values[i]) for i in self.kept])
            size = self.size(step)
            if not math.isfinite(size):
                return None
            factor, rest = min(1.0, self.far / size) if size else 1.0, math.inf
            while not rest <= (1 - factor / 4) * off:
                if factor < SHORTEST:
                    return None
                place = self.moved(found, step, factor)
                with suppress(ArithmeticError):
                    values, rows = self.at(place)
                    rest = self.off(values, sizes)
                factor /= 2
            found, off = place, rest
        return found

    def off(self, values: Sequence[Any], sizes: Sequence[float]) -> float:
        """The largest of the values that are kept, as parts of their sizes."""
        return max((abs(float(values[i])) / x for i, x in zip(self.kept, sizes)), default=0.0)

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
        """The same along the surface, by steps that reduce the distance. Their directions follow from how the
        slope has changed along earlier ones, see ``Curvature``."""
        slide, length = self.slide(start, x)
        with portion(math.log(max(length, NEAR) / NEAR**1.5)) as work:
            return self._descend(start, list(x), slide, length, work)

    def _descend(
        self, start: Sequence[Any], found: list[Any], slide: Mapping[int, float], length: float, work: Portion
    ) -> list[Any]:
        """The same from a point with this ``slide``, whose ``length`` becomes smaller as the work is done."""
        curvature, step, part = Curvature(self.weighted), slide, 1.0
        gap, begun, least, exact = self.gap(start, found), length, length, True
        for _ in range(self.descents):
            if length <= NEAR**1.5 or part < (SHORT if length <= NEAR else NEAR):
                break
            if part < FORGET and curvature:
                curvature.forget()
                step, part = slide, 1.0
            part = min(part, self.far / self.size(step))
            enough = max(self.unit, min(ROUGHLY, SMALLER * length * part))
            trial = self.reach(self.moved(found, step, part), enough, TRIAL_ROUNDS)
            other, rest = ({}, math.inf) if trial is None else self.slide(start, trial)
            far = math.inf if trial is None else self.gap(start, trial)
            if trial is None or not (far < gap * (1 - NEAR) or (rest < length and far <= gap * (1 + NEAR))):
                if exact:
                    part /= 2
                else:  # beside the surface it may be nearer than any point of it
                    found, exact = self.reach(found) or found, True
                    (slide, length), gap = self.slide(start, found), self.gap(start, found)
                continue
            way = self.vector({k: float(trial[k] - found[k]) for k in self.unknown})
            curvature.learn(way, self.vector(slide) - self.vector(other))
            found, slide, length, gap, part, exact = trial, other, rest, far, 1.0, False
            step = dict(zip(self.unknown, curvature.direction(self.vector(slide)).tolist()))
            least = min(least, max(length, NEAR**1.5))
            work.reach(math.log(begun / least))
        return found

    def vector(self, step: Mapping[int, float]) -> Array:
        """A displacement of the unknown coordinates, in their order."""
        return np.array([step.get(k, 0.0) for k in self.unknown])

    def weighted(self, step: Array) -> Array:
        """M times a displacement."""
        way = [0.0] * len(self.scale)
        for k, dx in zip(self.unknown, step.tolist()):
            way[k] = dx
        return np.array([float(one) for one in self.masses.times(way, self.unknown).values()])

    def slide(self, start: Sequence[Any], x: Sequence[Any]) -> tuple[Mapping[int, float], float]:
        """The displacement towards ``start`` along the surface, and its size."""
        pull = {k: float(one) for k, one in self.pull(start, x).items()}
        step, _ = self._shortest(self.at(x)[1]).solve(pull, [0.0] * len(self.kept))
        return step, self.size(step)

    def pull(self, start: Sequence[Any], x: Sequence[Any]) -> dict[int, Any]:
        """M (start - x)."""
        return (self.metric or self.masses).times([one - other for one, other in zip(start, x)], self.unknown)

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
        found = self.onto(start if begin is None else begin)
        if found is None:
            return None
        shortest = self.shorten(start, found)
        found = self.onto(shortest) or shortest  # the rounding errors of the long way
        way = {k: found[k] - start[k] for k in self.unknown}
        return list(start) if self.size(way) <= 4 * self.unit else found
