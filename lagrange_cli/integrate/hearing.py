"""Signals that take effect while compiled code runs.

Python runs a handler of signals in the main thread only, and not before compiled code has returned. One step
may be divided so often for its integrals that this takes minutes. Within ``heard`` a thread learns of each
signal at once, by the descriptor that Python's own handler writes to, and makes the code leave the step.
"""

from __future__ import annotations

import _thread
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext

from numpy import int64
from numpy.typing import NDArray

from lagrange_cli.native.guards import HALTED

ENDS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGALRM", "SIGBREAK")
ENDING = frozenset(int(getattr(signal, name)) for name in ENDS if hasattr(signal, name))
"""The numbers of the signals that ask a process to end."""

_steppers: list[NDArray[int64]] = []
"""The numbers (``%info``) that compiled code which is running now looks at."""


@contextmanager
def asked_by(info: NDArray[int64]) -> Iterator[None]:
    """A context in which a signal sets the place ``HALTED`` of ``info`` to 1, if the main thread hears
    it."""
    _steppers.append(info)
    try:
        with heard():
            yield
    finally:
        del _steppers[next(i for i, one in enumerate(_steppers) if one is info)]


@contextmanager
def heard() -> Iterator[None]:
    """A context in which signals reach the main thread at once, unless another program uses the
    descriptor."""
    with _listening() if threading.current_thread() is threading.main_thread() else nullcontext():
        yield


@contextmanager
def _listening() -> Iterator[None]:
    ear, mouth = os.pipe()
    before = _told_at(mouth)
    if before == -1:
        # Not a threading.Thread: to wait until that has begun, and until it has ended, costs a short motion
        # more than its steps do.
        _thread.start_new_thread(_listen, (ear,))
    elif before is not None:
        signal.set_wakeup_fd(before)
    try:
        yield
    finally:
        if before == -1:
            signal.set_wakeup_fd(-1)
        else:
            os.close(ear)
        os.close(mouth)  # which ends the listener


def _told_at(mouth: int) -> int | None:
    """From now on Python writes signals to this descriptor; that which it wrote them to before, -1 for none.
    None where it refuses, as the descriptor cannot be made one that does not block."""
    if hasattr(os, "set_blocking"):
        os.set_blocking(mouth, False)
    try:
        return signal.set_wakeup_fd(mouth, warn_on_full_buffer=False)
    except ValueError:
        return None


def _listen(ear: int) -> None:
    try:
        while numbers := os.read(ear, 64):
            if not ENDING.isdisjoint(numbers):
                for info in list(_steppers):
                    info[HALTED] = 1
    finally:
        os.close(ear)
