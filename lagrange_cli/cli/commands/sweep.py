"""``lagrange sweep``: integrate an ensemble of motions and write it to one HDF5 file."""

from __future__ import annotations

import os
import time
from typing import TYPE_CHECKING, Any

import click

from lagrange_cli.cli.completion.offers import files
from lagrange_cli.cli.console import STANDARD_INPUT, complain, emit, emit_json, run_each, stem
from lagrange_cli.cli.options.run import (
    EXIT_STATUS,
    STANDARD_OUTPUT,
    Request,
    find_output,
    list_of_outputs,
    output_name,
    prepare_run,
    run_options,
    units_of,
)
from lagrange_cli.cli.options.shared import SETTABLE, parse_pairs, system_argument
from lagrange_cli.cli.report.ensemble import (
    Ensemble,
    as_object,
    as_text,
    attributes,
    dimensions,
    made_by,
    sentence,
    series,
)
from lagrange_cli.cli.report.progress import Counter, Waiting
from lagrange_cli.cli.signals import Interrupts
from lagrange_cli.cli.source import read_bytes, read_run
from lagrange_cli.errors import UsageError
from lagrange_cli.run.formats import HDF5, format_of
from lagrange_cli.run.resume import Start, say_finished, take_up
from lagrange_cli.run.timings import Stopwatch, as_table

if TYPE_CHECKING:
    import numpy as np

    from lagrange_cli.cli.options.members import Draws
    from lagrange_cli.integrate.ensemble.outcome import EnsembleOutcome
    from lagrange_cli.integrate.method import Method
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.store.checkpoint import Checkpoint
    from lagrange_cli.store.resume import Earlier

LARGEST = 2**26
"""Bytes of one member's samples, which are kept in memory until it has ended."""


@click.command("sweep")
@system_argument
@click.option(
    "--over",
    metavar="NAME=VALUES",
    multiple=True,
    callback=parse_pairs,
    shell_complete=SETTABLE,
    help="Sweep NAME over START:STOP:COUNT (both ends included), log:START:STOP:COUNT or a list such as "
    "1,2,5. Repeat it for a grid of all combinations. NAME is a parameter or an initial value (theta, "
    "theta_dot).",
)
@click.option(
    "--random",
    metavar="NAME=DISTRIBUTION",
    multiple=True,
    callback=parse_pairs,
    shell_complete=SETTABLE,
    help="Draw NAME from normal(mean,deviation), uniform(low,high), lognormal(median,sigma) or "
    "loguniform(low,high); repeatable.",
)
@click.option(
    "--members", type=click.IntRange(min=1), help="The number of draws of --random, at each grid point."
)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    help="The seed of the random numbers: the same seed gives the same numbers [0].",
)
@click.option(
    "--table",
    metavar="FILE.csv",
    shell_complete=files("csv"),
    help="Run one motion for each row of a CSV file. The first line has the names, as in m,theta,theta_dot.",
)
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    help="The number of processors to use [all]. The results do not depend on it.",
)
@run_options(
    output="The file to write [SYSTEM_sweep.h5 in the current directory].",
    outputs=f"Write samples of each motion: {list_of_outputs()}. Without this option only the end is "
    "written.",
)
def sweep(
    system: str,
    request: Request,
    over: tuple[tuple[str, str], ...],
    random: tuple[tuple[str, str], ...],
    members: int | None,
    seed: int,
    table: str | None,
    jobs: int | None,
) -> int:
    """Integrate many motions of a system and write them to one HDF5 file.

    The motions, or members, differ in parameters or initial values: on a grid (--over), by random numbers
    (--random), or row by row of a table (--table). Each swept name is a dimension of the output.

    \b
    lagrange sweep pendulum.yaml --over theta=0:3:31
    lagrange sweep pendulum.yaml --over l=log:0.1:10:5 --over m=1,2
    lagrange sweep pendulum.yaml --random 'theta=normal(0,0.1)' --members 1000
    lagrange sweep pendulum.yaml --table runs.csv --outputs q,v --samples 101
    """
    from lagrange_cli.cli.options.members import Draws

    draws = Draws(over, random, table, members, seed)
    threads = processors() if jobs is None else jobs
    return run_each(
        (system,), lambda one: sweep_system(one, request, draws, threads), as_json=request.as_json
    )


