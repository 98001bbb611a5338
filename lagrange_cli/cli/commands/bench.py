"""``lagrange bench``: run time against error, for one system, over methods and tolerances."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import click

from lagrange_cli.cli.completion.offers import comma_list, files
from lagrange_cli.cli.console import INTERRUPTED, complain, emit, emit_json, stem
from lagrange_cli.cli.options.shared import shared_options, system_argument
from lagrange_cli.cli.report.progress import ContestProgress, Waiting
from lagrange_cli.cli.signals import Interrupts
from lagrange_cli.cli.source import derive_system, read_bytes, read_run
from lagrange_cli.errors import UsageError
from lagrange_cli.integrate.methods.table import METHODS, TAYLOR, Needs
from lagrange_cli.integrate.precision import DOUBLE, FULL_PRECISION
from lagrange_cli.outputs.catalog import DEFAULT_OUTPUTS
from lagrange_cli.records import replace
from lagrange_cli.run.settings import resolve_method, resolve_settings, resolve_tolerance
from lagrange_cli.run.times import with_times
from lagrange_cli.spec.spec import SolveDefaults

if TYPE_CHECKING:
    from lagrange_cli.cli.report.work_precision import Standings
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values
    from lagrange_cli.work_precision.measure import Contender, Result, Rules
    from lagrange_cli.work_precision.trajectory import Followed

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
MOST_WITH_JACOBIAN = 32
"""Coordinates up to which implicit methods run unasked: a larger dense Jacobian takes long to compile."""

SMALLEST_ERROR, LARGEST_ERROR = 1e-12, 0.1
BETTER = 100
"""By how much the reference is to be better than the error wanted."""
PATIENCE = 5
"""Budgets that each of the reference's runs may take: its steps are several times as short."""


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
    type=float,
    default=1e-9,
    show_default=True,
    help="Recommend the fastest method that reaches this error of q, relative to its size.",
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
    f"[{','.join(f'{x:g}' for x in TOLERANCES)}, and full precision for {TAYLOR}].",
)
@click.option(
    "--runs",
    type=click.IntRange(min=1),
    default=5,
    show_default=True,
    help="The number of timed runs after a warm-up run. Their median is reported.",
)
@click.option(
    "--budget",
    type=click.FloatRange(min=0, min_open=True),
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
@shared_options
def bench(
    system: str,
    wanted: float,
    stop: str | None,
    methods: str | None,
    tolerances: tuple[float, ...] | None,
    runs: int,
    budget: float,
    plot: str | None,
    overrides: dict[str, str],
    sizes: dict[str, str],
    as_json: bool,
    quiet: bool,
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
        raise UsageError(f"--error must be from {SMALLEST_ERROR:g} to {LARGEST_ERROR:g}, not {wanted:g}")
    if plot is not None:
        from lagrange_cli.work_precision.figure import check_picture, write_picture

        check_picture(plot)

    from lagrange_cli.spec.values import resolve_values
    from lagrange_cli.work_precision.measure import Rules

    waiting = Waiting(stem(system), quiet=quiet)
    with waiting.stage("reading the system file"):
        spec, values = read_run(
            read_bytes(system),
            system,
            sizes,
            lambda spec, problems: resolve_values(spec, overrides, problems),
        )
    entries, left_out = enter(methods, tolerances, len(spec.coordinates))
    progress = ContestProgress(spec.name, quiet=quiet)
    with Interrupts() as interrupted:
        standings = compete(
            spec, values, stop, wanted, entries, Rules(runs, budget), waiting, progress, interrupted
        )
    from lagrange_cli.cli.report.work_precision import as_object, as_text, curves_of

    progress.clear()
    if as_json:
        emit_json(as_object(standings))
    elif not quiet:
        emit("\n".join((as_text(standings), *left_out)))
    if plot is not None:
        write_picture(plot, curves_of(standings))
    if interrupted():
        complain(f"{spec.name}: interrupted after {len(standings.results)} of {count(entries)} measurements")
        return INTERRUPTED
    return 0


def enter(
    methods: str | None, tolerances: Sequence[float] | None, degrees: int
) -> tuple[dict[str, Sequence[float]], list[str]]:
    """The tolerances by method, and what is left out that was not asked for."""
    left_out = []
    names = [resolve_method(name.strip()) for name in methods.split(",")] if methods else list(METHODS)
    if methods is None and degrees > MOST_WITH_JACOBIAN:
        implicit = [name for name in names if METHODS[name].needs is Needs.JACOBIAN]
        names = [name for name in names if name not in implicit]
        left_out = [
            f"  left out: {', '.join(implicit)}, as the dense Jacobian of {degrees} coordinates takes long "
            f"to compile; add them with --methods {','.join(implicit)}"
        ]
    own = {name: (*TOLERANCES, *full_precision_of(name)) for name in names}
    return {name: own[name] if tolerances is None else tolerances for name in names}, left_out


def full_precision_of(method: str) -> tuple[float, ...]:
    """The tolerance of full double precision, for a method that has it by default."""
    _, default = METHODS[method].tolerances[DOUBLE]
    return (default,) if default == FULL_PRECISION else ()


def count(entries: Mapping[str, Sequence[float]]) -> int:
    """How many contenders there are."""
    return sum(len(set(tolerances)) for tolerances in entries.values())


def compete(
    spec: Spec,
    values: Values,
    stop: str | None,
    wanted: float,
    entries: Mapping[str, Sequence[float]],
    rules: Rules,
    waiting: Waiting,
    progress: ContestProgress,
    interrupted: Callable[[], bool],
) -> Standings:
    """Find the reference, and measure every contender against it."""
    from lagrange_cli.cli.report.work_precision import Standings
    from lagrange_cli.work_precision.measure import hold
    from lagrange_cli.work_precision.reference import TOLERANCES as OF_REFERENCE
    from lagrange_cli.work_precision.reference import find_reference
    from lagrange_cli.work_precision.trajectory import SAMPLES, follow

    times = {} if stop is None else {"stop": stop}
    settings = resolve_settings(
        spec, with_times(SolveDefaults(samples=SAMPLES), times, spec, values.parameters)
    )
    with waiting.stage("deriving the equations of motion"):
        prepare = preparing(spec, settings.backward)

    def reference_run(prepared: Prepared, times: Times) -> Followed:
        followed = follow(prepared, values, times, PATIENCE * rules.budget, interrupted)
        if interrupted():
            raise KeyboardInterrupt
        return followed

    progress.show(0, count(entries), "reference")
    reference = find_reference(
        [partial(reference_run, prepare(TAYLOR, tolerance)) for tolerance in OF_REFERENCE],
        settings.start,
        settings.stop,
        wanted / BETTER,
        groups_of(spec),
    )
    results: list[Result] = []

    def prepare_next(contender: Contender) -> Prepared:
        resolve_tolerance(contender.tolerance, contender.method)
        progress.show(len(results), count(entries), contender)
        return prepare(contender.method, contender.tolerance)

    for result in hold(entries, prepare_next, values, reference, rules, interrupted):
        results.append(result)
    return Standings(spec.name, len(spec.coordinates), wanted, reference, tuple(results))


def preparing(spec: Spec, backward: bool) -> Callable[[str, float], Prepared]:
    """A function that compiles the system for a method and tolerance: at once as well as for a long run."""
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.integrate.methods.selection import follower
    from lagrange_cli.integrate.prepare import prepare

    residual = derive_system(spec)
    compiled: dict[Needs, Prepared] = {}

    def prepared(method: str, tolerance: float) -> Prepared:
        asked = Compilation(method, tolerance, frozenset(DEFAULT_OUTPUTS), backward=backward)
        needs = METHODS[method].needs
        if needs is Needs.SERIES:
            return prepare(residual, asked)
        if needs not in compiled:  # these programs serve several methods, at any tolerance
            compiled[needs] = prepare(residual, asked)
        following = follower(compiled[needs].machine, asked)
        return replace(compiled[needs], compilation=asked, follower=following)

    return prepared


def groups_of(spec: Spec) -> list[str]:
    """Which coordinates are measured against one size: those of one unit, else those of one family."""
    from lagrange_cli.expression.vocabulary import family_name

    return [f"in {each.unit}" if each.unit else family_name(each.name) for each in spec.coordinates]
