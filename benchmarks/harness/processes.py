"""Whole processes, timed from start to end, as a user at the shell experiences them."""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from benchmarks import ROOT
from benchmarks.harness.turns import in_turns

PROGRAMS = ROOT / "benchmarks" / "peers" / "programs"
"""What a user of other programs would write."""
OURS = ("-m", "lagrange_cli")


@dataclass(frozen=True)
class Ended:
    """What a process took, in seconds, of which the ``processor`` worked for it, and, at most, in bytes of
    memory; its exit status (None: over the time limit), and what it printed."""

    seconds: float
    processor: float
    memory: int
    status: int | None
    printed: str
    errors: str


def run_process(
    arguments: tuple[str, ...],
    folder: Path,
    environment: Mapping[str, str],
    *,
    seconds: float | None = None,
    memory: int | None = None,
) -> Ended:
    """Run Python with these arguments in ``folder``, for no longer than so many seconds and in so many bytes
    of address space, if limits are given."""

    def limit() -> None:
        if memory is not None:
            resource.setrlimit(resource.RLIMIT_AS, (memory, memory))

    with tempfile.TemporaryFile() as printed, tempfile.TemporaryFile() as errors:
        began = time.perf_counter()
        child = subprocess.Popen(
            [sys.executable, *arguments],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
            stdin=subprocess.DEVNULL,
            stdout=printed,
            stderr=errors,
            preexec_fn=None if memory is None else limit,
        )
        late = threading.Event()

        def end() -> None:
            late.set()
            child.kill()

        timer = None if seconds is None else threading.Timer(seconds, end)
        if timer is not None:
            timer.start()
        _, status, usage = os.wait4(child.pid, 0)
        spent = time.perf_counter() - began
        if timer is not None:
            timer.cancel()
        child.returncode = os.waitstatus_to_exitcode(status)
        texts = []
        for stream in (printed, errors):
            stream.seek(0)
            texts.append(stream.read().decode("utf-8", "replace"))
    most = usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    ended = None if late.is_set() else child.returncode
    return Ended(spent, usage.ru_utime + usage.ru_stime, most, ended, *texts)


@dataclass(frozen=True)
class Shell:
    """A folder to run processes in, with a copy of ``systems/`` and with caches of compiled code that begin
    empty."""

    folder: Path

    def run(self, *arguments: str) -> Ended:
        """One process; what it prints is shown only if it fails."""
        environment = {
            "LAGRANGE_CACHE_DIR": str(self.folder / "cache"),
            "LAGRANGE_NO_CACHE": "",
            "HEYOKA_CACHE_DIR": str(self.folder / "heyoka"),
            "PYTHONDONTWRITEBYTECODE": "",  # an installed package has bytecode, as the others here do
        }
        ended = run_process(arguments, self.folder, environment)
        if ended.status:
            sys.stderr.write(ended.printed + ended.errors)
            raise subprocess.CalledProcessError(ended.status, arguments)
        return ended

    def in_turns(self, commands: Mapping[str, tuple[str, ...]], turns: int) -> dict[str, list[Ended]]:
        """Every command by its name, ``turns`` times; once more before, so that files are in memory, and
        bytecode and compiled programs on disk where the command keeps any."""
        tasks = {name: partial(self.run, *arguments) for name, arguments in commands.items()}
        in_turns(tasks, 1)
        return in_turns(tasks, turns)


@contextmanager
def shell(folder: Path | None = None) -> Iterator[Shell]:
    """A shell in a new folder (within ``folder``), which is removed at the end."""
    with tempfile.TemporaryDirectory(dir=folder) as name:
        shutil.copytree(ROOT / "systems", Path(name) / "systems")
        yield Shell(Path(name))
