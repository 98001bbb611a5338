"""What the actions of many members of a family of events set, looked at together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places, Whole, distinct, flat, integers
from lagrange_cli.expression.index_loops import within
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.syntax import Axis
from lagrange_cli.spec.draft import Entry, WrittenEvent
from lagrange_cli.spec.members import indices_of_all, members_at
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.whole import Part


class Together:
    """Members of a family of events that are written alike: those of some parts."""

    def __init__(self, names: Names, parts: Sequence[Part[WrittenEvent]]) -> None:
        self.names = names
        self.indices: dict[str, Whole] = {**names.sizes, **indices_of_all(parts)}
        self.count = sum(part.count for part in parts)

    def sound(self, changes: Sequence[Entry]) -> bool:
        """Whether it is certain that all that is set exists, and is set once by each event, and that its new
        values are right."""
        by_family: dict[str, list[Places]] = {}
        try:
            for entry in changes:
                indices, owners, places = rounds(entry.key.axes, self.indices, self.count)
                if not self._right(entry, indices, len(owners)):
                    return False
                base = entry.name.partition(".")[0]
                by_family.setdefault(base, []).append(self._set(base, owners, places))
        except Unsuited:
            return False
        return all(len(distinct(found := np.concatenate(one))) == len(found) for one in by_family.values())

    def _right(self, entry: Entry, indices: Mapping[str, Whole], count: int) -> bool:
        """Whether the new values are right for these values of the indices."""
        value = entry.value
        if value is None:
            return False
        if any(axis.index for axis in entry.key.axes):
            found = self.names.many.of_members(value.tree, indices, count)
        else:
            found = self.names.of_siblings(value)
        return found is not None and not isinstance(found, tuple)

    def _set(self, base: str, owners: Places, places: Sequence[Whole]) -> Places:
        """One number for each event and what it sets of a family. Raises ``Unsuited`` where there is none."""
        meaning = self.names.table[base]
        if meaning.family is None:
            if places or base not in self.names.values:
                raise Unsuited
            return owners
        if self.names.values.of_family(meaning.family) is None:
            raise Unsuited
        members = members_at(meaning.family, flat(places, meaning.family.shape, len(owners)))
        return owners * len(meaning.family.members) + members


def rounds(
    axes: Sequence[Axis], indices: Mapping[str, Whole], count: int
) -> tuple[Mapping[str, Whole], Places, list[Whole]]:
    """For each member that a key stands for, in the actions of ``count`` events with these ``indices``: the
    indices, whose action it is, and its place."""
    found, owners, places = indices, np.arange(count), list[Whole]()
    for k, axis in enumerate(axes):
        if axis.index:
            found, own = within([one for one in axes[k:] if one.index], found, len(owners))
            owners = owners[own]
            places = [one if isinstance(one, int) else one[own] for one in places]
        places.append(found[axis.index] if axis.index else integers(axis.bounds[0], found))
    return found, owners, places
