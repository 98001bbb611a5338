"""The numbers of the Radau IIA method of order 5 (E. Hairer and G. Wanner, Solving Ordinary Differential
Equations II, 2nd ed., 1996, sec. IV.5 and IV.8), as they follow from its nodes.

The increments z_i = y(t + c_i h) - y(t) are those of a polynomial p with p(0) = 0 whose rates at the nodes
are those of the equations: z = h A f, with a_ij the integral from 0 to c_i of Lagrange's polynomial for
node j.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from typing import TypeAlias, TypeVar

N = TypeVar("N", float, complex)
Rows: TypeAlias = "tuple[tuple[float, ...], ...]"

STAGES, ROOT = 3, sqrt(6)
NODES = (4 - ROOT) / 10, (4 + ROOT) / 10, 1.0
"""c_1, c_2, c_3: the zeros of (P_3 - P_2)(2 s - 1) (P: Legendre polynomials)."""
MONIC = -0.1, 0.9, -1.8, 1.0
"""The coefficients of (s - c_1) (s - c_2) (s - c_3)."""


def inverse(matrix: Sequence[Sequence[float]]) -> Rows:
    """That of a matrix of 3 rows, by Cramer's rule."""

    def cofactor(i: int, j: int) -> float:
        (a, b), (c, d) = ([matrix[(i + k) % 3][(j + m) % 3] for m in (1, 2)] for k in (1, 2))
        return a * d - b * c

    whole = sum(matrix[0][j] * cofactor(0, j) for j in range(3))
    return tuple(tuple(cofactor(j, i) / whole for j in range(3)) for i in range(3))


POWERS: Rows = tuple(tuple(c**k for k in (1, 2, 3)) for c in NODES)
POLYNOMIAL = inverse(POWERS)
"""Row k - 1: what each increment adds to the coefficient of s^k, in units of the step."""
WEIGHTS: Rows = (
    ((88 - 7 * ROOT) / 360, (296 - 169 * ROOT) / 1800, (-2 + 3 * ROOT) / 225),
    ((296 + 169 * ROOT) / 1800, (88 + 7 * ROOT) / 360, (-2 - 3 * ROOT) / 225),
    ((16 - ROOT) / 36, (16 + ROOT) / 36, 1 / 9),
)
"""The matrix A."""
REAL = 3.0 + 9.0 ** (1 / 3) - 3.0 ** (1 / 3)
COMPLEX = complex(3.0 + (3.0 ** (1 / 3) - 9.0 ** (1 / 3)) / 2, (3.0 ** (5 / 6) + 3.0 ** (7 / 6)) / 2)
"""The eigenvalues of A^-1: this one, and the other one with its conjugate."""


def eigenvector(value: N) -> list[N]:
    """Increments of the polynomial that grows at the nodes at a rate of ``value`` times itself: p' - value p
    is a multiple of ``MONIC``."""
    _, linear, square, _ = MONIC
    second = (3 + value * square) / value
    first = (2 * second + value * linear) / value
    return [first * c + second * c**2 + c**3 for c in NODES]


VALUES: Rows = tuple(
    (real, other.real, -other.imag) for real, other in zip(eigenvector(REAL), eigenvector(COMPLEX))
)
"""T: the increments are T w, where A^-1 multiplies w_1 by ``REAL`` and w_2 + i w_3 by ``COMPLEX``."""
PARTS = inverse(VALUES)
"""T^-1."""
ERROR = (-13 - 7 * ROOT) / 3, (-13 + 7 * ROOT) / 3, -1 / 3
"""The error's rate is f(t, y) + (these times the increments)/h, before it is filtered (eq. IV.8.19)."""
PLACE_ERROR = tuple(sum(e * row[j] for e, row in zip(ERROR, WEIGHTS)) for j in range(STAGES))
"""The same of coordinates, from the increments of velocities."""
