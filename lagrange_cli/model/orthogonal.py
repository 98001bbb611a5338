"""Which rows of a sparse matrix depend on earlier ones, by an orthogonal factorization.

Scalar products of rows know angles only down to the square root of rounding. Reflections know them to
rounding: they make the transposed matrix triangular, column by column, in small full matrices (*fronts*) that
are as wide as Cholesky's factors of the scalar products (I. S. Duff and J. K. Reid, ACM Trans. Math. Softw.
9, 1983; P. Matstoms, ACM Trans. Math. Softw. 20, 1994).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

TALL = 2
"""A front with so many times more rows than columns is made triangular."""


def leading(rows: Sequence[Mapping[int, float]], least: float, most: float) -> list[int] | None:
    """The rows of norm 1 that do not depend on earlier ones: what is orthogonal to these is longer than
    ``most``, and not longer than ``least`` where one does. None where it is between.

    Fronts are small if rows are in an order in which Cholesky's factors are."""
    waiting: list[list[tuple[list[int], NDArray[np.float64]]]] = [[] for _ in rows]
    for columns, entries in transposed(rows).values():
        waiting[columns[0]].append((columns, np.array([entries])))
    found: list[int] = []
    for i in range(len(rows)):
        columns, front = joined(waiting[i])
        waiting[i] = []
        first, rest = front[:, 0], front[:, 1:]
        norm = float(np.linalg.norm(first))
        if least < norm <= most:
            return None
        if norm > most:
            found.append(i)
            rest = reflected(first, norm, rest)
        if len(rest) > TALL * rest.shape[1]:
            rest = np.asarray(np.linalg.qr(rest, mode="r"))
        if rest.size:
            waiting[columns[1]].append((columns[1:], rest))
    return found


def transposed(rows: Sequence[Mapping[int, float]]) -> dict[int, tuple[list[int], list[float]]]:
    """The columns that have entries: the rows of these, in their order, and the entries."""
    made: dict[int, tuple[list[int], list[float]]] = {}
    for i, row in enumerate(rows):
        for k, entry in row.items():
            places, entries = made.setdefault(k, ([], []))
            places.append(i)
            entries.append(entry)
    return made


def joined(pieces: Sequence[tuple[list[int], NDArray[np.float64]]]) -> tuple[list[int], NDArray[np.float64]]:
    """Matrices below each other, and the columns that any of them has."""
    columns = sorted({column for places, _ in pieces for column in places})
    place = {column: k for k, column in enumerate(columns)}
    front = np.zeros((sum(len(piece) for _, piece in pieces), max(1, len(columns))))
    row = 0
    for places, piece in pieces:
        front[row : row + len(piece), [place[column] for column in places]] = piece
        row += len(piece)
    return columns, front


def reflected(first: NDArray[np.float64], norm: float, rest: NDArray[np.float64]) -> NDArray[np.float64]:
    """The later columns, without the first row, after the reflection that leaves only the first entry of the
    ``first`` column, which is as long as ``norm``."""
    normal = first.copy()
    normal[0] += math.copysign(norm, normal[0])
    shares = (normal @ rest) / (norm * abs(normal[0]))
    return rest[1:] - np.outer(normal[1:], shares)
