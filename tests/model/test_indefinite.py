"""Equations of masses and constraints that are factored in an order chosen before."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.model.indefinite import saddle_solved

COUNT, BOUND = 40, 12


def drawn(seed: int) -> tuple[list[dict[int, float]], list[dict[int, float]], np.ndarray]:
    """M, A and the right side of a random system; M is a band."""
    chance = np.random.default_rng(seed)
    matter = [{i: 2.0 + chance.random()} for i in range(COUNT)]
    for i in range(COUNT - 1):
        matter[i][i + 1] = matter[i + 1][i] = chance.random() - 0.5
    rows = [
        {int(k): float(chance.random()) + 0.1 for k in chance.choice(COUNT, 3, False)} for _ in range(BOUND)
    ]
    return matter, rows, chance.random(COUNT + BOUND)


def whole(matter: list[dict[int, float]], rows: list[dict[int, float]]) -> np.ndarray:
    """The matrix."""
    made = np.zeros((COUNT + BOUND, COUNT + BOUND))
    for i, row in enumerate([*matter, *rows]):
        for k, x in row.items():
            made[i, k] = made[k, i] = x
    return made


@pytest.mark.parametrize("seed", range(8))
def test_solutions_are_those_of_the_whole_matrix(seed: int) -> None:
    matter, rows, right = drawn(seed)
    found = saddle_solved(matter, rows, right)
    assert found is not None
    assert np.allclose(found, np.linalg.solve(whole(matter, rows), right), rtol=1e-9, atol=1e-11)


def test_what_is_singular_is_left_to_others() -> None:
    """Constraints that are the same, and a coordinate without mass in none of them."""
    matter, rows, right = drawn(0)
    assert saddle_solved(matter, [*rows[:-1], rows[0]], right) is None
    matter[0] = {}
    del matter[1][0]
    rows = [{k: a for k, a in row.items() if k} for row in rows]
    assert saddle_solved(matter, rows, right) is None


def test_what_is_not_sparse_is_left_to_others() -> None:
    count = 250
    matter = [{k: 1.0 + 9.0 * (i == k) for k in range(count)} for i in range(count)]
    assert saddle_solved(matter, [{0: 1.0}], np.ones(count + 1)) is None
