"""Which coordinates the accelerations of families depend on, from the tables of places."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lagrange_cli.families.arrays import Array, Chain, Source, Total
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.stepping.coupling import Coupling, IndexArray, coupling_of, full
from lagrange_cli.records import dataclass

FLAGS = 2**27
"""Pairs up to which each of them has a flag, and others are listed."""
MOST = 2**22
"""Pairs of a member and a coordinate beyond which matrices are full."""


class TooMany(Exception):
    """There are more pairs than are looked at."""


@dataclass(frozen=True, eq=False)
class Dependencies:
    """The coordinates that each number of an array depends on: those of number k from ``starts[k]`` on."""

    starts: IndexArray
    columns: IndexArray

    def read(self, table: IndexArray) -> tuple[IndexArray, IndexArray]:
        """What members depend on that read the numbers at the places of ``table``: members, coordinates."""
        counts = np.diff(self.starts)[table]
        total = int(counts.sum())
        if total > MOST:
            raise TooMany
        members = np.repeat(np.arange(len(table)), counts)
        inside = np.arange(total) - np.repeat(np.cumsum(counts) - counts, counts)
        return members, self.columns[np.repeat(self.starts[table], counts) + inside]


def of_families(system: FamilySystem) -> Coupling:
    """The coupling of a system of families."""
    count = system.q.count
    totals = needed([system.forces], system.slots)
    if system.joints is not None or system.bonds is not None or any(isinstance(one, Chain) for one in totals):
        return full(count)
    known: dict[Array, Dependencies] = {}
    try:
        for total in totals:
            known[total] = pairs_of(system, total, known)
    except TooMany:
        return full(count)
    found = known[system.forces]
    return coupling_of(count, np.repeat(np.arange(count), np.diff(found.starts)), found.columns)


def pairs_of(system: FamilySystem, total: Total, known: dict[Array, Dependencies]) -> Dependencies:
    """What the numbers of a total depend on; of those that it is made of this is ``known``."""
    count = system.q.count
    if total.count * count > FLAGS:
        found = [np.empty(0, dtype=np.int64)]
        for rows, columns in dependent(system, total, known):
            found.append(np.unique(rows * count + columns))
        keys = np.unique(np.concatenate(found))
    else:
        flags = np.zeros(total.count * count, dtype=bool)
        for rows, columns in dependent(system, total, known):
            flags[rows * count + columns] = True
        keys = np.flatnonzero(flags)
    rows, columns = np.divmod(keys, count)
    return Dependencies(np.searchsorted(rows, np.arange(total.count + 1)), columns)


def dependent(
    system: FamilySystem, total: Total, known: dict[Array, Dependencies]
) -> Iterator[tuple[IndexArray, IndexArray]]:
    """Numbers of a total, and what each of them depends on."""
    for term in total.terms:
        for _, slot in system.slots.inside(term.node):
            if slot.array.source in (Source.COORDINATES, Source.VELOCITIES):
                yield term.targets, slot.table
            elif slot.array in known:
                members, columns = known[slot.array].read(slot.table)
                yield term.targets[members], columns
