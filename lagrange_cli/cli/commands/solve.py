"""``lagrange solve``: integrate the motion and write it to an HDF5 file."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import nullcontext
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from lagrange_cli.cli.console import complain, emit, emit_json, run_each, stem
from lagrange_cli.cli.options.certify import (
    Demand,
    certificate_of,
    certify_options,
    companion_settings,
    series_of_errors,
)
from lagrange_cli.cli.options.run import (
    EXIT_STATUS,
    Request,
    find_output,
    list_of_outputs,
    origin,
    output_name,
    prepare_run,
    run_options,
    series_of,
    units_of,
)
from lagrange_cli.cli.options.shared import systems_argument
from lagrange_cli.cli.report.motion import as_object, as_text, attributes, doubt
from lagrange_cli.cli.report.progress import Progress as ProgressLine
from lagrange_cli.cli.report.progress import Waiting
from lagrange_cli.cli.signals import Interrupts
from lagrange_cli.cli.source import read_bytes, read_run
from lagrange_cli.errors import UsageError
from lagrange_cli.integrate.precision import DOUBLE, DOUBLE_DOUBLE_COST, PRECISIONS
from lagrange_cli.records import replace
from lagrange_cli.run.extend import samples_before, spaced_as_before
from lagrange_cli.run.formats import CSV, FORMATS, HDF5, format_of
from lagrange_cli.run.resume import Start, say_finished, take_up
from lagrange_cli.run.tabulate import check_table, tabulate
from lagrange_cli.run.timings import Stopwatch, as_table

if TYPE_CHECKING:
    import numpy as np

    from lagrange_cli.integrate.checkpoint import Progress
    from lagrange_cli.integrate.outcome import Outcome
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.run.settings import Settings
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values
    from lagrange_cli.store.checkpoint import Checkpoint
    from lagrange_cli.store.layout import Layout
    from lagrange_cli.store.resume import Earlier
    from lagrange_cli.store.writer import Writer


@click.command("solve")
@systems_argument
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    default=1,
    help="The number of systems to solve in parallel, each in its own process [1].",
)
@click.option(
    "--precision",
    type=click.Choice(PRECISIONS),
    default=DOUBLE,
    help="The arithmetic: double has about 16 digits; double-double has 31 and takes "
    f"{DOUBLE_DOUBLE_COST} times as long [{DOUBLE}].",
)
@click.option(
    "--portable",
    is_flag=True,
    help="Give the same bits on every machine, whatever its processor and its C library.",
)
@click.option(
    "--format",
    "asked_format",
    type=click.Choice(FORMATS),
    help="The format of the output [csv if the name of the output ends in .csv, else hdf5].",
)
@run_options(
    output="The file to write [SYSTEM.h5 in the current directory]; - is standard output, with --format csv.",
    outputs=f"What to write, as {list_of_outputs()}.",
)
@certify_options
def solve(
    systems: tuple[str, ...],
    request: Request,
    jobs: int,
    precision: str,
    portable: bool,
    asked_format: str | None,
    demand: Demand | None,
) -> int:
    """Integrate the motion of each system and write it to an HDF5 file, or to a table as CSV.

    SYSTEM.yaml may be - for standard input (written to stdin.h5). Options override the section 'solve' of the
    file.
    """
    form = format_of(request.output, asked_format)
    request = replace(request, precision=precision, portable=portable, format=form)
    refuse_shared_outputs(systems, request)
    if form == CSV:
        check_table(request)
    if demand is not None and precision != DOUBLE:
        raise UsageError(f"--certify needs precision {DOUBLE}: leave out one of the two")
    if demand is not None and portable:
        raise UsageError("--certify and --portable cannot be combined: leave out one of the two")
    solve_one = partial(solve_system, request=request, demand=demand)
    if jobs == 1 or len(systems) == 1:
        return run_each(systems, solve_one, as_json=request.as_json)
    from lagrange_cli.cli.jobs import run_side_by_side

    return run_side_by_side(systems, solve_one, jobs, as_json=request.as_json, quiet=request.quiet)


def refuse_shared_outputs(systems: tuple[str, ...], request: Request) -> None:
    """No two systems may be written to one file."""
    if request.output is not None and len(systems) > 1:
        raise UsageError("--output names one file, but there are several systems: leave it out")
    names = [output_name(system, request.output, format=request.format) for system in systems]
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"two of the systems would be written to {name}: solve them one by one")


def solve_system(system: str, request: Request, demand: Demand | None = None) -> int:
    """Read, derive, compile, integrate and write one system; returns the exit status."""
    began = time.process_time()
    watch = Stopwatch(Waiting(stem(system), quiet=request.quiet))
    spec, values, settings = read_motion(system, request, watch)
    with watch.stage("import"):
        name = output_name(system, request.output, format=request.format)
        options = {} if demand is None else demand.options_given()
        target = find_output(system, name, request, {"command": "'lagrange solve'", **options})
    if request.resume:
        settings = spaced_as_before(target, settings, request)
    made_by = origin(spec, settings, dict(values.parameters), initial_state(values))
    if demand is not None:
        made_by |= demand.attributes()
    with nullcontext() if request.streams else target.claimed():
        with watch.stage("import"):
            start = Start(target, made_by) if request.format == CSV else take_up(target, made_by, request)
        if start.finished is not None:
            return say_finished(start.finished, target.shown, watch, request)
        prepared, companions = prepare_all(spec, settings, watch, request, demand)
        outcome = integrate_and_write(
            spec, values, settings, prepared, start, watch, request, demand, companions
        )
    if outcome is None:
        return 0
    say = complain if request.streams else emit
    status = outcome.ending.status
    if request.as_json:
        emit_json(as_object(spec, settings, start, outcome, watch))
    elif not request.quiet:
        say(as_text(spec, settings, start, outcome, watch, demand))
        if request.timings:
            say(as_table(watch.report(), began, cached=prepared.cached))
    if status in ("failed", "interrupted"):
        resumable = outcome.progress is not None and request.format == HDF5
        way_on = "; --resume continues from there" if resumable else ""
        complain(f"{spec.name}: {outcome.message}{way_on}")
    warning = doubt(outcome, settings)
    if warning is not None and not request.quiet:
        complain(f"{spec.name}: warning: {warning}")
    return EXIT_STATUS[status]


def read_motion(system: str, request: Request, watch: Stopwatch) -> tuple[Spec, Values, Settings]:
    """The system, its numbers as run, and how it is to be run."""
    content = read_bytes(system)
    with watch.stage("import"):
        from lagrange_cli.spec.values import resolve_long_values, resolve_portable_values, resolve_values
    with watch.stage("parse"):
        resolve = resolve_portable_values if request.portable else resolve_values
        if request.precision != DOUBLE:
            resolve = resolve_long_values
        spec, values = read_run(
            content,
            system,
            request.sizes,
            lambda spec, problems: resolve(spec, request.overrides, problems),
        )
        return spec, values, request.settings(spec, values.parameters)


def initial_state(values: Values) -> list[Any]:
    """What stands for it in the output."""
    low = values.low
    return [values.q, values.v, *([] if low is None else [low.q, low.v, dict(low.parameters)])]


def prepare_all(
    spec: Spec, settings: Settings, watch: Stopwatch, request: Request, demand: Demand | None
) -> tuple[Prepared, list[Prepared]]:
    """The run in compiled form, and the companions that a certificate takes, prepared while LLVM compiles."""
    companions: list[Prepared] = []

    def meanwhile() -> None:
        import_the_rest(request.format)
        if demand is not None:
            chosen, orders = companion_settings(settings)
            cached = request.cache
            for order in orders:
                companions.append(
                    prepare_run(spec, chosen, watch, cached=cached, order=order, meanwhile=lambda: None)
                )

    prepared = prepare_run(spec, settings, watch, cached=request.cache, meanwhile=meanwhile)
    return prepared, companions


def import_the_rest(form: str) -> None:
    """Load what the run needs from here on; numpy and h5py are the most of it."""
    import lagrange_cli.integrate.methods.taylor
    import lagrange_cli.integrate.run

    if form == HDF5:
        import lagrange_cli.store.writer  # noqa: F401


def integrate_and_write(
    spec: Spec,
    values: Values,
    settings: Settings,
    prepared: Prepared,
    start: Start,
    watch: Stopwatch,
    request: Request,
    demand: Demand | None = None,
    companions: Sequence[Prepared] = (),
) -> Outcome | None:
    """Integrate chunk by chunk into the output, whatever way the motion ends; None where nobody reads it."""
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.store.layout import Layout

    times = Times(start=settings.start, stop=settings.stop, count=settings.count, step=settings.step)
    shown = ProgressLine(spec.name, settings.start, settings.stop, quiet=request.quiet)
    with watch.stage("write"):
        units = units_of(spec)
        series = series_of(units, prepared)
        if companions:
            series = series_of_errors(series, series_of(units, companions[0]))
        layout = Layout(series, time_unit=units.get("t", ""))
    if request.format == CSV:
        return tabulate(
            prepared, values, times, series, start.target, watch, shown, request, demand, companions
        )
    return record(values, settings, prepared, times, layout, start, watch, shown, request, demand, companions)


def record(
    values: Values,
    settings: Settings,
    prepared: Prepared,
    times: Times,
    layout: Layout,
    start: Start,
    watch: Stopwatch,
    shown: ProgressLine,
    request: Request,
    demand: Demand | None,
    companions: Sequence[Prepared],
) -> Outcome:
    """Integrate into an HDF5 file, with checkpoints."""
    from lagrange_cli.integrate.checkpoint import Checkpointing, Schedule
    from lagrange_cli.integrate.run import integrate
    from lagrange_cli.store.writer import Writer

    with Interrupts() as interrupted:
        with watch.stage("write"):
            writer = Writer(start.target, layout, expected=settings.count)

        def emit_chunk(chunk: dict[str, np.ndarray]) -> None:
            with watch.stage("write"):
                writer.append(chunk)

        def checkpoint(progress: Progress, *, inside: bool = False) -> Checkpoint:
            arrays = {"memory": progress.snapshot.memory, **writer.state()}
            content = {"reached": progress.snapshot.t, "progress": progress.as_data()}
            return start.checkpoint(content, arrays, inside=inside)

        def continued(outcome: Outcome) -> tuple[Checkpoint | None, Checkpoint | None]:
            if outcome.progress is None or outcome.ending.status == "failed":
                return None, None
            last = checkpoint(outcome.progress, inside=True)
            if outcome.ending.status == "interrupted":
                return last, None
            memory = {"memory": last.arrays["memory"]}
            return None, replace(last, head={**last.head, "replace": False}, arrays=memory)

        def keep(progress: Progress) -> None:
            with watch.stage("write"):
                writer.keep(checkpoint(progress))

        with writer:
            begin = None
            if start.earlier is not None:
                with watch.stage("write"):
                    rows = layout.chunk_rows(samples_before(start.earlier))
                    begin = replay(start.earlier, writer, prepared, times, rows)
            steps = 0 if begin is None else begin.snapshot.steps
            clock = Schedule(request.checkpoint, request.checkpoint_count, steps)
            keeping = Checkpointing(begin, clock, keep) if demand is None else None
            with watch.stage("integrate"), certificate_of(demand, companions, values, times) as certificate:
                outcome = integrate(
                    prepared, values, times, emit_chunk, interrupted, shown.show, keeping, certificate
                )
            shown.clear()
            with watch.stage("write"):
                writer.close(attributes(start.made_by, outcome, settings), *continued(outcome))
    return outcome


def replay(earlier: Earlier, writer: Writer, prepared: Prepared, times: Times, rows: int) -> Progress:
    """Append the samples of an earlier run, in chunks of ``rows``, and say how far it had come."""
    from lagrange_cli.integrate.checkpoint import Progress
    from lagrange_cli.store.checkpoint import damaged

    checkpoint, program = earlier.checkpoint, prepared.machine.program
    data, memory = checkpoint.head.get("progress"), checkpoint.arrays.get("memory")
    try:
        progress = Progress.from_data(data, memory, program, prepared.recording.conserved, times)
    except ValueError as error:
        raise damaged(earlier.shown) from error
    for chunk in earlier.chunks(rows, writer.shapes, progress.snapshot.samples):
        writer.append(chunk)
    return progress
