"""Rows that depend on earlier ones, beside those of full matrices and of exact numbers."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from lagrange_cli.model import orthogonal
from lagrange_cli.model.orthogonal import leading
from lagrange_cli.model.start.dependence import DEPENDENT, leading_dense, leading_sparse

Piece = tuple[list[int], np.ndarray]


def rows_of(seed: int, count: int, width: int, repeated: int) -> list[dict[int, float]]:
    """Sparse rows of norm 1 in a band; some are combinations of earlier ones."""
    chance = np.random.default_rng(seed)
    rows: list[dict[int, float]] = []
    for i in range(count):
        if len(rows) > 3 and repeated and chance.random() < repeated / 10:
            first, second = (rows[k] for k in chance.choice(len(rows), 2, replace=False))
            row = {k: first.get(k, 0.0) - 0.5 * second.get(k, 0.0) for k in {*first, *second}}
            row = {k: a for k, a in row.items() if a}
        else:
            places = i // 2 + chance.choice(width, min(3, width), replace=False)
            row = dict(zip(places.tolist(), chance.uniform(-1, 1, len(places)).tolist()))
        norm = float(np.sqrt(sum(a * a for a in row.values())))
        rows.append({k: a / norm for k, a in row.items()})
    return rows


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 40), st.integers(2, 9), st.integers(0, 4))
@example(31, 28, 4, 0)  # its smallest singular value is 7e-8
@example(215536, 37, 5, 3)  # 2e-9
def test_the_rows_that_lead_are_those_of_full_matrices(
    seed: int, count: int, width: int, repeated: int
) -> None:
    rows = rows_of(seed, count, width, repeated)
    assume(leading_dense(rows, DEPENDENT / 2) == leading_dense(rows, 2 * DEPENDENT))
    assert (
        leading(rows, DEPENDENT, DEPENDENT)
        == leading_dense(rows, DEPENDENT)
        == leading_sparse(rows, DEPENDENT)
    )


@settings(max_examples=20, deadline=None)
@given(st.lists(st.lists(st.integers(-3, 3), min_size=6, max_size=6).filter(any), min_size=1, max_size=9))
def test_the_rows_that_lead_are_those_of_exact_numbers(whole: list[list[int]]) -> None:
    rows = [{k: a / float(np.hypot.reduce(row)) for k, a in enumerate(row) if a} for row in whole]
    assert leading(rows, DEPENDENT, DEPENDENT) == independent(whole) == leading_sparse(rows, DEPENDENT)


def independent(rows: list[list[int]]) -> list[int]:
    """The rows that raise the rank, by elimination."""
    kept: list[tuple[int, list[Fraction]]] = []
    found: list[int] = []
    for i, row in enumerate(rows):
        rest = [Fraction(a) for a in row]
        for pivot, other in kept:
            share = rest[pivot] / other[pivot]
            rest = [a - share * b for a, b in zip(rest, other)]
        if any(rest):
            kept.append((next(k for k, a in enumerate(rest) if a), rest))
            found.append(i)
    return found


def test_nearly_parallel_rods_are_told_from_parallel_ones() -> None:
    """A straight chain of 200 rods, each twice, the second time turned by 1e-6 or by 1e-9."""
    for angle, count in ((1e-6, 400), (1e-9, 200)):
        rows: list[dict[int, float]] = []
        for i in range(200):
            for x, y in ((1.0, 0.0), (float(np.cos(angle)), float(np.sin(angle)))):
                row = {2 * i: x, 2 * i + 1: y, **({2 * i - 2: -x, 2 * i - 1: -y} if i else {})}
                norm = float(np.hypot.reduce([*row.values()]))
                rows.append({k: a / norm for k, a in row.items() if a})
        assert len(leading(rows, 1e-7, 1e-7)) == count == len(leading_sparse(rows, 1e-7))


@pytest.mark.parametrize("count", [60, 240])
def test_the_cost_of_long_trains_grows_with_their_length(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Carriages that rods connect, each with two wheels that do not slide sideways, one kind of constraints
    after another: those of the second wheels depend on others, and matrices are small in trains of any
    length."""
    turned = 0.7 * np.arange(count)
    rods = [{3 * i: -1.0, 3 * i + 3: 1.0} for i in range(count - 1)]
    wheels = [{3 * i: -float(np.sin(a)), 3 * i + 1: float(np.cos(a))} for i, a in enumerate(turned)]
    rows = [*rods, *wheels, *wheels, *({3 * i + 1: 0.6, 3 * i + 2: 0.8} for i in range(count))]
    rows = [{k: a / float(np.hypot.reduce([*row.values()])) for k, a in row.items()} for row in rows]
    sizes, joined = list[int](), orthogonal.joined

    def counted(pieces: Sequence[Piece]) -> Piece:
        columns, front = joined(pieces)
        sizes.append(front.size)
        return columns, front

    monkeypatch.setattr(orthogonal, "joined", counted)
    second = range(2 * count - 1, 3 * count - 1)
    assert leading_sparse(rows, DEPENDENT) == [i for i in range(len(rows)) if i not in second]
    assert sum(sizes) < 30 * len(rows)
    sizes.clear()
    assert len(leading(rows, DEPENDENT, DEPENDENT) or ()) == 3 * count - 1
    assert sum(sizes) > 6 * count**2
