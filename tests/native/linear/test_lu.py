"""Blocks of masses: factored and solved in machine code, in every kind of numbers, against what is known."""

import numpy as np
import pytest

from lagrange_cli.native.compilation.machine import FULL, QUICK
from tests.native.linear.blocks import KINDS, exact, solver


@pytest.mark.exhaustive(keep=3)
@pytest.mark.parametrize("level", [QUICK, FULL])
@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize(("size", "unrolled"), [(1, 0), (2, 0), (4, 5), (5, 0), (7, 0), (18, 0)])
def test_what_was_put_in_comes_out(name, size, unrolled, level):
    """Matrices with zeros on the diagonal, so that every column takes an interchange."""
    kind, source = KINDS[name], np.random.default_rng(size)
    solve, parts = solver(kind, size, level, unrolled), kind.parts
    unit = 2.0**-53 if parts == 1 else 2.0**-105
    for _ in range(3):  # in the same memory, as in step after step
        matrix = np.zeros((size, size, parts))
        matrix[..., 0] = source.normal(size=(size, size))
        if size > 1:
            np.fill_diagonal(matrix[..., 0], 0.0)
        if parts == 2:
            matrix[..., 1] = 2.0**-54 * matrix[..., 0] * source.uniform(-1, 1, (size, size))
        right = np.zeros((size, parts))
        right[:, 0] = source.normal(size=size)
        found = exact(solve(matrix, right))
        for row, wanted in zip(matrix, exact(right)):
            terms = [a * x for a, x in zip(exact(row), found)]
            assert abs(sum(terms) - wanted) <= 64 * size * unit * float(sum(map(abs, terms)) + abs(wanted))


@pytest.mark.exhaustive(keep=5)
@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("size", [1, 3, 5, 13])
def test_definite_blocks(name, size):
    """L D L^T of small ones, else L U: the equations hold to some units of rounding, a row twice is found."""
    kind, source = KINDS[name], np.random.default_rng(size)
    solve, parts = solver(kind, size, FULL, 5, "definite"), kind.parts
    unit = 2.0**-53 if parts == 1 else 2.0**-105
    half = source.integers(-9, 9, (size, size))
    matrix, right = np.zeros((size, size, parts)), np.zeros((size, parts))
    matrix[..., 0] = half @ half.T + np.eye(size)
    matrix[..., 1:] = 2.0**-60
    right[:, 0] = source.normal(size=size)
    found = exact(solve(matrix, right))
    for row, wanted in zip(matrix, exact(right)):
        terms = [a * x for a, x in zip(exact(row), found)]
        assert abs(sum(terms) - wanted) <= 64 * size * unit * float(sum(map(abs, terms)) + abs(wanted))
    if size > 1:
        matrix[-1], matrix[:, -1] = matrix[0], matrix[:, 0]
        assert solve(matrix, right) is None


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize(("size", "unrolled"), [(2, 5), (3, 0), (9, 0)])
def test_singular_blocks_are_found(name, size, unrolled):
    """By a pivot of a few units of rounding."""
    solve, parts = solver(KINDS[name], size, FULL, unrolled), KINDS[name].parts
    matrix = np.zeros((size, size, parts))
    matrix[..., 0] = np.random.default_rng(1).integers(-9, 9, (size, size))
    right = np.zeros((size, parts))
    assert solve(matrix, right) is not None
    matrix[-1] = matrix[0]
    matrix[:-1, :, 0] *= 3.0
    assert solve(matrix, right) is None


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize(("size", "unrolled"), [(4, 5), (4, 0), (9, 0)])
def test_large_rows_are_no_measure_for_others(name, size, unrolled):
    """As where what is held comes first: light masses beside it are no rounding errors. Other parts of a row
    that is there twice are."""
    solve, parts = solver(KINDS[name], size, FULL, unrolled), KINDS[name].parts
    matrix = np.zeros((size, size, parts))
    matrix[..., 0] = np.random.default_rng(1).integers(-9, 9, (size, size))
    right = np.zeros((size, parts))
    right[:, 0] = 1.0
    expected = solve(matrix, right)
    matrix[:2] *= 2.0**40
    right[:2] *= 2.0**40
    matrix[2:] *= 2.0**-20
    right[2:] *= 2.0**-20
    found = solve(matrix, right)
    assert found is not None
    assert np.allclose(found[:, 0], expected[:, 0], rtol=1e-12, atol=1e-12)
    matrix[1] = 3.0 * matrix[0]
    assert solve(matrix, right) is None
