"""Events in the output of a run: the groups of the file, and a summary."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from lagrange_cli.decimals import decimal, scientific

if TYPE_CHECKING:
    from lagrange_cli.integrate.events import Happened
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.outputs.recording import EventGroup
    from lagrange_cli.run.motion import Motion
    from lagrange_cli.spec.event import Event
    from lagrange_cli.spec.family import Family
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.store.layout import EventSeries, Series

NEXT_TO_NOTHING = 2.0**-40
"""An expression this small beside the coordinates is 0."""
MOST_TEXTS = 4
"""Members of a family whose texts are shown, where they differ."""


def crossings_of(
    spec: Spec, prepared: Prepared, units: Mapping[str, str], *, ensemble: bool = False
) -> tuple[EventSeries, ...]:
    """The groups of the file for the system's events, in a run or in an ensemble."""
    from lagrange_cli.store.layout import EventSeries

    return tuple(
        EventSeries(group.name, series_of(group, prepared, units, ensemble), described(spec, group))
        for group in prepared.recording.events
    )


def series_of(
    group: EventGroup, prepared: Prepared, units: Mapping[str, str], ensemble: bool
) -> tuple[Series, ...]:
    """The datasets of a group: t, the members of an ensemble, the indices of a family, q and v."""
    from lagrange_cli.integrate.event_log import MEMBER
    from lagrange_cli.integrate.samples import LOW
    from lagrange_cli.records import replace
    from lagrange_cli.store.layout import Series

    times = Series(f"{group.path}/t", unit=units.get("t", ""), long_name="time of the event")
    members = Series(f"{group.path}/{MEMBER}", long_name="member of the ensemble", kind="i8")
    indices = [
        Series(f"{group.path}/{index}", long_name=f"index {index} of the event", kind="i8")
        for index in group.indices
    ]
    states = [
        Series(f"{group.path}/{one.path}", one.shape, units.get(one.path, ""), one.long_name, one.axes)
        for one in prepared.recording.at_events
    ]
    found = [times, *([members] if ensemble else []), *indices, *states]
    if prepared.machine.program.parts > 1:
        text = "low part of {}, to be added to /{}"
        found += [
            replace(one, path=LOW + one.path, long_name=text.format(one.long_name, one.path))
            for one in (times, *states)
        ]
    return tuple(found)


def described(spec: Spec, group: EventGroup) -> dict[str, str]:
    """The attributes of a group, which say what the event is in the words of the system file."""
    from lagrange_cli.expression.vocabulary import family_name
    from lagrange_cli.model.events import DIRECTIONS, action_of
    from lagrange_cli.spec.content import written_by_family

    alike = written_by_family(spec.events)[family_name(group.members[0])]
    actions: dict[str, None] = {}
    each = any(one.key.axes for event in alike for one in event.sets)
    for event in (spec.events[name] for name in group.members) if each else alike:
        changes = "; ".join(f"{name} = {value.text}" for name, value in event.changes.items())
        actions[f"{action_of(event.stops, event.changes)} {changes}".strip()] = None
        if len(actions) > MOST_TEXTS:
            break
    return {
        "when": enumerated([*dict.fromkeys(one.when.text for one in alike)]),
        "direction": enumerated([*dict.fromkeys(DIRECTIONS[one.direction] for one in alike)]),
        "action": enumerated([*actions]),
    }


def enumerated(texts: Sequence[str]) -> str:
    """Texts in one, of many the first ones."""
    return "; ".join([*texts[:MOST_TEXTS], *(["..."] if len(texts) > MOST_TEXTS else [])])


def counts(prepared: Prepared, happened: Sequence[Happened]) -> list[int]:
    """How many crossings each group has, from what happened at each event."""
    members = iter(happened)
    return [sum(next(members).count for _ in group.members) for group in prepared.recording.events]


