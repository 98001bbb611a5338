"""``lagrange bench``: run time against error, for one system, over methods and tolerances."""

from __future__ import annotations

from collections.abc import Container

import click

from lagrange_cli.cli.console import INTERRUPTED, complain, emit, emit_json, stem
from lagrange_cli.cli.options.completion import comma_list, files
from lagrange_cli.cli.options.shared import Given, Integer, Number, given_options, system_argument
from lagrange_cli.cli.progress import MeasuringProgress, Waiting
from lagrange_cli.cli.source import read_system
from lagrange_cli.decimals import decimal
from lagrange_cli.errors import UsageError
from lagrange_cli.integrate.methods.table import METHODS, TAYLOR
from lagrange_cli.run.bench import TOLERANCES
from lagrange_cli.run.interrupts import Interrupts
from lagrange_cli.run.monitor import ignore
from lagrange_cli.run.settings.methods import proper_name

SMALLEST_ERROR, LARGEST_ERROR = 1e-12, 0.1


def parse_tolerances(
    context: click.Context, parameter: click.Parameter, text: str | None
) -> tuple[float, ...] | None:
    """``"1e-6,1e-9"`` as numbers."""
    if text is None:
        return None
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError as error:
        raise click.BadParameter(
            f"{text!r} is not a comma-separated list of numbers, as in --tolerances 1e-6,1e-9",
            context,
            parameter,
        ) from error


@click.command("bench")
@system_argument
@click.option(
    "--error",
    "wanted",
    type=Number(),
    default=1e-9,
    help="Recommend the fastest method that reaches this error of q, relative to its size [1e-9].",
)
@click.option(
    "--stop",
    metavar="TIME",
    help="The time at which the motion ends: a number, or an expression in parameters (10*2*pi/omega).",
)
@click.option(
    "--methods",
    metavar="LIST",
    shell_complete=comma_list(METHODS),
    help=f"The methods to compare: a comma-separated list of {', '.join(METHODS)} [all].",
)
@click.option(
    "--tolerances",
    metavar="LIST",
    callback=parse_tolerances,
    help="The tolerances to try: a comma-separated list "
    f"[{','.join(decimal(x) for x in TOLERANCES)}, and full precision for {TAYLOR}].",
)
@click.option(
    "--runs",
    type=Integer(min=1),
    default=5,
    show_default=True,
    help="The number of timed runs after a warm-up run. Their median is reported.",
)
@click.option(
    "--budget",
    type=Number(min=0, min_open=True, infinite=True),
    default=2.0,
    show_default=True,
    help="The time limit in seconds for all runs of one method at one tolerance, compilation excluded.",
)
@click.option(
    "--plot",
    metavar="FILE.svg",
    shell_complete=files("svg", "pdf", "png"),
    help="Plot the run time against the error, as .svg, .pdf or .png.",
)
@given_options
def bench(
    system: str,
    wanted: float,
    stop: str | None,
    methods: str | None,
    tolerances: tuple[float, ...] | None,
    runs: int,
    budget: float,
    plot: str | None,
    given: Given,
) -> int:
    """Measure the run time and the error of each method at several tolerances, and recommend one.

    Errors are relative to a reference solution of higher order and with shorter steps. A chaotic motion is
    compared only up to the time at which the reference is no longer accurate enough. The only file written is
    the figure of --plot.

    \b
    lagrange bench pendulum.yaml
    lagrange bench pendulum.yaml --error 1e-6 --plot pendulum.svg
    """
    if not SMALLEST_ERROR <= wanted <= LARGEST_ERROR:
        raise UsageError(
            f"--error must be from {decimal(SMALLEST_ERROR)} to {decimal(LARGEST_ERROR)}, "
            f"not {decimal(wanted)}"
        )
    if plot is not None:
        from lagrange_cli.work_precision.figure import check_picture, write_picture

        check_picture(plot)

    from lagrange_cli.run.bench import count, entries_of, rank_methods
    from lagrange_cli.run.ranking import as_object, as_text, curves_of
    from lagrange_cli.spec.values import resolve_values
    from lagrange_cli.work_precision.measure import Rules

    waiting = Waiting(stem(system), quiet=given.quiet)
    spec, values = read_system(system, given, resolve_values, waiting.stage)
    names = [proper_name(name.strip(), [*METHODS]) for name in methods.split(",")] if methods else None
    entries = entries_of(names, tolerances, len(spec.coordinates), constrained=bool(spec.all_constraints))
    progress = MeasuringProgress(spec.name, quiet=given.quiet)
    with Interrupts() as interrupted:
        ranking = rank_methods(
            spec,
            values,
            stop,
            wanted,
            entries,
            Rules(runs, budget),
            waiting.stage,
            progress.show,
            interrupted,
            given.overrides,
            ignore if given.quiet else complain,
        )
    progress.clear()
    if given.as_json:
        emit_json(as_object(ranking))
    elif not given.quiet:
        constrained = bool(spec.all_constraints)
        left_out = [] if methods or constrained else left_out_of(entries, len(spec.coordinates))
        emit("\n".join((as_text(ranking), *left_out)))
    if plot is not None:
        write_picture(plot, curves_of(ranking))
    if interrupted():
        complain(f"{spec.name}: interrupted after {len(ranking.results)} of {count(entries)} measurements")
        return INTERRUPTED
    return 0


def left_out_of(entries: Container[str], degrees: int) -> list[str]:
    """The line of the summary that says which methods were left out unasked."""
    names = [name for name in METHODS if name not in entries]
    if not names:
        return []
    return [
        f"  left out: {', '.join(names)}, as the dense Jacobian of {degrees} coordinates takes long "
        f"to compile; add them with --methods {','.join(names)}"
    ]
