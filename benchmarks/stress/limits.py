"""A process with limits of time and memory, so that a crash or a hang is a result like others."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from benchmarks.report import ROOT

MEMORY = 4 << 30
"""Bytes of address space."""


@dataclass(frozen=True)
class Ended:
    """The exit status (None: over the time limit), seconds, and what was printed."""

    status: int | None
    seconds: float
    printed: str
    errors: str


def run_limited(arguments: tuple[str, ...], folder: Path, seconds: float) -> Ended:
    """Run Python with these arguments in ``folder``, for no longer than so many seconds."""
    began = time.perf_counter()
    with tempfile.TemporaryFile("w+") as printed, tempfile.TemporaryFile("w+") as errors:
        child = subprocess.Popen(
            [sys.executable, *arguments],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(ROOT), "LAGRANGE_CACHE_DIR": str(folder / "cache")},
            stdin=subprocess.DEVNULL,
            stdout=printed,
            stderr=errors,
            preexec_fn=partial(resource.setrlimit, resource.RLIMIT_AS, (MEMORY, MEMORY)),
        )
        try:
            status: int | None = child.wait(seconds)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()
            status = None
        texts = []
        for stream in (printed, errors):
            stream.seek(0)
            texts.append(stream.read())
    return Ended(status, time.perf_counter() - began, *texts)
