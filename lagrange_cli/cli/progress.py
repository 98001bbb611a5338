"""How far a run has come: a line on standard error that is rewritten in place, on a terminal only."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from lagrange_cli.decimals import decimal

DELAY = 0.5
"""Seconds before the line is first shown and between its updates."""
PATIENCE = 2.0
"""Seconds of work before the motion after which its stage is shown."""
WORTH = 3.0
"""Seconds left of a stage that are shown."""
STAGES = {
    "import": "loading modules",
    "parse": "reading the system file",
    "start": "finding a consistent initial state",
    "derive": "deriving the equations of motion",
    "program": "writing the program",
    "compile": "compiling",
    "cache": "looking for a compiled program",
    "draw": "drawing",
    "verify": "comparing with the compiled equations",
    "print": "writing the equations",
}
"""The texts for stages that take long; the others show their progress themselves."""
LONG = 730 * 86400.0
"""Seconds from which on they are told in years."""
SHORTEST_NAME = 10
"""Columns of a name that are shown rather than the longest text."""
WIDTH = 80
"""Columns of a terminal that does not know its width."""


class Line:
    """A line that shows the progress of ``name``, on a terminal only."""

    shown: Line | None = None
    """The line that is on the terminal now."""

    def __init__(self, name: str, *, quiet: bool) -> None:
        self.enabled = not quiet and sys.stderr is not None and sys.stderr.isatty()
        self._name = name
        self._due = time.monotonic() + DELAY
        self.columns = 0

    def due(self) -> bool:
        """Whether it is time for an update."""
        return self.enabled and time.monotonic() >= self._due

    def say(self, *texts: str) -> None:
        """Rewrite the line with the first of the texts, or with one that is shorter where the terminal is
        narrow. The line is cut to its width: of the name first, as the text matters more."""
        self._due = time.monotonic() + DELAY
        width = terminal_width() - 1  # in the last column some terminals begin a new line
        name, fitting = printable(self._name), [printable(text) for text in texts]
        least = min(columns(name), SHORTEST_NAME) + 2
        text = next((text for text in fitting if columns(text) + least <= width), fitting[-1])
        room = width - columns(text) - 2
        line = cut(f"{cut(name, room)}: {text}" if room > 2 else text.lstrip(), width)
        self._write(line, width)
        self.columns = columns(line)
        Line.shown = self

    def clear(self) -> None:
        """Remove the line, so that what follows starts in the first column."""
        if self.columns:
            self._write("", terminal_width() - 1)
            with suppress(OSError, ValueError):
                sys.stderr.write("\r")
                sys.stderr.flush()
        self.columns = 0
        if Line.shown is self:
            Line.shown = None

    @staticmethod
    def clear_shown() -> None:
        """Remove the line that is shown now, if there is one, before another message."""
        if Line.shown is not None:
            Line.shown.clear()

    def _write(self, line: str, width: int) -> None:
        padding = max(0, min(self.columns, width) - columns(line))
        with suppress(OSError, ValueError):
            sys.stderr.write(f"\r{line}{' ' * padding}")
            sys.stderr.flush()


def terminal_width() -> int:
    """The columns of the terminal behind standard error, which may change at any time."""
    with suppress(OSError, ValueError, AttributeError):
        return os.get_terminal_size(sys.stderr.fileno()).columns or WIDTH
    return WIDTH


def printable(text: str) -> str:
    """What the terminal is going to show of the text, control characters replaced."""
    encoding = getattr(sys.stderr, "encoding", None) or "utf-8"
    shown = "".join(letter if letter.isprintable() else "?" for letter in text)
    return shown.encode(encoding, "backslashreplace").decode(encoding)


def columns(text: str) -> int:
    """The columns of a terminal that the text takes: letters of East Asia take two, combining ones none."""
    return len(text) if text.isascii() else sum(map(columns_of, text))


def columns_of(letter: str) -> int:
    """The columns that one character takes."""
    from unicodedata import category, east_asian_width

    if category(letter) in ("Mn", "Me", "Cf"):
        return 0
    return 2 if east_asian_width(letter) in ("W", "F") else 1


def cut(text: str, width: int) -> str:
    """The beginning of the text, as much as fits."""
    if columns(text) <= width:
        return text
    taken, used = 0, 0
    for letter in text:
        used += columns_of(letter)
        if used > width:
            break
        taken += 1
    return text[:taken]


class Rate:
    """The speed of something since it was first asked for; earlier progress does not count."""

    def __init__(self) -> None:
        self._first: tuple[float, float] | None = None

    def __call__(self, place: float) -> float:
        """The distance from the first place a second; 0 where that is not known yet."""
        now = time.monotonic()
        if self._first is None:
            self._first = place, now
        begin, began = self._first
        return (place - begin) / (now - began) if now > began else 0.0


def time_left(distance: float, rate: float) -> str:
    """``, 8 s left``; nothing where it is not known."""
    return f", {duration(distance / rate)} left" if rate and distance / rate > 0 else ""


def duration(seconds: float) -> str:
    """``8 s``, ``2 min 5 s``, ``3 h 20 min``, ``12 d 3 h``, ``3e8 years``."""
    if seconds >= LONG:
        from lagrange_cli.run.pace import in_years

        return in_years(seconds)
    minutes, rest = divmod(round(seconds), 60)
    if minutes == 0:
        return f"{rest} s"
    if minutes < 60:
        return f"{minutes} min {rest} s"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours < 48 else f"{hours // 24} d {hours % 24} h"


def roughly(seconds: float) -> str:
    """``about 5 s``, ``about 20 s``, ``about 3 min``, ``about 2 h``: an estimate has no more digits."""
    if seconds < 55:
        return f"about {5 if seconds < 7.5 else max(10, 10 * round(seconds / 10))} s"
    minutes = max(1, round(seconds / 60))
    return f"about {minutes} min" if minutes < 100 else f"about {round(minutes / 60)} h"


def eraser() -> bytes:
    """What removes the line that is shown now, for a process that ends at once."""
    return (
        b"" if Line.shown is None else f"\r{' ' * min(Line.shown.columns, terminal_width() - 1)}\r".encode()
    )


class Progress(Line):
    """Shows the time reached between ``start`` and ``stop``, and the time left."""

    def __init__(self, name: str, start: float, stop: float, *, quiet: bool) -> None:
        super().__init__(name, quiet=quiet)
        self._start, self._stop, self._rate = start, stop, Rate()

    def show(self, t: float) -> None:
        """The motion has reached ``t``."""
        rate = self._rate(t)
        if self.due():
            part = (t - self._start) / (self._stop - self._start)
            left = time_left(self._stop - t, rate)
            self.say(f"{part:4.0%}  t = {decimal(t)} of {decimal(self._stop)}{left}", f"{part:4.0%}{left}")


class Counter(Line):
    """Shows how many of ``count`` things have been done, how fast that goes, and the time left."""

    def __init__(self, name: str, count: int, noun: str, *, quiet: bool) -> None:
        super().__init__(name, quiet=quiet)
        self._count, self._noun, self._rate = count, noun, Rate()

    def show(self, done: float) -> None:
        """So many are done, those of an earlier run among them, and parts of others."""
        rate = self._rate(done)
        if self.due():
            left = time_left(self._count - done, rate)
            speed = f", {decimal(rate, 3)} per second" if rate else ""
            part, counted = f"{done / self._count:4.0%}", f"  {int(done)} of {self._count} {self._noun}"
            self.say(f"{part}{counted}{speed}{left}", f"{part}{counted}{left}", f"{part}{left}")


class MeasuringProgress(Line):
    """Shows which method is being measured."""

    def show(self, done: int, count: int, what: object) -> None:
        """``done`` of ``count`` are done, and ``what`` is next: each may take long, so this is shown at
        once."""
        if self.enabled:
            self.say(f"{done / count:4.0%}  {what}")


class Waiting:
    """Shows which stage of the work before the motion is on, once that has taken ``PATIENCE`` seconds.

    A thread updates the line while the stage works, so that the stage need not think of it.
    """

    def __init__(self, name: str, *, quiet: bool) -> None:
        self._line = Line(name, quiet=quiet)
        self._lock = threading.Lock()
        self._stage: str | None = None
        self._first: float | None = None
        self._began = 0.0
        self._updating: threading.Thread | None = None

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """A stage of the work, which may be within another. Nothing is shown in the course of one that is not
        among ``STAGES``."""
        before = self._enter(STAGES.get(name))
        try:
            yield
        finally:
            self._enter(*before)

    def _enter(self, text: str | None, began: float | None = None) -> tuple[str | None, float | None]:
        if not self._line.enabled:
            return None, None
        with self._lock:
            now, before = time.monotonic(), (self._stage, self._began)
            self._stage, self._began = text, now if began is None else began
            self._first = now if self._first is None else self._first
            if text is None:
                self._line.clear()
            elif self._updating is None:
                self._updating = threading.Thread(target=self._update, daemon=True)
                self._updating.start()
        return before

    def _update(self) -> None:
        while True:
            time.sleep(DELAY)
            with self._lock:
                if self._stage is None:
                    self._updating = None
                    return
                self.update()

    def update(self) -> None:
        """Bring the line up to date."""
        now = time.monotonic()
        if self._stage is not None and self._first is not None and now - self._first >= PATIENCE:
            passed = f"{self._stage}, {duration(now - self._began)}"
            self._line.say(*[f"{passed}, {roughly(left)} left" for left in self._left(now)], passed)

    def _left(self, now: float) -> list[float]:
        """The seconds left of the stage, if these are known and worth showing."""
        from lagrange_cli.portions import latest

        work = latest()
        left = work.left(now) if work is not None and work.began >= self._began else None
        return [left] if left is not None and left > WORTH else []
