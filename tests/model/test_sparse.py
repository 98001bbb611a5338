"""Sparse factorizations beside those of full matrices."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from lagrange_cli.model import sparse
from tests.model.test_orthogonal import rows_of


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 40))
def test_solutions_are_those_of_full_matrices(seed: int, count: int) -> None:
    rows = rows_of(seed, count, 5, 0)
    matrix = sparse.products(rows, rows)
    for i, row in enumerate(matrix):
        row[i] += 0.1
    full = np.array([[row.get(k, 0.0) for k in range(count)] for row in matrix])
    right = np.random.default_rng(seed).uniform(-1, 1, count)
    factors = sparse.factored(matrix, count**2)
    assert factors is not None
    assert np.max(np.abs(factors.solve(right.tolist()) - np.linalg.solve(full, right))) < 1e-11
    parts = sparse.parts_of(matrix)
    assert sorted(i for part in parts for i in part) == [*range(count)]
    for part in parts:
        others = [k for k in range(count) if k not in part]
        assert not np.any(full[np.ix_(part, others)])


def test_what_is_not_positive_or_too_full_is_not_factored() -> None:
    assert sparse.factored([{0: 1.0, 1: 1.0}, {0: 1.0, 1: 1.0}], 9) is None
    assert sparse.factored([{0: 1.0, 1: 0.5}, {0: 0.5, 1: 1.0}], 0) is None
