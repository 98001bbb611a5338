"""Which coordinates the accelerations of families depend on, from the tables of places."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lagrange_cli.expression.index_arrays import distinct
from lagrange_cli.families.arrays import Array, Chain, Source, Total
from lagrange_cli.families.coupled_masses import CoupledMasses
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.joints.responses import trees_of
from lagrange_cli.families.tables import in_groups
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
        if int(counts.sum()) > MOST:
            raise TooMany
        members, inside = in_groups(counts)
        return members, self.columns[self.starts[table][members] + inside]


def of_families(system: FamilySystem) -> Coupling:
    """The coupling of a system of families."""
    count = system.q.count
    joints, bonds = system.joints, system.bonds
    totals = needed([system.forces, *sums_in_masses(system)], system.slots)
    grouped = bonds is not None or joints is not None or system.curved
    chained = bonds is not None and any(one.holds for one in bonds.bounds)
    if chained or (joints is not None and joints.count):
        return full(count)
    if any(isinstance(one, Chain) for one in totals):
        return full(count)
    known: dict[Array, Dependencies] = {}
    try:
        for total in totals:
            known[total] = pairs_of(system, total, known)
        found = known[system.forces] if system.forces.terms else nothing(count)
        rows, columns = np.repeat(np.arange(count), np.diff(found.starts)), found.columns
        if grouped:
            rows, columns = of_groups(system, rows, columns, known)
        elif system.coupled_masses is not None:  # matrices are those of forces
            rows, columns = with_masses(system.coupled_masses, rows, columns)
    except TooMany:
        return full(count)
    return coupling_of(count, rows, columns)


def with_masses(
    masses: CoupledMasses, rows: IndexArray, columns: IndexArray
) -> tuple[IndexArray, IndexArray]:
    """Also the places of M."""
    i, j = masses.pairs.T
    keys = np.concatenate([one * masses.count + other for one, other in ((rows, columns), (i, j), (j, i))])
    which, column = np.divmod(distinct(keys), masses.count)
    return which, column


def nothing(count: int) -> Dependencies:
    """Those of so many numbers that depend on no coordinate."""
    return Dependencies(np.zeros(count + 1, dtype=np.int64), np.zeros(0, dtype=np.int64))


def sums_in_masses(system: FamilySystem) -> list[Total]:
    """The sums that masses contain which are no constants."""
    curved = system.coupled_masses.curved if system.coupled_masses else ()
    arrays = (slot.array for one in curved for _, slot in system.slots.inside(one.node))
    return [one for one in arrays if isinstance(one, Total)]


def of_groups(
    system: FamilySystem, rows: IndexArray, columns: IndexArray, known: dict[Array, Dependencies]
) -> tuple[IndexArray, IndexArray]:
    """What accelerations depend on where those of a joint without nodes are found together, and so are those
    of coordinates that constraints or masses couple; forces depend on ``columns`` by ``rows``, and what sums
    in masses depend on is ``known``."""
    count = system.q.count
    label = groups(system)
    every = np.arange(count)
    found = [label[rows] * count + columns, label * count + every]
    for bound in system.bonds.bounds if system.bonds else ():
        owner = np.full(system.bonds.count if system.bonds else 0, count)
        for held in bound.rows:
            owner[bound.numbers] = label[held]
        for node in (bound.node, *bound.slopes):
            for _, slot in system.slots.inside(node):
                if slot.array.source in (Source.COORDINATES, Source.VELOCITIES):
                    found.append(owner[bound.numbers] * count + slot.table)
    for one in system.coupled_masses.curved if system.coupled_masses else ():
        for _, slot in system.slots.inside(one.node):
            if slot.array.source is Source.COORDINATES:
                found += [label[rows] * count + slot.table for rows in (one.first, one.second)]
            elif slot.array in known:
                members, places = known[slot.array].read(slot.table)
                found += [label[rows[members]] * count + places for rows in (one.first, one.second)]
    keys = distinct(np.concatenate(found))
    order = np.argsort(label, kind="stable")
    starts = np.searchsorted(label[order], every)
    sizes = np.bincount(label, minlength=count)
    which, column = np.divmod(keys, count)
    if int(sizes[which].sum()) > MOST:
        raise TooMany
    owners, inside = in_groups(sizes[which])
    return order[starts[which][owners] + inside], column[owners]


def groups(system: FamilySystem) -> IndexArray:
    """The least coordinate of those that each one is found together with."""
    count, bonds = system.q.count, system.bonds
    label: IndexArray = np.arange(count) if system.joints is None else trees_of(system.joints, count)[1]
    joint, masses = label, system.coupled_masses
    while True:
        before, label = label, label.copy()
        for one in bonds.bounds if bonds else ():
            least = np.full(bonds.count if bonds else 0, count)
            for held in one.rows:
                np.minimum.at(least, one.numbers, label[held])
            for held in one.rows:
                np.minimum.at(label, held, least[one.numbers])
        if masses is not None:
            i, j = masses.pairs.T
            np.minimum.at(label, i, label[j])
            np.minimum.at(label, j, label[i])
        of_label = np.full(count, count)
        np.minimum.at(of_label, joint, label)
        label = of_label[joint]
        if np.array_equal(before, label):
            return label


def pairs_of(system: FamilySystem, total: Total, known: dict[Array, Dependencies]) -> Dependencies:
    """What the numbers of a total depend on; of those that it is made of this is ``known``."""
    count = system.q.count
    if total.count * count > FLAGS:
        found = [np.empty(0, dtype=np.int64)]
        for rows, columns in dependent(system, total, known):
            found.append(distinct(rows * count + columns))
        keys = distinct(np.concatenate(found))
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