def notes(
    spec: Spec, happened: Mapping[str, Happened], touching: Callable[[Event], bool] = lambda _: False
) -> list[str]:
    """Messages about the events at the end of a run: those that never happened, and those that rounding may
    have decided. ``touching`` says whether the expression of one is 0 at the start, which is no event."""
    from lagrange_cli.spec.spec import grouped

    found = []
    for family in grouped(happened, spec.families.get("events", {})):
        all_of_it = [happened[name] for name in family.members]
        if not any(one.count for one in all_of_it):
            first = spec.events[family.members[0]]
            later = " after the start, where its expression is 0" if touching(first) else ""
            found.append(f"event '{family.label}' did not occur{later}")
        found += rests(family, all_of_it)
        for doubt in grazing, blurred:
            said = [(name, doubt(one)) for name, one in zip(family.members, all_of_it) if doubt(one)]
            more = f" (also {len(said) - 1} more of its family)" if len(said) > 1 else ""
            found += [f"event '{name}': {text}{more}" for name, text in said[:1]]
    return found


def zero_at_start(motion: Motion) -> Callable[[Event], bool]:
    """Whether the expression of an event that sets something is 0 at the start: there the motion may rest."""

    def zero(event: Event) -> bool:
        from lagrange_cli.model.scope import Scope
        from lagrange_cli.model.start.equations import Equations, with_what_is_used

        if not event.changes:
            return False
        values = motion.values
        equations = Equations(motion.spec, values.parameters)
        algebra = equations.algebra(motion.settings.start, values.q, values.v)
        try:
            scope = Scope(with_what_is_used(motion.spec, [event.when]), algebra)
            size = abs(float(scope.scalar(event.when).value))
        except (ArithmeticError, ValueError, LookupError):
            return False
        return not scope.multipliers and size <= NEXT_TO_NOTHING * max(map(abs, values.q))

    return zero


def rests(family: Family, happened: Sequence[Happened]) -> Iterator[str]:
    """One message about the members of a family at whose events the motion has come to rest."""
    ends = [
        (one.accumulates, name, one.accumulations)
        for name, one in zip(family.members, happened)
        if one.accumulates is not None
    ]
    if len(ends) > 1:
        (first, *_), (last, *_) = min(ends), max(ends)
        when = (
            f"t = {decimal(first, 9)}" if first == last else f"t = {decimal(first, 9)} to {decimal(last, 9)}"
        )
        again = ", for the first time" if any(times > 1 for *_, times in ends) else ""
        members = f"{len(ends)} of {len(happened)} members"
        yield (
            f"event '{family.label}': infinitely many accumulate at {when}{again} ({members}); "
            "from then on each rests there"
        )
        return
    for t, name, times in ends:
        more = "" if times == 1 else f", the first of {times} such times"
        yield (
            f"event '{name}': infinitely many accumulate at t = {decimal(t, 9)}{more}; "
            "from then on the motion rests there"
        )


def notes_of_members(doubtful: Mapping[str, tuple[int, Happened]]) -> list[str]:
    """Messages about events that rounding may have decided, in the first such member of an ensemble."""
    return [
        f"event '{name}', in member {member}: {text}"
        for name, (member, one) in doubtful.items()
        for text in filter(None, (grazing(one), blurred(one)))
    ]


def grazing(one: Happened) -> str:
    """A message about zeros that may be none, or nothing."""
    if one.grazes is None or one.accumulations:  # impacts before their end are as weak as can be
        return ""
    times = "" if one.grazing == 1 else f", the first of {one.grazing} such times"
    return (
        f"its expression touches 0 without a clear change of sign "
        f"at t = {decimal(one.grazes, 9)}{times}; whether that counts depends on rounding"
    )


def blurred(one: Happened) -> str:
    """A message about zeros whose times rounding makes uncertain, or nothing."""
    if one.blurred is None:
        return ""
    off = f"may be off by {scientific(one.error)}" if math.isfinite(one.error) else "is not determined"
    return (
        f"at t = {decimal(one.blurred, 9)} its expression and its rate are both 0 up to rounding (a multiple "
        f"zero): the time {off}"
    )
