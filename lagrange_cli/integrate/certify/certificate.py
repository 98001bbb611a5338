"""``Certificate``: an estimate of the error of every sample, from companions that follow the same motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from types import TracebackType
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.certify.companion import Companion
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.times import Times

if TYPE_CHECKING:
    from lagrange_cli.spec.values import Values

FOLDER = "diagnostics/error/"
"""The group of the estimates, in which q and v have the places that they have in the root."""
MEMORY = 20
"""Earlier differences fade with this power of the time since the start: to an eighth when the time is a tenth
longer. So the estimate follows errors that shrink, as with friction."""
BEFORE = 1 / 32
"""The estimate is at least this part of the earlier differences, reduced in proportion if all of them are
smaller now: the error is not zero where motions cross by chance."""


class Certificate:
    """A context in which ``judge`` is given the samples of a run, chunk by chunk.

    ``errors`` holds {path: (c, *shape)} for the last chunk. ``trusted_until`` is the last sample time up to
    which each coordinate q_k has ``digits`` correct digits, relative to the largest |q_k| so far. ``missed``
    is the first sample time at which an error may exceed ``target``, on the same scale (None: there is none),
    and ``error`` the largest error of any coordinate at the last sample, likewise."""

    def __init__(
        self,
        companions: Sequence[Prepared],
        values: Values,
        times: Times,
        digits: float,
        target: float | None,
    ) -> None:
        self._companions = [Companion(one, values, times, 1 + i) for i, one in enumerate(companions)]
        self._recording, self._times = companions[0].recording, times
        self._rows = companions[0].machine.program.state.motion.stop
        self._wanted, self._target = 10.0**-digits, np.inf if target is None else target
        self._largest, self._differences = np.zeros((self._rows, 1)), np.zeros((self._rows, 1))
        self._trusting = True
        self.trusted_until = times.start
        self.error = 0.0
        self.missed: float | None = None
        self.errors: dict[str, Array] = {}

    def __enter__(self) -> Certificate:
        with ExitStack() as stack:
            for companion in self._companions:
                stack.enter_context(companion)
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.__exit__(kind, error, trace)

    @property
    def cut(self) -> bool:
        """Whether a companion was interrupted."""
        return any(companion.cut for companion in self._companions)

    def judge(self, times: Array, states: Array, interrupted: Callable[[], bool]) -> int:
        """Estimate the errors of samples at ``times`` (c,) with ``states`` (rows, c); returns how many of
        them meet the target. If ``interrupted``, do not wait for companions; the other errors are unknown
        (inf)."""
        count = len(times)
        values = states[: self._rows]
        beside = [companion.take(count, interrupted) for companion in self._companions]
        with np.errstate(all="ignore"):
            differences = typical_difference([values, *beside])
            self._largest, largest = running(self._largest, np.abs(values))
            ages = ((times - self._times.start) / (self._times.stop - self._times.start)) ** MEMORY
            weighted = np.where(ages > 0, differences * ages, 0)
            self._differences, weighted = running(self._differences, weighted)
            before = weighted / ages
            now = np.fmax.reduce(np.where(before > 0, differences / before, 0), axis=0)
            estimates = np.fmax(np.fmax(BEFORE * now * before, differences), np.spacing(largest))
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
        series = self._recording.series(estimates[:, :kept], (), {}, {})
        self.errors = {FOLDER + path: samples for path, samples in series.items()}
        return kept


def typical_difference(motions: Sequence[Array]) -> Array:
    """The distance of two motions (rows, c), or the middle one of the three distances of three.

    The middle one is not small just because two motions meet by chance or have the same rounding errors. It
    is inf where a companion has no sample."""
    run, beside, *others = motions
    pairs = [(run, beside), *((one, other) for one in others for other in (run, beside))]
    distances = [np.abs(one - other) for one, other in pairs]
    for distance in distances:
        distance[np.isnan(distance)] = np.inf
    if not others:
        return distances[0]
    a, b, c = distances
    return np.maximum(np.minimum(a, b), np.minimum(np.maximum(a, b), c))


def running(before: Array, values: Array) -> tuple[Array, Array]:
    """The running maximum of ``values`` (rows, c): at the end (rows, 1), and at each sample."""
    found = np.maximum.accumulate(np.concatenate([before, values], axis=1), axis=1)
    return found[:, -1:].copy(), found[:, 1:]


def first(flags: np.ndarray, otherwise: int) -> int:
    """The index of the first true value."""
    return int(np.argmax(flags)) if flags.any() else otherwise
