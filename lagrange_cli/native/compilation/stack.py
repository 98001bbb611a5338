"""Calls with a larger stack, for compiled functions that need more than the caller's."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, TypeVar

T = TypeVar("T")

PAGE = 2**16
_LOCK = threading.Lock()


class StackCall(threading.Thread):
    """``function`` in a thread with a stack of ``size`` bytes; only pages that are used take memory."""

    def __init__(self, function: Callable[[], Any], size: int) -> None:
        super().__init__(daemon=True)
        self._function = function
        with _LOCK:  # the size is a setting of the process
            before = threading.stack_size(-(-size // PAGE) * PAGE)
            try:
                self.start()
            finally:
                threading.stack_size(before)

    def run(self) -> None:
        try:
            self.value, self.error = self._function(), None
        except BaseException as error:
            self.error = error

    def result(self) -> Any:
        """What the function returned, or the exception that it raised.

        Ctrl-C waits until it has returned: it works on memory that the caller would free.
        """
        interrupt: BaseException | None = None
        while self.is_alive():
            try:
                self.join()
            except KeyboardInterrupt as error:
                interrupt = error
        if interrupt is not None:
            raise interrupt
        if self.error is not None:
            raise self.error
        return self.value


def with_stack(function: Callable[..., T], size: int) -> Callable[..., T]:
    """``function``, each call with ``size`` bytes of stack."""

    def call(*arguments: Any) -> T:
        value: T = StackCall(lambda: function(*arguments), size).result()
        return value

    return call
