"""``lagrange solve``: integrate the motion and write it to an HDF5 file."""

from __future__ import annotations

import time
from functools import partial
from typing import TYPE_CHECKING

import click

from lagrange_cli.cli.console import complain, discard_output, display_name, run_each, stem
from lagrange_cli.cli.options.certify import certify_options, options_given
from lagrange_cli.cli.options.run import format_option, list_of_outputs, precision_option, run_options
from lagrange_cli.cli.options.shared import Integer, systems_argument
from lagrange_cli.cli.output import Invocation, find_output, output_name, standard_output, with_format
from lagrange_cli.cli.progress import Progress, Waiting
from lagrange_cli.cli.report.motion import say_finished, say_solved
from lagrange_cli.cli.source import read_bytes
from lagrange_cli.errors import UsageError
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.records import replace
from lagrange_cli.run.interrupts import Interrupts
from lagrange_cli.run.monitor import Monitor, ignore
from lagrange_cli.run.timings import Stopwatch

if TYPE_CHECKING:
    from lagrange_cli.run.certify import Demand


@click.command("solve")
@systems_argument
@click.option(
    "--jobs",
    type=Integer(min=1),
    default=1,
    help="The number of systems to solve in parallel, each in its own process [1].",
)
@click.option(
    "--threads",
    type=Integer(min=1),
    help="The number of threads that share the work of one large system [all processors, divided among the "
    "systems that are solved in parallel]. The results do not depend on it.",
)
@precision_option
@click.option(
    "--portable",
    is_flag=True,
    help="Give the same bits on every machine, independent of its processor and C library.",
)
@format_option
@run_options(
    output="The file to write [SYSTEM.h5 in the current directory]; - is standard output, with --format csv.",
    outputs=f"What to write, as {list_of_outputs()}.",
)
@certify_options
def solve(
    systems: tuple[str, ...],
    asked: Invocation,
    jobs: int,
    threads: int | None,
    precision: str,
    portable: bool,
    asked_format: str | None,
    demand: Demand | None,
) -> int:
    """Integrate the motion of each system and write it to an HDF5 file, or to a table as CSV.

    SYSTEM.yaml may be - for standard input (written to stdin.h5). Options override the section 'solve' of the
    file.
    """
    asked = with_format(asked, asked_format)
    together = min(jobs, len(systems))
    if threads is None and together > 1:
        from lagrange_cli.integrate.processors import processors

        threads = max(1, processors() // together)
    request = replace(asked.request, precision=precision, portable=portable, threads=threads)
    asked = replace(asked, request=request)
    refuse_shared_outputs(systems, asked)
    if demand is not None and precision != DOUBLE:
        raise UsageError(f"--certify needs precision {DOUBLE}: leave out one of the two")
    if demand is not None and portable:
        raise UsageError("--certify and --portable cannot be combined: leave out one of the two")
    solve_one = partial(solve_system, asked=asked, demand=demand)
    if together == 1:
        return run_each(systems, solve_one, as_json=asked.as_json)
    from lagrange_cli.cli.jobs import run_side_by_side

    return run_side_by_side(systems, solve_one, jobs, as_json=asked.as_json, quiet=asked.quiet)


def refuse_shared_outputs(systems: tuple[str, ...], asked: Invocation) -> None:
    """No two systems may be written to one file."""
    if asked.output is not None and len(systems) > 1:
        raise UsageError("--output names one file, but there are several systems: leave it out")
    names = [output_name(system, asked.output, format=asked.request.format) for system in systems]
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"two of the systems would be written to {name}: solve them one by one")


def solve_system(system: str, asked: Invocation, demand: Demand | None = None) -> int:
    """Read, derive, compile, integrate and write one system; returns the exit status."""
    began = time.process_time()
    request, watch = asked.request, Stopwatch(Waiting(stem(system), quiet=asked.quiet).stage)
    content = read_bytes(system)
    with watch.stage("import"):
        from lagrange_cli.run.motion import read_motion
        from lagrange_cli.run.solve import solve as solve_motion
    motion = read_motion(content, display_name(system), request, watch.stage)
    with watch.stage("import"):
        name = output_name(system, asked.output, format=request.format)
        target = find_output(system, name, asked, {"command": "'lagrange solve'", **options_given(demand)})
    start, stop = motion.settings.start, motion.settings.stop
    progress = partial(Progress, motion.spec.name, start, stop, quiet=asked.quiet)
    tell = ignore if asked.quiet else complain
    monitor = Monitor(watch.stage, progress, tell, Interrupts, tell)
    stream = standard_output() if asked.streams else None
    solved = solve_motion(motion, target, request, monitor, demand=demand, stream=stream)
    if solved.start.finished is not None:
        return say_finished(solved.start.finished, target.shown, watch.report(), asked)
    if solved.outcome is None:
        discard_output()
        return 0
    return say_solved(solved, solved.outcome, watch.report(), began, asked, demand)
