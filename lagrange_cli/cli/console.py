"""What a command says: results on standard output, everything else on standard error."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import click

from lagrange_cli.cli.progress import Line
from lagrange_cli.errors import FileError, LagrangeError, MotionError, SpecError, UsageError
from lagrange_cli.run.source import STANDARD_INPUT as STANDARD_INPUT
from lagrange_cli.run.source import count_of as count_of
from lagrange_cli.run.source import display_name as display_name

if TYPE_CHECKING:
    from lagrange_cli.store.target import Target

INTERRUPTED = 130
INTERRUPTION = "Interrupted."
"""What is said where an interrupt cuts a command short."""
UNEXPECTED = 1
MEMORY = KILLED = 4
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""What the system says where nothing more can be written."""
EXIT_STATUS = {"complete": 0, "stopped": 0, "failed": MotionError.exit_code, "interrupted": INTERRUPTED}
"""The exit status for each way a motion can end; what was computed is written in every case."""


def stem(system: str) -> str:
    """``pendulum`` for ``systems/pendulum.yaml``; ``stdin`` for standard input.

    Raises ``UsageError`` for an empty name, such as that of a variable of the shell that is not set.
    """
    if not system:
        raise UsageError("the name of the file is empty")
    return "stdin" if system == STANDARD_INPUT else os.path.splitext(os.path.basename(system))[0]


REPLACED = " (replaced the result of an earlier run of this file)"


def replaced(target: Target) -> str:
    """What the summary says if an earlier output was replaced without ``--force``."""
    return REPLACED if target.replaced else ""


def emit(text: str) -> None:
    """Write text to standard output. A reader that has hung up ends the output, not the work.

    Raises ``FileError`` where standard output cannot be written for another reason (a full disk).
    """
    Line.clear_shown()
    try:
        click.echo(text)
    except BrokenPipeError:
        discard_output()
    except UnicodeEncodeError as error:
        letter = ascii(error.object[error.start])
        raise FileError(
            f"standard output has the encoding {error.encoding}, which lacks {letter}: set PYTHONUTF8=1"
        ) from error
    except OSError as error:
        discard_output()
        raise FileError(f"standard output could not be written: {error.strerror or error}") from error


def colored() -> bool:
    """Whether standard output is a terminal that shows colours, and whose user wants them (no-color.org)."""
    refused = os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb"
    return sys.stdout is not None and sys.stdout.isatty() and not refused


def discard_output() -> None:
    """Send what is still buffered for standard output to nowhere, so that closing it cannot fail."""
    try:
        output = sys.stdout.fileno()
    except (AttributeError, OSError):  # there is none, or it is no file: nothing is left to fail
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, output)
    os.close(nowhere)


def emit_json(content: Mapping[str, Any]) -> None:
    """Write one JSON object on one line; numbers that are not finite become null."""
    import json

    from lagrange_cli.run.attributes import finite

    emit(json.dumps(finite(content), allow_nan=False))


def complain(text: str) -> None:
    """Write a message to standard error; a failure of this is ignored."""
    Line.clear_shown()
    try:
        click.echo(text, err=True)
    except OSError:
        sys.stderr = None


def describe(error: BaseException, system: str = "") -> tuple[str, int]:
    """The message and the exit status for an error; ``system`` names the system if there are several."""
    if isinstance(error, SpecError):
        return str(error), error.exit_code
    where = f"{display_name(system)}: " if system and display_name(system) not in str(error) else ""
    if isinstance(error, LagrangeError):
        return f"Error: {where}{error}", error.exit_code
    if isinstance(error, (KeyboardInterrupt, click.Abort)):
        return INTERRUPTION, INTERRUPTED
    if isinstance(error, MemoryError):
        return f"Error: {where}not enough memory: use smaller sizes or fewer samples", MEMORY
    if isinstance(error, OSError) and error.errno in FULL:
        return f"Error: {where}the output could not be written: {error.strerror}", FileError.exit_code
    if os.environ.get("LAGRANGE_DEBUG") == "1":
        import traceback

        return "".join(traceback.format_exception(error)).rstrip(), UNEXPECTED
    kind = type(error).__name__
    what = " ".join(str(error).split())[:300]
    return (
        f"Error: {where}this is a fault in lagrange itself ({kind}: {what}); please report it "
        "(LAGRANGE_DEBUG=1 shows the traceback)",
        UNEXPECTED,
    )


def run_each(systems: Iterable[str], action: Callable[[str], int], *, as_json: bool) -> int:
    """Run ``action`` on every system, even if others fail, and return the highest status.
    An interrupt ends the whole run."""
    systems = tuple(systems)
    worst = 0
    for system in systems:
        status = run_one(system, action, as_json=as_json, named=len(systems) > 1)
        worst = max(worst, status)
        if status == INTERRUPTED:
            break
    return worst


def run_one(system: str, action: Callable[[str], int], *, as_json: bool, named: bool) -> int:
    """Run ``action`` on a system and return its status.

    A failure is reported on standard error, with the system's name if it is to be ``named``, and with
    ``as_json`` by an object on standard output, so that there is one object per system.
    """
    try:
        return action(system)
    except (KeyboardInterrupt, click.exceptions.Exit, click.ClickException):
        raise
    except Exception as error:
        message, status = describe(error, system if named else "")
        complain(message)
        if as_json:
            text = message.removeprefix("Error: ")
            emit_json({"name": stem(system), "status": "failed", "message": text, "exit_code": status})
        return status
