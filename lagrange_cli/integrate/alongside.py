"""Two things at once, where one of them leaves the interpreter to the other."""

from __future__ import annotations

import threading
from collections.abc import Callable
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
