"""``lagrange section``: where motions cross a surface, written to one HDF5 file, or as a table."""

from __future__ import annotations

import time
from functools import partial
from typing import TYPE_CHECKING

import click

from lagrange_cli.cli.console import complain, display_name, run_each, stem
from lagrange_cli.cli.options.completion import expression
from lagrange_cli.cli.options.draws import draw_options
from lagrange_cli.cli.options.run import format_option, list_of_outputs, precision_option, run_options
from lagrange_cli.cli.options.shared import Integer, system_argument
from lagrange_cli.cli.output import Invocation, find_output, output_name, standard_output, with_format
from lagrange_cli.cli.progress import Counter, Waiting
from lagrange_cli.cli.source import read_bytes
from lagrange_cli.errors import UsageError
from lagrange_cli.integrate.processors import processors
from lagrange_cli.records import replace
from lagrange_cli.run.interrupts import Interrupts
from lagrange_cli.run.monitor import Monitor, Stage, ignore
from lagrange_cli.run.request import CSV
from lagrange_cli.run.timings import Stopwatch

if TYPE_CHECKING:
    from lagrange_cli.run.ensembles.draws import Draws
    from lagrange_cli.run.ensembles.ensemble import Ensemble
    from lagrange_cli.run.sections.request import SectionRequest

CROSSINGS = 1000
DIRECTIONS = "rising", "falling", "either"


@click.command("section")
@system_argument
@click.option(
    "--where",
    metavar="EXPRESSION",
    shell_complete=expression("coordinates", "parameters"),
    help="The surface: where this expression in coordinates, velocities (theta_dot), t and parameters is 0.",
)
@click.option(
    "--every",
    metavar="PERIOD",
    shell_complete=expression("parameters"),
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
    type=Integer(min=1),
    default=CROSSINGS,
    help=f"The number of crossings of each motion [{CROSSINGS}].",
)
@draw_options
@click.option(
    "--stop",
    metavar="TIME",
    shell_complete=expression("parameters"),
    help="The time at which a motion ends, however few crossings it has: a number, or an expression in "
    "parameters. If it is before the start, the motion is followed backward [none].",
)
@precision_option
@format_option
@run_options(
    output="The file to write [SYSTEM_section.h5 in the current directory]; - is standard output, with "
    "--format csv.",
    outputs=f"What to write at each crossing, as {list_of_outputs()}.",
    without=("stop", "samples", "step", "proven"),
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
    precision: str,
    asked_format: str | None,
) -> int:
    """Find where motions of a system cross a surface, and write these states to one HDF5 file, or to a table
    as CSV if there is one motion.

    Without further options there is one motion, that of the file. Many motions may differ in parameters or
    initial values, as for 'lagrange sweep'. Each crossing is found to the precision of the motion, and none
    is missed by the default method, taylor.

    \b
    lagrange section henon_heiles.yaml --where x --crossings 10000
    lagrange section henon_heiles.yaml --where x --over y0=-0.2:0.4:31 -o many.h5
    lagrange section driven_damped_pendulum.yaml --every 2*pi/Omega --over A=1:1.5:500
    """
    from lagrange_cli.run.sections.request import SectionRequest

    where, every = (text if text and text.strip() else None for text in (where, every))
    if (where is None) == (every is None):
        raise UsageError("give either --where EXPRESSION, as in --where x, or --every PERIOD")
    if every is not None and direction is not None:
        raise UsageError("--direction belongs to --where: leave it out with --every")
    cut = SectionRequest(where or "", every or "", direction or DIRECTIONS[0], crossings)
    asked = with_format(asked, asked_format)
    asked = replace(asked, request=replace(asked.request, precision=precision))
    if asked.request.format == CSV and draws.any:
        raise UsageError(
            "sections of many motions are written as HDF5: give --output a name that ends in .h5"
        )
    threads = processors() if jobs is None else jobs
    return run_each((system,), lambda one: take(one, asked, cut, draws, threads), as_json=asked.as_json)


def take(system: str, asked: Invocation, cut: SectionRequest, draws: Draws, threads: int) -> int:
    """Read, derive, compile, follow and write; returns the exit status."""
    began = time.process_time()
    watch = Stopwatch(Waiting(stem(system), quiet=asked.quiet).stage)
    ensemble = read_section(system, asked, cut, draws, watch.stage)
    with watch.stage("import"):
        from lagrange_cli.cli.report.motion import say_finished
        from lagrange_cli.cli.report.section import say_crossed
        from lagrange_cli.run.sections.section import take_section

        given = {"command": "'lagrange section'", **draws.options_given(), **given_of(cut)}
        name = output_name(system, asked.output, "_section", asked.request.format)
        target = find_output(system, name, asked, given, draws.table)
    progress = partial(Counter, ensemble.spec.name, ensemble.values.members, "motions", quiet=asked.quiet)
    tell = ignore if asked.quiet else complain
    monitor = Monitor(watch.stage, progress, tell, Interrupts, tell)
    stream = standard_output() if asked.streams else None
    crossed = take_section(ensemble, target, asked.request, monitor, threads=threads, stream=stream)
    if crossed.start.finished is not None:
        return say_finished(crossed.start.finished, target.shown, watch.report(), asked)
    return say_crossed(crossed, watch.report(), began, asked)


def given_of(cut: SectionRequest) -> dict[str, str]:
    """The options as they were given, by what they set."""
    shown = {"where": cut.where, "every": cut.every, "crossings": cut.crossings, "direction": cut.direction}
    return {name: f"--{name} {value}" for name, value in shown.items() if value}


def read_section(system: str, asked: Invocation, cut: SectionRequest, draws: Draws, stage: Stage) -> Ensemble:
    """The system, the numbers of its motions, and how they are to be cut."""
    draws.check_input(system)
    request, content = asked.request, read_bytes(system)
    with stage("import"):
        from lagrange_cli.run.derive import read_run
        from lagrange_cli.run.ensembles.draws import draw_members
        from lagrange_cli.run.sections.request import make_section
    with stage("parse"):
        spec, _ = read_run(content, display_name(system), request.sizes, lambda spec, problems: None)
        members = draw_members(spec, draws, request.overrides) if draws.any else None
        return make_section(spec, members, request, cut)
