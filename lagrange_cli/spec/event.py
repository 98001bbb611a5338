"""An event of a file. What its action sets is written once, for all values of the indices in it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

from lagrange_cli.expression.indices import integer
from lagrange_cli.expression.loops import places
from lagrange_cli.expression.syntax import Key
from lagrange_cli.expression.vocabulary import member_name
from lagrange_cli.limits import whole
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.spec.source import Expression, Place

MAX_MEMBERS = whole("members")


@dataclass(frozen=True)
class Assignment:
    """What an action sets: a coordinate, a velocity or a parameter, or with indices in its ``key`` several of
    a family; and the new ``value``."""

    key: Key
    value: Expression

    def targets(self, indices: Mapping[str, int], sizes: Mapping[str, int]) -> dict[str, Expression]:
        """The new values by the names of what is set, for these values of the indices around."""
        key, known = self.key, {**sizes, **indices}
        if not any(axis.index for axis in key.axes):
            place = [integer(axis.bounds[0], known) for axis in key.axes]
            return {member_name(key.name, place) if place else key.name: replace(self.value, indices=indices)}
        return {
            member_name(key.name, place): replace(self.value, indices={**indices, **own})
            for place, own in places(key.axes, known, MAX_MEMBERS)
        }


@dataclass(frozen=True)
class Event:
    """What happens where ``when`` becomes 0.

    ``direction`` is +1 where it must rise, -1 where it must fall, 0 where either counts. The motion ends
    there if it ``stops``. ``sets`` are what the action sets, as the file has it, and ``indices`` the values
    of the indices in the event's own ``key``.
    """

    when: Expression
    direction: int
    stops: bool
    sets: tuple[Assignment, ...]
    place: Place
    key: Key | None = None
    sizes: Mapping[str, int] = field(default_factory=dict)
    indices: Mapping[str, int] = field(default_factory=dict)

    def member(self, name: str, indices: Mapping[str, int]) -> Event:
        """The event of one member of a family."""
        return replace(self, when=replace(self.when, indices=indices), indices=indices)

    @cached_property
    def changes(self) -> Mapping[str, Expression]:
        """The new values of coordinates, velocities and parameters, by name."""
        return {k: x for one in self.sets for k, x in one.targets(self.indices, self.sizes).items()}

    @property
    def in_structure(self) -> tuple[object, ...]:
        """What it has in the structure of a system."""
        return self.when, self.direction, self.stops, tuple((one.key.text, one.value) for one in self.sets)

    @property
    def written(self) -> tuple[Expression, ...]:
        """Its expressions, each once: those of what is set have 0 for indices of their own."""
        own = [{axis.index: 0 for axis in one.key.axes if axis.index} for one in self.sets]
        values = (replace(one.value, indices={**self.indices, **x}) for one, x in zip(self.sets, own))
        return (self.when, *values)
