"""Samples of the state, made into the datasets of the output.

Samples of double-double numbers give every dataset twice: the nearest doubles, and the remainders under
``low/``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.integrate.arrays import Array, aligned, with_modes
from lagrange_cli.integrate.checkpoint import Progress
from lagrange_cli.integrate.events import Change, parameters_in
from lagrange_cli.integrate.methods.table import METHODS
from lagrange_cli.native.interface import low
from lagrange_cli.outputs.recording import Making, ObservedPlaces, Rows
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from lagrange_cli.integrate.ending import State
    from lagrange_cli.integrate.method import Snapshot
    from lagrange_cli.integrate.prepared import Prepared

    Judge = Callable[[Mapping[str, Array]], int]

LOW = "low/"
H = "h", low("h")
EARLY, RARELY = 4096, 256
"""The size of h's terms is taken from each of the first ``EARLY`` samples, then from every ``RARELY``-th."""


def largest(*changes: float) -> float:
    """The largest of changes of a quantity: infinite where it has no finite value."""
    return math.inf if any(map(math.isnan, changes)) else max(changes)


def first_unknown(samples: Array) -> int | None:
    """The place of the first sample (c, ...) that is not finite."""
    if np.isfinite(samples).all():
        return None
    return int(np.argmin(np.isfinite(samples).reshape(len(samples), -1).all(axis=1)))


def samples_of(prepared: Prepared) -> type[Samples]:
    """The class that makes datasets of numbers with that many parts."""
    return Samples if prepared.machine.program.parts == 1 else DoubleDoubleSamples


