"""The products of a banded M for the matrices of implicit steps: those of M^-1 K are full where M is not
diagonal, and those of M and K are banded."""

from __future__ import annotations

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.native.families.arrangement import Arrangement
from lagrange_cli.native.families.tables import place_at
from lagrange_cli.native.families.vectors import DoubleVectors
from lagrange_cli.native.linear.banded import Banded
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Pointer, Real

PUSHED = "pushed"
"""The function that multiplies by M."""


class BandedMasses:
    """M of a program whose steps have matrices with the coordinates at ``places``, in this order."""

    def __init__(self, arrangement: Arrangement, places: tuple[int, ...]) -> None:
        factors, system = arrangement.factors, arrangement.system
        assert factors is not None and system.coupled_masses is not None
        self.arrangement, self.entries, count = arrangement, factors.entries, system.q.count
        at = np.arange(count)
        if places:
            at[np.array(places)] = np.arange(count)
        i, j = at[system.coupled_masses.pairs.T]
        every, below = np.arange(len(i)), i != j
        rows, columns, entries = (
            np.concatenate([one, other[below]]) for one, other in ((i, j), (j, i), (every, every))
        )
        order = np.lexsort((columns, rows))
        self.count = len(order)
        self.rows, self.columns, self.numbers = (self.table(one[order]) for one in (rows, columns, entries))

    def table(self, places: Places) -> int:
        """A table of places."""
        return self.arrangement.tables.of_array(places)

    def entry(self, f: Function, k: Integer) -> tuple[Integer, Integer, Real]:
        """A row, a column, and the number there."""
        arrangement = self.arrangement
        base = arrangement.scratch(DoubleVectors(f))
        numbers = f.place(base, arrangement.places[self.entries], "double")
        row, column, number = (place_at(f, k + one) for one in (self.rows, self.columns, self.numbers))
        return row, column, f.load(numbers, number)

    def function(self) -> Function:
        """``@pushed(constants, x, y)``: y = M x."""
        f = Function(
            f"define internal void @{PUSHED}(ptr noalias %constants, ptr noalias %x, ptr noalias %y) #0"
        )
        with f.loop(0, self.arrangement.degrees, tested=False) as p:
            f.store(f.constant(0.0), "%y", p)
        with f.loop(0, self.count, tested=False) as k:
            row, column, number = self.entry(f, k)
            f.store(f.fused(number, f.load("%x", column), f.load("%y", row)), "%y", row)
        f.give()
        return f

    def push(self, f: Function, x: Pointer, y: Pointer) -> None:
        """y = M x."""
        f.call(None, PUSHED, f.pointer("%constants"), x, y)

    def add(self, f: Function, band: Banded, terms: list[tuple[Pointer, Real]]) -> None:
        """Add M to matrices of this ``band``, times a number each."""
        with f.loop(0, self.count, tested=False) as k:
            row, column, number = self.entry(f, k)
            at = band.at(row, column)
            for matrix, factor in terms:
                f.store(f.fused(number, factor, f.load(matrix, at)), matrix, at)

    def inverse(self, f: Function, coordinate: Integer) -> Real:
        """About 1/M: that of the diagonal."""
        arrangement = self.arrangement
        base = arrangement.scratch(DoubleVectors(f))
        inverses = f.place(base, arrangement.places[arrangement.lasting.inverses], "double")
        return f.magnitude(f.load(inverses, coordinate))
