"""``lagrange solve``: integrate the motion and write it to an HDF5 file."""

from __future__ import annotations

import json
import time
from typing import TYPE_CHECKING, Any

import click

from lagrange_cli.cli.interrupts import Interrupts
from lagrange_cli.cli.options import refuse, systems_argument
from lagrange_cli.cli.progress import Progress
from lagrange_cli.cli.report import complain, count_of, display_name, emit, emit_json, finite, run_each
from lagrange_cli.cli.runs import (
    EXIT_STATUS,
    Request,
    drifts_shown,
    find_output,
    list_of_outputs,
    origin,
    output_name,
    prepare_run,
    run_options,
    series_of,
)
from lagrange_cli.cli.settings import resolve_settings
from lagrange_cli.cli.source import read_bytes
from lagrange_cli.cli.stopwatch import Stopwatch, as_table
from lagrange_cli.errors import UsageError

if TYPE_CHECKING:
    import numpy as np

    from lagrange_cli.cli.settings import Settings
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.integrate.run import Outcome
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values
    from lagrange_cli.store.target import Target


@click.command("solve")
@systems_argument
@click.option(
    "--resume",
    is_flag=True,
    expose_value=False,
    callback=refuse("interrupted runs cannot be resumed yet; --force starts anew"),
    help="Continue an interrupted run (not available yet).",
)
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    expose_value=False,
    callback=refuse("systems run one after the other for now", unless=1),
    help="Solve so many systems at a time (only 1 for now).",
)
@run_options(
    output="The file to write [SYSTEM.h5, in this directory].",
    outputs=f"What to write, as {list_of_outputs()}.",
)
def solve(systems: tuple[str, ...], request: Request) -> int:
    """Integrate the motion of each system and write it to an HDF5 file.

    SYSTEM.yaml may be - for standard input (written to stdin.h5). Options overrule the file's 'solve'.
    """
    refuse_shared_outputs(systems, request.output)
    return run_each(systems, lambda system: solve_system(system, request), as_json=request.as_json)


def refuse_shared_outputs(systems: tuple[str, ...], output: str | None) -> None:
    """No two systems may be written to one file."""
    if output is not None and len(systems) > 1:
        raise UsageError("--output names one file, but there are several systems; leave it out")
    names = [output_name(system, output) for system in systems]
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"two of the systems would be written to {name}: solve them one by one")


def solve_system(system: str, request: Request) -> int:
    """Read, derive, compile, integrate and write one system; returns the exit status."""
    began, watch = time.process_time(), Stopwatch()
    with watch.stage("import"):
        target = find_output(system, output_name(system, request.output), force=request.force)
    spec, values, settings = read_run(system, request, watch)
    prepared = prepare_run(spec, settings, watch, cached=request.cache, meanwhile=import_the_rest)
    outcome = integrate_and_write(spec, values, settings, prepared, target, watch, quiet=request.quiet)
    status = outcome.ending.status
    if request.as_json:
        emit_json(as_object(spec, settings, target, outcome, watch))
    elif not request.quiet:
        emit(as_text(spec, settings, target, outcome, watch))
        if request.timings:
            emit(as_table(watch.report(), began, cached=prepared.cached))
    if status in ("failed", "interrupted"):
        complain(f"{spec.name}: {outcome.message}")
    return EXIT_STATUS[status]


def read_run(system: str, request: Request, watch: Stopwatch) -> tuple[Spec, Values, Settings]:
    """The system, its numbers as run, and how it is to be run."""
    content = read_bytes(system)
    with watch.stage("import"):
        from lagrange_cli.spec.read import read_spec
        from lagrange_cli.spec.values import resolve_values
    with watch.stage("parse"):
        spec = read_spec(content, display_name(system), request.sizes)
        return spec, resolve_values(spec, request.overrides), resolve_settings(spec, request.options)


def import_the_rest() -> None:
    """Load what the run needs from here on; numpy and h5py are the most of it."""
    import lagrange_cli.integrate.run
    import lagrange_cli.integrate.taylor
    import lagrange_cli.store.writer  # noqa: F401


def integrate_and_write(
    spec: Spec,
    values: Values,
    settings: Settings,
    prepared: Prepared,
    target: Target,
    watch: Stopwatch,
    *,
    quiet: bool,
) -> Outcome:
    """Integrate chunk by chunk into the output file, whatever way the motion ends."""
    from lagrange_cli.integrate.run import Times, integrate
    from lagrange_cli.store.layout import Layout
    from lagrange_cli.store.writer import Writer

    times = Times(start=settings.start, stop=settings.stop, count=settings.count, step=settings.step)
    progress = Progress(spec.name, settings.start, settings.stop, quiet=quiet)
    with Interrupts() as interrupted:
        with watch.stage("write"):
            writer = Writer(target, Layout(series_of(spec, prepared)), expected=settings.count)

        def emit_chunk(chunk: dict[str, np.ndarray]) -> None:
            with watch.stage("write"):
                writer.append(chunk)

        with writer:
            with watch.stage("integrate"):
                outcome = integrate(prepared, values, times, emit_chunk, interrupted, progress.show)
            progress.clear()
            with watch.stage("write"):
                writer.close(attributes(spec, values, settings, outcome))
    return outcome


def attributes(
    spec: Spec, values: Values, settings: Settings, outcome: Outcome
) -> dict[str, str | int | float]:
    """The root's attributes: everything that made the file, and how the run ended."""
    return {
        **origin(spec, settings, dict(values.parameters)),
        "steps": outcome.steps,
        "status": outcome.ending.status,
        "message": outcome.message,
        "h_drift": float("nan") if outcome.h_drift is None else outcome.h_drift,
        "p_drift": json.dumps(finite(outcome.p_drift)),
    }


def as_object(
    spec: Spec, settings: Settings, target: Target, outcome: Outcome, watch: Stopwatch
) -> dict[str, Any]:
    """The run for ``--json``."""
    return {
        "name": spec.name,
        "output": target.shown,
        "status": outcome.ending.status,
        "message": outcome.message,
        "method": settings.method,
        "tolerance": settings.tolerance,
        "steps": outcome.steps,
        "evaluations": outcome.evaluations,
        "t": outcome.t,
        "h_drift": outcome.h_drift,
        "p_drift": dict(outcome.p_drift),
        "seconds": watch.report(),
    }


def ended(outcome: Outcome) -> str:
    """How the motion ended; why, if it did not reach the end, is said on standard error."""
    status: str = outcome.ending.status
    return outcome.message if status == "complete" else f"{status}; what was computed until then is written"


def as_text(spec: Spec, settings: Settings, target: Target, outcome: Outcome, watch: Stopwatch) -> str:
    """The run in a few lines."""
    seconds = watch.report()
    return "\n".join(
        (
            f"{spec.name}: {count_of(len(spec.coordinates), 'degree')} of freedom",
            f"  {ended(outcome)}",
            f"  t = {settings.start:g} to {outcome.t:.10g} in {count_of(outcome.steps, 'step')}, "
            f"method {settings.method}",
            f"  {drifts_shown(outcome.h_drift, outcome.p_drift.items())}",
            f"  wrote {target.shown} in {seconds['total']:.3f} s",
        )
    )
