"""The rounds of loops for many members at once, over arrays of numpy.

Where a loop has conditions, branch and prune finds the rounds that satisfy them without going through all: a
stretch of rounds is left out if bounds of the indices show that a condition holds for none of them, taken
whole if all hold for all, and else split in two. So pairs within a band, as in ``abs(i - j) == 1``, take
work in proportion to their number.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from lagrange_cli.expression.index_arrays import (
    Indices,
    Mask,
    Places,
    TooMany,
    Whole,
    distinct,
    holding,
    integers,
    limited,
    taken,
)
from lagrange_cli.expression.index_bounds import answer, bounds_of_loop
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.syntax import Axis, Loop, Sum, plain_names
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from numpy.typing import NDArray

Looped: TypeAlias = "Sum | Axis | Loop"
FEW = 2**12
"""So many rounds are gone through one by one."""
LONGEST = 2**40
"""The rounds of one member."""


class Rounds:
    """The rounds of a loop for each of ``count`` members: ``sizes`` many, the first at ``start``."""

    def __init__(self, loop: Looped, indices: Indices, count: int) -> None:
        bounds = [integers(bound, indices) for bound in loop.bounds]
        start, stop, step = (0, bounds[0], 1) if len(bounds) == 1 else (*bounds, 1)[:3]
        if not isinstance(step, int) or step == 0:
            raise Unsuited
        self.count, self.step = count, step
        self.start: Places = np.broadcast_to(np.asarray(start, dtype=np.int64), count)
        sizes = np.maximum(0, -((np.asarray(start, dtype=np.int64) - stop) // step))
        self.sizes: Places = np.broadcast_to(sizes, count)
        if np.any(sizes > LONGEST):
            raise TooMany

    def index(self, members: Places, number: Places) -> Places:
        """The loop's index in rounds of these numbers, counted from 0."""
        return self.start[members] + self.step * number

    def bounds(self, some: Stretches) -> tuple[Places, Places]:
        """The least and the greatest value of the loop's index in some stretches."""
        first = self.index(some.members, some.first)
        last = self.index(some.members, some.first + some.sizes - 1)
        return (first, last) if self.step > 0 else (last, first)

    def of(self, some: Stretches) -> tuple[Places, Places]:
        """Every round of some stretches: whose it is, and the loop's index."""
        total = limited(int(some.sizes.sum()))
        begin = np.cumsum(some.sizes) - some.sizes
        whose = np.repeat(some.members, some.sizes)
        return whose, self.index(whose, np.arange(total) + np.repeat(some.first - begin, some.sizes))

    @property
    def all(self) -> Stretches:
        """All rounds, member after member."""
        members = np.flatnonzero(self.sizes)
        return Stretches(members, np.zeros_like(members), self.sizes[members])


@dataclass(frozen=True)
class Stretches:
    """Rounds that follow one another: whose they are, the numbers of the first ones, and how many."""

    members: Places
    first: Places
    sizes: Places

    @property
    def arrays(self) -> tuple[Places, Places, Places]:
        """All three."""
        return self.members, self.first, self.sizes

    def taken(self, which: Mask | Places) -> Stretches:
        """Some of them."""
        return Stretches(*(one[which] for one in self.arrays))

    def halved(self) -> Stretches:
        """Each one as two."""
        low = self.sizes // 2
        firsts, sizes = (self.first, self.first + low), (low, self.sizes - low)
        return Stretches(
            np.repeat(self.members, 2), *(np.stack(one, axis=-1).ravel() for one in (firsts, sizes))
        )


def rounds(loops: Sequence[Looped], indices: Indices, count: int) -> tuple[Places, Places]:
    """Rounds of the first of some loops, each of which is within the one before it, for each of ``count``
    members: whose they are, and its index, in order. Those may be missing in which conditions of the loops
    never hold."""
    every = Rounds(loops[0], indices, count)
    chosen = every.all
    if any(one.conditions for one in loops) and int(chosen.sizes.sum()) > FEW:
        try:
            chosen = satisfying(every, loops, indices)
        except TooMany:
            raise
        except Unsuited:  # numbers are too large for bounds
            pass
    return every.of(chosen)


