"""The events of a file to those of a ``Spec``: targets of actions must exist, and expressions must vary."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from lagrange_cli.expression.confusions import rate_of
from lagrange_cli.expression.loops import places
from lagrange_cli.expression.near import known_hint, near_hint, shown
from lagrange_cli.expression.syntax import ExpressionError, Name, Span
from lagrange_cli.expression.vocabulary import family_name, member_name, velocity_name
from lagrange_cli.records import dataclass, field, replace
from lagrange_cli.spec.content import groups_of
from lagrange_cli.spec.draft import Draft, Entry, WrittenEvent
from lagrange_cli.spec.families import MAX_MEMBERS
from lagrange_cli.spec.kinds import Kind
from lagrange_cli.spec.names import Names
from lagrange_cli.spec.problems import Problems
from lagrange_cli.spec.settling import check_scalar
from lagrange_cli.spec.spec import Event, Expression

SETTABLE = frozenset({Kind.COORDINATE, Kind.VELOCITY, Kind.PARAMETER})
_HINTS = {
    Kind.TIME: "coordinates, velocities and parameters can be set, but not the time",
    Kind.PARTICLE: "set the coordinates and velocities that it depends on",
    Kind.BODY: "set the coordinates and velocities that it depends on",
    Kind.DEFINITION: "set the coordinates, velocities and parameters that it depends on",
    Kind.SIZE: "coordinates, velocities and parameters can be set, but not sizes",
}


def check_events(draft: Draft, names: Names, problems: Problems) -> dict[str, Event]:
    """The events by name, members of families one by one; mistakes are added to ``problems``."""
    checker = _Checker(draft, names, problems)
    found = {}
    for group in groups_of(draft.events):
        for event in names.apart(group):
            if event.when is not None:
                checker.when(event, event.when)
    for event in draft.events:
        changes = checker.changes(event)
        if event.when is not None:
            sets = tuple((one.key, one.value.tree) for one in event.changes if one.value is not None)
            found[event.name] = Event(
                event.when, event.direction, event.stops, changes, event.place, event.key, sets
            )
    return found


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

    def changes(self, event: WrittenEvent) -> dict[str, Expression]:
        """The new values by name, each of something that can be set and that is set once."""
        found: dict[str, Expression] = {}
        label = f"event '{event.key.label}'"
        for entry in event.changes:
            try:
                targets = [*self._targets(entry, event.indices)]
            except ExpressionError as error:
                self.problems.add_once(entry.at(error.span), f"{error.message} in {label}", error.hint)
                targets = []
            if not targets and entry.value is not None:
                self._check_value(replace(entry.value, indices=event.indices), entry, label)
            for name, indices in targets:
                if name in found:
                    message = f"{label} sets '{name}' twice"
                    self.problems.add_once(entry.place, message, "leave one of them out")
                if entry.value is not None:
                    found[name] = replace(entry.value, indices=indices)
                    self._check_value(found[name], entry, label)
        return found

    def _check_value(self, value: Expression, entry: Entry, label: str) -> None:
        check_scalar(self.names, value, "events", f"the new {entry.key.label} of {label}")

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
