"""Linear equations with double-double numbers: solved in doubles, and refined by what is left.

What is left of the equations is summed exactly, so that each solution adds the digits of doubles to those
before (J. H. Wilkinson, Rounding Errors in Algebraic Processes 1963, ch. 3).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.native.numbers.error_free import two_sum

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array

HALF = 2.0**27 + 1.0
"""The factor by which a double is split into two halves, the products of which are exact (T. J. Dekker)."""
ROUNDS = 3
"""Solutions that are added: a matrix with a condition of 2^20 leaves nothing that counts."""


def added(numbers: Array, change: Array) -> Array:
    """The sums of ``numbers`` (parts, n) and a ``change`` of each, which has no low part, or also one."""
    high, *low = np.atleast_2d(change)
    total, left = two_sum(numbers[0], high)
    parts = [total] if len(numbers) == 1 else two_sum(total, sum(low, numbers[1] + left))
    found: Array = np.stack(parts)
    return found


def left_of(
    entries: Array, places: tuple[NDArray[np.intp], NDArray[np.intp]], right: Array, solution: Array
) -> Array:
    """What a ``solution`` (parts, n) leaves of the right sides of equations with these ``entries`` (parts, k)
    at their places."""
    rows, columns = places
    (a, a_low), (x, x_low) = entries, solution[:, columns]
    halves, others = halved(a), halved(x)
    terms = np.stack([*(-p * q for p in halves for q in others), -a * x_low, -a_low * x])
    order = np.argsort(rows, kind="stable")
    ends = np.searchsorted(rows[order], np.arange(len(right) + 1)).tolist()
    sorted_terms = terms[:, order]
    return np.array(
        [
            math.fsum([one, *sorted_terms[:, first:last].ravel().tolist()])
            for one, first, last in zip(right.tolist(), ends, ends[1:])
        ]
    )


def halved(numbers: Array) -> tuple[Array, Array]:
    """The upper and the lower half of the digits of doubles."""
    large = HALF * numbers
    upper = large - (large - numbers)
    return upper, numbers - upper


def refined(
    solve: Callable[[Array], Array],
    entries: Array,
    places: tuple[NDArray[np.intp], NDArray[np.intp]],
    right: Array,
    rounds: int = ROUNDS,
) -> Array:
    """The solution (parts, n) of equations with ``entries`` (parts, k), from one that ``solve`` finds but for
    rounding."""
    solution = np.zeros((len(entries), len(right)))
    for _ in range(rounds):
        solution = added(solution, solve(left_of(entries, places, right, solution)))
    return solution


def chosen(
    kept: Sequence[int] | NDArray[np.intp], places: tuple[NDArray[np.intp], NDArray[np.intp]], size: int
) -> tuple[NDArray[np.bool_], tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Which entries of a matrix of this ``size`` are in the rows and columns ``kept``, and where there."""
    position = np.full(size, -1)
    position[np.asarray(kept)] = np.arange(len(kept))
    rows, columns = (position[np.asarray(one)] for one in places)
    own = (rows >= 0) & (columns >= 0)
    return own, (rows[own], columns[own])
