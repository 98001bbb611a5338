"""Linear algebra of constraints: equations with their slopes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from lagrange_cli.model import sparse
from lagrange_cli.model.start.equations import Matter, Row

if TYPE_CHECKING:
    from numpy.typing import NDArray

Array: TypeAlias = "NDArray[np.float64]"

DENSE = 100
"""Constraints up to which matrices are full."""
CUT = 1e-10
"""The part of the largest singular value below which others count as 0."""
CORRECTIONS = 3
TINY = 1e-13
"""The part of unit rows that makes their scalar products a positive matrix."""
FILLED = 200
"""Numbers for each of more constraints, up to which they are sparse."""


def scattered(number: int, count: int) -> list[float]:
    """Numbers from -1 to 1, the same in every run: another row for each ``number``."""
    golden = (math.sqrt(5) - 1) / 2
    return [2 * ((0.5 + golden * (number * count + k + 1)) % 1.0) - 1 for k in range(count)]


def scales(masses: Matter, values: Sequence[Any], extent: float = 0.0) -> list[float]:
    """How large a value of each coordinate, or velocity, is when the whole system moves by its own size.

    In the metric of the masses the size is sqrt(sum m_k x_k^2), or that of the ``extent`` of the particles.
    Without a mass it is the largest of the values.
    """
    diagonal = [abs(float(m)) for m in masses.diagonal(len(values))]
    numbers = [float(x) for x in values]
    whole = math.sqrt(max(sum(m * x * x for m, x in zip(diagonal, numbers)), extent))
    largest = max(map(abs, numbers), default=0.0) or 1.0
    return [whole / math.sqrt(m) if m and whole else largest for m in diagonal]


def steepness(rows: Sequence[Row], scale: Sequence[float]) -> list[float]:
    """The rate of change of each constraint with x_k/``scale[k]``."""
    return [math.hypot(*(float(a) * scale[k] for k, a in row.items())) for row in rows]


def products(rows: Sequence[Row], others: Sequence[Row]) -> Array:
    """The matrix of the rows' scalar products with others, of which there are as many."""
    plain, given = ([{k: float(a) for k, a in row.items()} for row in some] for some in (rows, others))
    return sparse.array_of(sparse.products(plain, given), len(others))


def damped(
    rows: Sequence[Row], values: Sequence[float], scale: Sequence[float], damping: float = 1.0
) -> dict[int, float]:
    """A step towards where ``values`` with these slopes are 0, whatever the rank: that of Levenberg and
    Marquardt, damped by the square of the values (J. Fan and Y. Yuan, Computing 74, 2005)."""
    norms = [x or 1.0 for x in steepness(rows, scale)]
    matrix = [{k: float(a) * scale[k] / norm for k, a in row.items()} for row, norm in zip(rows, norms)]
    right = [-value / norm for value, norm in zip(values, norms)]
    least = max(damping * sum(x * x for x in right), 1e-30)
    found: dict[int, float] = {}
    for row, x in zip(matrix, of_products(matrix, matrix, right, least)):
        for k, a in row.items():
            found[k] = found.get(k, 0.0) + scale[k] * a * x
    return found


def of_products(
    rows: Sequence[Mapping[int, float]],
    others: Sequence[Mapping[int, float]],
    right: Sequence[float],
    more: float = 0.0,
) -> list[float]:
    """The solution for the scalar products of rows with others, ``more`` of them with themselves."""
    if len(rows) <= DENSE:
        square = products(rows, others)
        square[np.diag_indices(len(rows))] += more
        return solved(square, np.array(right))
    matrix = sparse.products(rows, others)
    for i, row in enumerate(matrix):
        row[i] = row.get(i, 0.0) + more
    found = [0.0] * len(rows)
    for part in sparse.parts_of(matrix):
        mine, of = sparse.within(matrix, part), [right[i] for i in part]
        for i, x in zip(part, solved_sparsely(mine, of)):
            found[i] = x
    return found


