"""``lagrange animate``: the drawing of a motion as a film."""

from __future__ import annotations

import re
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from lagrange_cli.cli.commands.plot import MEMBER, opened, origin_of, parse_names, request_of, target_of
from lagrange_cli.cli.console import INTERRUPTED, emit, emit_json, replaced, stem
from lagrange_cli.cli.options.completion import comma_list, files, names
from lagrange_cli.cli.options.run import OPTIONS
from lagrange_cli.cli.options.shared import Given, Number, given_with, parse_overrides
from lagrange_cli.cli.progress import Counter, Waiting
from lagrange_cli.run.film_bounds import FASTEST, LEAST, MOST, SLOWEST

if TYPE_CHECKING:
    from lagrange_cli.cli.commands.plot import ReadMotion, Shown
    from lagrange_cli.run.monitor import Stage
    from lagrange_cli.run.reel import FilmRequest

PANELS = (
    "q", "v", "p", "phase", "energy", "drift", "action", "ledger", "observables", "reactions", "multipliers",
    "conserved",
)  # fmt: skip
PIXELS = re.compile(r"(\d+)\s*[xX]\s*(\d+)")


def parse_size(context: click.Context, parameter: click.Parameter, values: tuple[str, ...]) -> dict[str, str]:
    """``("640x480", "N=5")``: the picture's size becomes the parameter ``pixels``, others are returned."""
    context.params["pixels"] = None
    sizes = []
    for value in values:
        found = PIXELS.fullmatch(value.strip())
        if found is None and "=" not in value:
            message = f"{value!r} is neither pixels, as in --size 800x600, nor NAME=VALUE, as in --size N=50"
            raise click.BadParameter(message, context, parameter)
        if found is None:
            sizes.append(value)
            continue
        width, height = map(int, found.groups())
        if not (LEAST <= width <= MOST and LEAST <= height <= MOST):
            raise click.BadParameter(f"{value!r}: both must be from {LEAST} to {MOST}", context, parameter)
        context.params["pixels"] = width + width % 2, height + height % 2  # as films must have it
    return parse_overrides(context, parameter, tuple(sizes))


@click.command("animate")
@click.argument("source", metavar="RUN.h5|SYSTEM.yaml", shell_complete=files("h5", "yaml", "yml"))
@click.option(
    "-o", "--output", metavar="FILE.mp4", shell_complete=files("mp4", "gif", "apng"),
    help="The film to write, as .mp4, .gif or .apng; a name without an ending is that of a folder for single "
    "frames [RUN.mp4 in the current directory].",
)  # fmt: skip
@click.option(
    "--speed", type=Number(min=0, min_open=True),
    help="The time t that passes in a second of the film [1; if the film would be shorter than 0.2 s or "
    "longer than 60 s, a speed at which it lasts about 20 s].",
)  # fmt: skip
@click.option("--fps", type=Number(min=SLOWEST, max=FASTEST), help="Frames per second [30; .gif: 25].")
@click.option("--from", "begin", type=Number(), metavar="TIME", help="The time at which the film begins.")
@click.option("--to", "end", type=Number(), metavar="TIME", help="The time at which it ends.")
@click.option(
    "--trail", type=Number(min=0), metavar="TIME",
    help="The part of the path that is shown, in units of t; 0 for none [2 seconds of the film].",
)  # fmt: skip
@click.option(
    "--panels", metavar="LIST", callback=parse_names, shell_complete=comma_list(PANELS),
    help=f"Panels beside the drawing: a comma-separated list of {', '.join(PANELS)}.",
)  # fmt: skip
@MEMBER
@OPTIONS["start"]
@OPTIONS["stop"]
@OPTIONS["tolerance"]
@OPTIONS["method"]
@OPTIONS["project-initial"]
@OPTIONS["force"]
@OPTIONS["no-cache"]
@given_with(
    click.option(
        "--size",
        "sizes",
        metavar="WxH|NAME=N",
        multiple=True,
        callback=parse_size,
        shell_complete=names("sizes"),
        help="The size of the picture in pixels [800x600; with panels 1200x600], or a size that the file "
        "declares, as in N=50; repeatable.",
    )
)
def animate(
    source: str, output: str | None, speed: float | None, fps: float | None, begin: float | None,
    end: float | None, trail: float | None, panels: tuple[str, ...], pixels: tuple[int, int] | None,
    force: bool, given: Given, **run: Any,
) -> int:  # fmt: skip
    """Make a film of a motion: of an output of solve, or of a system.

    The motion of a system file is computed first; options such as --set and --stop apply to it. The drawing
    is that of 'lagrange view', and the section draw of the file changes it. Ctrl-C ends the film early.

    \b
    lagrange animate double_pendulum.yaml
    lagrange animate run.h5 --from 10 --to 20 --speed 0.5 --panels phase,energy -o run.gif
    """
    began = time.monotonic()
    from lagrange_cli.figures.film import FRAMES, check_film
    from lagrange_cli.run.animate import find_folder, format_of, told, write
    from lagrange_cli.run.interrupts import Interrupts
    from lagrange_cli.run.reel import FPS, USUAL_FPS, FilmRequest, reel_of

    check_film("lagrange animate")
    name = output or f"{stem(source)}.mp4"
    kind = format_of(name)
    asked = FilmRequest(fps or FPS.get(kind, USUAL_FPS), speed, begin, end, trail, panels, pixels)
    if kind == FRAMES:
        target = find_folder(name, force=force, origin=origin_of((source,), began, "lagrange animate"))
    else:
        target = target_of(name, (source,), began, "lagrange animate", force=force)
    with opened(source, given, None, run, read_for(asked), "shown") as result:
        waiting = Waiting(stem(source), quiet=given.quiet)
        with waiting.stage("draw"):
            reel = reel_of(result, asked)
        counter = Counter(reel.name, reel.count, "pictures", quiet=given.quiet)
        with Interrupts() as asking:
            made = write(reel, target, kind, counter, asking)
        ending = result.attributes.get("status")
    if given.as_json:
        report = {"name": reel.name, "output": target.shown, "replaced": target.replaced}
        report |= {"pictures": made.pictures, "of": made.count}
        emit_json({**report, "seconds": made.seconds, "speed": reel.speed, "status": ending})
    elif not given.quiet:
        short = "" if made.whole else f", interrupted after {made.pictures} of {made.count}"
        emit(f"{reel.name}: wrote {target.shown} ({told(reel, made)}){short}{replaced(target)}")
    return 0 if made.whole else INTERRUPTED


def read_for(asked: FilmRequest) -> ReadMotion:
    """What reads a motion for a film."""

    def read(content: bytes, shown: str, given: Given, run: Mapping[str, Any], stage: Stage) -> Shown:
        from lagrange_cli.run.animate import request_for
        from lagrange_cli.run.view.motion import read_shown

        request = request_of(given, run)
        request = request_for(read_shown(content, shown, request, stage), request, asked)
        return read_shown(content, shown, request, stage), request

    return read
