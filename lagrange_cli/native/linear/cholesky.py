"""Factorization of a large definite block of the mass matrix, eight rows at a time.

With blocks L_JK of eight by eight and W_J the inverse of L_JJ, the matrix becomes what the solution
(``triangular``) reads: the blocks above the diagonal -(L_JK W_K)^T, those on it W_J^T; the W_J are behind the
matrix.
"""

from __future__ import annotations

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.linear.pivots import FLOOR
from lagrange_cli.native.linear.triangular import solve_definite, solver_of
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Value
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.records import dataclass

PANEL = range(LANES)


@dataclass(frozen=True)
class LargeDefinite:
    """A block of ``size`` rows at ``%work[place]``; behind it are what is kept of its diagonal blocks, its
    pivots' row and a right-hand side."""

    emitter: Emitter
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
    def functions(self) -> tuple[str, ...]:
        """The functions that it calls."""
        return factor_definite(), arrange_definite(), solve_definite(self.stride)

    @property
    def _places(self) -> tuple[int, int, int]:
        pivots = self.place + self.stride * (self.stride + LANES)
        return self.place, pivots, pivots + self.stride

    def factor(self, matrix: list[list[Value]]) -> str:
        """Store the block and factor it; an i1 that tells whether it is regular."""
        place, pivots, _ = self._places
        for j, row in enumerate(matrix):
            for k in range(j, self.size):
                self.emitter.store(row[k], "%work", place + self.stride * j + k)
            self.emitter.store(row[j], "%work", pivots + j)
        f = self.emitter.body
        sizes = f.count(self.size), f.count(self.stride), f.constant(FLOOR * self.emitter.unit)
        return f.call(Bit, "factor_definite", *self._addresses(2), *sizes).name

    def solve(self, right: list[Value], scale: Value) -> list[Value]:
        """x with M x = ``scale * right``."""
        place = self._places[2]
        self.emitter.store_rows(self.stride, [self.emitter.mul(x, scale) for x in right], "%work", place)
        self.emitter.body.call(None, solver_of(self.stride), *self._addresses(3))
        return [self.emitter.load("%work", place + j) for j in range(self.size)]

    def _addresses(self, count: int) -> list[Pointer]:
        return [self.emitter.body.place("%work", place) for place in self._places[:count]]


def _function(result: str, name: str, sizes: str) -> tuple[Function, Pointer, Pointer, Integer, Pointer]:
    """A function with ``a``, ``reciprocal``, ``stride``, and what is behind the matrix."""
    given = f"ptr noalias %a, ptr noalias %reciprocal, {sizes}"
    f = Function(f"define internal {result} @{name}({given}) #0")
    a, reciprocal, stride = f.pointer("%a"), f.pointer("%reciprocal"), Integer(f, "%stride")
    return f, a, reciprocal, stride, f.place(a, stride * stride)


