"""Solution with a large definite block of the mass matrix, as ``cholesky`` leaves it, without loops.

With blocks of eight by eight, L y = b is r_J = b_J - sum_{K<J} L_JK W_K r_K with y_J = W_J r_J; and with
s = W^T y / D, block by block, x_K = s_K - sum_{J>K} (L_JK W_K)^T x_J. From one r or x to the next there is
one product with a matrix; it is the same both ways, so what the nearest memory has no room for is read once.
"""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Real


def solver_of(stride: int) -> str:
    """The name of the function for blocks of so many rows, a multiple of 8."""
    return f"solve_definite_{stride}"


def solve_definite(stride: int) -> str:
    """Its IR: ``%b`` becomes the solution."""
    given = "ptr noalias %a, ptr noalias %reciprocal, ptr noalias %b"
    f = Function(f"define internal void @{solver_of(stride)}({given}) #0")
    blocks, lanes, behind = range(stride // LANES), range(LANES), stride * stride

    def load(base: str, index: int) -> Real:
        return f.load_row(base, index, LANES, aligned=True)

    def lanes_of(vector: Real) -> list[Real]:
        """Each of its lanes in all lanes."""
        return [f.shuffle(vector, [lane] * LANES) for lane in lanes]

    def product(factors: Sequence[Real], first: int, step: int, start: Real | None = None) -> Real:
        """``start``, and the matrix with columns ``step`` doubles apart from ``first`` on times a vector."""
        even, odd = start, None
        for lane, factor in enumerate(factors):
            even, odd = odd, _add(f, factor, load("%a", first + step * lane), even)
        assert even is not None and odd is not None
        return even + odd

    right = [load("%b", LANES * j) for j in blocks]
    known: list[Real] = []
    for j in blocks:
        here, rows = lanes_of(right[j]), stride * LANES * j
        for i in blocks[j + 1 :]:
            right[i] = product(here, rows + LANES * i, stride, right[i])
        scaled = product(here, rows + LANES * j, stride) * load("%reciprocal", LANES * j)
        known.append(product(lanes_of(scaled), behind + LANES * LANES * j, LANES))
    for k in reversed(blocks):
        sums: list[Real | None] = [None] * LANES
        for j in reversed(blocks[k + 1 :]):
            sums = [
                _add(f, load("%a", stride * (LANES * k + lane) + LANES * j), known[j], total)
                for lane, total in enumerate(sums)
            ]
        parts = [one for one in sums if one is not None]
        if parts:
            known[k] = known[k] + _sum_across(f, parts)
        f.store_row(known[k], "%b", LANES * k, aligned=True)
    f.give()
    return f.text()


def _add(f: Function, a: Real, b: Real, total: Real | None) -> Real:
    return a * b if total is None else f.fused(a, b, total)


def _sum_across(f: Function, vectors: Sequence[Real]) -> Real:
    """In lane i the sum of the lanes of the i-th vector. For each pair of vectors, one half is added to the
    other, and they become one."""
    half = LANES // 2
    while half:
        lanes = range(LANES)
        low = [lane if lane & half == 0 else lane - half + LANES for lane in lanes]
        high = [lane + half if lane & half == 0 else lane + LANES for lane in lanes]
        pairs = zip(vectors[:half], vectors[half:])
        vectors = [f.shuffle(a, low, b) + f.shuffle(a, high, b) for a, b in pairs]
        half //= 2
    return vectors[0]
