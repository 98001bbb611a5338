"""Work whose amount is known beforehand: how much of it is done, for whoever shows the time left.

Whoever does such work says how far it has come, whether anyone looks or not, and whoever looks asks for
``latest``. So neither needs to know of the other.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager


class Portion:
    """Work of which ``done`` parts of ``total`` are done; it may be one part of an ``outer`` one."""

    __slots__ = ("_done", "_outer", "_part", "_total", "began", "told")

    def __init__(self, total: float, outer: Portion | None) -> None:
        self._total, self._outer = total, outer
        self._done = self._part = 0.0
        self.began = self.told = time.monotonic()

    def reach(self, done: float) -> None:
        """So many parts are done."""
        self._done = done
        self._tell(0.0)

    def _tell(self, within: float) -> None:
        """The part in progress is done up to a fraction."""
        self.told = time.monotonic()
        self._part = min(1.0, (self._done + within) / self._total)
        if self._outer is not None:
            self._outer._tell(self._part)

    def left(self, now: float) -> float | None:
        """Seconds left at the rate so far; None where nothing is done yet. They are less than 0 where it
        should have ended by ``now``."""
        if not self._part:
            return None
        return (self.told - self.began) * (1.0 / self._part - 1.0) - (now - self.told)


class _Innermost(threading.local):
    portion: Portion | None = None


_innermost = _Innermost()
_outermost: list[Portion] = []


@contextmanager
def portion(total: float) -> Iterator[Portion]:
    """A context for work of so many parts. Within another one, of the same thread, it is one part of that."""
    outer = _innermost.portion
    made = _innermost.portion = Portion(total, outer)
    if outer is None:
        _outermost.append(made)
    try:
        yield made
    finally:
        _innermost.portion = outer
        if outer is None:
            _outermost.remove(made)


def latest() -> Portion | None:
    """The whole work that was begun last and goes on, in any thread."""
    going = _outermost[-1:]  # at once, as another thread may end it
    return going[0] if going else None
