"""``lagrange section``: where motions cross a surface, written to one HDF5 file."""

from __future__ import annotations

import time
from functools import partial
from typing import TYPE_CHECKING

import click

from lagrange_cli.cli.commands.sweep import processors
from lagrange_cli.cli.console import STANDARD_INPUT, complain, display_name, run_each, stem
from lagrange_cli.cli.options.draws import draw_options
from lagrange_cli.cli.options.run import list_of_outputs, run_options
from lagrange_cli.cli.options.shared import system_argument
from lagrange_cli.cli.output import Invocation, find_output, format_of, output_name
from lagrange_cli.cli.progress import Counter, Waiting
from lagrange_cli.cli.source import read_bytes
from lagrange_cli.errors import UsageError
from lagrange_cli.run.interrupts import Interrupts
from lagrange_cli.run.monitor import Monitor, Stage, ignore
from lagrange_cli.run.request import HDF5
from lagrange_cli.run.timings import Stopwatch

if TYPE_CHECKING:
    from lagrange_cli.cli.options.members import Draws
    from lagrange_cli.run.ensemble import Ensemble
    from lagrange_cli.run.section import Asked

CROSSINGS = 1000
DIRECTIONS = "rising", "falling", "either"


@click.command("section")
@system_argument
@click.option(
    "--where",
    metavar="EXPRESSION",
    help="The surface: where this expression in coordinates, velocities (theta_dot), t and parameters is 0.",
)
@click.option(
    "--every",
    metavar="PERIOD",
    help="A stroboscopic section in place of --where: the states at multiples of this time after the start, "
    "a number or an expression in parameters (2*pi/omega).",
)
@click.option(
    "--direction",
    type=click.Choice(DIRECTIONS),
    help="Which crossings count: those where the expression rises through 0, falls through it, or either "
    "[rising].",
)
@click.option(
    "--crossings",
    type=click.IntRange(min=1),
    default=CROSSINGS,
    help=f"The number of crossings of each motion [{CROSSINGS}].",
)
@draw_options
@click.option(
    "--stop",
    metavar="TIME",
    help="The time at which a motion ends, however few crossings it has: a number, or an expression in "
    "parameters. If it is before the start, the motion is followed backward [none].",
)
@run_options(
    output="The file to write [SYSTEM_section.h5 in the current directory].",
    outputs=f"What to write at each crossing, as {list_of_outputs()}.",
    without=("stop", "samples", "step", "method", "proven", "resume", "checkpoint", "checkpoint-count"),
)
def section(
    system: str,
    asked: Invocation,
    where: str | None,
    every: str | None,
    direction: str | None,
    crossings: int,
    draws: Draws,
    jobs: int | None,
) -> int:
    """Find where motions of a system cross a surface, and write these states to one HDF5 file.

    The motion is that of the file, or there are many, which differ in parameters or initial values as those
    of 'lagrange sweep' do. No crossing is missed, and each is found to the precision of the motion.

    \b
    lagrange section henon_heiles.yaml --where x --crossings 10000
    lagrange section henon_heiles.yaml --where x --over y0=-0.2:0.4:31
    lagrange section driven_damped_pendulum.yaml --every 2*pi/Omega --over A=1:1.5:500
    """
    from lagrange_cli.run.section import Asked

    if (where is None) == (every is None):
        raise UsageError("give one of --where EXPRESSION, as in --where x, and --every PERIOD")
    if every is not None and direction is not None:
        raise UsageError("--direction belongs to --where: leave it out with --every")
    cut = Asked(where or "", every or "", direction or DIRECTIONS[0], crossings)
    threads = processors() if jobs is None else jobs
    return run_each((system,), lambda one: take(one, asked, cut, draws, threads), as_json=asked.as_json)


def take(system: str, asked: Invocation, cut: Asked, draws: Draws, threads: int) -> int:
    """Read, derive, compile, follow and write; returns the exit status."""
    began = time.process_time()
    watch = Stopwatch(Waiting(stem(system), quiet=asked.quiet).stage)
    with watch.stage("import"):
        if format_of(asked.output) != HDF5:
            raise UsageError("a section is written as HDF5: give --output a name that ends in .h5")
        if asked.streams:
            raise UsageError("a section cannot be written to standard output: give --output a name")
    ensemble = read_section(system, asked, cut, draws, watch.stage)
    with watch.stage("import"):
        from lagrange_cli.cli.report.section import say_crossed
        from lagrange_cli.run.section import take_section

        given = {"command": "'lagrange section'", **draws.options_given(), **given_of(cut)}
        target = find_output(system, output_name(system, asked.output, "_section"), asked, given)
    progress = partial(Counter, ensemble.spec.name, ensemble.values.members, "motions", quiet=asked.quiet)
    monitor = Monitor(watch.stage, progress, ignore if asked.quiet else complain, Interrupts)
    crossed = take_section(ensemble, target, asked.request, monitor, threads=threads)
    return say_crossed(crossed, watch.report(), began, asked)


def given_of(cut: Asked) -> dict[str, str]:
    """The options as they were given, by what they set."""
    shown = {"where": cut.where, "every": cut.every, "crossings": cut.crossings, "direction": cut.direction}
    return {name: f"--{name} {value}" for name, value in shown.items() if value}


def read_section(system: str, asked: Invocation, cut: Asked, draws: Draws, stage: Stage) -> Ensemble:
    """The system, the numbers of its motions, and how they are to be cut."""
    if draws.table == system == STANDARD_INPUT:
        raise UsageError("the system and the table cannot both come from standard input")
    request, content = asked.request, read_bytes(system)
    with stage("import"):
        from lagrange_cli.cli.options.members import draw_members
        from lagrange_cli.run.derive import read_run
        from lagrange_cli.run.section import make_section
    with stage("parse"):
        spec, _ = read_run(content, display_name(system), request.sizes, lambda spec, problems: None)
        members = draw_members(spec, draws, request.overrides) if draws.any else None
        return make_section(spec, members, request, cut)
