"""Linear algebra of constraints: which of them are independent, and equations with their slopes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from lagrange_cli.model import orthogonal, sparse
from lagrange_cli.model.start.equations import Matter, Row

if TYPE_CHECKING:
    from numpy.typing import NDArray

Array: TypeAlias = "NDArray[np.float64]"

DEPENDENT = 1e-7
"""A constraint depends on others where the sine of the angle between its slopes and theirs is smaller."""
APART = 1e-5
"""The same at states that are not known exactly."""
CLEAR = 1e-4
"""The square of this sine, from which on no closer look is needed."""
DENSE = 100
"""Constraints up to which matrices are full."""
CHANGED = 1e-5
"""Factors that differ by more, beside the largest, are not the same."""
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


def independent(
    rows: Sequence[Row], scale: Sequence[float], typical: Sequence[float] = (), sine: float = DEPENDENT
) -> list[int]:
    """The rows, in their order, that do not depend on earlier ones, with slopes by x_k/``scale[k]``.

    A row that is
    negligible beside its ``typical`` steepness depends on any others. ``sine`` is that of the
    angle below which one does.
    """
    scaled = [{k: float(a) * scale[k] for k, a in row.items()} for row in rows]
    norms, least = steepness(rows, scale), [sine * x for x in typical] or [0.0] * len(rows)
    kept = [i for i, norm in enumerate(norms) if least[i] < norm < math.inf]
    unit = [{k: a / norms[i] for k, a in scaled[i].items()} for i in kept]
    if len(kept) <= DENSE:
        return [kept[i] for i in leading_dense(unit, sine)]
    matrix = sparse.products(unit, unit)
    found: list[int] = []
    for part in sparse.parts_of(matrix):
        factors = sparse.factored(sparse.within(matrix, part), FILLED * len(part))
        if factors is not None and min(factors.pivots) > CLEAR:
            found += [kept[i] for i in part]
            continue
        mine = [unit[i] for i in part]
        chosen = leading_dense(mine, sine) if len(part) <= DENSE else orthogonal.leading(mine, sine)
        found += [kept[part[i]] for i in chosen]
    return sorted(found)


def leading_dense(unit: Sequence[Mapping[int, float]], sine: float) -> list[int]:
    """The rows of norm 1 that do not depend on earlier ones."""
    if not unit:
        return []
    try:
        pivots = np.diag(np.linalg.cholesky(products(unit, unit))) ** 2
        if pivots.min() > CLEAR:
            return [*range(len(unit))]
    except np.linalg.LinAlgError:
        pass
    places = {k: place for place, k in enumerate(sorted({k for row in unit for k in row}))}
    basis = np.zeros((min(len(unit), len(places)), len(places)))
    found: list[int] = []
    for i, row in enumerate(unit):
        rest = np.zeros(len(places))
        rest[[places[k] for k in row]] = list(row.values())
        done = basis[: len(found)]
        for _ in range(2):  # twice is enough (Kahan and Parlett)
            rest -= done.T @ (done @ rest)
        norm = float(np.linalg.norm(rest))
        if norm > sine and len(found) < len(basis):
            basis[len(found)] = rest / norm
            found.append(i)
    return found


def tied(rows: Sequence[Row], kept: Sequence[int], scale: Sequence[float]) -> list[set[int]]:
    """The rows of each combination that vanishes: one that is not ``kept``, and those it follows from."""
    unit = [
        {k: float(a) * scale[k] / (norm or 1.0) for k, a in row.items()}
        for row, norm in zip(rows, steepness(rows, scale))
    ]
    among = {*kept}
    rest = [i for i in range(len(rows)) if i not in among]
    found = {i: {i} for i in rest}
    for part in sparse.parts_of(sparse.products(unit, unit)) if rest else ():
        others, mine = [i for i in part if i not in among], [i for i in part if i in among]
        if others and mine:
            shares = shares_of([unit[i] for i in mine], [unit[i] for i in others])
            for k, j in np.argwhere(np.abs(shares) > APART).tolist():
                found[others[j]].add(mine[k])
    return [*found.values()]


def joined(groups: Iterable[Iterable[int]]) -> tuple[tuple[int, ...], ...]:
    """The same groups, those that have a number in common as one."""
    found: list[set[int]] = []
    of: dict[int, set[int]] = {}
    for group in groups:
        whole = {*group}
        for other in {id(of[i]): of[i] for i in whole if i in of}.values():
            whole |= other
        of.update(dict.fromkeys(whole, whole))
        found.append(whole)
    return tuple(sorted(tuple(sorted(one)) for one in found if of[min(one)] is one))


def in_turn(places: Sequence[Sequence[Row]], kept: Sequence[int], scale: Sequence[float]) -> tuple[int, ...]:
    """The rows that are not ``kept`` and are combinations of those by factors that differ between places, and
    those that are coupled with them."""
    among, found = {*kept}, list[int]()
    scaled = [[{k: float(a) * scale[k] for k, a in row.items()} for row in rows] for rows in places]
    for part in sparse.parts_of(sparse.products(scaled[0], scaled[0])):
        others, mine = [i for i in part if i not in among], [i for i in part if i in among]
        if others and mine:
            first, *rest = (shares_of([rows[i] for i in mine], [rows[i] for i in others]) for rows in scaled)
            largest = max((float(np.abs(one - first).max()) for one in rest), default=0.0)
            found += others if largest > CHANGED * float(np.abs(first).max()) else []
    return tuple(sorted(found))


def shares_of(own: Sequence[Row], others: Sequence[Row]) -> Array:
    """The combinations of ``own`` rows, which are independent, that are nearest to others: a column for
    each of these."""
    if len(own) > DENSE:
        factors = sparse.factored(sparse.products(own, own), FILLED * len(own))
        if factors is not None:
            columns = transposed(sparse.products(own, others), len(others))
            known = [factors.solve([row.get(i, 0.0) for i in range(len(own))]) for row in columns]
            return np.stack([np.array(one) for one in known], axis=1)
    return least_squares(products(own, own), products(own, others))


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
