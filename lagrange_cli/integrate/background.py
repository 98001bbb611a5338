"""Two things at once, if one of them releases the interpreter's lock."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import TracebackType
from typing import Generic, TypeVar

T = TypeVar("T")


class Work(threading.Thread, Generic[T]):
    """``function`` running in a thread of its own.

    The interpreter waits for its end before it ends itself: a compiler whose process is dismantled under it
    crashes. (The command line, which an interrupt must end at once, leaves nothing to be dismantled.)
    """

    def __init__(self, function: Callable[[], T]) -> None:
        super().__init__()
        self._function = function
        self._error: BaseException | None = None
        self.start()

    def run(self) -> None:
        try:
            self._value = self._function()
        except BaseException as error:
            self._error = error

    def result(self) -> T:
        """Wait for its end; returns its result, or raises its exception."""
        self.join()
        if self._error is not None:
            raise self._error
        return self._value


def concurrently(work: Callable[[], T], other: Callable[[], object]) -> T:
    """The result of ``work``, done while this thread does ``other``."""
    working = Work(work)
    other()
    return working.result()


class Pipelined:
    """A context for calls in another thread, one at a time: before the next one, and at the end of the
    context, it waits for the previous one and raises its exception."""

    def __init__(self) -> None:
        self._work: Work[object] | None = None

    def wait(self) -> None:
        """Wait for the end of the last call."""
        work, self._work = self._work, None
        if work is not None:
            work.result()

    def call(self, function: Callable[[], object]) -> None:
        """Start the next call."""
        self.wait()
        self._work = Work(function)

    def __enter__(self) -> Pipelined:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None:
            self.wait()
        elif self._work is not None:
            self._work.join()
