"""Rounds of a tiling that threads take in turns: each goes through the orders behind the round before it.

Order k of a round needs what the round before it has of order k. Vectors of eight there end up to seven
places further on, so it waits until that round has order k + 1, too: what is left to it lies further back.
The seam of a ring waits for all of the round before it.
"""

from __future__ import annotations

from lagrange_cli.native.board import LINE
from lagrange_cli.native.families.sharing import line
from lagrange_cli.native.families.spans import smaller
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Pointer
from lagrange_cli.records import dataclass

APART = 2
"""Orders that a round is behind the one before it."""


@dataclass(frozen=True)
class Rounds:
    """A part of a jet: so many rounds (``strips``), each of so many orders (``columns``). No more ``threads``
    than these can be at work: the memory of blocks is used again. ``@strip`` computes a round."""

    strips: int
    columns: int
    threads: int
    all_count: bool = False


@dataclass(frozen=True)
class Turn:
    """One round in the function that computes it; ``at`` is its place on the board."""

    f: Function
    rounds: Rounds
    seam: bool
    at: Pointer
    strip: Integer
    tag: Integer

    def begin(self) -> None:
        """Wait for the memory that it takes."""
        with self.f.when(self.strip >= self.rounds.threads):
            self._wait(self.rounds.threads, self.f.count(self.rounds.columns))

    def before(self, k: int | Integer) -> None:
        """Wait until order k can be computed."""
        f, columns = self.f, self.f.count(self.rounds.columns)
        least = smaller(f, f.count(k + APART) if isinstance(k, int) else k + APART, columns)
        if self.seam:
            least = f.select(self.strip.equals(self.rounds.strips - 1), columns, least)
        with f.when(self.strip > 0):
            self._wait(1, least)

    def after(self, k: int | Integer) -> None:
        """Order k has been computed."""
        self.f.publish(self.tag + 1 + k, self.at)

    def _wait(self, back: int, least: Integer) -> None:
        place = self.f.place(self.at, -LINE * back, "double")
        self.f.call(None, "wait", self.f.pointer("%constants"), place, self.tag + least)


def turn_of(f: Function, rounds: Rounds, seam: bool, board: Pointer) -> Turn:
    """The round that ``@strip`` computes."""
    strip, tag = (Integer(f, name, 1) for name in ("%strip", "%tag"))
    return Turn(f, rounds, seam, line(f, board, strip), strip, tag)
