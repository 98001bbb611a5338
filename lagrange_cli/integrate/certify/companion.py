"""``Companion``: the same motion integrated with another order, and therefore with other steps and rounding
errors; and with inputs that are rounded differently (see ``native.numbers.beside``)."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.background import Work
from lagrange_cli.integrate.event_log import EventLog
from lagrange_cli.integrate.method import End, Method, Observer, Start
from lagrange_cli.integrate.methods.backward import Backward
from lagrange_cli.integrate.methods.compiled import Beside
from lagrange_cli.integrate.methods.taylor import TaylorMethod
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.samples import Samples
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.interface import CONSTANTS
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.spec.values import Values

INPUTS = 8
"""How much larger the rounding errors of inputs are in one of the companions than in the run."""
FACTORS = INPUTS, 0
"""What they are multiplied by in each companion; 0 for one that has the inputs of the run."""
UNITS = 1.0, -1.0, 2.0, -2.0, 3.0
"""Units in the last place by which numbers of a state are changed where outputs are observed: others for
neighbours, whose differences change with them."""
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
        self._motion = program.state.motion
        self._rows = program.state.motion.stop + len(program.quantities)
        given, rest = (
            np.array([one.parameters[name] for name in program.parameters], float)
            for one in (values, rounding)
        )
        parameters = np.concatenate([given, factor / CONSTANTS * rest])
        state = np.array([*values.q, *values.v]) + factor * np.array([*rounding.q, *rounding.v])
        state = np.concatenate([state, np.zeros(len(program.integrals))])
        self._start = Start(parameters, state, times)
        self._samples = Samples(prepared, parameters, lambda chunk: None)
        self._log = EventLog(prepared, self._samples, lambda chunk: None)
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

        def accept(times: Array, states: Array) -> None:
            self._log.hand_over()
            if len(times):
                observed, _ = self._samples.observe(times, nudged(states, self._motion))
                put(np.concatenate([states[self._motion], *(row[None] for row in observed.values())]))

        def put(piece: Array | None) -> None:
            while not self._over.is_set():
                try:
                    self._pieces.put(piece, timeout=LOOK)
                    break
                except queue.Full:
                    pass

        try:
            observer = Observer(accept, lambda t: self._over.is_set() or self._halted.is_set(), self._log)
            return self._method.follow(self._start, observer)
        finally:
            put(None)

    @property
    def cut(self) -> bool:
        """Whether it was interrupted."""
        return self._halted.is_set()

    def take(self, count: int, interrupted: Callable[[], bool]) -> Array:
        """Its next samples of q, v and what it observes (rows, count), nan where it has none. If
        ``interrupted``, do not wait for them."""
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


def nudged(states: Array, motion: slice) -> Array:
    """States (rows, c) with each number of ``motion`` some units in the last place away: so quantities
    observed there are rounded differently than in a run with the same state."""
    found: Array = states.copy()
    units = np.resize(UNITS, found[motion].shape[0])
    found[motion] += units[:, None] * np.spacing(np.abs(found[motion]))
    return found


def companion_of(method: Method, beside: Beside) -> Method:
    """The method of a companion of a run by the Taylor method, forward or backward."""
    if isinstance(method, Backward):
        return replace(method, method=companion_of(method.method, replace(beside, late=-beside.late)))
    assert isinstance(method, TaylorMethod)
    return replace(method, beside=beside)
