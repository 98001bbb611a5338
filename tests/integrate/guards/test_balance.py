"""The choice of forces of friction that constraints bind together, in random problems."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.integrate.guards.balance import balanced, determined, factors, vertex


@pytest.mark.parametrize("size", [1, 2, 5, 12, 40])
def test_solutions_and_their_vertices(size: int) -> None:
    """Rates are 0 where forces are between their bounds, and have their signs elsewhere. At a vertex they are
    the same, and what is held determines all else that is 0."""
    seed = int(np.random.SeedSequence().generate_state(1)[0])
    print(f"{seed = }")
    source = np.random.default_rng(seed)
    for rank in range(0, size + 1, max(size // 6, 1)):
        root = source.standard_normal((size, rank))
        matrix = root @ root.T
        pushes = root @ source.standard_normal(rank) * source.choice([0.3, 1.0, 3.0])
        if source.random() < 0.3:  # constraints that drive what friction cannot hold
            pushes = pushes + source.standard_normal(size)
        s = balanced(matrix, pushes)
        assert s is not None
        small = 1e-9 * (1.0 + np.abs(matrix).sum())
        rates, inside = pushes - matrix @ s, np.abs(s) < 1.0
        assert np.all(np.abs(s) <= 1.0)
        assert np.all(np.abs(rates[inside]) <= small)
        assert np.all(rates[~inside] * s[~inside] >= -small)
        corner = vertex(matrix, s, np.abs(rates) <= small)
        held = np.abs(corner) < 1.0
        assert np.all(np.abs(corner) <= 1.0)
        assert np.allclose(matrix @ corner, matrix @ s, rtol=0.0, atol=10.0 * small)
        assert np.linalg.matrix_rank(matrix[np.ix_(held, held)], tol=small) == np.count_nonzero(held)
        follow = determined(matrix, held)
        assert np.linalg.matrix_rank(matrix[follow], tol=small) == np.count_nonzero(held) or not held.any()


def test_factors_make_slopes_symmetric() -> None:
    source = np.random.default_rng(3)
    root, limits = source.standard_normal((9, 6)), source.uniform(0.1, 4.0, 9)
    slopes = -(root @ root.T) * limits
    found = factors(slopes)
    assert found is not None
    assert np.allclose(found / found[0], limits / limits[0], rtol=1e-9)
    assert factors(-slopes) is None
