"""``lagrange check``: is the file right, what kind of system is it, and what will ``solve`` skip?"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from lagrange_cli.cli.console import complain, count_of, emit, emit_json, run_each, stem
from lagrange_cli.cli.options.shared import shared_options, systems_argument
from lagrange_cli.cli.report.progress import Waiting
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.errors import Problem
    from lagrange_cli.mechanics.residual import Residual
    from lagrange_cli.spec.spec import Spec

MOST_LINES = 20
"""Entries of one list that are shown."""


@click.command("check")
@systems_argument
@click.option("--verbose", is_flag=True, help="Also describe how the equations will be integrated.")
@shared_options
def check(
    systems: tuple[str, ...],
    verbose: bool,
    overrides: dict[str, str],
    sizes: dict[str, str],
    as_json: bool,
    quiet: bool,
) -> int:
    """Validate system files and classify the systems that they describe.

    Print the degrees of freedom, whether the system is scleronomic or rheonomic, the cyclic coordinates, the
    conserved quantities with the reasons, and what 'solve' will skip. A file is accepted exactly if 'solve'
    accepts it. All its mistakes are shown, and units that contradict each other are warned of. Nothing is
    integrated or written.
    """
    return run_each(
        systems,
        lambda system: check_system(system, overrides, sizes, as_json=as_json, quiet=quiet, verbose=verbose),
        as_json=as_json,
    )


def check_system(
    system: str,
    overrides: dict[str, str],
    sizes: dict[str, str],
    *,
    as_json: bool,
    quiet: bool,
    verbose: bool,
) -> int:
    """Check one system; returns the exit status."""
    from lagrange_cli.cli.source import derive_system, read_bytes, read_run
    from lagrange_cli.mechanics.omitted_work import engine, skipped
    from lagrange_cli.spec.values import resolve_values

    waiting = Waiting(stem(system), quiet=quiet)
    with waiting.stage("reading the system file"):
        spec, _ = read_run(
            read_bytes(system),
            system,
            sizes,
            lambda spec, problems: resolve_values(spec, overrides, problems),
        )
    with waiting.stage("deriving the equations of motion"):
        residual = derive_system(spec)
    warnings = contradicting_units(spec)
    left_out = skipped(residual, left_out_of(spec))
    if as_json:
        emit_json(as_object(spec.name, residual, left_out, engine(residual), warnings))
    elif not quiet:
        emit(as_text(spec.name, residual, left_out, engine(residual) if verbose else ()))
        for warning in warnings[:MOST_LINES]:
            complain(replace(warning, message=f"warning: {warning.message}").render(spec.filename))
        if len(warnings) > MOST_LINES:
            complain(f"{spec.filename}: {len(warnings) - MOST_LINES} more warnings, see --json")
    return 0


def contradicting_units(spec: Spec) -> list[Problem]:
    """A warning for each place of the file where units contradict each other."""
    from lagrange_cli.outputs.units import find_units
    from lagrange_cli.spec.source import Source

    conflicts = find_units(spec).conflicts
    source = Source(spec.filename, spec.text) if conflicts else None
    return [source.problem(one.place, one.message, one.hint) for one in conflicts if source]


def as_object(
    name: str,
    residual: Residual,
    skipped: tuple[str, ...],
    engine: tuple[str, ...],
    warnings: Sequence[Problem] = (),
) -> dict[str, Any]:
    """The facts for ``--json``."""
    return {
        "name": name,
        "degrees_of_freedom": len(residual.coordinates),
        "scleronomic": residual.scleronomic,
        "cyclic": list(residual.cyclic),
        "conserved": [
            {"quantity": each.quantity, "expression": each.expression, "because": each.because}
            for each in residual.conserved
        ],
        "skipped": list(skipped),
        "engine": list(engine),
        "formulation": residual.formulation,
        "convolutions": dict(residual.costs),
        "warnings": [
            {"line": each.line, "column": each.column, "message": each.message, "hint": each.hint}
            for each in warnings
        ],
    }


def left_out_of(spec: Spec) -> list[str]:
    """The outputs that the system has and that ``solve`` leaves out by default."""
    from lagrange_cli.outputs.catalog import OUTPUTS
    from lagrange_cli.run.settings import ALL, default_outputs, resolve_outputs

    particles = spec.lagrangian is None
    has = resolve_outputs((ALL,), has_particles=particles)
    asked = resolve_outputs(spec.solve.outputs or default_outputs(spec), has_particles=particles)
    none = {name for name, row in OUTPUTS.items() if row.section and not getattr(spec, row.section)}
    return [name for name in OUTPUTS if name in has - asked - none]


def as_text(name: str, residual: Residual, skipped: tuple[str, ...], engine: tuple[str, ...] = ()) -> str:
    """The facts in a few lines."""
    particles = residual.model.lagrangian is None
    if residual.scleronomic:
        kind = f"scleronomic: {'positions do' if particles else 'L does'} not depend on t"
    else:
        kind = f"rheonomic: {'positions depend' if particles else 'L depends'} on t"
    conserved = [f"{each.quantity} = {each.expression}: {each.because}" for each in residual.conserved]
    return "\n".join(
        (
            f"{name}: {count_of(len(residual.coordinates), 'degree')} of freedom, {kind}",
            f"  coordinates: {', '.join(in_short(residual.coordinates, residual))}",
            f"  cyclic: {', '.join(in_short(residual.cyclic, residual)) or 'none'}",
            *section("conserved", conserved, "neither h nor any p_k"),
            *section("skipped by solve", skipped, "nothing"),
            *(section("integration", engine, "") if engine else ()),
        )
    )


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
