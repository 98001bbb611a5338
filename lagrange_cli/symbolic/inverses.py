"""Inverses of matrices of many digits, to the digits of doubles, and solutions to all digits: where matrices
are regular beyond doubt, by iterative refinement (Higham, Accuracy and Stability of Numerical Algorithms,
section 12.1). This takes n^2 operations with many digits in place of n^3."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mpmath
import numpy as np

REGULAR = 1e10
"""A condition number, after rows and columns were scaled, up to which a matrix is regular beyond doubt."""
SINGULAR = 1e-20
"""With 30 digits, the determinant of a regular matrix is a larger part of the product of its diagonal."""
ROUNDS = 10
"""A round of refinement gains 6 digits or more."""


def nearly_inverse(matrix: Any) -> Any:
    """The inverse to about 6 digits or more; None where the matrix is not regular beyond doubt."""
    n = range(matrix.rows)
    rows = [max((abs(matrix[i, j]) for j in n), default=0) for i in n]
    if not all(mpmath.isfinite(size) and size for size in rows):
        return None
    columns = [max(abs(matrix[i, j]) / rows[i] for i in n) for j in n]
    if not all(columns):
        return None
    scaled = np.array([[float(matrix[i, j] / rows[i] / columns[j]) for j in n] for i in n])
    try:
        inverse = np.linalg.inv(scaled)
    except np.linalg.LinAlgError:
        return None
    condition = abs(scaled).sum(axis=1).max() * abs(inverse).sum(axis=1).max()
    if not condition < REGULAR:
        return None
    return mpmath.matrix([[mpmath.mpf(inverse[j, i]) / columns[j] / rows[i] for i in n] for j in n])


def inverse_of(matrix: Any) -> Any:
    """The inverse, to about 6 digits or more; raises ZeroDivisionError where there is none."""
    nearly = nearly_inverse(matrix)
    return matrix**-1 if nearly is None else nearly


def refined(matrix: Any, nearly: Any, right: Sequence[Any]) -> list[Any]:
    """The solution to all digits, by ``nearly``, the inverse to 6 digits or more."""
    right = mpmath.matrix(right)
    found = nearly * right
    for _ in range(ROUNDS):
        change = nearly * (right - matrix * found)
        found += change
        if all(abs(step) <= mpmath.eps * abs(whole) for step, whole in zip(change, found, strict=True)):
            break
    return list(found)


def is_singular(matrix: Any) -> bool:
    """Whether a symmetric matrix is singular up to rounding: its determinant vanishes beside its diagonal."""
    if nearly_inverse(matrix) is not None:
        return False
    size = mpmath.fprod(abs(matrix[k, k]) for k in range(matrix.rows))
    return not abs(mpmath.det(matrix)) > SINGULAR * size
