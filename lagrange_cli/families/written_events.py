"""The events of a file and what their actions set, as groups: what is written once is looked at once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places, Whole, flat
from lagrange_cli.expression.syntax import Tree
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.families.groups import Group
from lagrange_cli.records import dataclass
from lagrange_cli.spec.content import groups_by_name, names_of
from lagrange_cli.spec.event import Event
from lagrange_cli.spec.events.together import rounds
from lagrange_cli.spec.family import Family
from lagrange_cli.spec.members import indices_of_all, members_at, numbers_of
from lagrange_cli.spec.spec import Spec
from lagrange_cli.spec.whole import Part, WrittenFamily


@dataclass(frozen=True, eq=False)
class Alike:
    """Events of a ``name`` that are written alike: their ``numbers`` among all events, and the values of the
    indices."""

    name: str
    event: Event
    numbers: Places
    indices: Mapping[str, Places]


def events_alike(spec: Spec) -> Iterator[Alike]:
    """The events of a file, in which those that are written alike are one."""
    first = 0
    for name, one in groups_by_name(spec.events).items():
        if not isinstance(one, WrittenFamily):
            indices = {name: np.array([value]) for name, value in one.indices.items()}
            yield Alike(name, one, np.array([first]), indices)
            first += 1
            continue
        alike: dict[int, list[Part[Event]]] = {}
        for part in one.parts:
            alike.setdefault(id(part.item.when.tree), []).append(part)
        for parts in alike.values():
            numbers = np.concatenate([numbers_of(one.family, part) for part in parts])
            yield Alike(name, parts[0].item, first + numbers, indices_of_all(parts))
        first += len(one)


def arguments_of(spec: Spec) -> Group:
    """What becomes 0 at each event."""
    return group_of_trees([(one.event.when.tree, one.numbers, one.indices) for one in events_alike(spec)])


def directions_of(spec: Spec) -> tuple[Places, Places]:
    """The direction of each event, and whether the motion ends there (0 or 1)."""
    found = np.zeros((2, len(spec.events)), dtype=np.int64)
    for one in events_alike(spec):
        found[0, one.numbers] = one.event.direction
        found[1, one.numbers] = one.event.stops
    return found[0], found[1]


@dataclass(frozen=True, eq=False)
class Assigned:
    """What actions set: the number of the event, the place that is set among coordinates, velocities and
    parameters, and the new values, in the order of the events."""

    events: Places
    places: Places
    values: Group


def assigned_by(spec: Spec) -> Assigned:
    """All that is set by the events of a file."""
    places, made = Numbering(spec), list[tuple[Tree, Places, Places, Mapping[str, Whole]]]()
    order = list[Places]()
    for alike in events_alike(spec):
        for k, one in enumerate(alike.event.sets):
            count = len(alike.numbers)
            indices, owners, at = rounds(one.key.axes, {**spec.sizes, **alike.indices}, count)
            own = {name: x for name, x in indices.items() if name not in spec.sizes}
            made.append(
                (one.value.tree, alike.numbers[owners], places.of(one.key.name, at, len(owners)), own)
            )
            order.append(np.full(len(owners), k))
    if not made:
        nothing = np.zeros(0, dtype=np.int64)
        return Assigned(nothing, nothing, group_of_trees([]))
    events = np.concatenate([one for _, one, *_ in made])
    sort = np.lexsort((np.concatenate(order), events))
    rank = np.empty_like(sort)
    rank[sort] = np.arange(len(sort))
    ends = np.cumsum([len(one) for _, one, *_ in made])
    pieces = [(tree, rank[end - len(own) : end], indices) for end, (tree, own, _, indices) in zip(ends, made)]
    set_at = np.concatenate([one for _, _, one, _ in made])
    return Assigned(events[sort], set_at[sort], group_of_trees(pieces))


class Numbering:
    """The numbers of coordinates, velocities and parameters, one after the other."""

    def __init__(self, spec: Spec) -> None:
        coordinates, parameters = names_of(spec.coordinates), names_of(spec.parameters)
        count = len(spec.coordinates)
        self._of: dict[str, tuple[int, Family | None]] = {}
        for name, start in coordinates.starts.items():
            family = spec.coordinate_families.get(name)
            self._of[name] = start, family
            self._of[velocity_name(name)] = count + start, family
        for name, start in parameters.starts.items():
            self._of[name] = 2 * count + start, spec.families.get("parameters", {}).get(name)

    def of(self, name: str, places: Sequence[Whole], count: int) -> Places:
        """The numbers of ``count`` members of a family, or as often that of a name."""
        start, family = self._of[name]
        if family is None:
            return np.full(count, start)
        return start + members_at(family, flat(places, family.shape, count))


def group_of_trees(pieces: Sequence[tuple[Tree, Places, Mapping[str, Whole]]]) -> Group:
    """Expressions as the members of a group without a name: each tree with the numbers of its members, and
    the values of the indices in it."""
    pieces = sorted((one for one in pieces if len(one[1])), key=lambda one: int(one[1].min()))
    count = sum(len(numbers) for _, numbers, _ in pieces)
    labels, seen, trees = np.zeros(count, dtype=np.int64), dict[int, int](), list[Tree]()
    names = dict.fromkeys(name for *_, indices in pieces for name in indices)
    values = {name: np.zeros(count, dtype=np.int64) for name in names}
    for tree, numbers, indices in pieces:
        if id(tree) not in seen:
            seen[id(tree)] = len(trees)
            trees.append(tree)
        labels[numbers] = seen[id(tree)]
        for name, own in indices.items():
            values[name][numbers] = own
    return Group(Family("", (), ("",), ()), None, tuple(trees), labels, values)
