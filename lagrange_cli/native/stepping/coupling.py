"""Which rates depend on which coordinates and velocities: the form of the matrices of implicit steps.

Coordinates are put in an order in which those that depend on each other are near (E. Cuthill and J. McKee,
Proc. 24th Nat. Conf. ACM, 1969): then the matrices are banded in chains, rings and lattices.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from lagrange_cli.expression.index_arrays import distinct
from lagrange_cli.native.linear.banded import Banded
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.mechanics.residual import Residual
    from lagrange_cli.native.llvm.function import Function
    from lagrange_cli.native.llvm.vector import Integer, Pointer, Real

IndexArray = np.ndarray[Any, np.dtype[np.int64]]
FEW = 16
"""Up to so many coordinates, matrices are full."""


class Masses(Protocol):
    """M, where accelerations depend on more coordinates than forces do."""

    def function(self) -> Function:
        """What ``push`` calls."""

    def push(self, f: Function, x: Pointer, y: Pointer) -> None:
        """y = M x, in the order of the rows."""

    def add(self, f: Function, band: Banded, terms: list[tuple[Pointer, Real]]) -> None:
        """Add M to matrices of this ``band``, times a number each."""

    def inverse(self, f: Function, coordinate: Integer) -> Real:
        """About 1/M of a coordinate."""


@dataclass(frozen=True)
class Coupling:
    """The ``band`` of a matrix in whose row p is coordinate ``places[p]``, or p if none are given."""

    band: Banded
    places: tuple[int, ...] = ()
    masses: Masses | None = None
    """M, if the matrices are those of forces, times M."""

    @property
    def colours(self) -> int:
        """Columns that are so far apart have no row in common."""
        return min(self.band.size, 2 * self.band.reach + 1)


def full(count: int) -> Coupling:
    """That of ``count`` coordinates each of which may depend on all."""
    return Coupling(Banded(count, count - 1))


def coupling_of(count: int, rows: IndexArray, columns: IndexArray) -> Coupling:
    """The coupling where the rates at ``rows`` depend on the coordinates or velocities at ``columns``; no
    pair comes twice."""
    if not len(rows):
        return Coupling(Banded(count, 0))
    if Banded(count, int(np.bincount(rows).max()) // 2).full:
        return full(count)
    given = Banded(count, int(np.max(np.abs(rows - columns))))
    places = near(count, rows, columns)
    at = np.empty(count, dtype=np.int64)
    at[places] = np.arange(count)
    found = Banded(count, int(np.max(np.abs(at[rows] - at[columns]))))
    best = found if found.reach < given.reach else given
    if best.full:
        return full(count)
    return Coupling(best, tuple(places.tolist()) if best is found else ())


def near(count: int, rows: IndexArray, columns: IndexArray) -> IndexArray:
    """The coordinates in an order in which neighbours are near: each one is followed by those of its
    neighbours that have not come yet, those with few neighbours first."""
    keys = distinct(np.concatenate([rows * count + columns, columns * count + rows]))
    first, second = np.divmod(keys, count)
    bounds, others = np.searchsorted(first, np.arange(count + 1)).tolist(), second.tolist()
    degrees = np.diff(bounds).tolist()
    neighbours = [sorted(others[bounds[k] : bounds[k + 1]], key=degrees.__getitem__) for k in range(count)]

    def spread(start: int, done: Sequence[bool]) -> list[int]:
        seen, listed = {start}, [start]
        for one in listed:
            for other in neighbours[one]:
                if other not in seen and not done[other]:
                    seen.add(other)
                    listed.append(other)
        return listed

    done, order = [False] * count, list[int]()
    for one in sorted(range(count), key=degrees.__getitem__):
        if not done[one]:
            end = spread(one, done)[-1]  # as far as possible from the other ones
            found = spread(end, done)
            order += found
            for each in found:
                done[each] = True
    return np.array(order, dtype=np.int64)


def of_residual(residual: Residual) -> Coupling:
    """The coupling of equations of motion that are written singly."""
    count = len(residual.state_q)
    special = residual.dependent or residual.cyclic_momenta or residual.contacts or residual.bent
    if count <= FEW or special or len(residual.residual) != count + len(residual.multipliers):
        return full(count)
    from lagrange_cli.expression.node import bits, union
    from lagrange_cli.mechanics.matrices import connected

    index = {
        symbol.symbols.bit_length() - 1: k
        for symbols in (residual.model.q, residual.model.v)
        for k, symbol in enumerate(symbols)
    }
    rows, columns = list[int](), list[int]()
    for block in connected(residual.mass_matrix):  # accelerations, and multipliers, in it depend on the same
        together = [node for k in block for node in (residual.residual[k], *residual.mass_matrix[k])]
        found = {index[bit] for bit in bits(union(together)) if bit in index}
        for k in (k for k in block if k < count):
            rows += [k] * len(found)
            columns += found
    return coupling_of(count, np.array(rows, dtype=np.int64), np.array(columns, dtype=np.int64))