def smallest(rows: Sequence[Row], right: Sequence[float], unknown: Sequence[int]) -> list[float]:
    """The solution of least squares and least norm, for the ``unknown`` coordinates.

    Large systems have that of A^T (A A^T + e)^-1 or (A^T A + e)^-1 A^T, with a small e, and are corrected by
    what is left (Å. Björck, Numerical Methods for Least Squares Problems, 1996, sec. 6.6.5).
    """
    place = {k: number for number, k in enumerate(unknown)}
    if min(len(rows), len(unknown)) <= DENSE:
        matrix = np.zeros((len(rows), len(unknown)))
        for i, row in enumerate(rows):
            for k, a in row.items():
                matrix[i, place[k]] = a
        return least_squares(matrix, np.array(right)).tolist()  # type: ignore[no-any-return]
    sizes = [math.hypot(*row.values()) or 1.0 for row in rows]
    lines = [{place[k]: a / size for k, a in row.items()} for row, size in zip(rows, sizes)]
    columns = transposed(lines, len(unknown))
    wide = len(lines) <= len(columns)
    rest = np.array([x / size for x, size in zip(right, sizes)])
    found = np.zeros(len(unknown))
    first = float(np.abs(rest).max(initial=0.0))
    square = lines if wide else columns
    for _ in range(CORRECTIONS):
        some = rest if wide else times(columns, rest)
        some = np.array(of_products(square, square, some.tolist(), TINY))
        found = found + (times(columns, some) if wide else some)
        rest = rest - (times(lines, times(columns, some)) if wide else times(lines, some))
        if float(np.abs(rest).max(initial=0.0)) <= TINY * first:
            break
    return found.tolist()  # type: ignore[no-any-return]


def transposed(rows: Sequence[Row], count: int) -> list[dict[int, float]]:
    """The columns of a sparse matrix, ``count`` of them."""
    columns: list[dict[int, float]] = [{} for _ in range(count)]
    for i, row in enumerate(rows):
        for k, a in row.items():
            columns[k][i] = a
    return columns


def times(rows: Sequence[Row], x: Array) -> Array:
    """A sparse matrix times x."""
    numbers = x.tolist()
    return np.array([sum(a * numbers[k] for k, a in row.items()) for row in rows])


def steep(rows: Sequence[Row], count: int, least: float) -> bool:
    """Whether the values of ``rows`` change by more than ``least`` along each direction of ``count``
    coordinates: A^T A - s^2 is positive then."""
    numbers = sorted({k for row in rows for k in row})
    if not len(rows) >= len(numbers) == count:
        return False
    place = {k: number for number, k in enumerate(numbers)}
    columns = transposed([{place[k]: float(a) for k, a in row.items()} for row in rows], count)
    matrix = sparse.products(columns, columns)
    for i, row in enumerate(matrix):
        row[i] = row.get(i, 0.0) - least * least
    return sparse.factored(matrix, FILLED * count) is not None


def solved_sparsely(matrix: sparse.Matrix, right: Sequence[float]) -> list[float]:
    """``solved`` for a sparse matrix."""
    diagonal = [row.get(i, 0.0) for i, row in enumerate(matrix)]
    for more in (0.0, TINY) if len(matrix) > DENSE else ():  # a matrix that is not regular becomes positive
        larger = [{**row, i: (1 + more) * diagonal[i]} for i, row in enumerate(matrix)]
        factors = sparse.factored(larger, FILLED * len(matrix))
        if factors is None:
            continue
        found, rest = [0.0] * len(matrix), [*right]
        for _ in range(CORRECTIONS if more else 1):
            found = [x + dx for x, dx in zip(found, factors.solve(rest))]
            rest = [x - sum(a * found[k] for k, a in row.items()) for row, x in zip(matrix, right)]
        if max(map(abs, rest)) <= 1e-6 * max(map(abs, right)):
            return found
    full = np.zeros((len(matrix), len(matrix)))
    for i, row in enumerate(matrix):
        full[i, [*row]] = [*row.values()]
    return solved(full, np.array(right))


def solved(matrix: Array, right: Array) -> list[float]:
    """The solution, or that of least squares and least norm."""
    if not len(right):
        return []
    try:
        with np.errstate(all="ignore"):
            found = np.linalg.solve(matrix, right)
        if np.isfinite(found).all() and np.abs(matrix @ found - right).max() <= 1e-6 * np.abs(right).max():
            return found.tolist()  # type: ignore[no-any-return]
    except np.linalg.LinAlgError:
        pass
    if not np.isfinite(matrix).all():
        raise ArithmeticError("a slope of the constraints has no value")
    return least_squares(matrix, right).tolist()  # type: ignore[no-any-return]


def least_squares(matrix: Array, right: Array) -> Array:
    """The solution of least squares and least norm."""
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=CUT)[0], dtype=np.float64)
