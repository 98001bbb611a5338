"""Groups of rows of numbers that add up to zero."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

ROUNDING = 1e-9
"""Coefficients this near to 0 or 1 are equal to it up to rounding."""
Array = npt.NDArray[np.float64]


def cancelling(rows: Sequence[Sequence[float]]) -> Iterator[list[int]]:
    """Groups of ``rows`` with the sum 0, as places among them.

    A vector of coefficients with which all rows cancel is in their null space. Where that has a basis of
    vectors which share no rows, each with equal coefficients, these are the groups.
    """
    for vector in reduced(null_space(np.array(rows))):
        members = np.abs(vector) > ROUNDING
        if np.allclose(vector[members], 1.0, rtol=0, atol=ROUNDING):
            yield members.nonzero()[0].tolist()


def null_space(rows: Array) -> Array:
    """A basis of the vectors c with c @ rows = 0, as rows."""
    largest = np.max(np.abs(rows), axis=0)
    left, sizes, _ = np.linalg.svd(rows[:, largest > 0] / largest[largest > 0])
    rank = int(np.sum(sizes > ROUNDING * sizes[:1]))
    return np.asarray(left[:, rank:].T)


def reduced(rows: Array) -> Array:
    """The reduced row echelon form (by Gauss and Jordan, with pivots)."""
    rows, done = rows.copy(), 0
    for column in range(rows.shape[1]):
        if done == len(rows):
            break
        pivot = done + int(np.argmax(np.abs(rows[done:, column])))
        if abs(rows[pivot, column]) > ROUNDING:
            rows[[done, pivot]] = rows[[pivot, done]]
            rows[done] /= rows[done, column]
            others = np.arange(len(rows)) != done
            rows[others] -= np.outer(rows[others, column], rows[done])
            done += 1
    return rows
