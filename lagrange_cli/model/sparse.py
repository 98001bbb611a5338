"""Which entries of L in L D L^T of a sparse symmetric matrix are not 0, and which can be found together.

Unknowns are eliminated in *rounds*: those of a round are not coupled, so that they depend on earlier rounds
only. Among the rest, those coupled to the fewest others come first (minimum degree, several at a time: J. W.
H. Liu, ACM Trans. Math. Softw. 11, 1985). A chain takes as many rounds as its length has bits: that is cyclic
reduction.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

from lagrange_cli.records import dataclass

SLACK = 1
"""How many more than the fewest others an unknown may meet to belong to a round."""


@dataclass(frozen=True)
class Elimination:
    """The ``rounds`` of unknowns, those of ``first`` parts before the others, and ``columns[p]``: the later
    unknowns i with L_ip."""

    rounds: Sequence[Sequence[int]]
    first: int
    columns: Sequence[Sequence[int]]

    @cached_property
    def rows(self) -> Sequence[Sequence[int]]:
        """The earlier unknowns p with L_ip, of each i."""
        made: list[list[int]] = [[] for _ in self.columns]
        for one in self.rounds:
            for p in one:
                for i in self.columns[p]:
                    made[i].append(p)
        return made

    @property
    def entries(self) -> int:
        """The numbers of L below its diagonal."""
        return sum(map(len, self.columns))


def eliminated(neighbours: Sequence[set[int]], coordinates: int, most: int) -> Elimination | None:
    """The elimination of the ``coordinates`` and then of the others; None where L would have more than
    ``most`` numbers.

    ``neighbours`` are the places of entries off the diagonal, by row; it is used up.
    """
    rounds: list[list[int]] = []
    columns: list[list[int]] = [[] for _ in neighbours]
    first = size = 0
    for part in (range(coordinates), range(coordinates, len(neighbours))):
        left = set(part)
        while left:
            one = independent(neighbours, left)
            left.difference_update(one)
            for p in one:
                around = neighbours[p]
                columns[p] = sorted(around)
                size += len(around)
                if size > most:
                    return None
                for i in around:
                    neighbours[i] |= around
                    neighbours[i] -= {i, p}
            rounds.append(one)
        first = first or len(rounds)
    return Elimination(rounds, first, columns)


def independent(neighbours: Sequence[set[int]], left: set[int]) -> list[int]:
    """Some of those ``left`` that meet few others, and not each other."""
    degrees = {p: len(neighbours[p]) for p in left}
    most = min(degrees.values()) + SLACK
    chosen: list[int] = []
    barred: set[int] = set()
    for p in sorted((p for p in left if degrees[p] <= most), key=lambda p: (degrees[p], p)):
        if p not in barred:
            chosen.append(p)
            barred |= neighbours[p]
    return sorted(chosen)
