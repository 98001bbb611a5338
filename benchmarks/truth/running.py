"""A case as ``lagrange`` is asked for it: as ``solve``, as a member of a ``sweep``, and in double-double."""

from __future__ import annotations

import io
import os
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

from benchmarks.harness.processes import OURS, run_process
from benchmarks.truth.case import MP, Case

SOLVE, SWEEP, DOUBLE_DOUBLE = MODES = ("solve", "sweep", "double-double")
SECONDS = 60.0
"""Processor time after which a run hangs."""
MEMBERS = 9
"""Of a sweep: more than fill the lanes; the first and the last are compared with the truth."""


@dataclass(frozen=True)
class Ran:
    """What a run of the command printed, and how it ended (None: a hang)."""

    status: int | None
    printed: str
    errors: str


def over(case: Case) -> list[str]:
    """The values of the number that a sweep varies: the case's own, and others nearby."""
    value = MP.mpf(case.numbers[case.over])
    return [
        case.numbers[case.over],
        *(MP.nstr(value * (1 + MP.mpf(k) / 1000), 12) for k in range(1, MEMBERS)),
    ]


def command(case: Case, mode: str, file: Path) -> list[str]:
    """The arguments of ``lagrange``."""
    words = [
        "sweep" if mode == SWEEP else "solve",
        file.name,
        "-o",
        f"{case.name}-{mode}.h5",
        "--force",
        "--json",
        "--no-cache",
        "--stop",
        case.stop,
        "--samples",
        str(case.samples),
        "--outputs",
        ",".join(case.outputs),
    ]
    if mode == SWEEP:
        words += ["--jobs", "1", "--over", f"{case.over}={','.join(over(case))}"]
    if mode == DOUBLE_DOUBLE:
        words += ["--precision", mode]
    return words


def run(words: Sequence[str], folder: Path, *, shell: bool = False) -> Ran:
    """The command in this process, or in one of its own, for at most ``SECONDS`` of processor time."""
    if shell:
        ended = run_process((*OURS, *words), folder, {}, seconds=4 * SECONDS)
        return Ran(ended.status, ended.printed, ended.errors)
    from lagrange_cli.cli.main import main

    printed, errors = Stream(), Stream()
    before = os.getcwd()
    os.chdir(folder)
    try:
        with redirect_stdout(printed), redirect_stderr(errors), interrupted_after(SECONDS):
            status: int | None = main([*words])
    finally:
        os.chdir(before)
    return Ran(None if status == 130 else status, printed.text(), errors.text())


class Stream(io.TextIOWrapper):
    """Text that is kept in memory."""

    def __init__(self) -> None:
        super().__init__(io.BytesIO(), encoding="utf-8", write_through=True)

    def fileno(self) -> int:
        return 2

    def text(self) -> str:
        """What was written."""
        return self.buffer.getvalue().decode()  # type: ignore[attr-defined, no-any-return]


@contextmanager
def interrupted_after(seconds: float) -> Iterator[None]:
    """A context that is interrupted, as by Ctrl-C, after so many seconds of processor time."""

    def interrupt(number: int, frame: object) -> None:
        signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGPROF, interrupt)
    signal.setitimer(signal.ITIMER_PROF, seconds, 1.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
