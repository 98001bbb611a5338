"""Two things at once, where one of them leaves the interpreter to the other."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import TracebackType
from typing import Generic, TypeVar

T = TypeVar("T")


class Work(threading.Thread, Generic[T]):
    """``function`` in a thread of its own, from now on."""

    def __init__(self, function: Callable[[], T]) -> None:
        super().__init__(daemon=True)  # an interrupt need not wait for it
        self._function = function
        self._error: BaseException | None = None
        self.start()

    def run(self) -> None:
        try:
            self._value = self._function()
        except BaseException as error:
            self._error = error

    def result(self) -> T:
        """What it gives, or the exception that it raises, once it has come to its end."""
        self.join()
        if self._error is not None:
            raise self._error
        return self._value


def alongside(work: Callable[[], T], other: Callable[[], object]) -> T:
    """What ``work`` gives, while this thread does ``other``."""
    working = Work(work)
    other()
    return working.result()


class Behind:
    """A context for calls that are made beside this thread, one at a time: before the next, and at the end of
    the context, the one before is waited for, and what that raised is raised."""

    def __init__(self) -> None:
        self._work: Work[object] | None = None

    def wait(self) -> None:
        """For the last call to come to its end."""
        work, self._work = self._work, None
        if work is not None:
            work.result()

    def call(self, function: Callable[[], object]) -> None:
        """Begin the next call."""
        self.wait()
        self._work = Work(function)

    def __enter__(self) -> Behind:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None:
            self.wait()
        elif self._work is not None:
            self._work.join()
