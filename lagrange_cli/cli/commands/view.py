"""``lagrange view``: a web page that draws a system and computes its motion in the browser."""

from __future__ import annotations

import os
import sys
import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from lagrange_cli.cli.commands.plot import MEMBER, OUTPUTS
from lagrange_cli.cli.console import (
    STANDARD_INPUT,
    complain,
    display_name,
    emit,
    emit_json,
    replaced,
    run_each,
    stem,
)
from lagrange_cli.cli.options.completion import SYSTEMS, files
from lagrange_cli.cli.options.run import OPTIONS
from lagrange_cli.cli.options.shared import Given, given_options
from lagrange_cli.cli.output import check_apart
from lagrange_cli.cli.progress import Waiting
from lagrange_cli.cli.source import read_bytes
from lagrange_cli.errors import UsageError
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.run.request import Request
    from lagrange_cli.store.target import Target

STANDARD_OUTPUT = "-"
ENDING = ".html"


@dataclass(frozen=True)
class ViewRequest:
    """What is asked for: a motion, where its page goes, and whether the page is opened."""

    request: Request
    output: str | None
    member: int | None
    force: bool
    opening: bool
    given: Given


@click.command("view")
@click.argument("file", metavar="SYSTEM.yaml|FILE.h5", shell_complete=files(*SYSTEMS, "h5"))
@click.option(
    "-o",
    "--output",
    metavar="FILE.html",
    shell_complete=files("html"),
    help="The page to write [SYSTEM.html in the current directory]; - is standard output.",
)
@MEMBER
@click.option("--open", "opening", is_flag=True, help="Show the page in the browser.")
@OPTIONS["start"]
@OPTIONS["stop"]
@OPTIONS["samples"]
@OPTIONS["project-initial"]
@OPTIONS["force"]
@OPTIONS["no-cache"]
@given_options
def view(
    file: str, output: str | None, member: int | None, opening: bool, force: bool, no_cache: bool,
    given: Given, **times: Any,
) -> int:  # fmt: skip
    """Write a web page that draws a system and computes its motion.

    The page is one file and needs no network. It contains the equations of motion, compiled to WebAssembly.
    When the sliders of parameters and initial values are moved, it computes the motion again, with the same
    steps as 'lagrange solve'.

    \b
    lagrange view double_pendulum.yaml --open
    lagrange view double_pendulum.h5

    For an output of 'lagrange solve', the page replays its motion. For a sweep, it has a slider for the
    members, and computes their motions.
    """
    from lagrange_cli.run.request import TIMES, Request, check_page
    from lagrange_cli.spec.spec import SolveDefaults

    check_page(output or "")
    if output == STANDARD_OUTPUT and given.as_json:
        raise UsageError("--json and the page would both go to standard output: give --output a name")
    if output == STANDARD_OUTPUT and opening:
        raise UsageError("a page on standard output cannot be opened: give --output a name")
    request = Request(
        SolveDefaults(samples=times["samples"]),
        {name: times[name] for name in TIMES if times.get(name) is not None},
        given.overrides,
        given.sizes,
        cache=not no_cache,
        projected=times["projected"],
    )
    asked = ViewRequest(request, output, member, force, opening, given)
    return run_each((file,), partial(view_one, asked=asked), as_json=given.as_json)


def view_one(file: str, asked: ViewRequest) -> int:
    """Write the page of one file; returns the exit status."""
    began = time.monotonic()
    waiting = Waiting(stem(file), quiet=asked.given.quiet)
    content = read_bytes(file)
    with waiting.stage("import"):
        from lagrange_cli.run.view.motion import read_shown
        from lagrange_cli.run.view.page import view, write
    if is_output(content) or Path(file).suffix.lower() in OUTPUTS:
        refuse_changes(asked)
        target = None if asked.output == STANDARD_OUTPUT else target_of(file, asked, began)
        with waiting.stage("import"):
            from lagrange_cli.run.replay import view_output
        name, page = view_output(Path(file), waiting.stage, asked.member)
    elif asked.member is not None:
        raise UsageError(f"--member is for the output of a sweep, and {display_name(file)} is a system file")
    else:
        motion = read_shown(content, display_name(file), asked.request, waiting.stage)
        target = None if asked.output == STANDARD_OUTPUT else target_of(file, asked, began)
        name, page = motion.spec.name, view(motion, waiting.stage)
    if target is None:
        emit(page.text)
        return 0
    size = write(page, target)
    report = {
        "name": name,
        "output": target.shown,
        "replaced": target.replaced,
        "bytes": size,
        "live": page.live,
        "message": page.why,
    }
    if asked.given.as_json:
        emit_json(report)
    elif not asked.given.quiet:
        how = ", computes in the browser" if page.live else f". {page.why.rstrip('.')}"
        emit(f"{name}: {target.shown}, {size / 1000:.0f} kB{how}{replaced(target)}")
    if asked.opening:
        show(target.path)
    return 0


def is_output(content: bytes) -> bool:
    """Whether a file is an HDF5 file, by what it begins with."""
    from lagrange_cli.spec.source import HDF5_SIGNATURE

    return content.startswith(HDF5_SIGNATURE)


def refuse_changes(asked: ViewRequest) -> None:
    """Raise ``UsageError`` for options that would change a motion that has been computed."""
    request = asked.request
    given: dict[str, object] = {
        "--set": request.overrides,
        "--size": request.sizes,
        "--samples": request.options.samples,
    }
    given |= {f"--{name}": text for name, text in request.times.items()}
    given["--project-initial"] = request.projected
    names = [name for name, value in given.items() if value]
    if names:
        raise UsageError(f"{names[0]} belongs to a system file: the motion of an output is as it is")


def target_of(file: str, asked: ViewRequest, began: float) -> Target:
    """The page's file, checked before any work is done."""
    from lagrange_cli.store.find_target import find_target
    from lagrange_cli.store.notes import Origin

    name = stem(file) + ENDING if asked.output is None else asked.output
    check_apart(name, file)
    origin = None
    if file != STANDARD_INPUT:
        origin = Origin(os.path.realpath(file), {"command": "'lagrange view'"}, began, asked.request.cache)
    return find_target(name, force=asked.force, origin=origin, ending=ENDING)


def show(path: Path) -> None:
    """Open a page in the browser, or say where it is."""
    import webbrowser

    headless = (
        sys.platform.startswith("linux") and not {"DISPLAY", "WAYLAND_DISPLAY", "BROWSER"} & os.environ.keys()
    )
    if headless or not webbrowser.open(path.as_uri()):
        complain(f"no browser could be opened: the page is {path}")
