"""``Certificate``: an estimate of the error of every sample, from companions that follow the same motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from types import TracebackType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lagrange_cli.expression.vocabulary import family_name, velocity_name
from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.certify.companion import INPUTS, Companion
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.times import Times

if TYPE_CHECKING:
    from lagrange_cli.spec.values import Values

FOLDER = "diagnostics/error/"
"""The group of the estimates, in which q, v, multipliers and reactions have the places that they have in the
root."""
AS_RUN = FOLDER + "as_run/"
"""The group of those that count the inputs of the run as exact, likewise."""
MEMORY = 20
"""Earlier differences fade with this power of the time since the start: to an eighth when the time is a tenth
longer. So the estimate follows errors that shrink, as with friction."""
BEFORE = 1 / 32
"""The estimate is at least this part of the earlier differences, reduced in proportion if all of them are
smaller now: the error is not zero where motions cross by chance."""
APART = 0.25
"""Once the distance of motions exceeds this fraction of their size, it is no longer proportional to the
rounding errors of their inputs."""
SMALL = 0.1
"""The roundings of inputs prevail if the error without them is smaller than this part."""
STILL = 0.3
"""A motion has not left its start if its displacement is less than this fraction of that of another one."""
ROUND = 2.0**-52
"""The relative error of what is known but for rounding."""
FEW = 8
"""Estimates of rounding errors are so many times as large at most."""


class Certificate:
    """A context in which ``judge`` is given the samples of a run, chunk by chunk.

    ``errors`` holds {path: (c, *shape)} for the last chunk: estimates of the difference from the motion of
    the problem as it is ``written``, and as it is ``run``, with its inputs rounded to doubles. ``missed`` is
    the first sample time at which the former may exceed ``target``, for a coordinate relative to its largest
    value so far (None: there is none). ``rounded`` names the parameters, coordinates and velocities whose
    values are not exactly those that are written; ``prevailing``
    tells that their rounding limits the ``digits``, and ``staying`` that it makes a motion leave an
    equilibrium."""

    def __init__(
        self,
        companions: Sequence[Prepared],
        values: Values,
        rounding: Values,
        times: Times,
        digits: float,
        target: float | None,
    ) -> None:
        self._values = values
        self._companions = [
            Companion(one, values, rounding, times, 1 + i) for i, one in enumerate(companions)
        ]
        self._recording, self._times = companions[0].recording, times
        program = companions[0].machine.program
        self._state, self._observed = program.state.motion.stop, program.quantities
        self._rows = self._state + len(self._observed)
        self._vectors = [
            [
                self._state + self._observed.index(name)
                for name in made.sources[first : first + made.components]
            ]
            for made in self._recording.made
            if made.components
            for first in range(0, len(made.sources), made.components)
        ]
        """Rows of the components of each vector: a small one is rounded as coarsely as the others."""
        names = [*map(family_name, self._recording.coordinates)]
        numbers = {name: k for k, name in enumerate(dict.fromkeys(names))}
        self._families = np.array([numbers[one] for one in names], dtype=np.int64)
        """A number for each coordinate, the same for all of a family."""
        self._target = np.inf if target is None else target
        self._largest, self._apart = np.zeros((self._rows, 1)), np.zeros((self._rows, 1))
        self.written, self.run = (
            Estimate(self._rows, self._state, times.start, 10.0**-digits) for _ in range(2)
        )
        self.rounded = rounded_of(rounding, self._recording.coordinates)
        self.prevailing = self.staying = False
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

    def judge(
        self, times: Array, states: Array, observed: Mapping[str, Array], interrupted: Callable[[], bool]
    ) -> int:
        """Estimate the errors of samples at ``times`` (c,) with ``states`` (rows, c) and what is ``observed``
        there, rows (c,) by name; returns how many of them meet the target. If ``interrupted``, do not wait
        for companions; the other errors are unknown (inf)."""
        count = len(times)
        values = np.concatenate([states[: self._state], *(observed[name][None] for name in self._observed)])
        beside = [companion.take(count, interrupted) for companion in self._companions]
        with np.errstate(all="ignore"):
            self._largest, largest = running(self._largest, np.abs(values))
            for rows in self._vectors:
                largest[rows] = np.max(largest[rows], axis=0)
            ages = ((times - self._times.start) / (self._times.stop - self._times.start)) ** MEMORY
            typical = typical_difference([values, *beside])
            self._apart, apart = running(self._apart, np.nan_to_num(typical / largest, nan=0.0))
            own, shown = differences(values, beside), np.where(apart < APART, typical / INPUTS, typical)
            as_run = self.run.of(own, typical, ages, largest)
            estimates = self.written.of(np.maximum(own, shown), typical, ages, largest)
            half = self._state // 2
            relative, relative_as_run = (self._relative(one, largest) for one in (estimates, as_run))
        kept = first(~(relative <= self._target), count)
        if kept < count and not self.cut:
            self.missed = float(times[kept])
        lost = self.written.judge(times[:kept], relative[:kept])
        self.run.judge(times[:kept], relative_as_run[:kept])
        if lost is not None and relative_as_run[lost] < SMALL * relative[lost]:
            self.prevailing, as_written = True, values + (beside[0] - values) / INPUTS
            self.staying = self._stays(as_written[:half, lost], values[:half, lost])
        self.errors = {
            folder + path: samples
            for folder, rows in ((FOLDER, estimates), (AS_RUN, as_run))
            for path, samples in self._series(rows[:, :kept]).items()
        }
        return kept

    def _series(self, rows: Array) -> dict[str, Array]:
        """Estimates of the rows as datasets by path."""
        observed = dict(zip(self._observed, rows[self._state :]))
        return self._recording.series(rows[: self._state], (), observed, {})

    def _stays(self, written: Array, run: Array) -> bool:
        """Whether the motion as written is still at its start, at rest, and that of the run is not."""
        begin = np.array(self._values.q)
        found = np.max(np.abs(written - begin)) < STILL * np.max(np.abs(run - begin))
        return bool(found) and not any(self._values.v)

    def _relative(self, estimates: Array, largest: Array) -> Array:
        """The largest error of a coordinate (c,), relative to its largest value so far."""
        half = self._state // 2
        found: Array = np.max(relative(estimates[:half], largest[:half], self._families), axis=0)
        return found


def relative(errors: Array, sizes: Array, families: NDArray[np.int64]) -> Array:
    """Errors (rows, c) relative to ``sizes``; 1 where that is 0 and the error is not.

    An error below the rounding of the largest member of a family is rounding, too: other members may be 0 but
    for that, such as those that constraints keep there, or that begin in the node of a wave. Of what is
    itself at most ``FEW`` roundings, so are errors of as many. ``families`` has a number for each row.
    """
    most = np.zeros((np.max(families, initial=-1) + 1, sizes.shape[1]))
    np.maximum.at(most, families, sizes)
    with np.errstate(all="ignore"):
        found = np.where(sizes > 0, errors / sizes, errors > np.spacing(0.0))
    unit = np.spacing(most[families])
    hidden = (errors <= unit) | (np.maximum(errors, sizes) <= FEW * unit)
    hidden &= sizes < most[families]
    return np.where(hidden, np.fmin(found, ROUND), found)


class Estimate:
    """An estimate for each of so many ``rows``, which remembers earlier differences. The first of them are
    those of the ``state``.

    ``trusted_until`` is the last sample time, from ``start`` on, up to which the error of a coordinate
    relative to its largest value so far is at most ``wanted``, and ``error`` the largest one at the last
    sample."""

    def __init__(self, rows: int, state: int, start: float, wanted: float) -> None:
        self._state = state
        self._differences, self._largest = np.zeros((rows, 1)), np.zeros((rows, 1))
        self._wanted, self._trusting = wanted, True
        self.trusted_until, self.error = start, 0.0

    def judge(self, times: Array, relative: Array) -> int | None:
        """Record relative errors (c,) at ``times``; returns the first sample that cannot be trusted."""
        count, trusting = len(times), self._trusting
        trusted = first(~(relative <= self._wanted), count) if trusting else 0
        if trusted:
            self.trusted_until = float(times[trusted - 1])
        self._trusting = self._trusting and trusted == count
        if count:
            self.error = float(relative[-1])
        return trusted if trusting and trusted < count else None

    def of(self, differences: Array, typical: Array, ages: Array, largest: Array) -> Array:
        """The estimates for samples with such differences (rows, c) from what is compared with them: no
        smaller than earlier ones, as far as the ``typical`` difference is not either."""
        weighted = np.where(ages > 0, differences * ages, 0)
        self._differences, weighted = running(self._differences, weighted)
        self._largest, most = running(self._largest, differences)
        before = weighted / ages
        state = slice(self._state)
        now = np.fmax.reduce(np.where(before > 0, differences / before, 0)[state], axis=0)
        found: Array = np.fmax.reduce(
            [BEFORE * now * before, np.fmin(typical, most), differences, np.spacing(largest)]
        )
        return found


def differences(run: Array, beside: Sequence[Array]) -> Array:
    """The distance of a run from its last companion, which has the same inputs if there is more than one; inf
    where that has no sample."""
    found = np.abs(run - beside[-1])
    found[np.isnan(found)] = np.inf
    return found


def typical_difference(motions: Sequence[Array]) -> Array:
    """The distance of two motions (rows, c), or the median of the three distances of three. The median is not
    small just because two motions meet by chance or have the same rounding errors. It is inf where a
    companion has no sample."""
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


def rounded_of(rounding: Values, coordinates: Sequence[str]) -> tuple[str, ...]:
    """The names of values that are not 0."""
    velocities = map(velocity_name, coordinates)
    named = [*rounding.parameters.items(), *zip(coordinates, rounding.q), *zip(velocities, rounding.v)]
    return tuple(name for name, value in named if value)
