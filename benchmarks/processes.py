"""Whole processes, timed from start to end, as a user at the shell experiences them."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from benchmarks.report import ROOT
from benchmarks.turns import in_turns

SCRIPTS = Path(__file__).resolve().parent / "scripts"
"""What a user of other programs would write."""

OURS = ("-m", "lagrange_cli")


@dataclass(frozen=True)
class Ended:
    """What a process took: seconds, and the most memory that it held, in bytes."""

    seconds: float
    memory: int


def run_process(arguments: tuple[str, ...], folder: Path, environment: Mapping[str, str]) -> Ended:
    """Run Python with these arguments in ``folder``; what it prints is shown only if it fails."""
    with tempfile.TemporaryFile() as printed:
        began = time.perf_counter()
        child = subprocess.Popen(
            [sys.executable, *arguments],
            cwd=folder,
            env={**os.environ, **environment},
            stdout=printed,
            stderr=subprocess.STDOUT,
        )
        _, status, usage = os.wait4(child.pid, 0)
        seconds = time.perf_counter() - began
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode:
            printed.seek(0)
            sys.stderr.buffer.write(printed.read())
            raise subprocess.CalledProcessError(child.returncode, child.args)
    return Ended(seconds, usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024))


@dataclass(frozen=True)
class Shell:
    """A folder to run processes in, with a copy of ``systems/`` and with caches of compiled code that begin
    empty."""

    folder: Path

    def run(self, *arguments: str) -> Ended:
        """One process."""
        environment = {
            "LAGRANGE_CACHE_DIR": str(self.folder / "cache"),
            "LAGRANGE_NO_CACHE": "",
            "HEYOKA_CACHE_DIR": str(self.folder / "heyoka"),
            "PYTHONPATH": str(ROOT),
            "PYTHONDONTWRITEBYTECODE": "",  # an installed package has bytecode, as the others here do
        }
        return run_process(arguments, self.folder, environment)

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
