"""The code of one round of a tiling: which members, and which positions, are due in each order."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from lagrange_cli.native.board import LINE
from lagrange_cli.native.families.sharing import Part, Strip
from lagrange_cli.native.families.spans import Span, behind, larger, smaller
from lagrange_cli.native.families.tables import Tables, place_at
from lagrange_cli.native.families.tiling import Numbers, Tiling
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Index, Integer
from lagrange_cli.records import dataclass, replace

APART = 2
"""Orders that a round is behind the one before it."""


@dataclass(frozen=True)
class Turn:
    """The round that ``@strip`` computes. Rounds are strips, each of so many orders (columns), and no more
    threads than they are made for can be at work: the memory of blocks is used again.

    Order k of a round needs what the round before it has of order k. Vectors of eight there end up to seven
    places further on, so it waits until that round has order k + 1, too: what is left to it lies further
    back. The seam of a ring waits for all of the round before it.
    """

    made: Strip
    rounds: Part
    seam: bool

    def begin(self) -> None:
        """Wait for the memory that it takes."""
        with self.made.f.when(self.made.strip >= self.rounds.threads):
            self._wait(self.rounds.threads, self.made.f.count(self.rounds.columns))

    def before(self, k: Index) -> None:
        """Wait until order k can be computed."""
        f, columns = self.made.f, self.made.f.count(self.rounds.columns)
        least = smaller(f, f.count(k + APART) if isinstance(k, int) else k + APART, columns)
        if self.seam:
            least = f.select(self.made.strip.equals(self.rounds.strips - 1), columns, least)
        with f.when(self.made.strip > 0):
            self._wait(1, least)

    def after(self, k: Index) -> None:
        """Order k has been computed."""
        self.made.f.publish(self.made.tag + 1 + k, self.made.at)

    def _wait(self, back: int, least: Integer) -> None:
        f = self.made.f
        place = f.place(self.made.at, -LINE * back, "double")
        f.call(None, "wait", f.pointer("%constants"), place, self.made.tag + least)


@dataclass(frozen=True, eq=False)
class Windows:
    """Those of the ``turn``-th round."""

    f: Function
    tables: Tables
    tiling: Tiling
    turn: Integer
    among: Turn | None = None
    """The same, if threads share the rounds."""
    piece: Integer | None = None
    """Which piece of the round, if not all of it."""

    @property
    def seam(self) -> Bit:
        """Whether the seam of a ring is due."""
        return self.turn.equals(self.tiling.rounds)

    @contextmanager
    def order(self, k: Index) -> Iterator[None]:
        """What is computed of order k."""
        with self._orders(k, k):
            yield

    @contextmanager
    def together(self, k: Integer, count: int) -> Iterator[Windows]:
        """What is computed of ``count`` orders from k on, piece by piece: of each order the same piece."""
        with self._orders(k, k + (count - 1)):
            pieces = self.f.count(self.tiling.pieces)
            if self.tiling.ring:
                pieces = self.f.select(self.seam, self.f.count(1), pieces)
            with self.f.loop(0, pieces, tested=False) as piece:
                yield replace(self, among=None, piece=piece)

    @contextmanager
    def _orders(self, first: Index, last: Index) -> Iterator[None]:
        if self.among is not None:
            self.among.before(last)
        yield
        if self.among is not None:
            self.among.after(last)

    @contextmanager
    def parts(self) -> Iterator[Integer]:
        """The seam has two: before the blocks, and behind them."""
        if self.tiling.ring:
            both = self.f.select(self.seam, self.f.count(2), self.f.count(1))
            with self.f.loop(0, both, tested=False) as part:
                yield part
        else:
            yield self.f.count(0)

    def units(self, k: Index, lag: int, part: Integer) -> Span:
        """The units of order k that are ``lag`` behind its beginning."""
        first, last = self._between(self._shift(k, lag))
        if not self.tiling.ring:
            return first, last
        edge = self._edge(k, lag)
        before = part.equals(0)
        low = self.f.select(before, self.f.count(0), self.f.count(self.tiling.full) - edge)
        high = self.f.select(before, edge, self.f.count(self.tiling.count))
        return self.f.select(self.seam, low, first), self.f.select(self.seam, high, last)

    def blocks(self, loop: int, k: Index, part: Integer, ahead: int = 0) -> Span:
        """The blocks of a loop that order k computes; at the seam, those of so many orders ahead, too."""
        f, tiling, cuts = self.f, self.tiling, self.tiling.cuts[loop]
        shift = self._shift(k, tiling.lags[loop])
        first, last = (self._at(cuts.up, one) for one in self._between(shift))
        if not tiling.ring:
            return first, last
        first = larger(f, first, self._at(cuts.down, shift + tiling.stride))
        last = larger(f, first, last)
        edge, before = self._edge(k + ahead, tiling.lags[loop]), part.equals(0)
        below = self._at(cuts.down, edge)
        above = larger(f, below, self._at(cuts.up, f.count(tiling.full) - edge))
        low = f.select(before, f.count(0), above)
        high = f.select(before, below, f.count(int(cuts.up[-1])))
        return f.select(self.seam, low, first), f.select(self.seam, high, last)

    def positions(self, span: Span, most: int) -> Span:
        """Positions up to ``most`` in these units."""
        first, last = (smaller(self.f, one * self.tiling.unit, self.f.count(most)) for one in span)
        return first, last

    def _shift(self, k: Index, lag: int) -> Integer:
        if isinstance(k, int):
            return self.f.count(k * self.tiling.stride + lag)
        return k * self.tiling.stride + lag

    def _edge(self, k: Index, lag: int) -> Integer:
        """How many units of the seam are before the blocks, and as many behind them."""
        return self._shift(k, 3 * self.tiling.stride - lag)

    def _between(self, shift: Integer) -> Span:
        """The units of a block, so far back."""
        f, tiling = self.f, self.tiling
        before = self.turn * tiling.block
        ends = before, before + tiling.block
        if self.piece is not None:
            at = before + self.piece * tiling.piece
            ends = at, smaller(f, at + tiling.piece, ends[1])
        if tiling.ring:
            end, least = f.count(tiling.full - tiling.stride), shift + tiling.stride
            first, last = (larger(f, least, behind(f, smaller(f, one, end), shift)) for one in ends)
        else:
            first, last = (smaller(f, behind(f, one, shift), f.count(tiling.count)) for one in ends)
        return first, last

    def _at(self, values: Numbers, i: Integer) -> Integer:
        return place_at(self.f, i + self.tables.of_places(values.tolist()))
