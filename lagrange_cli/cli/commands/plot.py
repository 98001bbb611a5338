"""``lagrange plot``: pictures of outputs, or of a system's motion."""

from __future__ import annotations

import os
import re
import shutil
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import click

from lagrange_cli.cli.console import (
    colored,
    complain,
    count_of,
    display_name,
    emit,
    emit_json,
    replaced,
    stem,
)
from lagrange_cli.cli.options.certify import certify_options
from lagrange_cli.cli.options.completion import comma_list, files
from lagrange_cli.cli.options.run import OPTIONS
from lagrange_cli.cli.options.shared import Given, Integer, given_options
from lagrange_cli.cli.output import check_apart
from lagrange_cli.cli.progress import Progress, Waiting
from lagrange_cli.cli.source import read_bytes
from lagrange_cli.errors import UsageError
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.run.certify import Demand
    from lagrange_cli.run.monitor import Stage
    from lagrange_cli.run.motion import Motion
    from lagrange_cli.run.plot import PlotRequest
    from lagrange_cli.run.request import Request
    from lagrange_cli.store.notes import Origin
    from lagrange_cli.store.result import Result

    Shown: TypeAlias = tuple[Motion, Request]
    ReadMotion: TypeAlias = Callable[[bytes, str, Given, Mapping[str, Any], Stage], Shown]

WHAT = (
    "q", "v", "p", "phase", "path", "positions", "drift", "energy", "action", "ledger", "error", "spectrum",
    "observables", "reactions", "multipliers", "constraints", "conserved", "final",
)  # fmt: skip
OUTPUTS = (".h5", ".hdf5")
TERMINAL = 100
"""Columns of a plot on a terminal of unknown width."""


def parse_names(context: click.Context, parameter: click.Parameter, text: str | None) -> tuple[str, ...]:
    """``"q, drift"`` as a tuple of names."""
    parts = re.split(r",(?![^\[]*\])", text or "")  # not within the indices of a member
    return tuple(part.strip() for part in parts if part.strip())


def parse_size(
    context: click.Context, parameter: click.Parameter, text: str | None
) -> tuple[float, float] | None:
    """``"7x5"`` as width and height in inches."""
    if text is None:
        return None
    parts = text.lower().replace(",", "x").split("x")
    try:
        width, height = map(float, parts)
    except ValueError:
        width = height = 0.0
    if not (1 <= width <= 100 and 1 <= height <= 100):
        raise click.BadParameter(f"{text!r} is not a size in inches from 1x1 to 100x100, as in --inches 7x5")
    return width, height


MEMBER = click.option(
    "--member", type=Integer(min=0), metavar="N",
    help="The number of a member, from 0, if the file is the output of a sweep. Its motion is computed "
    "again.",
)  # fmt: skip