def satisfying(every: Rounds, loops: Sequence[Looped], indices: Indices) -> Stretches:
    """The stretches of rounds that may satisfy the conditions of all loops."""
    trees = [tree for one in loops for tree in (*one.bounds, *one.conditions)]
    used = frozenset[str]().union(*map(plain_names, trees))
    known = {name: one for name, one in indices.items() if name in used}
    done, some = list[Stretches](), every.all
    while len(some.members):
        limited(len(some.members))
        may, must = answers(every, loops, taken(known, some.members), some)
        whole = may & (must | (some.sizes == 1))
        done.append(some.taken(whole))
        some = some.taken(may & ~whole).halved()
    members, first, sizes = (np.concatenate(parts) for parts in zip(*(one.arrays for one in done)))
    return Stretches(members, first, sizes).taken(np.lexsort((first, members)))


def answers(every: Rounds, loops: Sequence[Looped], known: Indices, some: Stretches) -> tuple[Mask, Mask]:
    """Which stretches of rounds may satisfy the conditions of all loops, and which certainly do in every
    round."""
    bounds = {name: (one, one) for name, one in known.items()}
    may, must = np.ones(len(some.members), dtype=np.bool_), np.ones(len(some.members), dtype=np.bool_)
    for loop in loops:
        if loop is loops[0]:
            bounds[loop.index] = every.bounds(some)
        else:
            bounds[loop.index], any_ = bounds_of_loop(loop.bounds, bounds)
            may = may & any_
        for condition in loop.conditions:
            possible, certain = answer(condition, bounds)
            may, must = may & possible, must & certain
    return may, must


def chained(loop: Sum) -> list[Sum]:
    """A loop, and the loops whose terms are its terms, from the outside in."""
    found = [loop]
    while isinstance(found[-1].body, Sum):
        found.append(found[-1].body)
    return found


def every_value(loop: Sum, indices: Indices, count: int) -> Places:
    """The index of a loop in all rounds of all members."""
    every = Rounds(loop, indices, count)
    return every.of(every.all)[1]


def visited(loop: Sum, indices: Indices, count: int) -> Places:
    """The values that the index of a loop takes for any of ``count`` members, each once, in ascending
    order."""
    bounds = [integers(bound, indices) for bound in loop.bounds]
    if all(isinstance(bound, int) for bound in bounds):
        values = every_value(loop, indices, 1)
        return values if len(values) < 2 or values[0] < values[1] else values[::-1]
    if len(bounds) > 2:
        return distinct(every_value(loop, indices, count))
    start, stop = (np.broadcast_to(one, count) for one in (0, *bounds)[-2:])
    runs = np.flatnonzero(start < stop)
    if not len(runs):
        return np.zeros(0, dtype=np.int64)
    first = int(start[runs].min())
    begun = np.zeros(limited(int(stop[runs].max()) - first) + 1, dtype=np.int64)
    np.add.at(begun, start[runs] - first, 1)
    np.add.at(begun, stop[runs] - first, -1)
    return first + np.flatnonzero(np.cumsum(begun))


def inner(loop: Sum, indices: Indices, count: int) -> tuple[dict[str, Whole], Places]:
    """The indices of all terms of a sum, and to which of ``count`` members each term belongs."""
    return within(chained(loop), indices, count)


def within(loops: Sequence[Looped], indices: Indices, count: int) -> tuple[dict[str, Whole], Places]:
    """The indices in all rounds of the first of some loops that satisfy its conditions, and to which of
    ``count`` members each round belongs."""
    members, own = rounds(loops, indices, count)
    found = {**taken(indices, members), loops[0].index: own}
    for condition in loops[0].conditions:
        chosen = np.flatnonzero(np.broadcast_to(holding(condition, found), len(members)))
        members, found = members[chosen], taken(found, chosen)
    return found, members


def values_of(loop: Sum, indices: Mapping[str, int]) -> list[int]:
    """The values of a loop's index that satisfy its conditions, in order. Those may be missing for which a
    loop within it has no rounds."""
    found, _ = inner(loop, indices, 1)
    return [*map(int, np.atleast_1d(found[loop.index]))]


def places(loops: Sequence[Looped], indices: Mapping[str, int]) -> NDArray[np.int64]:
    """The values of the indices of all loops, or the places of a key's members, in the order in which the
    loops take them (members, loops)."""
    found: dict[str, Whole] = {**indices}
    count, columns = 1, list[Places]()
    for k, loop in enumerate(loops):
        if loop.index:
            found, owners = within([one for one in loops[k:] if one.index], found, count)
            count, columns = len(owners), [one[owners] for one in columns]
        own = found[loop.index] if loop.index else integers(loop.bounds[0], found)
        columns.append(np.broadcast_to(np.asarray(own, dtype=np.int64), count))
    return np.stack(columns, axis=-1)
