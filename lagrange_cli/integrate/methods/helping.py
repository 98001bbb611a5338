"""Threads that share the evaluations of one large motion (see ``native.families.sharing``)."""

from __future__ import annotations

import ctypes
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.native.compilation.machine import Machine
from lagrange_cli.native.interface import Board

NAP = 1e-4
"""Seconds between two looks at an evaluation, where there has been none for a while."""


@contextmanager
def helped(machine: Machine, constants: Array, threads: int) -> Iterator[None]:
    """A context in which as many ``threads``, this one among them, share evaluations, if the program's are
    large enough. ``constants`` have been prepared."""
    helpers = min(threads, machine.program.strips) - 1
    if helpers < 1 or machine.help is None:
        yield
        return
    board = constants[machine.program.board :].view(np.int64)
    board[Board.YIELD] = yielding()
    working = [threading.Thread(target=_help, args=(machine, constants), daemon=True) for _ in range(helpers)]
    try:
        for one in working:
            one.start()
        board[Board.HELPERS] = helpers
        yield
    finally:
        board[Board.HELPERS] = 0
        board[Board.HALT] = 1
        for one in working:
            if one.ident is not None:
                one.join()
        board[Board.HALT] = 0


def _help(machine: Machine, constants: Array) -> None:
    assert machine.help is not None
    while machine.help(constants.ctypes.data):
        time.sleep(NAP)


def yielding() -> int:
    """The address of the system's function by which a thread lets others go first."""
    if sys.platform == "win32":
        function = ctypes.windll.kernel32.SwitchToThread
    else:
        function = ctypes.CDLL(None).sched_yield
    return ctypes.cast(function, ctypes.c_void_p).value or 0
