"""``Certificate``: an estimate of the error of every sample, from a companion that follows the same motion
with another order, and so with other steps and other roundings."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.alongside import Work
from lagrange_cli.integrate.motion import Array, End
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.taylor import TaylorMethod
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.spec.values import Values

FOLDER = "diagnostics/error/"
"""Where the estimates are written, in the places that q and v have in the root."""
MEMORY = 20
"""A difference counts for less with time, as this power of the time since the start: to an eighth when a
tenth more has passed. So errors that shrink, as friction makes them, are seen to shrink."""
NOW, BEFORE = 3.0, 0.25
"""The estimate is so many times the difference, and at least this part of the differences before: where two
motions cross each other, the error is not zero. (Fitted to the systems of ``benchmarks.certified``.)"""
LOOK = 0.5
"""Seconds between two looks at whether the other side is still there."""


class Certificate:
    """A context in which ``judge`` is given the samples of a run, chunk by chunk.

    ``errors`` holds {path: (c, *shape)} for the chunk judged last. ``trusted_until`` is the last sample time
    up to which each coordinate q_k is known to ``digits`` digits of the largest |q_k| so far, ``missed`` the
    first one at which an error may exceed ``target``, measured in the same way (None: there is none), and
    ``error`` the largest error of any coordinate at the last sample, likewise.
    """

    def __init__(
        self, companion: Prepared, values: Values, times: Times, digits: float, target: float | None
    ) -> None:
        program = companion.machine.program
        assert isinstance(companion.follower, TaylorMethod)
        self._method = replace(companion.follower, beside=True)
        self._companion, self._times, self._rows = companion, times, 2 * program.degrees
        self._parameters = np.array([values.parameters[name] for name in program.parameters])
        self._state = np.concatenate([values.q, values.v, np.zeros(len(program.integrals))])
        self._wanted, self._target = 10.0**-digits, np.inf if target is None else target
        self._pieces: queue.Queue[Array | None] = queue.Queue(maxsize=1)
        self._rest = np.empty((self._rows, 0))
        self._over, self._halted = threading.Event(), threading.Event()
        self._largest, self._differences = np.zeros((self._rows, 1)), np.zeros((self._rows, 1))
        self._trusting = True
        self.trusted_until = times.start
        self.error = 0.0
        self.missed: float | None = None
        self.errors: dict[str, Array] = {}

    def __enter__(self) -> Certificate:
        self._work = Work(self._follow)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._over.set()
        if error is None:
            self._work.result()

    def _follow(self) -> End:
        """The companion's way, in a thread of its own."""

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
        """Whether the companion was interrupted."""
        return self._halted.is_set()

    def judge(self, times: Array, states: Array, interrupted: Callable[[], bool]) -> int:
        """Estimate the errors of samples at ``times`` (c,) with ``states`` (rows, c); how many of them meet
        the target. Where ``interrupted``, the companion is not waited for, and the rest not known (inf)."""
        count = len(times)
        values = states[: self._rows]
        with np.errstate(all="ignore"):
            differences = np.abs(values - self._beside(count, interrupted))
            differences[np.isnan(differences)] = np.inf
            self._largest, largest = running(self._largest, np.abs(values))
            ages = ((times - self._times.start) / (self._times.stop - self._times.start)) ** MEMORY
            weighted = np.where(ages > 0, differences * ages, 0)
            self._differences, weighted = running(self._differences, weighted)
            estimates = np.fmax(np.fmax(BEFORE * weighted / ages, NOW * differences), np.spacing(largest))
            half = self._rows // 2
            relative = np.max(estimates[:half] / largest[:half], axis=0, where=largest[:half] > 0, initial=0)
        kept = first(~(relative <= self._target), count)
        if kept < count and not self.cut:
            self.missed = float(times[kept])
        trusted = first(~(relative[:kept] <= self._wanted), kept) if self._trusting else 0
        if trusted:
            self.trusted_until = float(times[trusted - 1])
        self._trusting = self._trusting and trusted == count
        if kept:
            self.error = float(relative[kept - 1])
        series = self._companion.recording.series(estimates[:, :kept], (), {}, {})
        self.errors = {FOLDER + path: samples for path, samples in series.items()}
        return kept

    def _beside(self, count: int, interrupted: Callable[[], bool]) -> Array:
        """The companion's next samples (rows, count): nan where it has none."""
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


def running(before: Array, values: Array) -> tuple[Array, Array]:
    """The largest of ``values`` (rows, c) so far, at the end (rows, 1) and at each of them."""
    found = np.maximum.accumulate(np.concatenate([before, values], axis=1), axis=1)
    return found[:, -1:].copy(), found[:, 1:]


def first(flags: np.ndarray, otherwise: int) -> int:
    """The index of the first that is true."""
    return int(np.argmax(flags)) if flags.any() else otherwise
