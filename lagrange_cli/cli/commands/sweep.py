"""``lagrange sweep``: integrate an ensemble of motions and write it to one HDF5 file."""

from __future__ import annotations

import time
from functools import partial
from typing import TYPE_CHECKING

import click

from lagrange_cli.cli.console import complain, display_name, run_each, stem
from lagrange_cli.cli.options.draws import draw_options
from lagrange_cli.cli.options.run import list_of_outputs, run_options
from lagrange_cli.cli.options.shared import system_argument
from lagrange_cli.cli.output import Invocation, find_output, output_name, refuse_tables
from lagrange_cli.cli.progress import Counter, Waiting
from lagrange_cli.cli.source import read_bytes
from lagrange_cli.errors import UsageError
from lagrange_cli.integrate.processors import processors
from lagrange_cli.run.interrupts import Interrupts
from lagrange_cli.run.monitor import Monitor, Stage, ignore
from lagrange_cli.run.timings import Stopwatch

if TYPE_CHECKING:
    from lagrange_cli.run.ensembles.draws import Draws
    from lagrange_cli.run.ensembles.ensemble import Ensemble


@click.command("sweep")
@system_argument
@draw_options
@run_options(
    output="The file to write [SYSTEM_sweep.h5 in the current directory].",
    outputs=f"Write samples of each motion: {list_of_outputs()}. Without this option only final states "
    "are written.",
)
def sweep(system: str, asked: Invocation, draws: Draws, jobs: int | None) -> int:
    """Integrate many motions of a system and write them to one HDF5 file.

    The motions, or members, differ in parameters or initial values: on a grid (--over), by random numbers
    (--random), or row by row of a table (--table). Each swept name is a dimension of the output.

    \b
    lagrange sweep pendulum.yaml --over theta=0:3:31
    lagrange sweep pendulum.yaml --over l=log:0.1:10:5 --over m=1,2 -o grid.h5
    lagrange sweep pendulum.yaml --random 'theta=normal(0,0.1)' --members 1000 -o random.h5
    lagrange sweep pendulum.yaml --table runs.csv --outputs q,v --samples 101 -o runs.h5
    """
    threads = processors() if jobs is None else jobs
    return run_each((system,), lambda one: sweep_system(one, asked, draws, threads), as_json=asked.as_json)


def sweep_system(system: str, asked: Invocation, draws: Draws, threads: int) -> int:
    """Read, derive, compile, integrate and write an ensemble; returns the exit status."""
    began = time.process_time()
    watch = Stopwatch(Waiting(stem(system), quiet=asked.quiet).stage)
    with watch.stage("import"):
        refuse_tables(asked, "sweep")
    ensemble = read_ensemble(system, asked, draws, watch.stage)
    with watch.stage("import"):
        from lagrange_cli.cli.report.ensemble import say_swept
        from lagrange_cli.cli.report.motion import say_finished
        from lagrange_cli.run.ensembles.sweep import sweep as sweep_ensemble

        name = output_name(system, asked.output, "_sweep")
        given = {"command": "'lagrange sweep'", **draws.options_given()}
        target = find_output(system, name, asked, given, draws.table)
    progress = partial(Counter, ensemble.spec.name, ensemble.values.members, "members", quiet=asked.quiet)
    tell = ignore if asked.quiet else complain
    monitor = Monitor(watch.stage, progress, tell, Interrupts, tell)
    swept = sweep_ensemble(ensemble, target, asked.request, monitor, threads=threads)
    if swept.start.finished is not None:
        return say_finished(swept.start.finished, target.shown, watch.report(), asked)
    assert swept.outcome is not None
    return say_swept(swept, swept.outcome, watch.report(), began, asked)


def read_ensemble(system: str, asked: Invocation, draws: Draws, stage: Stage) -> Ensemble:
    """The system, the numbers of its members, and how they are to be run."""
    request = asked.request
    if request.options.outputs is None and (request.options.samples is not None or "step" in request.times):
        raise UsageError(
            "without --outputs only the end of each motion is written: add --outputs q,v to write samples"
        )
    draws.check_input(system)
    content = read_bytes(system)
    with stage("import"):
        from lagrange_cli.run.derive import read_run
        from lagrange_cli.run.ensembles.draws import draw_members
        from lagrange_cli.run.ensembles.ensemble import make_ensemble
    with stage("parse"):
        spec, _ = read_run(content, display_name(system), request.sizes, lambda spec, problems: None)
        return make_ensemble(spec, draw_members(spec, draws, request.overrides), request)
