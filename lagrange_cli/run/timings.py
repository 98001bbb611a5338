"""Where the time of a run goes, stage by stage."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from lagrange_cli.run.monitor import Stage, untimed

STAGES = ("import", "parse", "derive", "compile", "cache", "integrate", "write")
"""In the order of the pipeline; ``cache`` is looking for a compiled program there, and keeping a new one."""

PARTS = {"start": "parse", "program": "derive"}
"""Stages that are shown while they run, but counted as parts of others."""


class Stopwatch:
    """Seconds by stage. Stages do not overlap: one within another stops the outer one's time.

    ``show`` is a context for each stage, too: it may show which one is on.
    """

    def __init__(self, show: Stage = untimed) -> None:
        self._show = show
        self.seconds = dict.fromkeys(STAGES, 0.0)
        self._started = time.perf_counter()
        self._inner = 0.0

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Add the time spent inside to the stage of that name."""
        before, outer, self._inner = time.perf_counter(), self._inner, 0.0
        try:
            with self._show(name):
                yield
        finally:
            spent = time.perf_counter() - before
            self.seconds[PARTS.get(name, name)] += spent - self._inner
            self._inner = outer + spent

    def report(self) -> dict[str, float]:
        """The seconds of the stages, and the ``total`` since the stopwatch was made."""
        return {**self.seconds, "total": time.perf_counter() - self._started}
