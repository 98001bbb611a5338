"""The pattern of nonzero entries for factoring and solving equations with constraints in blocks of eight.

The numbers themselves are in arrays of the work space; ``saddle`` writes the loops over these tables.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import accumulate
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.index_arrays import distinct
from lagrange_cli.families.tables import in_groups
from lagrange_cli.model.sparse import SparseElimination
from lagrange_cli.native.families.tables import Tables
from lagrange_cli.native.interface import LANES
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places

FLOORS = "unknowns"
"""The array in which the sizes of pivots are, as they are found."""
Entry = tuple[int, int]
"""Two unknowns."""


@dataclass(frozen=True)
class RowSums:
    """Sums of products of so many ``blocks`` of eight, ``length`` terms together; and where their tables are:
    the first and the last term of each block, what it is taken from, and the places of both factors."""

    blocks: int
    length: int
    starts: int
    ends: int
    targets: int
    first: int
    second: int


@dataclass(frozen=True)
class Terms:
    """Products of what is at the places ``first`` and ``second``, for what is at the place ``targets``."""

    targets: Places
    first: Places
    second: Places

    def of(self, which: Places) -> Terms:
        """Some of them."""
        return Terms(self.targets[which], self.first[which], self.second[which])


@dataclass(frozen=True)
class EliminationRounds:
    """The rounds of an elimination: sums for entries of D and of L, and tables of where those of a round
    begin among these, among blocks of positions, and among blocks of pairs."""

    diagonal: RowSums
    lower: RowSums
    of_diagonal: int
    of_lower: int
    positions: int
    pairs: int


class SaddleTables:
    """The tables of an elimination, and where its arrays are behind a beginning."""

    def __init__(self, elimination: SparseElimination, tables: Tables) -> None:
        self.elimination, self.tables = elimination, tables
        self.listed: list[int | None] = []
        """The unknowns by their positions: each round begins a block of eight."""
        ends, pair_ends = [0], [0]
        self.pairs: list[Entry | None] = []
        """The places (i, p) of L, of each round in whole blocks."""
        for one in elimination.rounds:
            self.listed += [*one, *[None] * (-len(one) % LANES)]
            ends.append(len(self.listed))
            pairs = [(i, p) for p in one for i in elimination.columns[p]]
            self.pairs += [*pairs, *[None] * (-len(pairs) % LANES)]
            pair_ends.append(len(self.pairs))
        self.pivot = positions(self.listed)
        """Where 1/D is for each unknown."""
        self.count = len(self.pivot)
        self._places = np.array([self.pivot[i] for i in range(self.count)], dtype=np.int64)
        self.tail, before = tail_of(elimination)
        """The last unknowns, as many as one block has: they are solved for together."""
        self.tail_at = ends[before]
        """Where these are in a solution: side by side."""
        self.solved = [*self.listed[: self.tail_at], *self.tail, *[None] * (-len(self.tail) % LANES)]
        """The unknowns by their positions in a solution."""
        self.position = positions(self.solved)
        kept = [(place, pair) for place, pair in enumerate(self.pairs) if pair is not None]
        self._numbers = np.array([place for place, _ in kept], dtype=np.int64)
        rows = np.array([pair for _, pair in kept], dtype=np.int64).reshape(-1, 2)
        self._later, self._earlier = rows[:, 0], rows[:, 1]
        self.in_solution = np.array([self.position[i] for i in range(self.count)], dtype=np.int64)
        known, reverse = self.in_solution[self._earlier], self.in_solution[self._later]
        early = np.flatnonzero(known < self.tail_at)
        size, zero = len(self.solved) // LANES, len(self.listed)
        terms = Terms(reverse, self._numbers, known)
        self.forward = self._rows(
            terms.of(early[np.argsort(known[early], kind="stable")]), np.arange(size), zero
        )
        terms = Terms(known, self._numbers, reverse)
        by_row = np.lexsort((self._later, self._places[self._earlier]))  # by the one eliminated earlier
        blocks = np.arange(self.tail_at // LANES)[::-1]
        self.backward = self._rows(terms.of(by_row[known[by_row] < self.tail_at]), blocks, zero, every=True)
        self.within = {pair: place for place, pair in kept if pair[1] in self.tail}
        """Where L has the entries of the last unknowns."""
        self.factoring = self._factoring(np.array(ends), np.array(pair_ends))
        self.pivots = self.tables.of_array(
            np.array([0 if pair is None else self.pivot[pair[1]] for pair in self.pairs], dtype=np.int64)
        )
        """Where 1/D is for each pair."""
        sizes = {
            "unknowns": len(self.listed) + LANES,
            "inverse": len(self.listed),
            "diagonal": len(self.listed),
            "lower": len(self.pairs) + LANES,
            "upper": len(self.pairs) + LANES,
            "rows": LANES * self.forward.length,
            "columns": LANES * self.backward.length,
            "tail_rows": LANES * LANES,
            "tail_columns": LANES * LANES,
        }
        self.places = dict(zip(sizes, accumulate(sizes.values(), initial=0)))
        self.size = sum(sizes.values())
        """The doubles of all arrays."""

    def _factoring(self, ends: Places, pair_ends: Places) -> EliminationRounds:
        """The tables of factoring: what entries of D and of L are given by earlier pivots."""
        zero = len(self.pairs)
        diagonal = Terms(self._places[self._later], self._numbers, self._numbers)
        starts = np.flatnonzero(np.diff(self._earlier, prepend=-1))
        counts = np.diff(np.append(starts, len(self._earlier)))
        one, other = couples(starts, counts)
        below = self._places[self._later[one]] > self._places[self._later[other]]
        one, other = one[below], other[below]
        keys = self._later * self.count + self._earlier
        order = np.argsort(keys)
        wanted = self._later[one] * self.count + self._later[other]
        targets = self._numbers[order[np.searchsorted(keys[order], wanted)]] if len(one) else one
        lower = Terms(targets, self._numbers[one], self._numbers[other])
        sums, limits = [], [some // LANES for some in (ends, pair_ends)]
        for terms, limit in zip((diagonal, lower), limits):
            met = distinct(terms.targets // LANES)
            sums.append((self._rows(terms, met, zero), self.tables.of_array(np.searchsorted(met, limit))))
        (pivots, of_diagonal), (under, of_lower) = sums
        begins = [self.tables.of_array(limit) for limit in limits]
        return EliminationRounds(pivots, under, of_diagonal, of_lower, *begins)

    def _rows(self, terms: Terms, blocks: Places, zero: int, *, every: bool = False) -> RowSums:
        """Tables of the terms of these ``blocks`` of eight targets, in this order; blocks without terms are
        left out unless ``every`` one stays. Where a target has fewer terms than others of its block, these
        are products with what is at the place ``zero``."""
        order = np.argsort(terms.targets, kind="stable")
        sorted_ = terms.of(order)
        counts = np.bincount(sorted_.targets, minlength=LANES * (int(blocks.max(initial=0)) + 1))
        ranks = in_groups(counts)[1]
        longest = counts.reshape(-1, LANES).max(axis=1)
        kept = blocks if every else blocks[longest[blocks] > 0]
        ends = np.cumsum(longest[kept])
        starts = ends - longest[kept]
        length = int(ends[-1]) if len(ends) else 0
        begins = np.zeros(len(longest), dtype=np.int64)
        begins[kept] = starts
        at = (begins[sorted_.targets // LANES] + ranks) * LANES + sorted_.targets % LANES
        both = []
        for places in (sorted_.first, sorted_.second):
            filled = np.full(LANES * length, zero if places is sorted_.second else len(self.pairs))
            filled[at] = places
            both.append(filled)
        tables = [self.tables.of_array(one) for one in (starts, ends, kept, *both)]
        return RowSums(len(kept), length, *tables)

    def placed(self, pairs: Places, sizes: Places | None = None) -> Mapping[str, Places]:
        """Where the entries of the unknowns ``pairs`` (entries, 2) are, by the arrays that they are factored
        in. Behind them are 0 and 1, for what is no entry and for places of no unknown on the diagonal. Where
        entries on the diagonal do not tell how large pivots are, ``sizes`` has the place of one that does,
        for each unknown."""
        known, zero = {(i, j): k for k, (i, j) in enumerate(pairs.tolist())}, len(pairs)
        diagonal = [zero + 1 if i is None else known.get((i, i), zero) for i in self.listed]
        lower = [zero if pair is None else known.get((max(pair), min(pair)), zero) for pair in self.pairs]
        found = {"diagonal": np.array(diagonal, np.int64), "lower": np.array(lower, np.int64)}
        if sizes is not None:
            listed = [zero if i is None else int(sizes[i]) for i in self.listed]
            found[FLOORS] = np.array(listed, np.int64)
        return found


def positions(listed: Sequence[int | None]) -> dict[int, int]:
    """The places of unknowns in a list."""
    return {i: place for place, i in enumerate(listed) if i is not None}


def tail_of(elimination: SparseElimination) -> tuple[Sequence[int], int]:
    """The unknowns of the last rounds, if these are several and their unknowns one block together, and how
    many rounds there are before."""
    tail: list[int] = []
    before = len(elimination.rounds)
    while before and len(elimination.rounds[before - 1]) + len(tail) <= LANES:
        before -= 1
        tail = [*elimination.rounds[before], *tail]
    several = len(elimination.rounds) - before > 1
    return (tail, before) if several else ((), len(elimination.rounds))


def couples(starts: Places, counts: Places) -> tuple[Places, Places]:
    """All pairs within groups of so many that begin at these places: both members."""
    times, begins = np.repeat(counts, counts), np.repeat(starts, counts)
    one, within = in_groups(times)
    return one, begins[one] + within
