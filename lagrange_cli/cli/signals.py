"""Signals that ask the process to end."""

from __future__ import annotations

import atexit
import os
import signal
from contextlib import suppress
from types import FrameType

from lagrange_cli.cli.console import INTERRUPTED, INTERRUPTION
from lagrange_cli.cli.progress import eraser
from lagrange_cli.errors import UsageError
from lagrange_cli.limits import time_over
from lagrange_cli.run.interrupts import ENDING, ignored


def heed_endings() -> None:
    """From now on, end the process at once where Ctrl-C, or what else asks it to end, comes."""
    for number in (signal.SIGINT, *ENDING):
        if not ignored(number):
            signal.signal(number, leave)


def leave(number: int, frame: FrameType | None) -> None:
    """End the process. (An exception would be lost where it falls into code that is called back.)"""
    with suppress(OSError, UsageError):
        os.write(2, eraser() + f"{INTERRUPTION}\n".encode())
        if reason := time_over():
            os.write(2, f"{reason}\n".encode())
    atexit._run_exitfuncs()
    os._exit(INTERRUPTED)
