"""Code that factors the mass matrix once a step and solves with it at every order.

Each diagonal block on its own. A definite block by Cholesky's method in the form L D L^T, which needs no
pivoting (Golub and Van Loan, Matrix Computations, 4th ed., sec. 4.1); any other by Gaussian elimination
with partial pivoting. Small blocks are written out, with exchanges as selections; large ones call the
loops of ``linear.ll`` and ``definite.ll``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.linear.triangular import solver_of
from lagrange_cli.native.numbers.double import ONE, Emitter, Value, literal, operand
from lagrange_cli.native.recurrences.convolution import store_rows
from lagrange_cli.records import dataclass

UNROLLED = {"definite": 12, "general": 5}
"""Rows of a block up to which its elimination is written out."""

DEFINITE_FLOOR = 64 * 2.0**-52
"""A pivot smaller than this part of its diagonal entry is rounding: the matrix is singular."""


@dataclass(frozen=True)
class Definite:
    """L D L^T of a block: ``lower[j][i]`` for i < j, and the reciprocals of D."""

    lower: tuple[tuple[Value, ...], ...]
    reciprocal: tuple[Value, ...]

    def solve(self, emitter: Emitter, right: list[Value], scale: Value) -> list[Value]:
        """x with M x = ``scale * right``."""
        x = list(right)
        size = len(x)
        for j in range(size):
            for i in range(j):
                x[j] = emitter.fms(self.lower[j][i], x[i], x[j])
        scales = [emitter.mul(reciprocal, scale) for reciprocal in self.reciprocal]
        x = [emitter.mul(value, factor) for value, factor in zip(x, scales)]
        for j in reversed(range(size)):
            for i in range(j + 1, size):
                x[j] = emitter.fms(self.lower[i][j], x[i], x[j])
        return x


@dataclass(frozen=True)
class General:
    """P M = L U of a block: ``swaps[j][i]`` says (as an i1) whether rows j and i were exchanged."""

    swaps: tuple[tuple[str, ...], ...]
    lower: tuple[tuple[Value, ...], ...]
    upper: tuple[tuple[Value, ...], ...]
    reciprocal: tuple[Value, ...]

    def solve(self, emitter: Emitter, right: list[Value], scale: Value) -> list[Value]:
        """x with M x = ``scale * right``."""
        x = [emitter.mul(value, scale) for value in right]
        size = len(x)
        for j in range(size):
            for i, swap in zip(range(j + 1, size), self.swaps[j]):
                x[j], x[i] = exchange(emitter, swap, x[j], x[i])
        for j in range(size):
            for i in range(j + 1, size):
                x[i] = emitter.fms(self.lower[i][j], x[j], x[i])
        for j in reversed(range(size)):
            for i in range(j + 1, size):
                x[j] = emitter.fms(self.upper[j][i], x[i], x[j])
            x[j] = emitter.mul(x[j], self.reciprocal[j])
        return x


@dataclass(frozen=True)
class InMemory:
    """A block of ``size`` rows at ``%work[place]``; behind it are what ``definite.py`` keeps of its diagonal
    blocks, its pivots' row and the right-hand side's."""

    kind: str
    place: int
    size: int

    @property
    def stride(self) -> int:
        """Doubles of a row: whole vectors."""
        return LANES * -(-self.size // LANES)

    @property
    def doubles(self) -> int:
        """Doubles that the block takes in all."""
        return self.stride * (self.stride + LANES + 2)

    @property
    def pivots(self) -> int:
        """Where its pivots' row is."""
        return self.place + self.stride * (self.stride + LANES)

    @property
    def right(self) -> int:
        """Where its right-hand side is."""
        return self.pivots + self.stride

    @property
    def _sizes(self) -> tuple[str, str]:
        return f"i64 {self.size}", f"i64 {self.stride}"

    def _call(self, emitter: Emitter, result: str, name: str, places: Sequence[int], *more: str) -> str:
        pointers = [
            "ptr " + emitter.define(f"getelementptr inbounds double, ptr %work, i64 {place}")
            for place in places
        ]
        return f"call {result} @{name}({', '.join([*pointers, *more])})"

    def factor(self, emitter: Emitter, matrix: list[list[Value]]) -> str:
        """Store the block and factor it; an i1 that tells whether it is regular."""
        for j, row in enumerate(matrix):
            for k in range(j if self.kind == "definite" else 0, self.size):
                emitter.store(row[k], "%work", self.place + self.stride * j + k)
            if self.kind == "definite":
                emitter.store(row[j], "%work", self.pivots + j)
        places, name = (self.place, self.pivots), f"factor_{self.kind}"
        floor = f"double {operand(literal(DEFINITE_FLOOR))}"
        return emitter.define(self._call(emitter, "i1", name, places, *self._sizes, floor))

    def solve(self, emitter: Emitter, right: list[Value], scale: Value) -> list[Value]:
        """x with M x = ``scale * right``."""
        scaled = [emitter.mul(value, scale) for value in right]
        store_rows(emitter, self.stride, scaled, "%work", self.right)
        places = self.place, self.pivots, self.right
        if self.kind == "definite":
            emitter.line("  " + self._call(emitter, "void", solver_of(self.stride), places))
        else:
            emitter.line("  " + self._call(emitter, "void", "solve_general", places, *self._sizes))
        return [emitter.load("%work", self.right + j) for j in range(self.size)]


