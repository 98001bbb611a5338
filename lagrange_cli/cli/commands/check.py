"""``lagrange check``: is the file right, what kind of system is it, and what will ``solve`` skip?"""

from __future__ import annotations

from functools import partial

import click

from lagrange_cli.cli.console import complain, emit, emit_json, run_each, stem
from lagrange_cli.cli.options.shared import Given, given_options, systems_argument
from lagrange_cli.cli.progress import Waiting
from lagrange_cli.cli.source import read_system
from lagrange_cli.records import replace


@click.command("check")
@systems_argument
@click.option(
    "--verbose",
    is_flag=True,
    help="Also say what the system is made of, and how the equations will be integrated.",
)
@given_options
def check(systems: tuple[str, ...], verbose: bool, given: Given) -> int:
    """Validate system files and classify the systems that they describe.

    Print the degrees of freedom, whether the system is scleronomic or rheonomic, the cyclic coordinates, the
    conserved quantities with the reasons, and what 'solve' will skip. A file is accepted exactly if 'solve'
    accepts it. All its mistakes are shown. There are warnings about units that contradict each other, about
    conditions that rounding may decide, about names that nothing uses, about dissipation that does not brake,
    and about masses, or angles of a body, that are singular at the start. Nothing is integrated or written.
    """
    return run_each(systems, partial(check_system, given=given, verbose=verbose), as_json=given.as_json)


def check_system(system: str, given: Given, *, verbose: bool) -> int:
    """Check one system; returns the exit status."""
    from lagrange_cli.run.check import classify
    from lagrange_cli.run.classification import as_object, as_text
    from lagrange_cli.run.shortened import MOST_LINES
    from lagrange_cli.spec.values import resolve_values

    waiting = Waiting(stem(system), quiet=given.quiet)
    spec, values = read_system(system, given, resolve_values, waiting.stage)
    found = classify(spec, waiting.stage, values, given.overrides)
    if given.as_json:
        emit_json(as_object(found))
    elif not given.quiet:
        emit(as_text(found, verbose=verbose))
        for warning in found.warnings[:MOST_LINES]:
            complain(replace(warning, message=f"warning: {warning.message}").render(spec.filename))
        if len(found.warnings) > MOST_LINES:
            complain(f"{spec.filename}: {len(found.warnings) - MOST_LINES} more warnings, see --json")
    return 0
