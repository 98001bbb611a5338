"""``lagrange solve``: integrate the motion and write it to an HDF5 file."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import lagrange_cli
from lagrange_cli.cli.interrupts import Interrupts
from lagrange_cli.cli.options import parse_outputs, refuse, shared_options, systems_argument
from lagrange_cli.cli.progress import Progress
from lagrange_cli.cli.report import (
    INTERRUPTED,
    complain,
    count_of,
    display_name,
    emit,
    emit_json,
    finite,
    run_each,
    stem,
)
from lagrange_cli.cli.settings import DEFAULT_OUTPUTS, DEFAULT_SAMPLES, METHODS, OUTPUTS, resolve_settings
from lagrange_cli.cli.source import derive_system, read_bytes
from lagrange_cli.cli.stopwatch import Stopwatch, as_table
from lagrange_cli.errors import MotionError, UsageError
from lagrange_cli.records import dataclass
from lagrange_cli.spec.spec import SolveDefaults

if TYPE_CHECKING:
    import numpy as np

    from lagrange_cli.cli.settings import Settings
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.integrate.run import Outcome
    from lagrange_cli.spec.spec import Spec
    from lagrange_cli.spec.values import Values
    from lagrange_cli.store.layout import Layout
    from lagrange_cli.store.target import Target

EXIT_STATUS = {"complete": 0, "stopped": 0, "failed": MotionError.exit_code, "interrupted": INTERRUPTED}
"""The exit status for each way a motion can end; what was computed is written in every case."""

MOST_DRIFTS = 8
"""Momenta whose drifts are shown one by one."""


@dataclass(frozen=True)
class Request:
    """What the command line asks of every system."""

    options: SolveDefaults
    overrides: dict[str, str]
    sizes: dict[str, str]
    output: str | None
    force: bool
    cache: bool
    timings: bool
    as_json: bool
    quiet: bool


@click.command("solve")
@systems_argument
@click.option("-o", "--output", metavar="FILE.h5", help="The file to write [SYSTEM.h5, in this directory].")
@click.option("--stop", type=float, help="The time at which the motion ends.")
@click.option(
    "--samples", type=int, help=f"Write so many samples, evenly from start to stop [{DEFAULT_SAMPLES}]."
)
@click.option("--step", type=float, help="Write a sample every STEP instead.")
@click.option(
    "--tolerance", type=float, help="The relative error of a step [full double precision; scipy: 1e-10]."
)
@click.option("--method", metavar="NAME", help=f"One of {', '.join(METHODS)} [{METHODS[0]}].")
@click.option(
    "--outputs",
    metavar="LIST",
    callback=parse_outputs,
    help=f"What to write, as a comma list of {', '.join(OUTPUTS)}, or all [{','.join(DEFAULT_OUTPUTS)}].",
)
@click.option("--force", is_flag=True, help="Replace an existing output; otherwise it is kept and reported.")
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
@click.option("--no-cache", is_flag=True, help="Compile anew, and keep nothing ('lagrange cache --help').")
@click.option("--timings", is_flag=True, help="Say how long each stage took.")
@shared_options
def solve(
    systems: tuple[str, ...],
    output: str | None,
    stop: float | None,
    samples: int | None,
    step: float | None,
    tolerance: float | None,
    method: str | None,
    outputs: tuple[str, ...] | None,
    force: bool,
    no_cache: bool,
    timings: bool,
    overrides: dict[str, str],
    sizes: dict[str, str],
    as_json: bool,
    quiet: bool,
) -> int:
    """Integrate the motion of each system and write it to an HDF5 file.

    SYSTEM.yaml may be - for standard input (written to stdin.h5). Options overrule the file's 'solve'.
    """
    refuse_shared_outputs(systems, output)
    request = Request(
        SolveDefaults(
            stop=stop, samples=samples, step=step, method=method, tolerance=tolerance, outputs=outputs
        ),
        overrides,
        sizes,
        output,
        force,
        not no_cache,
        timings,
        as_json,
        quiet,
    )
    return run_each(systems, lambda system: solve_system(system, request), as_json=as_json)


def refuse_shared_outputs(systems: tuple[str, ...], output: str | None) -> None:
    """No two systems may be written to one file."""
    if output is not None and len(systems) > 1:
        raise UsageError("--output names one file, but there are several systems; leave it out")
    names = [output_name(system, output) for system in systems]
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"two of the systems would be written to {name}: solve them one by one")


def output_name(system: str, output: str | None) -> str:
    """The file a system is written to."""
    return f"{stem(system)}.h5" if output is None else output


def find_output(system: str, request: Request) -> Target:
    """The output, checked before any work is done for it."""
    from lagrange_cli.store.target import find_target

    name = output_name(system, request.output)
    if name == "-":
        raise UsageError("an HDF5 file cannot be written to standard output: give --output a name")
    target = find_target(name, force=request.force)
    if target.path.exists() and Path(system).exists() and target.path.samefile(system):
        raise UsageError(f"{name} is the system file itself: give --output another name")
    return target


def solve_system(system: str, request: Request) -> int:
    """Read, derive, compile, integrate and write one system; returns the exit status."""
    began, watch = time.process_time(), Stopwatch()
    with watch.stage("import"):
        target = find_output(system, request)
    spec, values, settings = read_run(system, request, watch)
    prepared = prepare_run(spec, settings, watch, cached=request.cache)
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


def prepare_run(spec: Spec, settings: Settings, watch: Stopwatch, *, cached: bool) -> Prepared:
    """What the run needs in compiled form, from an earlier run if ``cached`` and there is one."""
    with watch.stage("import"):
        from lagrange_cli.integrate.prepare import prepare_system
        from lagrange_cli.native.cache import find_cache
    return prepare_system(
        spec,
        derive_system,
        find_cache(wanted=cached),
        method=settings.method,
        tolerance=settings.tolerance,
        outputs=settings.outputs,
        stage=watch.stage,
        meanwhile=import_the_rest,
    )


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
    from lagrange_cli.store.writer import Writer

    times = Times(start=settings.start, stop=settings.stop, count=settings.count, step=settings.step)
    progress = Progress(spec.name, settings.start, settings.stop, quiet=quiet)
    with Interrupts() as interrupted:
        with watch.stage("write"):
            writer = Writer(target, layout(spec, prepared), expected=settings.count)

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


def layout(spec: Spec, prepared: Prepared) -> Layout:
    """The datasets of the run, with the units the file gives."""
    from lagrange_cli.expression.vocabulary import family_name
    from lagrange_cli.store.layout import Layout, Series

    units = {f"q/{family_name(each.name)}": each.unit for each in spec.coordinates}
    units |= {f"v/{family_name(each.name)}": f"{each.unit}/s" for each in spec.coordinates if each.unit}
    return Layout(
        tuple(
            Series(
                dataset.path,
                dataset.shape,
                units.get(dataset.path, ""),
                dataset.long_name,
                dataset.axes,
                dataset.components,
            )
            for dataset in prepared.datasets
            if dataset.path != "t"
        )
    )


def attributes(
    spec: Spec, values: Values, settings: Settings, outcome: Outcome
) -> dict[str, str | int | float]:
    """The root's attributes: everything that made the file, and how the run ended."""
    return {
        "generator": f"lagrange-cli {lagrange_cli.__version__}",
        "name": spec.name,
        "spec": spec.text,
        "parameters": json.dumps(dict(values.parameters)),
        **({"sizes": json.dumps(dict(spec.sizes))} if spec.sizes else {}),
        "method": settings.method,
        "tolerance": settings.tolerance,
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


def largest(drifts: dict[str, float]) -> dict[str, float]:
    """The drifts as they are shown: where there are many momenta, only the one that drifted most."""
    momenta = {name: drift for name, drift in drifts.items() if name != "h"}
    if len(momenta) <= MOST_DRIFTS:
        return drifts
    name = max(momenta, key=lambda one: momenta[one])
    kept = {"h": drifts["h"]} if "h" in drifts else {}
    return kept | {f"at most, of {len(momenta)} momenta, {name}": momenta[name]}


def as_text(spec: Spec, settings: Settings, target: Target, outcome: Outcome, watch: Stopwatch) -> str:
    """The run in a few lines."""
    drifts = {} if outcome.h_drift is None else {"h": outcome.h_drift}
    drifts |= {f"p_{coordinate}": drift for coordinate, drift in outcome.p_drift.items()}
    seconds = watch.report()
    return "\n".join(
        (
            f"{spec.name}: {count_of(len(spec.coordinates), 'degree')} of freedom",
            f"  {ended(outcome)}",
            f"  t = {settings.start:g} to {outcome.t:.10g} in {count_of(outcome.steps, 'step')}, "
            f"method {settings.method}",
            "  drift: "
            + (", ".join(f"{name} {drift:.1e}" for name, drift in largest(drifts).items()) or "none checked"),
            f"  wrote {target.shown} in {seconds['total']:.3f} s",
        )
    )
