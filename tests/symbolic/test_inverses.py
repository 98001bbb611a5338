"""Linear systems with many digits, solved by inverses of doubles."""

from __future__ import annotations

from random import Random

import mpmath
import pytest

from lagrange_cli.symbolic.inverses import is_singular, nearly_inverse, refined
from lagrange_cli.symbolic.measured import Measured, solve_measured


def random_matrix(n, seed, spread):
    """A symmetric one that is regular, with rows and columns of very different sizes."""
    draw = Random(seed)
    sizes = [mpmath.mpf(10) ** draw.uniform(-spread, spread) for _ in range(n)]
    entries = [[mpmath.mpf(draw.uniform(-1, 1)) for _ in range(n)] for _ in range(n)]
    return mpmath.matrix(
        [
            [sizes[i] * sizes[j] * (entries[min(i, j)][max(i, j)] + n * (i == j)) for j in range(n)]
            for i in range(n)
        ]
    )


@pytest.mark.parametrize("spread", [0, 10, 300])
def test_solutions_have_all_digits(spread):
    with mpmath.workdps(30):
        matrix, exact = random_matrix(7, 1, spread), [mpmath.mpf(k) / 3 - 1 for k in range(7)]
        with mpmath.workdps(100):
            right = list(matrix * mpmath.matrix(exact))
        found = refined(matrix, nearly_inverse(matrix), right)
        sizes = [mpmath.sqrt(matrix[k, k]) for k in range(7)]
        errors = [abs(x - y) * size for x, y, size in zip(found, exact, sizes, strict=True)]
        assert max(errors) < 1e-28 * max(map(mpmath.fmul, sizes, map(abs, exact)))
        unit = nearly_inverse(matrix) * matrix
        assert all(abs(unit[k, k] - 1) < 1e-10 for k in range(7))


def test_what_is_nearly_singular_is_solved_with_many_digits():
    with mpmath.workdps(30):
        hilbert = mpmath.hilbert(12)
        assert nearly_inverse(hilbert) is None
        rows = [[Measured(x, abs(x)) for x in hilbert[k, :]] for k in range(12)]
        ones = [Measured(x, abs(x)) for x in hilbert * mpmath.ones(12, 1)]
        assert all(abs(one.value - 1) < 1e-11 for one in solve_measured(rows, ones))


@pytest.mark.parametrize(
    ("rows", "singular"),
    [
        ([[1, 2], [2, 4]], True),
        ([[1, 2], [2, 4 + 1e-12]], False),
        ([[0, 0], [0, 1]], True),
        ([[1e-200, 0], [0, 1e200]], False),
        ([[0, 1], [1, 0]], False),
    ],
)
def test_singular_matrices_are_recognized(rows, singular):
    with mpmath.workdps(30):
        assert is_singular(mpmath.matrix(rows)) is singular
