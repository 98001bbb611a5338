"""Scales of unknowns that may be 0 up to rounding, as others cancel in them: by Schwarz's inequality in the
metric of the masses.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mpmath

from lagrange_cli.symbolic.inverses import inverse_of, is_singular
from lagrange_cli.symbolic.measured import Measured, are_dependent, pseudoinverse

Rows = Sequence[Sequence[Measured]]


def by_norms(
    masses: Rows,
    force: Sequence[Measured],
    columns: Rows,
    slopes: Rows,
    rates: Sequence[Measured],
    unknowns: Sequence[Measured],
) -> list[Measured]:
    """The solution of M a = f + C^T lambda, A a = b, with the scales that norms allow, or more. ``columns``
    are C, ``slopes`` A, and ``rates`` -b.

    With g = |f| + |C^T lambda| these are (M^-1)_kk^(1/2) (g^T M^-1 g)^(1/2) for accelerations. Forces of
    constraint are no larger than f and what b needs, so that with G = A M^-1 A^T the multipliers have
    (G^-1)_ii^(1/2) ((f^T M^-1 f)^(1/2) + (b^T G^-1 b)^(1/2)). Where M is singular, the solution is that of
    M + c A^T A and f + c A^T b, as in the compiled equations (``native.linear.symmetric``).
    """
    coordinates, multipliers = range(len(force)), unknowns[len(force) :]
    matrix = values(masses)
    applied = [abs(one.value) for one in force]
    if is_singular(matrix):
        if not multipliers:
            return [*unknowns]
        jacobian = values(slopes)
        weight = sum(matrix[k, k] for k in coordinates) / sum(entry**2 for entry in jacobian)
        matrix += weight * jacobian.T * jacobian
        if is_singular(matrix):
            return [*unknowns]
        for row, b in zip(slopes, rates, strict=True):
            applied = [size + weight * abs(entry.value * b.value) for size, entry in zip(applied, row)]
    inverse = inverse_of(matrix)
    acting = [
        size + sum(abs(column[k].value * one.value) for column, one in zip(columns, multipliers, strict=True))
        for k, size in enumerate(applied)
    ]
    sizes = bounds(inverse, norm(inverse, acting))
    if multipliers:
        effective = values(slopes) * inverse * values(slopes).T
        if not are_dependent(slopes) and is_singular(effective):
            return [*unknowns]
        effective = pseudoinverse(effective) if are_dependent(slopes) else inverse_of(effective)
        sizes += bounds(effective, norm(inverse, applied) + norm(effective, [abs(b.value) for b in rates]))
    return [Measured(own.value, max(own.scale, size)) for own, size in zip(unknowns, sizes, strict=True)]


def values(rows: Rows) -> Any:
    """The matrix of the values."""
    return mpmath.matrix([[entry.value for entry in row] for row in rows])


def norm(inverse: Any, vector: Sequence[Any]) -> Any:
    """(x^T M^-1 x)^(1/2), with absolute values of M^-1."""
    n = range(len(vector))
    return mpmath.sqrt(sum(vector[i] * abs(inverse[i, j]) * vector[j] for i in n for j in n))


def bounds(inverse: Any, whole: Any) -> list[Any]:
    """Those of the components of M^-1 x, where x has this norm."""
    return [mpmath.sqrt(abs(inverse[k, k])) * whole for k in range(inverse.rows)]