@click.command("plot")
@click.argument(
    "sources",
    metavar="RUN.h5|SYSTEM.yaml...",
    nargs=-1,
    required=True,
    shell_complete=files("h5", "yaml", "yml"),
)
@click.option(
    "--what",
    metavar="LIST",
    callback=parse_names,
    shell_complete=comma_list(WHAT),
    help=f"What to draw: a comma-separated list of {', '.join(WHAT)} "
    "[motions: q,phase,path,drift; sweeps: q,final,drift; sections: phase].",
)
@click.option("--x", metavar="NAME", help="The quantity along x, with --y [t].")
@click.option(
    "--y", metavar="LIST", callback=parse_names,
    help="Quantities to draw, each in a panel: theta, theta_dot, p_theta, bob.x, h, an observable, or the "
    "path of a dataset.",
)  # fmt: skip
@click.option(
    "-o", "--output", metavar="FILE.png", shell_complete=files("png", "svg", "pdf"),
    help="The picture to write, as .png, .svg or .pdf [RUN.png in the current directory].",
)  # fmt: skip
@click.option("--inches", metavar="WxH", callback=parse_size, help="The size of the picture in inches.")
@click.option("--terminal", is_flag=True, help="Draw on the terminal, with characters; no file is written.")
@MEMBER
@OPTIONS["start"]
@OPTIONS["stop"]
@OPTIONS["samples"]
@OPTIONS["step"]
@OPTIONS["tolerance"]
@OPTIONS["method"]
@OPTIONS["project-initial"]
@OPTIONS["force"]
@OPTIONS["no-cache"]
@given_options
@certify_options
def plot(
    sources: tuple[str, ...], what: tuple[str, ...], x: str | None, y: tuple[str, ...], output: str | None,
    inches: tuple[float, float] | None, terminal: bool, force: bool, given: Given, demand: Demand | None,
    **run: Any,
) -> int:  # fmt: skip
    """Draw outputs of solve, sweep and section, or the motion of a system.

    Several outputs of one kind are drawn over each other. The motion of a system file is computed first, with
    the outputs that the plot needs; options such as --set and --stop apply to it. Curves are pale where an
    estimate of the error (--certify) says that six digits can no longer be trusted.

    \b
    lagrange plot double_pendulum.yaml
    lagrange plot run.h5 --what phase,energy -o run.pdf
    lagrange plot run.h5 --x theta --y theta_dot,h
    """
    began = time.monotonic()
    if terminal and output is not None:
        raise UsageError("--terminal writes no file: leave out --output")
    if what and (x or y):
        raise UsageError("--what and --y both say what to draw: give one of them")
    from lagrange_cli.figures.style import check_matplotlib
    from lagrange_cli.figures.terminal import check_plotext
    from lagrange_cli.run.plot import PlotRequest, check_format, page_of

    check_plotext("--terminal") if terminal else check_matplotlib("lagrange plot")
    name = output or f"{stem(sources[0])}.png"
    if output is None and name in sources:
        raise UsageError(f"{name} is a picture: plot draws outputs of solve, sweep and section, and systems")
    suffix = "" if terminal else check_format(name)
    asked = PlotRequest(what, x, y)
    target = None if terminal else target_of(name, sources, began, "lagrange plot", force=force)
    with ExitStack() as stack:
        results = [
            stack.enter_context(opened(one, given, demand, run, read_for(asked), "drawn")) for one in sources
        ]
        waiting = Waiting(stem(sources[0]), quiet=given.quiet)
        with waiting.stage("draw"):
            page = page_of(results, asked)
            if target is None:
                from lagrange_cli.figures.terminal import as_text

                width = shutil.get_terminal_size((TERMINAL, 24)).columns
                emit(as_text(page, width, colored=colored()))
            else:
                from lagrange_cli.figures.draw import draw
                from lagrange_cli.run.plot import write

                write(draw(page, suffix, "lagrange-cli", inches), target)
    if target is not None:
        titles = [panel.title or panel.y for panel in page.panels]
        if given.as_json:
            told = {"name": page.title, "output": target.shown, "replaced": target.replaced}
            emit_json({**told, "panels": titles})
        elif not given.quiet:
            panels = count_of(len(titles), "panel")
            emit(f"{page.title}: wrote {target.shown} ({panels}){replaced(target)}")
    return 0


def target_of(name: str, sources: tuple[str, ...], began: float, command: str, *, force: bool) -> Any:
    """The picture's file, checked before any work is done."""
    from lagrange_cli.store.find_target import find_target

    check_apart(name, *sources)
    return find_target(name, force=force, origin=origin_of(sources, began, command))


def origin_of(sources: tuple[str, ...], began: float, command: str) -> Origin | None:
    """What makes the pictures of ``sources``, by which a later call knows its own earlier work."""
    if sources[0] == "-":
        return None
    from lagrange_cli.store.notes import Origin

    return Origin(os.path.realpath(sources[0]), {"command": f"'{command}'"}, began)


