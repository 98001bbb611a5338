"""The command ``lagrange``: in this process, which is quick, or as a process of its own, as for a user."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from unittest import mock

ROOT = Path(__file__).resolve().parents[2]
SYSTEMS = ROOT / "systems"
PATIENCE = 600
"""Seconds after which a process hangs, however busy the machine is."""


class Stream(io.TextIOWrapper):
    """Text that is kept in memory; what insists on a descriptor gets that of standard error."""

    def __init__(self, content: str = "") -> None:
        super().__init__(io.BytesIO(content.encode()), encoding="utf-8", write_through=True)

    def fileno(self) -> int:
        return 2

    def getvalue(self) -> str:
        return self.buffer.getvalue().decode()  # type: ignore[attr-defined, no-any-return]


@contextmanager
def working_in(folder: Path) -> Iterator[None]:
    """A context in which ``folder`` is the working directory."""
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def lagrange(*arguments: str | Path, cwd: Path, input: str = "") -> subprocess.CompletedProcess[str]:
    """Run ``lagrange`` in this process; its status and what it wrote."""
    from lagrange_cli.cli.main import main  # not earlier, so that the fuzzer can instrument it

    out, errors = Stream(), Stream()
    with (
        working_in(cwd),
        mock.patch.dict(os.environ, COLUMNS="100"),
        mock.patch.object(sys, "stdin", Stream(input)),
        redirect_stdout(out),
        redirect_stderr(errors),
    ):
        status = main([*map(str, arguments)])
    return subprocess.CompletedProcess(arguments, status, out.getvalue(), errors.getvalue())


def environment() -> dict[str, str]:
    """The environment of a process that tests start: warnings are errors there, too.

    OpenBLAS would take 40 MB of address space for each core, and some processes may only use so much.
    Bytecode is kept: to compile 150 modules takes longer than most commands.
    """
    return {
        **os.environ, "PYTHONPATH": str(ROOT), "PYTHONWARNINGS": "error", "COLUMNS": "100",
        "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "",
    }  # fmt: skip


def lagrange_process(*arguments: str | Path, cwd: Path, **options) -> subprocess.CompletedProcess[str]:
    """Run ``lagrange`` as a process of its own; its status and what it wrote."""
    command = [sys.executable, "-m", "lagrange_cli", *map(str, arguments)]
    return subprocess.run(
        command, cwd=cwd, env=environment(), capture_output=True, text=True, timeout=PATIENCE, **options
    )


def wait_until(condition: Callable[[], object], running: subprocess.Popen | None = None) -> None:
    """Wait until ``condition`` holds, or the process has ended."""
    end = time.monotonic() + PATIENCE
    while not condition() and (running is None or running.poll() is None):
        assert time.monotonic() < end, "nothing happens"
        time.sleep(0.005)


SEVERAL = """
import json, sys
from pathlib import Path
from tests.support.command import lagrange
for folder, arguments in json.load(sys.stdin):
    run = lagrange(*arguments, cwd=Path(folder))
    print(json.dumps([run.returncode, run.stdout, run.stderr]), flush=True)
"""


def lagrange_processes(
    commands: Sequence[tuple[Path, Sequence[str | Path]]], **options
) -> list[subprocess.CompletedProcess[str]]:
    """Run several commands, each in its folder, one after the other in one process of their own."""
    given = json.dumps([[str(folder), [*map(str, arguments)]] for folder, arguments in commands])
    made = subprocess.run(
        [sys.executable, "-c", SEVERAL], env=environment(), input=given, capture_output=True, text=True,
        timeout=PATIENCE, **options,
    )  # fmt: skip
    assert (made.returncode, made.stderr) == (0, ""), made.stderr
    answers = map(json.loads, made.stdout.splitlines())
    return [
        subprocess.CompletedProcess(arguments, *answer)
        for (_, arguments), answer in zip(commands, answers, strict=True)
    ]
