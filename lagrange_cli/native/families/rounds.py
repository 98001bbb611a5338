"""Rounds of a tiling that threads take in turns: each goes through the orders behind the round before it.

Order k of a round needs what the round before it has of order k. Vectors of eight there end up to seven
places further on, so it waits until that round has order k + 1, too: what is left to it lies further back.
The seam of a ring waits for all of the round before it.
"""

from __future__ import annotations

from lagrange_cli.native.board import LINE
from lagrange_cli.native.families.sharing import Part, Strip
from lagrange_cli.native.families.spans import smaller
from lagrange_cli.native.llvm.vector import Integer
from lagrange_cli.records import dataclass

APART = 2
"""Orders that a round is behind the one before it."""


@dataclass(frozen=True)
class Turn:
    """The round that ``@strip`` computes. Rounds are strips, each of so many orders (columns), and no more
    threads than they are made for can be at work: the memory of blocks is used again."""

    made: Strip
    rounds: Part
    seam: bool

    def begin(self) -> None:
        """Wait for the memory that it takes."""
        with self.made.f.when(self.made.strip >= self.rounds.threads):
            self._wait(self.rounds.threads, self.made.f.count(self.rounds.columns))

    def before(self, k: int | Integer) -> None:
        """Wait until order k can be computed."""
        f, columns = self.made.f, self.made.f.count(self.rounds.columns)
        least = smaller(f, f.count(k + APART) if isinstance(k, int) else k + APART, columns)
        if self.seam:
            least = f.select(self.made.strip.equals(self.rounds.strips - 1), columns, least)
        with f.when(self.made.strip > 0):
            self._wait(1, least)

    def after(self, k: int | Integer) -> None:
        """Order k has been computed."""
        self.made.f.publish(self.made.tag + 1 + k, self.made.at)

    def _wait(self, back: int, least: Integer) -> None:
        f = self.made.f
        place = f.place(self.made.at, -LINE * back, "double")
        f.call(None, "wait", f.pointer("%constants"), place, self.made.tag + least)