class Samples:
    """Turns states into the datasets of the plan, and records the drift of the conserved quantities. Emitted
    arrays are valid until the next call of ``emit``.
    """

    def __init__(
        self, prepared: Prepared, parameters: Array, emit: Callable[[dict[str, Array]], None]
    ) -> None:
        self._prepared, self._emit = prepared, emit
        self._constants = aligned(max(1, prepared.machine.program.constants))
        self._prepare(parameters)
        self._wide = self._other = np.empty((0, 0))
        self._first: dict[str, float] = {}
        """The observed quantities at the start."""
        self._base: dict[str, float] = {}
        """The same, and what actions have added to it."""
        self.balances = any(one.making is Making.BALANCE for one in prepared.recording.made)
        """Whether actions change what is written beside the state."""
        self._places = ObservedPlaces(prepared.machine.program.quantities)
        momenta = tuple(f"p_{name}" for name in prepared.recording.coordinates)
        self._momenta = momenta if self._places.keys() >= set(momenta) else None
        """The names of all momenta, if they are observed."""
        self._changes: list[Change] = []
        """Changes by actions that no sample follows yet."""
        self._done = 0
        self._drift = dict.fromkeys(prepared.recording.conserved, 0.0)
        self._size, self._count = 0.0, 0
        self._last = np.empty(0), np.empty((0, 0))
        self.final: State | None = None
        """The last sample, once there is one."""
        self.unknown: dict[str, float] = {}
        """The datasets with samples that are not finite, and the time of the first of these."""
        self.extent = 0.0
        """The largest coordinate or velocity, of a method whose errors are ``absolute``."""
        self._absolute = METHODS[prepared.compilation.method].absolute

    def change(self, change: Change) -> None:
        """Record the changes of an action, before the samples that follow it."""
        if self.balances or not np.array_equal(*change.parameters):
            self._changes.append(change)

    def accept(self, times: Array, states: Array, judge: Judge | None = None) -> int:
        """Compute, emit and forget one chunk: times (c,), states (rows, c). Returns how many of its samples
        were emitted: all, or as many as ``judge`` says, which is given what is observed."""
        if not len(times):
            return 0
        program, recording = self._prepared.machine.program, self._prepared.recording
        observed, base = self.observe(times, states)
        if judge is not None:
            count = judge(observed)
            if not count:
                return 0
            times, states = times[:count], states[:, :count]
            observed = observed.until(count)
            base = {name: x if isinstance(x, float) else x[:count] for name, x in base.items()}
        for name, drift in self._drift.items():
            row, first = observed[name], self._first[name]
            self._drift[name] = largest(drift, float(np.max(row)) - first, first - float(np.min(row)))
        self._measure(observed, states)
        if self._absolute:
            self.extent = max(self.extent, float(np.max(np.abs(states[program.state.motion]), initial=0.0)))
        series = recording.series(states, program.integrals, observed, base)
        self._emit({"t": times, **self._looked_through(times, series)})
        return len(times)

    def _looked_through(self, times: Array, series: Mapping[str, Array]) -> dict[str, Array]:
        """The datasets, of which those with samples that are not finite are noted: where these are nan, it is
        always the same one. Its sign depends on the code that computes it, as of a run that is continued."""
        looked = dict(series)
        for path, found in series.items():
            first = first_unknown(found)
            if first is not None:
                if not path.startswith(LOW):
                    self.unknown.setdefault(path, float(times[first]))
                looked[path] = np.where(np.isnan(found), np.nan, found)
        return looked

    def _prepare(self, parameters: Array) -> None:
        given = with_modes(self._prepared.machine.program, parameters)
        self._prepared.machine.prepare(given.ctypes.data, self._constants.ctypes.data)

    def _apply(self, changes: Iterable[Change]) -> None:
        """Add the changes of actions to the initial values of the balances."""
        for one in changes:
            values, same = [], bool(np.array_equal(*one.parameters))
            for parameters, state in zip(one.parameters, (one.before, one.after)):
                if not same:
                    self._prepare(parameters)
                found = np.empty((len(self._prepared.machine.program.quantities), 1))
                self._compute(np.array([one.t]), state[:, None], found, 1)
                values.append(dict(zip(self._prepared.machine.program.quantities, found[:, 0].tolist())))
            self._add(*values)

    def _add(self, before: Mapping[str, float], after: Mapping[str, float]) -> None:
        """Add the change of each quantity to the initial value of its balance."""
        for name in self._base:
            self._base[name] += after[name] - before[name]

    def _measure(self, observed: Rows, states: Array) -> None:
        """Update the size of h's terms from the first samples and some of the others, which do not depend on
        the chunks. Does nothing if the momenta are not observed."""
        layout = self._prepared.machine.program.state
        if "h" not in self._drift or self._momenta is None:
            return
        before, count = self._count, states.shape[1]
        self._count += count
        early = min(max(0, EARLY - before), count)
        for part in (slice(early), slice(early + -(before + early) % RARELY, None, RARELY)):
            momenta, velocities = observed.block(self._momenta)[:, part], states[layout.v, part]
            with np.errstate(over="ignore", invalid="ignore"):
                terms = np.add.accumulate(np.abs(momenta * velocities))[-1]
            sizes = np.maximum(np.abs(observed["h"][part]), terms)
            self._size = float(np.max(sizes, initial=self._size))

    def observe(self, times: Array, states: Array) -> tuple[Rows, Mapping[str, Any]]:
        """The observed quantities, and the initial value of each balance: a number, or one for each
        sample."""
        names, count = self._prepared.machine.program.quantities, len(times)
        self._last = times[-1:].copy(), states[:, -1:].copy()
        states = states if states.strides[1] == 8 else np.ascontiguousarray(states)
        stride = states.strides[0] // 8
        self._wide, self._other = self._other, self._wide
        if self._wide.shape[1] != stride:  # reused: new memory costs as much as the computation
            self._wide = np.empty((len(names), stride))
        wide, begin = self._wide, self._done
        bases: list[dict[str, float]] = []
        lengths: list[int] = []
        self._done += count
        now = [one for one in self._changes if one.sample < self._done]
        self._changes = self._changes[len(now) :]
        places = [max(0, one.sample - begin) for one in now]
        for i, (start, stop) in enumerate(zip([0, *places], [*places, count])):
            self._apply(now[i - 1 : i] if i else ())
            if stop == start:
                continue
            self._compute(times[start:stop], states[:, start:], wide[:, start:], stride)
            if not self._first:
                self._first = dict(zip(names, wide[:, 0].tolist()))
                self._base = self._first.copy()
            if now:
                bases.append(self._base.copy())
                lengths.append(stop - start)
        observed = Rows(self._places, wide[:, :count])
        if not now:
            return observed, self._base
        return observed, {name: np.repeat([base[name] for base in bases], lengths) for name in names}

    def _compute(self, times: Array, states: Array, results: Array, stride: int) -> None:
        """The observed quantities at times (c,) of states whose rows, like those of the ``results``, are
        ``stride`` apart."""
        machine = self._prepared.machine
        if machine.program.quantities:
            machine.observe(
                self._constants.ctypes.data, np.ascontiguousarray(times).ctypes.data, states.ctypes.data,
                results.ctypes.data, stride, len(times),
            )  # fmt: skip

    def progress(self, snapshot: Snapshot) -> Progress:
        """The progress of the run when the method is at ``snapshot``."""
        self._apply(self._changes)
        self._changes = []
        first, base = dict(self._first), {} if self._base == self._first else dict(self._base)
        found = Progress(snapshot, first, dict(self._drift), self._size, self.final, base=base)
        return replace(found, unknown=dict(self.unknown), extent=self.extent)

    def restore(self, progress: Progress) -> Snapshot:
        """Continue from the progress of another run."""
        self._first, self._drift = dict(progress.first), dict(progress.drift)
        self._base = {**self._first, **progress.base}
        self._size, self._count = progress.size, progress.snapshot.samples
        self.final, self._done = progress.final, progress.snapshot.samples
        self.unknown, self.extent = dict(progress.unknown), progress.extent
        program, memory = self._prepared.machine.program, progress.snapshot.memory
        if program.changed:
            self._prepare(parameters_in(program, memory))
        return progress.snapshot

    def drifts(self) -> tuple[float | None, dict[str, float]]:
        """max |x - x(0)| for h (None where it is not conserved or not computed) and for each conserved
        p_k."""
        momenta = {name.removeprefix("p_"): drift for name, drift in self._drift.items() if name != "h"}
        return self._drift.get("h"), momenta

    @property
    def size(self) -> float:
        """How large |h| and sum |p_k q_dot_k| have been, which tells whether a drift of h is rounding; else
        0."""
        return self._size

    def rounding(self) -> float:
        """By how much h changes where coordinates and velocities of the last sample do by rounding; 0 if it
        is not known."""
        from lagrange_cli.integrate.rounding import change_of, rounded_otherwise

        program = self._prepared.machine.program
        if not len(self._last[0]) or "h" not in program.quantities:
            return 0.0
        states = rounded_otherwise(self._last[1], program)
        found = np.empty((len(program.quantities), states.shape[1]))
        self._compute(np.repeat(self._last[0], states.shape[1]), states, found, states.shape[1])
        return change_of([row for name, row in zip(program.quantities, found) if name in H])


