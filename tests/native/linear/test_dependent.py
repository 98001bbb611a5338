"""Equations with constraints of which some follow from others: the solution of least norm, in every kind of
numbers."""

from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from lagrange_cli.native.compilation.machine import FULL
from tests.native.linear.blocks import KINDS, exact, solver
from tests.support.draws import examples


@cache
def made(kind, size, form, **constraints):
    """The compiled function, once for all examples."""
    return solver(kind, size, FULL, 5, form, **constraints)


def bordered(source, coordinates, constraints, surplus, *, light=0):
    """[[M, -A^T], [-A, 0]] of small whole numbers, so that A has its rank exactly; some coordinates have no
    mass."""
    half = source.integers(-5, 5, (coordinates, coordinates))
    masses = half @ half.T + np.eye(coordinates)
    masses[:light], masses[:, :light] = 0.0, 0.0
    rank = constraints - surplus
    slopes = source.integers(-3, 4, (rank, coordinates)).astype(float)
    slopes[:light, :light] += 9.0 * np.eye(rank, coordinates)[:light, :light]
    mixed = source.integers(-2, 3, (surplus, rank)) @ slopes
    slopes = source.permutation(np.concatenate([slopes, mixed]))
    return np.block([[masses, -slopes.T], [-slopes, np.zeros((constraints, constraints))]])


@pytest.mark.exhaustive(keep=6)
@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize(
    ("coordinates", "constraints", "surplus", "light"),
    [(3, 3, 1, 0), (2, 3, 2, 0), (7, 4, 1, 0), (9, 8, 3, 0), (6, 5, 2, 2)],
)
@pytest.mark.parametrize("form", ["definite", "general"])
@given(seed=st.integers(0, 2**32))
@examples(5)
def test_the_solution_of_least_norm(name, form, coordinates, constraints, surplus, light, seed):
    """That of numpy's singular values, up to the condition; and the equations hold to rounding."""
    kind, source, size = KINDS[name], np.random.default_rng(seed), coordinates + constraints
    counts = {"constraints": constraints, "surplus": surplus, "loose": light > 0}
    solve, parts = made(kind, size, form, **counts), kind.parts
    square = bordered(source, coordinates, constraints, surplus, light=light)
    _, singular, vectors = np.linalg.svd(square)
    rank = size - surplus
    assume(singular[rank - 1] > 1e-7 * singular[0])
    matrix, right = np.zeros((size, size, parts)), np.zeros((size, parts))
    matrix[..., 0], right[:, 0] = square, square @ source.integers(-9, 9, size)
    solution = solve(matrix, right)
    expected = np.linalg.lstsq(square, right[:, 0], rcond=1e-11)[0]
    largest, lost = np.abs(expected).max(), singular[0] / singular[rank - 1]
    unit, off = 2.0**-53 if parts == 1 else 2.0**-104, 0.0
    for row, wanted in zip(matrix, exact(right)):
        rest = sum(a * x for a, x in zip(exact(row), exact(solution))) - wanted
        off = max(off, abs(float(rest)))
    assert off <= 64 * unit * (np.abs(square).max() * largest + 1)
    assert np.abs(solution[:, 0] - expected).max() <= 64 * lost * 2.0**-53 * (largest + 1)
    along = vectors[rank:, coordinates:] @ solution[coordinates:, 0]
    assert np.abs(along).max() <= 64 * lost * 2.0**-53 * (largest + 1)


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("form", ["definite", "general"])
def test_a_lower_rank_is_found(name, form):
    """Where yet another constraint follows from others, the equations are singular."""
    kind, source = KINDS[name], np.random.default_rng(2)
    solve, parts = made(kind, 9, form, constraints=4, surplus=1), kind.parts
    for surplus, regular in ((1, True), (2, False)):
        matrix = np.zeros((9, 9, parts))
        matrix[..., 0] = bordered(source, 5, 4, surplus)
        assert (solve(matrix, np.zeros((9, parts))) is not None) is regular
