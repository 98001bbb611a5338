"""The pattern of nonzero entries for factoring and solving equations with constraints in blocks of eight.

The numbers themselves are in arrays of the work space; ``saddle`` writes the loops over these tables.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.model.sparse import Elimination, eliminated
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.recurrences.batches.tables import Tables
from lagrange_cli.records import dataclass

MOST = 16
"""Numbers of L for each unknown up to which its places are listed."""

NOWHERE = -1, -1
"""No place of the matrix."""

T = TypeVar("T")
Term = tuple[int, int]
"""The places of two factors."""


def elimination_of(residual: Residual) -> Elimination | None:
    """How the matrix of the equations is eliminated; None where it is full, or may not be eliminated in any
    order."""
    firm = residual.definite and not (residual.pushed or residual.weightless)
    if not (firm and residual.multipliers) or residual.inertias or residual.cyclic_momenta:
        return None
    neighbours = [{k for k in row if k != j} for j, row in enumerate(residual.entries)]
    return eliminated(neighbours, len(residual.model.q), MOST * len(neighbours))


@dataclass(frozen=True)
class Rows:
    """Sums of products of so many ``blocks`` of eight, ``length`` terms together; and where their tables are:
    the first and the last term of each block, what it is taken from, and the places of both factors."""

    blocks: int
    length: int
    starts: int
    ends: int
    targets: int
    first: int
    second: int


class SaddleTables:
    """The tables of an elimination, and where its arrays are, from ``first`` on."""

    def __init__(self, elimination: Elimination, tables: Tables, first: int) -> None:
        self.elimination, self.tables = elimination, tables
        self.listed: list[int | None] = []
        """The unknowns by their positions: each round begins a block of eight."""
        self.ends: list[int] = []
        for one in elimination.rounds:
            self.listed += [*one, *[None] * (-len(one) % LANES)]
            self.ends.append(len(self.listed))
        self.position = {i: place for place, i in enumerate(self.listed) if i is not None}
        self.begin = self.ends[elimination.first - 1]
        """The first row of the constraints."""
        self.pairs: list[tuple[int, int] | None] = []
        """The places (i, p) of L, of each round in whole blocks."""
        self.pair_ends: list[int] = []
        for one in elimination.rounds:
            pairs = [(i, p) for p in one for i in elimination.columns[p]]
            self.pairs += [*pairs, *[None] * (-len(pairs) % LANES)]
            self.pair_ends.append(len(self.pairs))
        self.number = {pair: place for place, pair in enumerate(self.pairs) if pair is not None}
        self.forward, self.backward = self._passes()
        sizes = {
            "unknowns": len(self.listed) + LANES,
            "inverse": len(self.listed),
            "diagonal": len(self.listed),
            "lower": len(self.pairs) + LANES,
            "upper": len(self.pairs) + LANES,
            "rows": LANES * self.forward.length,
            "columns": LANES * self.backward.length,
        }
        self.end, self.places = first, dict[str, int]()
        for name, size in sizes.items():
            self.places[name] = self.end
            self.end += size

    def _passes(self) -> tuple[Rows, Rows]:
        """The tables of both passes of a solution: the unknowns that each one takes from, and how much."""
        rows, columns = self.elimination.rows, self.elimination.columns
        zero = len(self.pairs), len(self.listed)

        def of(unknown: int | None, forward: bool) -> list[Term]:
            if unknown is None:
                return []
            if forward:
                return [(self.number[unknown, p], self.position[p]) for p in rows[unknown]]
            return [(self.number[i, unknown], self.position[i]) for i in columns[unknown]]

        size = len(self.listed) // LANES
        order = [*range(size)], [*reversed(range(size))]
        return (
            self.rows_of([[of(i, True) for i in self._eight(b)] for b in order[0]], order[0], zero),
            self.rows_of([[of(i, False) for i in self._eight(b)] for b in order[1]], order[1], zero, True),
        )

    def _eight(self, block: int) -> Sequence[int | None]:
        return self.listed[LANES * block : LANES * (block + 1)]

    def rows_of(
        self, terms: Sequence[Sequence[list[Term]]], targets: Sequence[int], zero: Term, all: bool = False
    ) -> Rows:
        """Tables of the ``terms`` of blocks of eight; blocks without terms are left out unless ``all``
        stay."""
        first, second = list[int](), list[int]()
        starts, ends, kept = list[int](), list[int](), list[int]()
        for eight, target in zip(terms, targets):
            longest = max(map(len, eight))
            if not longest and not all:
                continue
            starts.append(len(first) // LANES)
            kept.append(target)
            for t in range(longest):
                row = [one[t] if t < len(one) else zero for one in eight]
                first += [a for a, _ in row]
                second += [b for _, b in row]
            ends.append(len(first) // LANES)
        made = (starts, ends, kept, first, second)
        tables = [self.tables.of_places(one) if one else 0 for one in made]
        return Rows(len(kept), len(first) // LANES, *tables)

    def entries(self, of: Callable[[int, int], T], one: T, other: T) -> Mapping[str, Sequence[T]]:
        """The entries ``of`` the matrix by the arrays that they are factored in; where there is no unknown
        they are ``one``, and ``other`` among the constraints. Off the diagonal there are none then."""
        firm = [one if place < self.begin else other for place in range(len(self.listed))]
        diagonal = [sign if i is None else of(i, i) for i, sign in zip(self.listed, firm)]
        return {"diagonal": diagonal, "lower": [of(*(pair or NOWHERE)) for pair in self.pairs]}
