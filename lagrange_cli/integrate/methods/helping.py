"""Threads that share the evaluations of one large motion (see ``native.families.sharing``)."""

from __future__ import annotations

import ctypes
import sys
import threading
import time

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.processors import processors
from lagrange_cli.native.board import Board
from lagrange_cli.native.compilation.machine import Machine

NAP = 1e-4
"""Seconds between two looks for an evaluation, where there has been none for a while."""
SLOWER = 0.75
"""Where helpers make so much less of a difference than before, it is tried whether they still make one."""
AGAIN = 16
"""And after so many spans of time without them, they are tried again."""
FREE = 0.85
"""Where the thread that they help has a processor for less than this part of the time, others are waiting for
one, too: then helpers are waited for in vain."""


class Helpers:
    """A context in which as many ``threads``, this one among them, share evaluations: None for one on each
    processor. ``constants`` have been prepared.

    Where other programs keep the processors busy, it takes longer to wait for helpers than to do without. So
    ``judge`` lets them rest as long as they are of no use.
    """

    def __init__(self, machine: Machine, constants: Array, threads: int | None) -> None:
        self._board = constants[machine.program.board :].view(np.int64)
        self._board[Board.YIELD] = yielding()
        self._wanted = threading.Event()
        wanted = processors() if threads is None else threads
        self._threads = [
            threading.Thread(target=help_with, args=(machine, constants, self._wanted), daemon=True)
            for _ in range(min(wanted, machine.program.strips) - 1)
        ]
        self._best, self._alone = 0.0, 0.0
        """Evaluations a second, with helpers and without."""
        self._spans = 0

    @property
    def threads(self) -> int:
        """How many threads there are, with the one that they help."""
        return 1 + len(self._threads)

    @property
    def active(self) -> bool:
        """Whether they take part."""
        return bool(self._board[Board.HELPERS])

    @active.setter
    def active(self, value: bool) -> None:
        self._board[Board.HELPERS] = len(self._threads) if value else 0
        if value:
            self._wanted.set()
        else:
            self._wanted.clear()

    @property
    def unsure(self) -> bool:
        """Whether it is not known yet how long it takes without them."""
        return self._alone == 0.0

    def __enter__(self) -> Helpers:
        try:
            for one in self._threads:
                one.start()
        except BaseException:
            self._end()
            raise
        self.active = True
        return self

    def __exit__(self, *error: object) -> None:
        self._end()

    def _end(self) -> None:
        self.active = False
        self._board[Board.HALT] = 1
        self._wanted.set()
        for one in self._threads:
            if one.ident is not None:
                one.join()

    def judge(self, evaluations: int, seconds: float, computed: float) -> None:
        """Take note of so many evaluations in a span of time, and decide whether helpers take part in the
        next one. For so many of the seconds, this thread had a processor."""
        speed, free = evaluations / max(seconds, 1e-9), computed >= FREE * seconds
        self._spans += 1
        if not self.active:
            self._alone = speed
            self.active = free and (speed < self._best or self._spans >= AGAIN)
            self._spans = 0 if self.active else self._spans
        elif speed < self._alone or speed < SLOWER * self._best or self.unsure or not free:
            self._best, self._spans, self.active = speed, 0, False
        else:
            self._best = max(self._best, speed)


def help_with(machine: Machine, constants: Array, wanted: threading.Event) -> None:
    """Take part in evaluations until there are no more, and sleep while that is not ``wanted``."""
    assert machine.help is not None
    while machine.help(constants.ctypes.data):
        if wanted.is_set():
            time.sleep(NAP)
        else:
            wanted.wait()


def yielding() -> int:
    """The address of the system's function by which a thread lets others go first."""
    if sys.platform == "win32":
        function = ctypes.windll.kernel32.SwitchToThread
    else:
        function = ctypes.CDLL(None).sched_yield
    return ctypes.cast(function, ctypes.c_void_p).value or 0
