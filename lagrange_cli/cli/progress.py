"""How far a run has come: a line on standard error that is rewritten in place, on a terminal only."""

from __future__ import annotations

import sys
import time
from contextlib import suppress

DELAY = 0.5
"""Seconds before the line is first shown and between its updates."""


class Progress:
    """Shows the time reached between ``start`` and ``stop``; says nothing where nobody watches."""

    def __init__(self, name: str, start: float, stop: float, *, quiet: bool) -> None:
        self._name, self._start, self._stop = name, start, stop
        self._enabled = not quiet and sys.stderr is not None and sys.stderr.isatty()
        self._due = time.monotonic() + DELAY
        self._length = 0

    def show(self, t: float) -> None:
        """Say that the motion has reached ``t``, if it is time to say something."""
        if not self._enabled or time.monotonic() < self._due:
            return
        self._due = time.monotonic() + DELAY
        fraction = (t - self._start) / (self._stop - self._start)
        self._write(f"{self._name}: {fraction:4.0%}  t = {t:.6g} of {self._stop:g}")

    def clear(self) -> None:
        """Take the line away, so that what follows starts in the first column."""
        if self._length:
            self._write("")

    def _write(self, line: str) -> None:
        with suppress(OSError):
            sys.stderr.write("\r" + line.ljust(self._length) + ("" if line else "\r"))
            sys.stderr.flush()
        self._length = len(line)