@dataclass(frozen=True)
class DoubleDouble:
    """Numbers, each the sum of two doubles (c,) or of two for all."""

    high: Array
    low: Array

    def __add__(self, other: DoubleDouble) -> DoubleDouble:
        from lagrange_cli.native.numbers.error_free import two_sum

        high, error = two_sum(self.high, other.high)
        low, rest = two_sum(self.low, other.low)
        high, error = two_sum(high, error + low)
        return DoubleDouble(*two_sum(high, error + rest))

    def __sub__(self, other: DoubleDouble) -> DoubleDouble:
        return self + DoubleDouble(-other.high, -other.low)


class DoubleDoubleSamples(Samples):
    """``Samples`` for states (2 rows, c) whose low parts follow all high ones."""

    def accept(self, times: Array, states: Array, judge: Judge | None = None) -> int:
        assert judge is None
        if not len(times):
            return 0
        program, recording = self._prepared.machine.program, self._prepared.recording
        flat, beginnings = self.observe(times, states)
        observed, first, base = (
            {name: DoubleDouble(*map(np.asarray, (rows[name], rows[low(name)]))) for name in program.observed}
            for rows in (flat, self._first, beginnings)
        )
        with np.errstate(invalid="ignore"):
            for name, drift in self._drift.items():
                change = float(np.max(np.abs((observed[name] - first[name]).high)))
                self._drift[name] = largest(drift, change)
        self._measure(flat, states)
        high, beyond = np.split(states, [program.rows])
        integrals = program.state.integrals
        parts = zip(program.integrals, high[integrals], beyond[integrals])
        quadratures = {name: DoubleDouble(part, rest) for name, part, rest in parts}
        chunk: dict[str, Any] = {"t": times}
        for prefix, part in (("", high), (LOW, beyond)):
            chunk |= {prefix + path: row for path, row in recording.state_series(part).items()}
        for made in recording.made:
            rows = made.parts(observed, quadratures, base)
            chunk[made.path] = made.shaped([row.high for row in rows])
            chunk[LOW + made.path] = made.shaped([row.low for row in rows])
        both = {path: chunk[path] for one in recording.made for path in (one.path, LOW + one.path)}
        self._emit(chunk | self._looked_through(times, both))
        return len(times)

    def _add(self, before: Mapping[str, float], after: Mapping[str, float]) -> None:
        for name in self._prepared.machine.program.observed if self._base else ():
            base, old, new = (
                DoubleDouble(np.array(rows[name]), np.array(rows[low(name)]))
                for rows in (self._base, before, after)
            )
            total = base + (new - old)
            self._base[name], self._base[low(name)] = float(total.high), float(total.low)
