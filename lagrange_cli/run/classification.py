"""What ``check`` finds, in words and as data."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from lagrange_cli.records import fields_of
from lagrange_cli.run.shortened import by_template, cut, in_short, listed, readable, section, together
from lagrange_cli.run.source import count_of
from lagrange_cli.spec.content import firsts, groups_by_name, names_of
from lagrange_cli.spec.spec import freedom
from lagrange_cli.spec.whole import WrittenFamily

if TYPE_CHECKING:
    from lagrange_cli.run.check import Classification, Eliminated
    from lagrange_cli.spec.event import Event
    from lagrange_cli.spec.source import Expression
    from lagrange_cli.spec.spec import Spec

MOST_SET = 3
"""If an action sets more members of a family, they are shown together."""


def as_object(found: Classification) -> dict[str, Any]:
    """The facts for ``--json``."""
    from lagrange_cli.model.events import DIRECTIONS, action_of
    from lagrange_cli.spec.spelling import spelled

    mechanics = found.mechanics
    return {
        "name": found.spec.name,
        "degrees_of_freedom": found.spec.degrees_of_freedom,
        "scleronomic": not mechanics.depending,
        "cyclic": list(mechanics.cyclic),
        **constraints_object(found),
        "conserved": [
            {
                "quantity": each.quantity,
                "expression": each.expression,
                "because": each.because,
                **({"broken_by": list(each.breaks)} if each.breaks else {}),
            }
            for each in mechanics.conserved
        ],
        "events": [
            {
                "name": name,
                "when": spelled(each.when, found.spec.sizes),
                "direction": DIRECTIONS[each.direction],
                "action": action_of(each.stops, each.changes),
                "set": {target: spelled(value, found.spec.sizes) for target, value in each.changes.items()},
            }
            for name, each in found.spec.events.items()
        ],
        "skipped": list(found.skipped),
        "structure": list(mechanics.structure),
        "engine": list(mechanics.engine),
        "formulation": mechanics.formulation,
        "convolutions": dict(mechanics.convolutions),
        "warnings": [
            {"line": each.line, "column": each.column, "message": each.message, "hint": each.hint}
            for each in found.warnings
        ],
    }


def dependence_on_time(found: Classification) -> str:
    """Whether the system is scleronomic or rheonomic, and by what."""
    mechanics, spec = found.mechanics, found.spec
    depending = mechanics.depending
    if depending:
        depend = "depends" if depending == ("L",) else "depend"
        return f"rheonomic: {listed(depending)} {depend} on t"
    independent = ["L" if spec.lagrangian is not None else "positions"]
    independent += ["orientations"] * bool(spec.bodies)
    independent += ["constraints"] * bool(spec.independent.all_constraints)
    do = "does" if independent == ["L"] else "do"
    return f"scleronomic: {listed(independent)} {do} not depend on t"


def as_text(found: Classification, *, verbose: bool) -> str:
    """The facts in a few lines."""
    names, spec = [*names_of(found.spec.coordinates)], found.spec
    mechanics = found.mechanics
    conserved = {
        one.quantity: f"{one.quantity} = {readable(one.expression)}: {one.because}"
        for one in mechanics.conserved
    }
    free = freedom(spec.degrees_of_freedom, spec.of_first_order)
    return "\n".join(
        (
            f"{spec.name}: {free}, {dependence_on_time(found)}",
            f"  coordinates: {', '.join(in_short(names, spec))}",
            f"  cyclic: {', '.join(in_short(found.mechanics.cyclic, spec)) or 'none'}",
            *constraints_shown(found),
            *section("conserved", together(conserved, spec), "neither h nor any p_k"),
            *(section("events", events_of(spec), "") if spec.events else ()),
            *section("skipped by solve", found.skipped, "nothing"),
            *(section("structure", mechanics.structure, "") if verbose and mechanics.structure else ()),
            *(section("integration", details(found), "") if verbose and mechanics.engine else ()),
        )
    )


def constraints_object(found: Classification) -> dict[str, Any]:
    """The properties of constraints, for ``--json``."""
    from lagrange_cli.expression.text import text_of

    names = found.spec.all_constraints
    massless = [*(found.spec.massless.values() or found.spec.first_order)]
    without_mass = {"massless": massless} if massless else {}
    if not names:
        return {**without_mass, "initial": found.begin.as_data()} if massless else {}
    said: dict[str, Any] = {"constraints": [*names], "initial": found.begin.as_data(), **without_mass}
    said["eliminated"] = [
        {name: getattr(one, name) for name in fields_of(one)} for one in found.mechanics.eliminated
    ]
    if found.integrability is not None:
        integrability = found.integrability
        said["integrable"] = {"together": integrability.together, **integrability.alone}
        said["combinations"] = {
            each.name: {
                "constraints": [*each.constraints],
                "factors": None if each.factors is None else [text_of(factor) for factor in each.factors],
            }
            for each in integrability.combinations
        }
        kept, coordinates = integrability.functions, len(found.spec.coordinates)
        said["reachable"] = None if kept is None else coordinates - kept
        said["integrals"] = dict(found.integrals)
    return said


def constraints_shown(found: Classification) -> list[str]:
    """The same in lines."""
    from lagrange_cli.run.start_notes import notes

    names = found.spec.all_constraints
    lines = [line.removeprefix("warning: ") for line in notes(found.begin)]
    if found.spec.first_order:
        light = ", ".join(in_short([*found.spec.first_order], found.spec))
        lines.insert(0, "their equations of motion contain no accelerations, and give their velocities")
        return [f"  without mass: {light}", *(f"    {line}" for line in lines)]
    if not names:
        return []
    massless = [*found.spec.massless.values()]
    if massless:
        those = "has no mass: its equation of motion is" if len(massless) == 1 else "have no mass: their"
        those += " a constraint" if len(massless) == 1 else " equations of motion are constraints"
        lines.append(f"{', '.join(in_short(massless, found.spec))} {those}, without accelerations")
    lines += [*integrable(found), *eliminated(found)]
    kept = {each.quantity for each in found.mechanics.conserved}
    changing = [name for name in found.mechanics.cyclic if f"p_{name}" not in kept]
    if changing:
        cyclic = ", ".join(in_short(changing, found.spec))
        those = "it, so that its momentum" if len(changing) == 1 else "them, so that their momenta"
        lines.append(f"L does not contain {cyclic}, but forces may act along {those} may change")
    shown = in_short([*names], found.spec, ("constraints", "nonholonomic"))
    return [f"  constraints: {', '.join(shown)}", *(f"    {line}" for line in lines)]


def eliminated(found: Classification) -> list[str]:
    """Which coordinates follow from linear constraints before the motion is followed, in one sentence."""
    given = found.mechanics.eliminated
    if not given:
        return []
    names = in_short([one.coordinate for one in given], found.spec)
    if len(given) > 1:
        return [f"{listed(names)} follow from linear constraints: the equations are solved without them"]
    return [sentence(found, given[0])]


def sentence(found: Classification, one: Eliminated) -> str:
    """From which constraint a coordinate follows, and what it is."""
    line = found.spec.all_constraints[one.constraint].place.line
    where = f"the constraint {one.constraint} (line {line}), which is linear"
    return f"{one.quantity} follows from {where}: {one.quantity} = {one.expression}"


def details(found: Classification) -> list[str]:
    """How the equations are integrated, in sentences."""
    mechanics = found.mechanics
    each = [sentence(found, one) for one in mechanics.eliminated]
    return [*(each if len(each) > 1 else []), *mechanics.engine]


def integrable(found: Classification) -> list[str]:
    """What Frobenius' theorem says of each constraint on velocities, and of all of them."""
    if found.integrability is None:
        return []
    lines, alone = [], found.integrability.alone
    each_so = {
        name: f"{name} is integrable (Frobenius), so it is holonomic: {kept_by(found, name)}"
        for name, is_so in alone.items()
        if is_so
    }
    lines += cut(by_template(each_so, found.spec))
    others = [name for name, is_so in alone.items() if is_so is False]
    for name in in_short(others, found.spec, ("nonholonomic",)):
        each = "" if name in alone else "each of "
        lines.append(f"{each}{name} is not integrable (Frobenius): it is nonholonomic")
    lines += combined(found)
    if len(alone) > 1 and found.integrability.together and not all(alone.values()):
        every = ", ".join(in_short([*alone], found.spec, ("nonholonomic",)))
        lines.append(f"together {every} are integrable (Frobenius): they are holonomic")
    kept, coordinates = found.integrability.functions, len(found.spec.coordinates)
    if kept is not None and (
        found.integrability.combinations or any(alone.values()) or found.integrability.together
    ):
        reached = f"at most {count_of(coordinates - kept, 'dimension')} of {coordinates}"
        between = " between events" if found.spec.acts else ""
        lines.append(f"so the configurations that a motion reaches{between} have {reached}")
    return lines