@contextmanager
def opened(
    source: str, given: Given, demand: Demand | None, run: Mapping[str, Any], read: ReadMotion, how: str
) -> Iterator[Result]:
    """The output called ``source``, or that of its motion if it is a system file, which is ``read`` first; if
    that fails, a message says that it is shown up to then, and ``how``."""
    written = Path(source).suffix.lower() in OUTPUTS
    if written:
        refuse_settings(source, given, demand, run)
    if written and run["member"] is None:
        from lagrange_cli.store.result import Result

        with Result(source) as result:
            yield result
        return
    from lagrange_cli.run.attributes import notes
    from lagrange_cli.run.interrupts import Interrupts
    from lagrange_cli.run.monitor import Monitor, ignore
    from lagrange_cli.run.plot import solved

    content, given, run = motion_of(source, given, run)
    waiting = Waiting(stem(source), quiet=given.quiet)
    motion, request = read(content, display_name(source), given, run, waiting.stage)
    tell = ignore if given.quiet else complain
    name, settings = motion.spec.name, motion.settings
    progress = partial(Progress, name, settings.start, settings.stop, quiet=given.quiet)
    monitor = Monitor(waiting.stage, progress, tell, Interrupts, tell)
    with solved(motion, request, demand, monitor) as (result, outcome):
        if outcome.ending.status == "failed":
            tell(f"{name}: {outcome.message}; the motion up to then is {how}")
        for note in notes(motion, outcome):
            tell(note)
        yield result


def request_of(given: Given, run: Mapping[str, Any], **options: Any) -> Request:
    """The request for a motion, with these ``options`` besides tolerance and method."""
    from lagrange_cli.run.request import TIMES, Request
    from lagrange_cli.spec.spec import SolveDefaults

    times = {name: run[name] for name in TIMES if run.get(name) is not None}
    defaults = SolveDefaults(tolerance=run["tolerance"], method=run["method"], **options)
    cache, projected = not run["no_cache"], run["projected"]
    return Request(defaults, times, given.overrides, given.sizes, cache=cache, projected=projected)


def read_for(asked: PlotRequest) -> ReadMotion:
    """What reads a motion for a plot."""

    def read(content: bytes, shown: str, given: Given, run: Mapping[str, Any], stage: Stage) -> Shown:
        from lagrange_cli.run.motion import read_motion
        from lagrange_cli.run.plot import drawn, finely_sampled, outputs_for
        from lagrange_cli.spec.read import read_spec

        spec = read_spec(content, shown, given.sizes)
        outputs = outputs_for(asked, has_particles=not spec.lagrangian)
        request = drawn(request_of(given, run, samples=run["samples"], outputs=outputs), asked)
        motion = read_motion(content, shown, request, stage)
        finer = finely_sampled(motion, request)
        return (motion if finer is request else read_motion(content, shown, finer, stage)), finer

    return read


def motion_of(source: str, given: Given, run: Mapping[str, Any]) -> tuple[bytes, Given, Mapping[str, Any]]:
    """The system file of a motion that is to be computed, and the options for it: they are as given, or
    those of one ``--member`` of a sweep."""
    if run["member"] is None:
        return read_bytes(source), given, run
    if Path(source).suffix.lower() not in OUTPUTS:
        raise UsageError(f"--member is for the output of a sweep, and {source} is a system file")
    from lagrange_cli.run.replay import member_of

    found = member_of(Path(source), run["member"])
    values = replace(given, overrides=dict(found.values), sizes=dict(found.sizes))
    return found.content, values, {**run, **found.times}


def refuse_settings(source: str, given: Given, demand: Demand | None, run: Mapping[str, Any]) -> None:
    """An output is drawn as it is: raise ``UsageError`` for options that would change its motion."""
    given_ones = [
        f"--{name}"
        for name in ("start", "stop", "samples", "step", "tolerance", "method")
        if run.get(name) is not None
    ]
    given_ones += ["--set"] * bool(given.overrides) + ["--size"] * bool(given.sizes)
    given_ones += ["--certify"] * (demand is not None)
    if given_ones:
        raise UsageError(f"{given_ones[0]} is for the motion of a system file, and {source} is an output")
