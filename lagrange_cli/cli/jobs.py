"""Several systems at a time, each in its own process; their output appears in the order of the systems."""

from __future__ import annotations

import atexit
import io
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from lagrange_cli import limits
from lagrange_cli.cli.console import (
    INTERRUPTED,
    INTERRUPTION,
    KILLED,
    STANDARD_INPUT,
    complain,
    describe,
    display_name,
    emit,
    run_one,
)
from lagrange_cli.cli.progress import Counter, Line
from lagrange_cli.cli.signals import heed_endings
from lagrange_cli.cli.source import read_bytes
from lagrange_cli.run.interrupts import Interrupts

Action = Callable[[str], int]

OFTEN = 0.1
"""Seconds between two looks for an interrupt."""
CONTEXT: Any = multiprocessing.get_context("fork" if sys.platform == "linux" else "spawn")


class Job:
    """One system in a process, which writes what it says to files in ``folder``."""

    def __init__(self, number: int, system: str, action: Action, folder: Path, *, as_json: bool) -> None:
        self.system = system
        self._files = folder / f"{number}.out", folder / f"{number}.err"
        self._control, other = CONTEXT.Pipe()
        content = read_bytes(system) if system == STANDARD_INPUT else None
        arguments = system, action, as_json, content, other, self._files
        self._process = CONTEXT.Process(target=work, args=arguments)
        self._process.start()
        self.sentinel: int = self._process.sentinel
        self.cut_short = False

    @property
    def ended(self) -> bool:
        """Whether the process has come to its end."""
        return self._process.exitcode is not None

    def stop(self) -> None:
        """Interrupt it, as Ctrl-C does."""
        with suppress(OSError):
            self._control.send_bytes(b"stop")

    def kill(self) -> None:
        """Interrupt it once more: it gives up at once."""
        self._process.terminate()
        self._process.join()

    def tell(self) -> int:
        """Say what it has said, and return its exit status.

        That an interrupt has cut it short is left for whoever speaks for all: see ``cut_short``.
        """
        out, err = (
            path.read_text(encoding="utf-8", errors="surrogateescape") if path.exists() else ""
            for path in self._files
        )
        if out:
            emit(out.removesuffix("\n"))
        self.cut_short = err == f"{INTERRUPTION}\n"
        if err and not self.cut_short:
            complain(err.removesuffix("\n"))
        status: int = self._process.exitcode
        if status < 0:
            complain(f"Error: {display_name(self.system)}: its process was killed by signal {-status}")
            return KILLED
        return status


def run_side_by_side(systems: Sequence[str], action: Action, jobs: int, *, as_json: bool, quiet: bool) -> int:
    """``run_each`` with so many systems at a time. An interrupt lets each that is running end as it does
    alone; a second one gives up at once."""
    progress = Counter("solve", len(systems), "systems", quiet=quiet)
    started: list[Job] = []
    statuses: list[int] = []
    with TemporaryDirectory(prefix="lagrange-") as folder, Interrupts() as interrupted:
        try:
            stopped = False
            while len(statuses) < (len(started) if stopped else len(systems)):
                running = [job for job in started if not job.ended]
                if not stopped and (interrupted() or INTERRUPTED in statuses):
                    stopped = True
                    for job in running:
                        job.stop()
                if not stopped and len(running) < jobs and len(started) < len(systems):
                    number = len(started)
                    started.append(Job(number, systems[number], action, Path(folder), as_json=as_json))
                    continue
                wait([job.sentinel for job in running], OFTEN)
                progress.show(sum(job.ended for job in started))
                for job in started[len(statuses) :]:
                    if not job.ended:
                        break
                    statuses.append(job.tell())
        finally:
            for job in started:
                if not job.ended:
                    job.kill()
            progress.clear()
    if any(job.cut_short for job in started):
        complain(INTERRUPTION)
    return max([*statuses, INTERRUPTED if stopped else 0])


def work(
    system: str, action: Action, as_json: bool, content: bytes | None, control: Connection,
    files: tuple[Path, Path],
) -> None:  # fmt: skip
    """One system, in a process of its own; ``content`` is that of standard input."""
    with suppress(AttributeError, OSError):
        os.setpgid(0, 0)  # Ctrl-C is for the process that waits for this one, which passes it on
    atexit._clear()  # that is for the process that waits
    heed_endings()
    threading.Thread(target=heed, args=(control,), daemon=True).start()
    Line.shown = None
    sys.stdout, sys.stderr = (
        open(path, "w", encoding="utf-8", errors="surrogateescape", buffering=1)  # noqa: SIM115
        for path in files
    )
    os.dup2(sys.stdout.fileno(), 1)  # libraries that are not Python's write there
    os.dup2(sys.stderr.fileno(), 2)
    if content is not None:
        sys.stdin = io.TextIOWrapper(io.BytesIO(content), encoding="utf-8")
    try:
        limits.enforce()
        status = run_one(system, action, as_json=as_json, named=True)
    except BaseException as error:
        message, status = describe(error, system)
        complain(message)
    sys.stdout.flush()
    os._exit(status)


def heed(control: Connection) -> None:
    """Interrupt this process when the one that has started it says so, or has been killed."""
    parent = multiprocessing.parent_process()
    wait([control, *([] if parent is None else [parent.sentinel])])
    if hasattr(os, "setpgid"):
        os.kill(os.getpid(), signal.SIGINT)  # to the main thread, wherever it waits
    else:
        signal.raise_signal(signal.SIGINT)
