"""``Companion``: the same motion integrated with another order, and therefore with other steps and rounding
errors; and with inputs that are rounded otherwise (see ``native.numbers.beside``)."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.background import Work
from lagrange_cli.integrate.method import End, Method
from lagrange_cli.integrate.methods.backward import Backward
from lagrange_cli.integrate.methods.stepper import Beside
from lagrange_cli.integrate.methods.taylor import TaylorMethod
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.interface import CONSTANTS
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.spec.values import Values

INPUTS = 8
"""How much larger the rounding errors of inputs are in one of the companions than in the run."""
FACTORS = INPUTS, 0
"""What they are multiplied by in each companion; 0 for one that has the inputs of the run."""
LOOK = 0.5
"""Seconds between two checks whether the other side is still there."""


class Companion:
    """A context in which ``take`` gives its samples; it is the ``number``-th companion of a run, from 1 on.

    The numbers as they are written exceed ``values`` by ``rounding``.
    """

    def __init__(
        self, prepared: Prepared, values: Values, rounding: Values, times: Times, number: int
    ) -> None:
        program, factor = prepared.machine.program, FACTORS[number - 1]
        late = factor * rounding.times["start"]
        self._method = companion_of(prepared.follower, Beside(number, late))
        self._times, self._rows = times, program.state.motion.stop
        given, rest = (
            np.array([one.parameters[name] for name in program.parameters], float)
            for one in (values, rounding)
        )
        self._parameters = np.concatenate([given, factor / CONSTANTS * rest])
        state = np.array([*values.q, *values.v]) + factor * np.array([*rounding.q, *rounding.v])
        self._state = np.concatenate([state, np.zeros(len(program.integrals))])
        self._pieces: queue.Queue[Array | None] = queue.Queue(maxsize=1)
        self._rest = np.empty((self._rows, 0))
        self._over, self._halted = threading.Event(), threading.Event()

    def __enter__(self) -> Companion:
        self._work = Work(self._follow)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._over.set()
        if error is None:
            self._work.result()

    def _follow(self) -> End:
        """Integrate the motion, in a thread of its own."""

        def put(piece: Array | None) -> None:
            while not self._over.is_set():
                try:
                    self._pieces.put(piece, timeout=LOOK)
                    break
                except queue.Full:
                    pass

        try:
            return self._method.follow(
                self._parameters,
                self._state,
                self._times,
                lambda times, states: put(states[: self._rows].copy()),
                lambda t: self._over.is_set() or self._halted.is_set(),
            )
        finally:
            put(None)

    @property
    def cut(self) -> bool:
        """Whether it was interrupted."""
        return self._halted.is_set()

    def take(self, count: int, interrupted: Callable[[], bool]) -> Array:
        """Its next samples of q and v (rows, count), nan where it has none. If ``interrupted``, do not wait
        for them."""
        pieces, found = [self._rest], self._rest.shape[1]
        while found < count:
            try:
                piece = self._pieces.get(timeout=LOOK)
            except queue.Empty:
                if interrupted():
                    self._halted.set()
                continue
            if piece is None:
                self._pieces.put(None)  # for the next chunk
                pieces.append(np.full((self._rows, count - found), np.nan))
                break
            pieces.append(piece)
            found += piece.shape[1]
        joined = np.concatenate(pieces, axis=1)
        self._rest = joined[:, count:]
        return joined[:, :count]


def companion_of(method: Method, beside: Beside) -> Method:
    """The method of a companion of a run by the Taylor method, forward or backward."""
    if isinstance(method, Backward):
        return replace(method, method=companion_of(method.method, replace(beside, late=-beside.late)))
    assert isinstance(method, TaylorMethod)
    return replace(method, beside=beside)