Factored: TypeAlias = "Definite | General | InMemory"


def factor_block(
    emitter: Emitter, matrix: list[list[Value]], definite: bool, place: int
) -> tuple[Factored, str, int]:
    """A factored block, an i1 that tells whether it is regular, and the doubles it takes at
    ``%work[place]``."""
    kind = "definite" if definite else "general"
    if len(matrix) > UNROLLED[kind]:
        block = InMemory(kind, place, len(matrix))
        return block, block.factor(emitter, matrix), block.doubles
    factored, regular = (factor_definite if definite else factor_general)(emitter, matrix)
    return factored, regular, 0


def exchange(emitter: Emitter, swap: str, a: Value, b: Value) -> tuple[Value, Value]:
    """(b, a) where ``swap`` holds, else (a, b)."""
    if a is None and b is None:
        return None, None
    first = emitter.define(f"select i1 {swap}, double {operand(b)}, double {operand(a)}")
    second = emitter.define(f"select i1 {swap}, double {operand(a)}, double {operand(b)}")
    return first, second


def factor_definite(emitter: Emitter, matrix: list[list[Value]]) -> tuple[Definite, str]:
    """L D L^T of a symmetric positive block, and an i1 that tells whether it is regular."""
    size = len(matrix)
    lower: list[list[Value]] = [[] for _ in range(size)]
    scaled: list[list[Value]] = [[] for _ in range(size)]  # L[j][i] * D[i]
    reciprocal: list[Value] = []
    regular = "true"
    for j in range(size):
        for i in range(j):
            value = matrix[j][i]
            for m in range(i):
                value = emitter.fms(scaled[j][m], lower[i][m], value)
            scaled[j].append(value)
            lower[j].append(emitter.mul(value, reciprocal[i]))
        pivot = matrix[j][j]
        for m in range(j):
            pivot = emitter.fms(scaled[j][m], lower[j][m], pivot)
        floor = emitter.mul(literal(DEFINITE_FLOOR), matrix[j][j]) if j else None
        good = emitter.define(f"fcmp ogt double {operand(pivot)}, {operand(floor)}")
        regular = emitter.define(f"and i1 {regular}, {good}")
        reciprocal.append(emitter.div(ONE, pivot))
    return Definite(tuple(map(tuple, lower)), tuple(reciprocal)), regular


def factor_general(emitter: Emitter, matrix: list[list[Value]]) -> tuple[General, str]:
    """P M = L U of a block by partial pivoting, and an i1 that tells whether it is regular."""
    size = len(matrix)
    rows = [list(row) for row in matrix]
    lower: list[list[Value]] = [[None] * size for _ in range(size)]
    swaps: list[tuple[str, ...]] = []
    reciprocal: list[Value] = []
    regular = "true"
    for j in range(size):
        swapped = []
        scale: Value = None
        for i in range(j, size):
            scale = emitter.call("llvm.maxnum.f64", scale, emitter.call("llvm.fabs.f64", matrix[i][j]))
        for i in range(j + 1, size):
            here = emitter.call("llvm.fabs.f64", rows[j][j])
            there = emitter.call("llvm.fabs.f64", rows[i][j])
            swap = emitter.define(f"fcmp ogt double {there}, {here}")
            swapped.append(swap)
            for k in range(size):
                if k >= j:
                    rows[j][k], rows[i][k] = exchange(emitter, swap, rows[j][k], rows[i][k])
                else:
                    lower[j][k], lower[i][k] = exchange(emitter, swap, lower[j][k], lower[i][k])
        swaps.append(tuple(swapped))
        floor = emitter.mul(literal(DEFINITE_FLOOR), scale) if j else None
        good = emitter.define(
            f"fcmp ogt double {emitter.call('llvm.fabs.f64', rows[j][j])}, {operand(floor)}"
        )
        regular = emitter.define(f"and i1 {regular}, {good}")
        reciprocal.append(emitter.div(ONE, rows[j][j]))
        for i in range(j + 1, size):
            lower[i][j] = emitter.mul(rows[i][j], reciprocal[j])
            for k in range(j + 1, size):
                rows[i][k] = emitter.fms(lower[i][j], rows[j][k], rows[i][k])
    return General(
        tuple(swaps), tuple(map(tuple, lower)), tuple(map(tuple, rows)), tuple(reciprocal)
    ), regular
