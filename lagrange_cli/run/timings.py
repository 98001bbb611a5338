"""Where the time of a run goes, stage by stage."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lagrange_cli.cli.report.progress import Waiting

WAITING = {
    "import": "loading modules",
    "parse": "reading the system file",
    "derive": "deriving the equations of motion",
    "program": "writing the program",
    "compile": "compiling",
    "cache": "looking for a compiled program",
}
"""What is shown of stages that take long; the others show their progress themselves."""

STAGES = ("import", "parse", "derive", "compile", "cache", "integrate", "write")
"""In the order of the pipeline; ``cache`` is looking for a compiled program there, and keeping a new one."""

PARTS = {"program": "derive"}
"""What is a stage to those who wait, and a part of another in the account."""

NOTES = {
    "import": "loading Python modules",
    "parse": "reading and checking the system file",
    "derive": "deriving the equations of motion, and writing the program",
    "compile": "waiting for the compiler, which runs while modules are loaded",
    "cache": "looking for a compiled program, and storing a new one",
    "integrate": "integrating the motion",
    "write": "writing the HDF5 file",
}


class Stopwatch:
    """Seconds by stage. Stages do not overlap: one within another stops the outer one's time.

    ``waiting`` shows which stage is on, where it takes long.
    """

    def __init__(self, waiting: Waiting | None = None) -> None:
        self._show = waiting.stage if waiting is not None else nullcontext
        self.seconds = dict.fromkeys(STAGES, 0.0)
        self._started = time.perf_counter()
        self._inner = 0.0

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Add the time spent inside to the stage of that name."""
        before, outer, self._inner = time.perf_counter(), self._inner, 0.0
        try:
            with self._show(WAITING.get(name)):
                yield
        finally:
            spent = time.perf_counter() - before
            self.seconds[PARTS.get(name, name)] += spent - self._inner
            self._inner = outer + spent

    def report(self) -> dict[str, float]:
        """The stages, and the total since the system's turn came."""
        return {**self.seconds, "total": time.perf_counter() - self._started}


def as_table(seconds: Mapping[str, float], start: float, *, cached: bool) -> str:
    """A line for each stage that took place, in seconds; ``start`` is what passed before the first."""
    skipped = {"derive", "compile"} if cached else set()
    notes = NOTES | {"cache": "found the compiled program"} if cached else NOTES
    rows = [("start", start, "starting Python, reading the command line")]
    rows += [(name, seconds[name], notes[name]) for name in STAGES if name not in skipped]
    rows += [("total", start + seconds["total"], "")]
    names = {"cache": "cache hit"} if cached else {}
    return "\n".join(
        f"  {names.get(name, name):<10}{spent:8.3f} s  {note}".rstrip() for name, spent, note in rows
    )