def processors() -> int:
    """How many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def sweep_system(system: str, request: Request, draws: Draws, threads: int) -> int:
    """Read, derive, compile, integrate and write an ensemble; returns the exit status."""
    began = time.process_time()
    watch = Stopwatch(Waiting(stem(system), quiet=request.quiet))
    with watch.stage("import"):
        if format_of(request.output) != HDF5:
            raise UsageError("a sweep is written as HDF5: give --output a name that ends in .h5")
        if request.output == STANDARD_OUTPUT:
            raise UsageError("a sweep cannot be written to standard output: give --output a name")
    ensemble = read_ensemble(system, request, draws, watch)
    with watch.stage("import"):
        name = output_name(system, request.output, "_sweep")
        target = find_output(system, name, request, {"command": "'lagrange sweep'", **draws.options_given()})
    with target.claimed():
        with watch.stage("import"):
            start = take_up(target, made_by(ensemble), request)
        if start.finished is not None:
            return say_finished(start.finished, target.shown, watch, request)
        prepared = prepare_run(
            ensemble.spec,
            ensemble.settings,
            watch,
            cached=request.cache,
            ensemble=True,
            meanwhile=import_the_rest,
        )
        refuse_long_samples(ensemble, prepared)
        outcome = follow_and_write(ensemble, prepared, start, watch, threads=threads, request=request)
    if request.as_json:
        emit_json(as_object(ensemble, start, outcome, watch))
    elif not request.quiet:
        emit(as_text(ensemble, start, outcome, watch))
        if request.timings:
            emit(as_table(watch.report(), began, cached=prepared.cached))
    if outcome.status != "complete":
        way_on = "; --resume continues with the others" if outcome.status == "interrupted" else ""
        complain(f"{ensemble.spec.name}: {sentence(ensemble, outcome)}{way_on}")
    return EXIT_STATUS[outcome.status]


def read_ensemble(system: str, request: Request, draws: Draws, watch: Stopwatch) -> Ensemble:
    """The system, the numbers of its members, and how they are to be run."""
    asked = request.options
    sampled = asked.outputs is not None
    if not sampled and (asked.samples is not None or "step" in request.times):
        raise UsageError(
            "without --outputs only the end of each motion is written: add --outputs q,v to write samples"
        )
    if draws.table == system == STANDARD_INPUT:
        raise UsageError("the system and the table cannot both come from standard input")
    content = read_bytes(system)
    with watch.stage("import"):
        from lagrange_cli.cli.options.members import draw_members
        from lagrange_cli.spec.ensemble import resolve_ensemble
        from lagrange_cli.spec.spec import grouped
    with watch.stage("parse"):
        spec, _ = read_run(content, system, request.sizes, lambda spec, problems: None)
        members = draw_members(spec, draws, request.overrides)
        values = resolve_ensemble(spec, request.overrides, members.columns)
        settings = request.settings(spec, values.common)
        coordinates = [coordinate.name for coordinate in spec.coordinates]
        families = grouped(coordinates, spec.families.get("coordinates", {}))
        return Ensemble(spec, draws, members, values, settings, sampled, families)


def import_the_rest() -> None:
    """Load what the run needs from here on."""
    import lagrange_cli.integrate.ensemble.datasets
    import lagrange_cli.integrate.ensemble.lanes
    import lagrange_cli.store.ensemble  # noqa: F401


def refuse_long_samples(ensemble: Ensemble, prepared: Prepared) -> None:
    """The samples of one member must fit into memory, and many times so."""
    program, count = prepared.machine.program, ensemble.settings.count
    most = LARGEST // (8 * (program.rows + len(program.observed)))
    if ensemble.sampled and count > most:
        raise UsageError(
            f"{count} samples per member exceed the limit of {most}, as they are kept in memory: "
            "use fewer --samples, or solve the members one by one"
        )


def follow_and_write(
    ensemble: Ensemble,
    prepared: Prepared,
    start: Start,
    watch: Stopwatch,
    *,
    threads: int,
    request: Request,
) -> EnsembleOutcome:
    """Follow all members into the output file, whatever way they end."""
    from lagrange_cli.integrate.checkpoint import Checkpointing, Schedule
    from lagrange_cli.integrate.ending import Ending
    from lagrange_cli.integrate.ensemble.datasets import follow_ensemble
    from lagrange_cli.integrate.ensemble.outcome import UNFINISHED, EnsembleOutcome
    from lagrange_cli.integrate.methods.selection import ensemble_method
    from lagrange_cli.store.ensemble import EnsembleWriter
    from lagrange_cli.store.layout import Layout

    times, sampled, members = times_of(ensemble), ensemble.sampled, ensemble.values.members
    progress = Counter(ensemble.spec.name, members, "members", quiet=request.quiet)
    with Interrupts() as interrupted:
        with watch.stage("write"):
            units = units_of(ensemble.spec)
            writer = EnsembleWriter(
                start.target,
                Layout(series(ensemble, prepared, units), time_unit=units.get("t", "")),
                members=members,
                times=times.chunk(0, times.count) if sampled else None,
                dimensions=dimensions(ensemble, units),
            )

        def write(index: np.ndarray, values: dict[str, Any]) -> None:
            with watch.stage("write"):
                writer.write(index, values)

        def alone() -> Method:
            single = prepare_run(
                ensemble.spec, ensemble.settings, Stopwatch(), cached=request.cache, meanwhile=int
            )
            return single.follower

        def report(done: int) -> bool:
            progress.show(done)
            return interrupted()

        def checkpoint(outcome: EnsembleOutcome, *, inside: bool = False) -> Checkpoint:
            ended = outcome.endings != UNFINISHED
            content = {"outcome": outcome.as_data(), "regions": writer.regions(ended)}
            reached = members - outcome.count("interrupted")
            return start.checkpoint(
                {"reached": reached, **content}, {"endings": outcome.endings}, inside=inside
            )

        def keep(outcome: EnsembleOutcome) -> None:
            with watch.stage("write"):
                writer.keep(checkpoint(outcome))

        def restored(earlier: Earlier) -> EnsembleOutcome:
            head, endings = earlier.checkpoint.head, earlier.checkpoint.arrays.get("endings")
            try:
                begin = EnsembleOutcome.from_data(head.get("outcome"), endings, members)
            except ValueError as error:
                raise damaged(earlier.shown) from error
            writer.restore(earlier, begin.endings != UNFINISHED)
            return begin

        with writer:
            begin = None
            if start.earlier is not None:
                from lagrange_cli.store.checkpoint import damaged

                with watch.stage("write"):
                    begin = restored(start.earlier)
            clock = Schedule(request.checkpoint, request.checkpoint_count, start.reached or 0)
            with watch.stage("integrate"):
                outcome = follow_ensemble(
                    prepared,
                    ensemble_method(prepared, alone),
                    ensemble.values,
                    ensemble.families,
                    times,
                    write,
                    report,
                    sampled=sampled,
                    threads=threads,
                    checkpointing=Checkpointing(begin, clock, keep),
                )
            progress.clear()
            with watch.stage("write"):
                last = checkpoint(outcome, inside=True) if outcome.status == "interrupted" else None
                sentences = [ending.value for ending in Ending]
                writer.write_texts("message", "how the member ended", sentences, outcome.endings)
                writer.close({**start.made_by, **attributes(ensemble, outcome)}, last)
    return outcome


def times_of(ensemble: Ensemble) -> Times:
    """When members are sampled: as ``solve`` does, or only at start and end."""
    from lagrange_cli.integrate.times import Times

    settings = ensemble.settings
    if ensemble.sampled:
        return Times(settings.start, settings.stop, settings.count, settings.step)
    return Times(settings.start, settings.stop, 2, settings.stop - settings.start)