def combined(found: Classification) -> list[str]:
    """The combinations of constraints that are integrable, those without an integral in one line."""
    if found.integrability is None:
        return []
    names = [each.name for each in found.integrability.combinations]
    lines = [
        f"{name} is integrable (Frobenius): {kept_by(found, name)}"
        for name in names
        if name in found.integrals
    ]
    rest = [name for name in names if name not in found.integrals]
    if rest:
        alone = found.integrability.alone
        known = [name for name in found.spec.all_constraints if alone.get(name, True)]
        known = in_short(known, found.spec, ("constraints", "nonholonomic"))
        known += [name for name in names if name in found.integrals]
        where = f"where {listed(known)} {'hold' if len(known) > 1 else 'holds'}, " if known else ""
        kept = f"{len(rest)} functions of q and t are" if len(rest) > 1 else "a function of q and t is"
        those = f"{listed(rest)} {'are integrable together' if len(rest) > 1 else 'is integrable'}"
        lines.append(f"{where}{those} (Frobenius): {kept} constant")
    return lines


def kept_by(found: Classification, name: str) -> str:
    """What an integrable constraint, or a combination of constraints, keeps constant."""
    integral = found.integrals.get(name)
    return f"{integral} is constant" if integral is not None else "a function of q and t is constant"


def events_of(spec: Spec) -> list[str]:
    """Each event in a line: its name, where it is, and what happens there; members of a family together, as
    the file has them."""
    lines = []
    for name, group in groups_by_name(spec.events).items():
        if isinstance(group, WrittenFamily) and len(group) > 1:
            alike = {one.key.text if one.key else one.when.text: one for one in firsts(group)}
            lines += [event_of(key, one, None) for key, one in alike.items()]
        else:
            lines.append(event_of(name, spec.events[name], spec))
    return lines


def event_of(name: str, event: Event, spec: Spec | None) -> str:
    """The line of one event: with the numbers that indices have in a ``spec``, or as it is written."""
    from lagrange_cli.model.events import HOW
    from lagrange_cli.spec.spelling import spelled

    def text(one: Expression) -> str:
        return one.text if spec is None else spelled(one, spec.sizes)

    what = "the motion ends" if event.stops else "recorded"
    if spec is None or len(event.changes) > max(MOST_SET, len(event.sets)):
        changes = [(one.key.text, one.value.text) for one in event.sets]
    else:
        changes = [(name, text(value)) for name, value in event.changes.items()]
    if changes:
        what = ", ".join(f"{target} -> {value}" for target, value in changes)
    return f"{name}: {text(event.when)} = 0, {HOW[event.direction]}: {what}"
