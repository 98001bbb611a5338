"""Full and banded matrices in machine code, real and complex, against what is known."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import numpy as np
import pytest

from lagrange_cli.integrate.arrays import aligned
from lagrange_cli.native.compilation.llvm import compile_text
from lagrange_cli.native.compilation.machine import QUICK, load
from lagrange_cli.native.linear.banded import Banded
from lagrange_cli.native.state import LANES

SHAPES = [(1, 0), (2, 1), (3, 2), (7, 6), (9, 8), (33, 32), (40, 0), (40, 1), (41, 2), (43, 4), (64, 9)]


def solver(band: Banded, parts: int) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """(matrix, right-hand side) -> solution. What is behind the numbers of the right-hand side is not finite,
    as it is after another one that was not."""
    text = "\n".join(f.text().replace("internal ", "") for f in band.functions(parts))
    loaded, pointer = load(compile_text(text, QUICK)), ctypes.c_void_p
    factor = ctypes.CFUNCTYPE(None, pointer)(loaded.address(f"factor_{parts}"))
    solve = ctypes.CFUNCTYPE(None, pointer, pointer)(loaded.address(f"solve_{parts}"))
    work, x = aligned(band.room(parts)), aligned(parts * band.length)

    def solution(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
        assert loaded
        planes = (matrix.real, matrix.imag)[:parts]
        for k, plane in enumerate(planes):
            work[k * band.doubles : (k + 1) * band.doubles] = 0.0
            for i, j in zip(*np.nonzero(plane)):
                work[k * band.doubles + band.first + i * band.stride + j] = plane[i, j]
        x[:] = np.nan
        for k, plane in enumerate((right.real, right.imag)[:parts]):
            x[k * band.length : k * band.length + band.size] = plane
        factor(work.ctypes.data)
        solve(work.ctypes.data, x.ctypes.data)
        found = [x[k * band.length : k * band.length + band.size] for k in range(parts)]
        behind = [k * band.length + band.size for k in range(parts)]
        assert not any(x[first : first + LANES].any() for first in behind)
        return found[0] + 1j * found[1] if parts == 2 else found[0].copy()

    return solution


@pytest.mark.exhaustive(keep=11)
@pytest.mark.parametrize("parts", [1, 2], ids=["real", "complex"])
@pytest.mark.parametrize(("size", "reach"), SHAPES)
def test_solutions_are_those_of_lapack(size: int, reach: int, parts: int) -> None:
    """Diagonals of zeros here and there ask for interchanges."""
    band, chance = Banded(size, reach), np.random.default_rng(size + reach)
    assert band.full == (3 * reach + 9 >= size)
    solve = solver(band, parts)
    near = abs(np.subtract.outer(np.arange(size), np.arange(size))) <= reach
    for _ in range(3):
        matrix = chance.normal(size=(2, size, size))[:parts]
        matrix = np.where(near, matrix[0] + (1j * matrix[1] if parts == 2 else 0), 0)
        if reach:
            matrix[np.arange(0, size, 3), np.arange(0, size, 3)] = 0
        right = chance.normal(size=size) + (1j * chance.normal(size=size) if parts == 2 else 0)
        expected = np.linalg.solve(matrix, right)
        error = np.max(np.abs(solve(matrix, right) - expected)) / np.max(np.abs(expected))
        assert error < 1e-15 * np.linalg.cond(matrix) + 1e-14


def test_a_band_takes_memory_in_proportion_to_its_rows() -> None:
    one, ten = (Banded(size, 2).room(2) for size in (10_000, 100_000))
    assert ten < 10.1 * one
    assert one < 10_000 * 90
