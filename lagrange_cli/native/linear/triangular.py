"""Solution with a large definite block of the mass matrix, as ``definite`` leaves it, written out.

With blocks of eight by eight, L y = b is r_J = b_J - sum_{K<J} L_JK W_K r_K with y_J = W_J r_J; and with
s = W^T y / D, block by block, x_K = s_K - sum_{J>K} (L_JK W_K)^T x_J. From one r or x to the next there is
one product with a matrix; it is the same both ways, so what the nearest memory has no room for is read once.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.eights import VECTOR, fma, shuffle, splat


def solver_of(stride: int) -> str:
    """The name of the function for blocks of so many rows, a multiple of 8."""
    return f"solve_definite_{stride}"


def solve_definite(stride: int) -> str:
    """Its IR: ``%b`` becomes the solution."""
    emitter, blocks = Emitter(), range(stride // LANES)
    behind = stride * stride
    right = [_load(emitter, "%b", LANES * j) for j in blocks]
    known: list[str] = []
    for j in blocks:
        rows = [LANES * j + lane for lane in range(LANES)]
        here = [emitter.define(splat(right[j], lane)) for lane in range(LANES)]
        for i in blocks[j + 1 :]:
            right[i] = _add(emitter, here, [stride * row + LANES * i for row in rows], right[i])
        y = _add(emitter, here, [stride * row + LANES * j for row in rows])
        pivots = _load(emitter, "%reciprocal", LANES * j)
        divided = emitter.define(f"fmul {VECTOR} {y}, {pivots}")
        here = [emitter.define(splat(divided, lane)) for lane in range(LANES)]
        known.append(_add(emitter, here, [behind + LANES * row for row in rows]))
    for k in reversed(blocks):
        sums: list[str | None] = [None] * LANES
        for j in reversed(blocks[k + 1 :]):
            for lane in range(LANES):
                row = _load(emitter, "%a", stride * (LANES * k + lane) + LANES * j)
                sums[lane] = _multiply_add(emitter, row, known[j], sums[lane])
        parts = [one for one in sums if one is not None]
        if parts:
            known[k] = emitter.define(f"fadd {VECTOR} {known[k]}, {_sum_across(emitter, parts)}")
        place = emitter.define(f"getelementptr inbounds double, ptr %b, i64 {LANES * k}")
        emitter.line(f"  store {VECTOR} {known[k]}, ptr {place}, align 64")
    body = "\n".join(emitter.lines)
    head = "ptr noalias %a, ptr noalias %reciprocal, ptr noalias %b"
    return f"define internal void @{solver_of(stride)}({head}) #0 {{\n{body}\n  ret void\n}}\n"


def _load(emitter: Emitter, base: str, offset: int) -> str:
    place = emitter.define(f"getelementptr inbounds double, ptr {base}, i64 {offset}")
    return emitter.define(f"load {VECTOR}, ptr {place}, align 64")


def _multiply_add(emitter: Emitter, a: str, b: str, total: str | None) -> str:
    return emitter.define(f"fmul {VECTOR} {a}, {b}" if total is None else fma(a, b, total))


def _add(emitter: Emitter, factors: Sequence[str], rows: Iterable[int], start: str | None = None) -> str:
    """``start`` and the sum of the vectors at these places of ``%a``, each times its factor."""
    totals = [start, None]
    for turn, (factor, row) in enumerate(zip(factors, rows)):
        totals[turn % 2] = _multiply_add(emitter, factor, _load(emitter, "%a", row), totals[turn % 2])
    return emitter.define(f"fadd {VECTOR} {totals[0]}, {totals[1]}")


def _sum_across(emitter: Emitter, vectors: Sequence[str]) -> str:
    """In lane i the sum of the lanes of the i-th vector. Of two vectors each, one half is added to the other,
    and they become one."""
    half = LANES // 2
    while half:
        lanes = range(LANES)
        low = [lane if lane & half == 0 else lane - half + LANES for lane in lanes]
        high = [lane + half if lane & half == 0 else lane + LANES for lane in lanes]
        pairs = zip(vectors[:half], vectors[half:])
        vectors = [
            emitter.define(
                f"fadd {VECTOR} {emitter.define(shuffle(a, b, low))}, {emitter.define(shuffle(a, b, high))}"
            )
            for a, b in pairs
        ]
        half //= 2
    return vectors[0]
