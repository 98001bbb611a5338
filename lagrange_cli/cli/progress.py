"""How far a run has come: a line on standard error that is rewritten in place, on a terminal only."""

from __future__ import annotations

import sys
import time
from contextlib import suppress

DELAY = 0.5
"""Seconds before the line is first shown and between its updates."""


class Line:
    """A line that says how far ``name`` has come; it says nothing where nobody watches."""

    def __init__(self, name: str, *, quiet: bool) -> None:
        self._name = name
        self._enabled = not quiet and sys.stderr is not None and sys.stderr.isatty()
        self._due = time.monotonic() + DELAY
        self._length = 0

    def due(self) -> bool:
        """Whether it is time to say something."""
        return self._enabled and time.monotonic() >= self._due

    def say(self, fraction: float, rest: str) -> None:
        """Rewrite the line: the fraction that is done, and what else there is to say."""
        self._due = time.monotonic() + DELAY
        self._write(f"{self._name}: {fraction:4.0%}  {rest}")

    def clear(self) -> None:
        """Take the line away, so that what follows starts in the first column."""
        if self._length:
            self._write("")

    def _write(self, line: str) -> None:
        with suppress(OSError):
            sys.stderr.write("\r" + line.ljust(self._length) + ("" if line else "\r"))
            sys.stderr.flush()
        self._length = len(line)


class Progress(Line):
    """Shows the time reached between ``start`` and ``stop``."""

    def __init__(self, name: str, start: float, stop: float, *, quiet: bool) -> None:
        super().__init__(name, quiet=quiet)
        self._start, self._stop = start, stop

    def show(self, t: float) -> None:
        """Say that the motion has reached ``t``, if it is time to say something."""
        if self.due():
            self.say((t - self._start) / (self._stop - self._start), f"t = {t:.6g} of {self._stop:g}")


class MembersProgress(Line):
    """Shows how many members of an ensemble have ended, how fast that goes, and the time left."""

    def __init__(self, name: str, members: int, *, quiet: bool) -> None:
        super().__init__(name, quiet=quiet)
        self._members, self._began = members, time.monotonic()

    def show(self, done: int) -> None:
        """Say that ``done`` members have ended, if it is time to say something."""
        if self.due():
            rate = done / (time.monotonic() - self._began)
            left = f", {duration((self._members - done) / rate)} left" if done else ""
            self.say(done / self._members, f"{done} of {self._members} members, {rate:.3g} a second{left}")


def duration(seconds: float) -> str:
    """``8 s``, ``2 min 5 s``, ``3 h 20 min``."""
    minutes, rest = divmod(round(seconds), 60)
    if minutes == 0:
        return f"{rest} s"
    return f"{minutes} min {rest} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


class ContestProgress(Line):
    """Shows which of the contenders is on."""

    def show(self, done: int, count: int, what: object) -> None:
        """Say that ``done`` of ``count`` are through and what comes next: each may take long, so at once."""
        if self._enabled:
            self.say(done / count, str(what))
