"""Polynomials through a motion before some time, that lead beyond it.

They interpolate the motion at Chebyshev points, and their Chebyshev series are cut off. So they are nearly
those of least squares, which errors of single states change little (L. N. Trefethen, Approximation Theory and
Approximation Practice, 2013, ch. 3-5). In double-double, numbers are decimals here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from decimal import Context, Decimal, localcontext
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.records import dataclass

DECIMALS = Context(prec=40)
"""More digits than double-double has."""
exact: Any = np.frompyfunc(Decimal, 1, 1)
"""Doubles as decimals."""


@dataclass(frozen=True)
class Choice:
    """Which polynomials are tried: those of these ``degrees``, that are known up to a part of their length
    before the time that they lead beyond, and lead as far beyond it: this one, or the next one if no other
    leads ``away``. (Nearer polynomials are known better, but steps from there lead less far.) One is believed
    if that of ``LOWER`` degrees less has ``agreed`` with it so well, relative to the motion; if they agree to
    ``rounding``, they differ by no more."""

    degrees: tuple[int, ...]
    away: tuple[float, ...]
    agreed: float
    rounding: float


CHOICES = {
    1: Choice((14, 20, 26), (1 / 75, 1 / 300), 1e-10, 2.0**-46),
    2: Choice((26, 38, 50), (1 / 300,), 1e-16, 2.0**-90),
}
"""For numbers that are sums of so many doubles."""
LOWER = 2


@dataclass(frozen=True)
class Passage:
    """A polynomial for all rows of the state between ``start`` and ``stop``: Chebyshev coefficients
    (degree + 1, rows) on the interval that it is known on, from ``start`` to ``known``; and how little a
    lower degree differs from it at ``stop``."""

    start: float
    known: float
    stop: float
    coefficients: Any
    error: float

    def at(self, times: Array) -> Array:
        """The states (rows of every part, n) at times."""
        with localcontext(DECIMALS):
            return doubles(chebyshev.chebval(self._place(times), self.coefficients))

    def rates(self, t: float) -> Array:
        """The rates (rows,) at a time."""
        with localcontext(DECIMALS):
            slopes = chebyshev.chebval(self._place(np.array([t])), chebyshev.chebder(self.coefficients))
        return np.asarray(slopes[:, 0].astype(float) * (2.0 / (self.known - self.start)))

    def _place(self, times: Array) -> Any:
        return place(times, self.start, self.known, 1 if self.coefficients.dtype == float else 2)


def passages(
    singular: float,
    lengths: Iterator[float],
    sampled: Callable[[Array], Array | None],
    parts: int,
    part: float,
) -> Iterator[Passage]:
    """Polynomials of the chosen degrees that are known for so long before the ``singular`` time, up to this
    ``part`` of it.

    ``sampled`` gives the states (rows of every part, n) at times before it, or None.
    """
    choice = CHOICES[parts]
    highest = choice.degrees[-1]
    points = np.sort(chebyshev.chebpts1(highest + 1))
    for length in lengths:
        away = length * part
        start, known, stop = singular - length, singular - away, singular + away
        times = (start + known) / 2.0 + (known - start) / 2.0 * points
        states = sampled(times)
        if states is None or not np.all(np.isfinite(states)):
            continue
        with localcontext(DECIMALS):
            places = place(times, start, known, parts)
            series = solved(polynomials(places, highest), numbers(states, parts).T)
            ends = polynomials(place(np.array([stop]), start, known, parts), highest).T * series
        for degree in choice.degrees:
            value = np.abs(np.sum(ends[: degree + 1], axis=0)).astype(float)
            rest = np.abs(np.sum(ends[degree + 1 - LOWER : degree + 1], axis=0)).astype(float)
            error = float(np.max(rest)) / max(1e-300, float(np.max(value)))
            yield Passage(start, known, stop, series[: degree + 1], error)


def numbers(states: Array, parts: int) -> Any:
    """The numbers (rows, n) that states (rows of every part, n) are."""
    if parts == 1:
        return states
    high, low = np.split(states, 2)
    return exact(high) + exact(low)


def doubles(numbers: Any) -> Array:
    """The states (rows of every part, n) that are these numbers (rows, n)."""
    high = np.asarray(numbers.astype(float))
    return high if numbers.dtype == float else np.concatenate([high, (numbers - exact(high)).astype(float)])


def place(times: Array, start: float, known: float, parts: int) -> Any:
    """Where times are in the interval from ``start`` to ``known``, which becomes that from -1 to 1."""
    t, first, last = (one if parts == 1 else exact(one) for one in (times, np.array(start), np.array(known)))
    return (2 * t - first - last) / (last - first)


def polynomials(x: Any, highest: int) -> Any:
    """The Chebyshev polynomials (n, highest + 1) at places (n,)."""
    found = [x * 0 + 1, x]
    while len(found) <= highest:
        found.append(2 * x * found[-1] - found[-2])
    return np.stack(found, axis=1)


def solved(matrix: Any, right: Any) -> Any:
    """The solution (n, m) of linear equations, by elimination with row pivots: of doubles or decimals."""
    rows, count = np.concatenate([matrix, right], axis=1), len(matrix)
    for k in range(count):
        pivot = k + int(np.argmax(np.abs(rows[k:, k])))
        rows[[k, pivot]] = rows[[pivot, k]]
        rows[k] = rows[k] / rows[k, k]
        others = np.arange(count) != k
        rows[others] = rows[others] - rows[others, k][:, None] * rows[k]
    return rows[:, count:]
