"""``lagrange check``: is the file right, what kind of system is it, and what will ``solve`` skip?"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from lagrange_cli.cli.console import complain, count_of, emit, emit_json, run_each, stem
from lagrange_cli.cli.options.shared import Given, given_options, systems_argument
from lagrange_cli.cli.progress import Waiting
from lagrange_cli.cli.source import read_system
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.mechanics.residual import Residual
    from lagrange_cli.run.check import Classification
    from lagrange_cli.spec.spec import Spec

MOST_LINES = 20
"""Entries of one list that are shown."""


@click.command("check")
@systems_argument
@click.option("--verbose", is_flag=True, help="Also describe how the equations will be integrated.")
@given_options
def check(systems: tuple[str, ...], verbose: bool, given: Given) -> int:
    """Validate system files and classify the systems that they describe.

    Print the degrees of freedom, whether the system is scleronomic or rheonomic, the cyclic coordinates, the
    conserved quantities with the reasons, and what 'solve' will skip. A file is accepted exactly if 'solve'
    accepts it. All its mistakes are shown. Units that contradict each other, and conditions that rounding may
    decide, are warned of. Nothing is integrated or written.
    """
    return run_each(systems, partial(check_system, given=given, verbose=verbose), as_json=given.as_json)


def check_system(system: str, given: Given, *, verbose: bool) -> int:
    """Check one system; returns the exit status."""
    from lagrange_cli.run.check import classify
    from lagrange_cli.spec.values import resolve_values

    waiting = Waiting(stem(system), quiet=given.quiet)
    spec, _ = read_system(system, given, resolve_values, waiting.stage)
    found = classify(spec, waiting.stage)
    if given.as_json:
        emit_json(as_object(found))
    elif not given.quiet:
        emit(as_text(found, verbose=verbose))
        for warning in found.warnings[:MOST_LINES]:
            complain(replace(warning, message=f"warning: {warning.message}").render(spec.filename))
        if len(found.warnings) > MOST_LINES:
            complain(f"{spec.filename}: {len(found.warnings) - MOST_LINES} more warnings, see --json")
    return 0


def as_object(found: Classification) -> dict[str, Any]:
    """The facts for ``--json``."""
    from lagrange_cli.model.events import DIRECTIONS, action_of
    from lagrange_cli.spec.spelling import spelled

    residual = found.residual
    return {
        "name": found.spec.name,
        "degrees_of_freedom": len(residual.coordinates),
        "scleronomic": residual.scleronomic,
        "cyclic": list(residual.cyclic),
        "conserved": [
            {
                "quantity": each.quantity,
                "expression": each.expression,
                "because": each.because,
                **({"broken_by": list(each.breaks)} if each.breaks else {}),
            }
            for each in residual.conserved
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
        "engine": list(found.engine),
        "formulation": residual.formulation,
        "convolutions": dict(residual.costs),
        "warnings": [
            {"line": each.line, "column": each.column, "message": each.message, "hint": each.hint}
            for each in found.warnings
        ],
    }


def as_text(found: Classification, *, verbose: bool) -> str:
    """The facts in a few lines."""
    residual = found.residual
    particles = residual.model.lagrangian is None
    if residual.scleronomic:
        kind = f"scleronomic: {'positions do' if particles else 'L does'} not depend on t"
    else:
        kind = f"rheonomic: {'positions depend' if particles else 'L depends'} on t"
    conserved = [f"{each.quantity} = {each.expression}: {each.because}" for each in residual.conserved]
    return "\n".join(
        (
            f"{found.spec.name}: {count_of(len(residual.coordinates), 'degree')} of freedom, {kind}",
            f"  coordinates: {', '.join(in_short(residual.coordinates, residual))}",
            f"  cyclic: {', '.join(in_short(residual.cyclic, residual)) or 'none'}",
            *section("conserved", conserved, "neither h nor any p_k"),
            *(section("events", events_of(found.spec), "") if found.spec.events else ()),
            *section("skipped by solve", found.skipped, "nothing"),
            *(section("integration", found.engine, "") if verbose and found.engine else ()),
        )
    )


def events_of(spec: Spec) -> list[str]:
    """Each event in a line: its name, where it is, and what happens there."""
    from lagrange_cli.model.events import HOW
    from lagrange_cli.spec.spelling import spelled

    lines = []
    for name, each in spec.events.items():
        what = "the motion ends" if each.stops else "recorded"
        if each.changes:
            sizes = spec.sizes
            what = ", ".join(f"{target} -> {spelled(value, sizes)}" for target, value in each.changes.items())
        lines.append(f"{name}: {spelled(each.when, spec.sizes)} = 0, {HOW[each.direction]}: {what}")
    return lines


def in_short(names: Sequence[str], residual: Residual) -> list[str]:
    """The names, with all members of a family as one: ``u[0..19,0..9]``."""
    from lagrange_cli.expression.vocabulary import family_name, member_name

    families = residual.model.families.get("coordinates", {})
    present = set(names)
    whole = {name: family for name, family in families.items() if present.issuperset(family.members)}
    shown: dict[str, None] = {}
    for name in names:
        family = whole.get(family_name(name))
        shown[name if family is None else member_name(family.name, (f"0..{n - 1}" for n in family.shape))] = (
            None
        )
    return list(shown)


def section(title: str, lines: Sequence[str], none: str) -> list[str]:
    """A titled list, one line for each entry as long as there are not too many; ``none`` if it is empty."""
    left = len(lines) - MOST_LINES
    more = [f"    and {left} more, see --json"] if left > 0 else []
    shown = [f"    {line}" for line in lines[:MOST_LINES]]
    return [f"  {title}:", *shown, *more] if lines else [f"  {title}: {none}"]
