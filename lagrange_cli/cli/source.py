"""System files, as they are named on the command line."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from lagrange_cli.cli.console import STANDARD_INPUT, display_name
from lagrange_cli.errors import FileError
from lagrange_cli.limits import whole
from lagrange_cli.run.source import read_file

if TYPE_CHECKING:
    from lagrange_cli.cli.options.shared import Given
    from lagrange_cli.run.monitor import Stage
    from lagrange_cli.spec.problems import Problems
    from lagrange_cli.spec.spec import Spec

Numbers = TypeVar("Numbers")


def read_system(
    system: str, given: Given, resolve: Callable[[Spec, dict[str, str], Problems], Numbers], stage: Stage
) -> tuple[Spec, Numbers]:
    """The system of a file and the numbers that ``resolve`` finds, with the options that are ``given``.

    Raises ``FileError`` where the file cannot be read, ``SpecError`` where it is wrong, ``UsageError`` where
    an option is.
    """
    from lagrange_cli.run.derive import read_run

    with stage("parse"):
        return read_run(
            read_bytes(system),
            display_name(system),
            given.sizes,
            lambda spec, problems: resolve(spec, given.overrides, problems),
        )


def read_bytes(system: str) -> bytes:
    """The content of the file, or of standard input, up to one byte more than the reader accepts."""
    if system == STANDARD_INPUT:
        if sys.stdin is None or sys.stdin.closed:
            raise FileError("standard input is closed: give the name of a system file")
        return sys.stdin.buffer.read(whole("bytes") + 1)
    return read_file(system)
