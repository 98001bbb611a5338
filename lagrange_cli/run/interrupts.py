"""Interrupts that take effect between two chunks of work instead of in the middle of one."""

from __future__ import annotations

import signal
import threading
from types import FrameType, TracebackType
from typing import Any

ENDS = ("SIGTERM", "SIGHUP", "SIGALRM", "SIGBREAK")
ENDING = tuple(getattr(signal, name) for name in ENDS if hasattr(signal, name))
"""Other signals that ask a process to end; they have the same effect as Ctrl-C. Not every platform has all:
SIGALRM is that of ``limits``, SIGBREAK that of Ctrl-Break on Windows."""


class Interrupts:
    """A context within which Ctrl-C (or SIGTERM, SIGHUP) makes calling this object return True.

    A second one is raised as ``KeyboardInterrupt``, in case this object is not called. In a program that is
    not ours only Ctrl-C is heeded (``alone``), and only where it would raise ``KeyboardInterrupt``.
    """

    def __init__(self, *, alone: bool = False) -> None:
        self._alone = alone
        self._seen = False
        self._before: dict[signal.Signals, Any] = {}

    def __call__(self) -> bool:
        return self._seen

    def __enter__(self) -> Interrupts:
        if threading.current_thread() is threading.main_thread():  # elsewhere Python sets no handlers
            numbers = (signal.SIGINT, *(number for number in ENDING if not ignored(number)))
            if self._alone:
                own = signal.getsignal(signal.SIGINT) is signal.default_int_handler
                numbers = (signal.SIGINT,) if own else ()
            self._before = {number: signal.signal(number, self._note) for number in numbers}
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _note(self, number: int, frame: FrameType | None) -> None:
        if self._seen:
            raise KeyboardInterrupt
        self._seen = True


def ignored(number: signal.Signals) -> bool:
    """Whether the process was started so as to ignore the signal, as ``nohup`` does."""
    return signal.getsignal(number) == signal.SIG_IGN
