"""How equations of many unknowns with a symmetric matrix are factored, from the places of its entries."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.model.sparse import SparseElimination, eliminated
from lagrange_cli.records import dataclass

MOST, TOGETHER = 64, 48
"""Numbers of L for each unknown in L D L^T up to which it is sparse; and unknowns that meet each other up to
which they are one block, where some constraints follow from others in turn."""
DENSE = 2048
"""Unknowns up to which L D L^T may be dense: 32 MB, and 1.4e9 multiplications a step."""
PAIRS = 2**17
"""Pairs of blocks that an earlier one couples, besides some for each unknown: they are listed in tables."""


def elimination_of(count: int, places: Places, waiting: int | None = None) -> SparseElimination | None:
    """How a matrix of ``count`` unknowns with entries at ``places`` (entries, 2), those on the diagonal and
    below, is factored; None where it is taken as dense. Raises ``Unsuited`` where L has too many numbers.
    Unknowns from number ``waiting`` on have none on the diagonal: they wait for all that they meet."""
    found, most = None, MOST * count
    if len(places) - count <= most:
        neighbours: list[set[int]] = [set() for _ in range(count)]
        for i, j in places.tolist():
            if i != j:
                neighbours[i].add(j)
                neighbours[j].add(i)
        found = eliminated(neighbours, most, waiting)
    if found is None and count > DENSE:
        raise Unsuited
    return found


@dataclass(frozen=True)
class Blocks:
    """The unknowns of ``blocks``, in the order in which these are eliminated, and the later ones that each
    meets then, ``columns``."""

    blocks: Sequence[Sequence[int]]
    columns: Sequence[Sequence[int]]

    @property
    def numbers(self) -> int:
        """Those of all blocks, and of what couples them."""
        sizes = [*map(len, self.blocks)]
        return sum(n * (n + 2 * sum(sizes[c] for c in later)) for n, later in zip(sizes, self.columns))

    @property
    def pairs(self) -> int:
        """Pairs of later ones, over all blocks."""
        return sum(len(later) ** 2 for later in self.columns)


def in_blocks(count: int, pairs: Places, tied: Iterable[Sequence[int]], first: int) -> Blocks:
    """How such a matrix is factored where constraints are ``tied`` to each other, in groups, of which some
    follow from the others: each group is a block. From number ``first`` on, unknowns are multipliers, which
    wait for all that they meet if there are others. Raises ``Unsuited`` where there are too many numbers.

    A combination z of a group's constraints with K z = 0 stays one while others are eliminated. So each
    block has a rank that is known.
    """
    parts = parts_of(count, pairs)
    small = [part for part in parts if len(part) <= TOGETHER]
    inside = {i for part in parts if len(part) > TOGETHER for i in part}
    links = [(group[0], i) for group in tied for i in group]
    groups = [one for one in parts_of(count, np.array(links, dtype=np.int64)) if one[0] in inside]
    groups.sort(key=lambda group: group[0] >= first)
    of = {i: number for number, group in enumerate(groups) for i in group}
    neighbours: list[set[int]] = [set() for _ in groups]
    for i, j in pairs.tolist():
        if i in of and of[i] != of[j]:
            neighbours[of[i]].add(of[j])
            neighbours[of[j]].add(of[i])
    others = sum(group[0] < first for group in groups)
    sparse = eliminated(neighbours, MOST * count, others or None)
    if sparse is None:
        raise Unsuited
    order = [number for some in sparse.rounds for number in some]
    place = {number: k for k, number in enumerate(order)}
    columns = [[place[later] for later in sparse.columns[number]] for number in order]
    found = Blocks([*(groups[k] for k in order), *small], [*columns, *([] for _ in small)])
    if found.numbers > MOST * count + DENSE * DENSE or found.pairs > 4 * MOST * count + PAIRS:
        raise Unsuited
    return found


def parts_of(count: int, pairs: Places) -> list[list[int]]:
    """The unknowns that meet each other, directly or not, from the places of a matrix's entries."""
    above = [*range(count)]

    def root(i: int) -> int:
        while above[i] != i:
            above[i] = above[above[i]]
            i = above[i]
        return i

    for i, j in pairs.tolist():
        a, b = root(i), root(j)
        above[max(a, b)] = min(a, b)
    found: dict[int, list[int]] = {}
    for i in range(count):
        found.setdefault(root(i), []).append(i)
    return [*found.values()]