def factor_definite() -> str:
    """IR of ``i1 @factor_definite(a, reciprocal, n, stride, floor)``: whether the block is regular.

    ``a`` has ``stride`` rows of ``stride`` doubles, a multiple of 8, and behind them 8 doubles a row.
    ``reciprocal`` holds the diagonal, and becomes the 1/d_j; what is beyond ``n`` is left out.

    It leaves D L^T in the upper triangle. What earlier rows take off eight others is taken off in
    registers, so that each is read and written once. Behind the matrix are their factors, the panel's -L."""
    f, a, reciprocal, stride, factors = _function(
        "i1", "factor_definite", "i64 %n, i64 %stride, double %floor"
    )
    n, floor, none = Integer(f, "%n"), Real(f, "%floor"), f.constant(0.0)
    regular = f.variable(Bit(f, "true"))

    def rows_at(place: Pointer) -> tuple[list[Pointer], list[Real]]:
        places = [f.place(place, stride * r) for r in PANEL]
        return places, [f.load_row(each, 0, LANES, aligned=True) for each in places]

    def less_above(rows: list[Real], column: Integer, j: Integer) -> list[Real]:
        """Rows of the block there, less what all rows above the panel take off them."""
        totals = [f.variable(row) for row in rows]
        with f.loop(0, j) as k:
            row = f.load_row(a, k * stride + column, LANES, aligned=True)
            of_row = f.place(factors, k * LANES)
            for r, total in enumerate(totals):
                total.set(f.fused(f.splat(f.load(of_row, r), LANES), row, total.get()))
        return [total.get() for total in totals]

    with f.loop(0, stride, step=LANES, tested=False) as j:
        with f.loop(0, j) as k:
            inverse = f.splat(-f.load(reciprocal, k), LANES)
            row = f.load_row(a, k * stride + j, LANES, aligned=True)
            f.store_row(row * inverse, factors, k * LANES, aligned=True)
        places, rows = rows_at(f.place(a, j * stride + j))
        rows = less_above(rows, j, j)
        for r, (place, row) in enumerate(zip(places, rows)):
            pivot, i = f.lane(row, r), j + r
            outside = i >= n
            regular.set(regular.get() & ((pivot > f.load(reciprocal, i) * floor) | outside))
            inverse = f.select(outside, none, 1.0 / pivot)
            f.store(inverse, reciprocal, i)
            taken = row * f.splat(-inverse, LANES)
            f.store_row(taken, factors, i * LANES, aligned=True)
            for below in range(r + 1, LANES):
                rows[below] = f.fused(f.shuffle(taken, [below] * LANES), row, rows[below])
            upper = ", ".join(f"i1 {str(lane >= r).lower()}" for lane in PANEL)
            kept = f.select(Bit(f, f"<{upper}>", LANES), row, f.vector([0.0] * LANES))
            f.store_row(kept, place, 0, aligned=True)
        with f.loop(j + LANES, stride, step=LANES) as column:
            places, rows = rows_at(f.place(a, j * stride + column))
            rows = less_above(rows, column, j)
            for r in PANEL:
                of_row = f.place(factors, (j + r) * LANES)
                for below in range(r + 1, LANES):
                    rows[below] = f.fused(f.splat(f.load(of_row, below), LANES), rows[r], rows[below])
                f.store_row(rows[r], places[r], 0, aligned=True)
    f.call(None, "arrange_definite", a, reciprocal, stride)
    f.give(regular.get())
    return f.text()


def arrange_definite() -> str:
    """``@arrange_definite(a, reciprocal, stride)``: the form that the solution reads."""
    f, a, reciprocal, stride, blocks = _function("void", "arrange_definite", "i64 %stride")
    with f.loop(0, stride, tested=False) as j:
        inverse, row = -f.load(reciprocal, j), f.place(a, j * stride)
        f.store(f.constant(0.0), row, j)
        first = j & -LANES
        with f.loop(first, stride, tested=False) as i:
            lower = f.load(row, i) * inverse
            f.store(lower, row, i)
            with f.when((i & -LANES).equals(first)):
                f.store(lower, blocks, i * LANES + (j & LANES - 1))
    with f.loop(0, stride, step=LANES, tested=False) as j:
        _invert(f, f.place(blocks, j * LANES), f.place(a, j * stride + j), stride)
    with f.loop(0, stride - LANES, step=LANES) as k:
        inverse_at = f.place(a, k * stride + k)
        with f.loop(k + LANES, stride, step=LANES, tested=False) as column:
            _multiply(f, f.place(a, k * stride + column), inverse_at, stride)
    f.give()
    return f.text()


def _invert(f: Function, block: Pointer, columns: Pointer, stride: Integer) -> None:
    """From the rows of -L in the block those of its inverse, in place, and its columns.

    Row i of it is that of the unit matrix less the sum over j < i of L_ij times row j.
    """
    inverse: list[Real] = []
    for i in PANEL:
        row = f.vector([float(lane == i) for lane in PANEL])
        lower = f.load_row(block, LANES * i, LANES, aligned=True)
        for j in range(i):
            row = f.fused(f.shuffle(lower, [j] * LANES), inverse[j], row)
        inverse.append(row)
    for i, row in enumerate(inverse):
        f.store_row(row, block, LANES * i, aligned=True)
        for j in PANEL:
            f.store(f.lane(row, j), columns, stride * j + i)


def _multiply(f: Function, upper: Pointer, inverse: Pointer, stride: Integer) -> None:
    """The block at ``upper``, of -L^T, times W^T, which is at ``inverse``, from the left."""
    places = [f.place(upper, stride * r) for r in PANEL]
    rows = [f.load_row(place, 0, LANES, aligned=True) for place in places]
    for r in PANEL:
        total, factors = rows[r], f.place(inverse, stride * r)
        for lane in range(r + 1, LANES):
            total = f.fused(f.splat(f.load(factors, lane), LANES), rows[lane], total)
        f.store_row(total, places[r], 0, aligned=True)
