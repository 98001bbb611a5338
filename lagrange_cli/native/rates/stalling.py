"""Motions that are stuck: thousands of steps together are shorter than one before, and nothing moves.

Where friction jumps and is to hold what rests, but is not written so that this is found
(``mechanics.guards``), velocities change their sign every few steps. Steps on rates pass each jump with an
error that the tolerance allows, and are as short as that: it may take them years to reach the end. With
series no step passes.

What is counted is in the state's memory: a motion that is continued ends where it would have ended otherwise.
"""

from __future__ import annotations

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Real
from lagrange_cli.native.rates.places import LONGEST, PATH, SPAN, STALLED
from lagrange_cli.records import dataclass

ENOUGH = 2.0**13
"""After so many steps a motion is stuck."""
SHORT = 2.0**-4
"""Together they are shorter than this part of the longest one so far."""


@dataclass(frozen=True)
class Stalling:
    """Counts steps, in the numbers that are carried from ``first`` on. No coordinate moves if all that they
    move, relative to 1 + their size, is below ``least``."""

    first: int
    least: float

    def stuck(self, f: Function) -> Bit:
        """Whether the motion is stuck. If so, counting begins anew: it may go on in another way."""
        place = self.first + STALLED
        count = f.load("%state", place)
        found = count >= ENOUGH
        f.store(f.select(found, f.constant(0.0), count), "%state", place)
        return found

    def count(self, f: Function, length: Real, moved: Real) -> None:
        """Count a step of this ``length`` in which coordinates ``moved`` so far."""
        zero, longest = f.constant(0.0), f.larger(f.load("%state", self.first + LONGEST), length)
        f.store(longest, "%state", self.first + LONGEST)
        counts = {STALLED: f.constant(1.0), SPAN: length, PATH: moved}
        sums = {place: f.load("%state", self.first + place) + one for place, one in counts.items()}
        still = (sums[SPAN] < longest * SHORT) & (sums[PATH] < self.least)
        for place, one in sums.items():
            f.store(f.select(still, one, zero), "%state", self.first + place)
