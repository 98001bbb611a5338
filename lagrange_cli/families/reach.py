"""Which constraints on chains and trees act on each other: the force of one moves the trees that it meets.

A column of A M^-1 A^T is what the force of one constraint does to all of them. Columns that have no row in
common are found at once, in one *turn*: one for all norms of quaternions of bodies that hang on no others.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.families.arrays import NONE
from lagrange_cli.families.joints import Articulation
from lagrange_cli.records import dataclass


@dataclass(frozen=True, eq=False)
class Reach:
    """The trees that coordinates and nodes are on, ``tree_of`` them; the ``trees`` that each constraint
    meets, and for each the others, and itself, that meet one of these (``met``). ``turn`` (constraints,) says
    which columns are found together, in so many ``turns``."""

    tree_of: Places
    trees: Sequence[Sequence[int]]
    met: Sequence[Sequence[int]]
    turn: Places
    turns: int

    @property
    def pairs(self) -> Iterator[tuple[int, int]]:
        """All constraints that act on each other."""
        return ((i, j) for i, some in enumerate(self.met) for j in some)

    @property
    def listed(self) -> tuple[Places, Places]:
        """The constraints turn by turn, and where those of each turn begin, and the last ones end."""
        ends = np.cumsum([0, *np.bincount(self.turn, minlength=self.turns)])
        return np.argsort(self.turn, kind="stable"), ends


def reach_of(
    found: Articulation, size: int, holding: Iterable[tuple[Places, Places]], count: int, most: int
) -> Reach:
    """That of ``count`` constraints. They are ``holding`` some of ``size`` coordinates and then of the nodes:
    numbers of constraints, and what each of them holds. Raises ``Unsuited`` where they take more than
    ``most`` turns."""
    tree_of = trees_of(found, size)
    inside: list[set[int]] = [set() for _ in range(count)]
    for numbers, held in holding:
        for i, tree in zip(numbers.tolist(), tree_of[held].tolist()):
            inside[i].add(tree)
    meeting: dict[int, list[int]] = {}
    for i, some in enumerate(inside):
        for tree in some:
            meeting.setdefault(tree, []).append(i)
    if max(map(len, meeting.values()), default=0) > most:
        raise Unsuited
    met = [sorted({i for tree in some for i in meeting[tree]}) for some in inside]
    turn = np.full(count, NONE, dtype=np.int64)
    for j, around in enumerate(met):
        taken = {int(turn[other]) for i in around for other in met[i]}
        turn[j] = next(k for k in range(count) if k not in taken)
        if turn[j] >= most:
            raise Unsuited
    return Reach(tree_of, [sorted(one) for one in inside], met, turn, int(turn.max(initial=NONE)) + 1)


def trees_of(found: Articulation, size: int) -> Places:
    """The tree of each of ``size`` coordinates and then of each node, by a number."""
    parents = found.parents
    roots = np.arange(len(parents))
    for node in found.nodes[0].tree.order.tolist() if found.nodes and found.nodes[0].tree else ():
        if parents[node] != NONE:
            roots[node] = roots[parents[node]]
    made = np.concatenate([np.arange(size), roots + size])
    for one in found.joints:
        if not one.rows:
            continue
        own = one.rows[0].copy()
        if one.nodes is not None:
            own = roots[one.nodes] + size
        elif one.parents is not None:
            hung = one.parents < len(roots)
            own[hung] = roots[one.parents[hung]] + size
        for rows in one.rows:
            made[rows] = own
    return made
