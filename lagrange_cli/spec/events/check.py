"""The events of a file to those of a ``Spec``: targets of actions must exist, and expressions must vary."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain

from lagrange_cli.expression.confusions import rate_of
from lagrange_cli.expression.loops import places
from lagrange_cli.expression.near import known_hint, near_hint, shown
from lagrange_cli.expression.syntax import ExpressionError, Name, Span
from lagrange_cli.expression.vocabulary import family_name, member_name, velocity_name
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.spec.content import by_name, groups_of, parts_by_name
from lagrange_cli.spec.draft import Draft, Entry, WrittenEvent
from lagrange_cli.spec.event import Assignment, Event
from lagrange_cli.spec.families import MAX_MEMBERS
from lagrange_cli.spec.kinds import Kind
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.settling import check_scalar
from lagrange_cli.spec.spec import Expression
from lagrange_cli.spec.whole import Part, WrittenFamily

SETTABLE = frozenset({Kind.COORDINATE, Kind.VELOCITY, Kind.PARAMETER})
_HINTS = {
    Kind.TIME: "coordinates, velocities and parameters can be set, but not the time",
    Kind.PARTICLE: "set the coordinates and velocities that it depends on",
    Kind.BODY: "set the coordinates and velocities that it depends on",
    Kind.DEFINITION: "set the coordinates, velocities and parameters that it depends on",
    Kind.SIZE: "coordinates, velocities and parameters can be set, but not sizes",
}


def check_events(draft: Draft, names: Names, problems: Problems) -> Mapping[str, Event]:
    """The events by name; mistakes are added to ``problems``. Members of a family that are alike are checked
    at once."""
    checker, groups = _Checker(draft, names, problems), groups_of(draft.events)
    for group in groups:
        for event in names.apart(group):
            if event.when is not None:
                checker.when(event, event.when)
    for group in groups:
        for event in checker.apart(group):
            checker.changes(event)
    return by_name(parts_by_name(groups, lambda event: event_of(event, names.sizes)))


def event_of(written: WrittenEvent, sizes: Mapping[str, int]) -> Event | None:
    """An event that has what it needs."""
    if written.when is None:
        return None
    sets = tuple(Assignment(one.key, one.value) for one in written.changes if one.value is not None)
    return Event(written.when, written.direction, written.stops, sets, written.place, written.key, sizes)


@dataclass
class _Checker:
    draft: Draft
    names: Names
    problems: Problems
    examined: set[int] = field(default_factory=set)
    """Entries (by ``id``) whose names can be set, whatever member of a family of events they belong to."""
    members: dict[str, frozenset[str]] = field(default_factory=dict)
    """By family: its members, without those that have mistakes."""

    def when(self, event: WrittenEvent, when: Expression) -> None:
        """Check that it is a scalar that varies along the motion."""
        where = f"event '{event.key.label}'"
        kinds = check_scalar(self.names, when, "events", where)
        if self.problems.trusts(when.tree) and kinds <= {Kind.PARAMETER, Kind.SIZE}:
            self.problems.add_once(
                when.place,
                f"{where} needs an expression that becomes 0, but this one never changes",
                "let it depend on a coordinate, a velocity or t",
            )

    def apart(self, group: WrittenEvent | WrittenFamily[WrittenEvent]) -> Iterator[WrittenEvent]:
        """The events whose actions have to be checked one by one: of members that are alike the first one, if
        nothing is wrong with the others."""
        if not isinstance(group, WrittenFamily):
            yield group
            return
        alike: dict[int, list[Part[WrittenEvent]]] = {}
        for part in group.parts:
            alike.setdefault(id(part.item), []).append(part)
        for parts in alike.values():
            members = chain.from_iterable(map(group.of_part, parts))
            yield next(members)
            if parts[0].item.changes and not (self.names.has_many(*parts) and self._sound(parts)):
                yield from members

    def _sound(self, parts: Sequence[Part[WrittenEvent]]) -> bool:
        """Whether it is certain that nothing is wrong with what the actions of members set that are alike."""
        from lagrange_cli.spec.events.together import Together

        changes = parts[0].item.changes
        trusted = all(one.value is None or self.problems.trusts(one.value.tree) for one in changes)
        return trusted and Together(self.names, parts).sound(changes)

    def changes(self, event: WrittenEvent) -> None:
        """Check that each new value is that of something that can be set, and that is set once."""
        found = set[str]()
        label = f"event '{event.key.label}'"
        for entry in event.changes:
            try:
                targets = [*self._targets(entry, event.indices)]
            except ExpressionError as error:
                self.problems.add_once(entry.at(error.span), f"{error.message} in {label}", error.hint)
                targets = []
            if not targets and entry.value is not None:
                own = {axis.index: 0 for axis in entry.key.axes if axis.index}
                value = replace(entry.value, indices={**event.indices, **own})
                if own:  # none of them has a value
                    self.names.check_names(value, "events", named(entry, label))
                else:
                    self._check_value(value, entry, label)
            for name, indices in targets:
                if name in found:
                    message = f"{label} sets '{name}' twice"
                    self.problems.add_once(entry.place, message, "leave one of them out")
                if entry.value is not None:
                    found.add(name)
                    self._check_value(replace(entry.value, indices=indices), entry, label)

    def _check_value(self, value: Expression, entry: Entry, label: str) -> None:
        check_scalar(self.names, value, "events", named(entry, label))

    def _targets(self, entry: Entry, around: Mapping[str, int]) -> Iterator[tuple[str, Mapping[str, int]]]:
        """The names that an entry sets, each with the values of the indices in its new value.

        Raises:
            ExpressionError: where one of them does not exist or cannot be set.
        """
        base, _, component = entry.name.partition(".")
        axes = entry.key.axes
        if base in self.problems.broken:
            return
        known = {**self.names.sizes, **around}
        if id(entry) not in self.examined:
            self._examine(entry, base, component, known)
            self.examined.add(id(entry))
        family = self.names.table[base].family
        if family is not None and base not in self.members:
            self.members[base] = frozenset(one for one in family.members if one in self.names.values)
        for place, own in places(axes, known, MAX_MEMBERS):
            member = member_name(base, place) if axes else base
            if member not in self.members.get(base, ()) and member not in self.names.values:
                if self.names.table[base].value is None:
                    continue  # mistakes of the family itself have been reported
                assert family is not None
                raise ExpressionError(axes[0].span, f"no member '{member}'", family.hint(member))
            yield member, {**around, **own}

    def _examine(self, entry: Entry, base: str, component: str, known: Mapping[str, int]) -> None:
        """Raise ExpressionError where the name of an entry, or one of its indices, is none."""
        axes = entry.key.axes
        name = Name(entry.name, Span(0, len(entry.name)), tuple(axis.bounds[0] for axis in axes))
        self._settable(name, base, component)
        for axis in axes:
            if axis.index:
                self.names.check_index(axis.index, axis.span)
                if axis.index in known:
                    message = f"the index '{axis.index}' is already used"
                    raise ExpressionError(axis.span, message, "give the index another name")

    def _settable(self, name: Name, base: str, component: str) -> None:
        """Raise ExpressionError for a name of something that an event cannot set."""
        meaning = self.names.table.get(base)
        if meaning is None:
            observables = {family_name(entry.name) for entry in self.draft.entries("observables")}
            if base in observables:
                hint = "set the coordinates, velocities and parameters that it depends on"
                raise ExpressionError(name.span, f"the observable '{base}' cannot be set", hint)
            raise ExpressionError(name.span, *self._unknown(base))
        if meaning.what not in SETTABLE:
            message = f"the {meaning.what.value} '{base}' cannot be set"
            if component and meaning.what in (Kind.PARTICLE, Kind.BODY):
                message = f"'{name.identifier}' follows from the coordinates and cannot be set"
            raise ExpressionError(name.span, message, _HINTS[meaning.what])
        if base in self.draft.tables:
            hint = "it is used as an index, and indices do not change as the system moves"
            raise ExpressionError(name.span, f"'{base}' cannot be set", hint)
        if component and meaning.value is not None:
            self.names.check_component(name, meaning, base, component)
        self.names.check_indices(name, meaning)

    def _unknown(self, name: str) -> tuple[str, str]:
        """The message for a name that does not exist, and a hint."""
        known = {one: meaning for one, meaning in self.names.table.items() if meaning.what in SETTABLE}
        coordinate, order = rate_of(
            name, [one for one, meaning in known.items() if meaning.what is Kind.COORDINATE]
        )
        if order > 1:
            return f"the acceleration '{name}' cannot be set", "the equations of motion determine it"
        hint = f"write {velocity_name(coordinate)} for the velocity of {coordinate}" if order else ""
        words = [meaning.family.label if meaning.family else one for one, meaning in known.items()]
        return f"unknown name {shown(name)}", hint or near_hint(name, known) or known_hint(words)


def named(entry: Entry, label: str) -> str:
    """What messages call a new value."""
    return f"the new {entry.key.label} of {label}"
