"""From the ends, or the samples, of many motions to the datasets of the output."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from itertools import repeat
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange_cli.integrate.arrays import Array, aligned, with_modes
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.ensemble.method import EndedMembers, Section
from lagrange_cli.integrate.ensemble.outcome import ENDINGS, STATUS, UNFINISHED, EnsembleOutcome
from lagrange_cli.integrate.events import Change, Happened
from lagrange_cli.integrate.method import Cause, End
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.run import sentence
from lagrange_cli.integrate.samples import LOW, Samples, first_unknown, samples_of
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.native.compilation.machine import Machine

    Index = NDArray[np.int64]
    Emit = Callable[[Index, dict[str, Any]], None]
    Explain = Callable[[int, End], Cause | None]

MEMORY = 16 * 2**20
"""Bytes of initial values that are laid out at a time, and of ended members that are written at a time."""
OFTEN = 1.0
"""Seconds after which ended members are written, however few they are."""
LOW_TIME = f"{LOW}t"
"""The low parts of the times of a section."""


def unexplained(member: int, end: End) -> Cause | None:
    """No reason for the end of a member's motion is known."""
    return None


def accelerations(machine: Machine, parameters: Array, t: float, state: Array) -> Array:
    """Those of the coordinates where a motion ended; none where it did not begin."""
    from lagrange_cli.integrate.guards.one_state import space_at

    if not np.all(np.isfinite(state)):
        return np.zeros(0)
    return space_at(machine, parameters, t, state).rates()[: machine.program.degrees]


class EnsembleDatasets:
    """Gathers members that have ended and turns them into datasets, some megabytes at a time."""

    def __init__(
        self,
        prepared: Prepared,
        times: Times,
        emit: Emit,
        *,
        sampled: bool,
        members: int,
        section: Section | None = None,
        chosen: NDArray[np.bool_] | None = None,
        explain: Explain = unexplained,
    ) -> None:
        self._explain = explain
        self._chosen = np.ones(members, dtype=np.bool_) if chosen is None else chosen
        """Members that are not ``chosen`` are left to others."""
        self._prepared, self._machine, self._recording = prepared, prepared.machine, prepared.recording
        self._start, self._emit = times.start, emit
        self._times = times.chunk(0, times.count) if sampled else None
        self._section = section
        self._alone, self._partial = section is not None and members == 1, False
        """Whether the motion is the only one: then crossings are kept where it is interrupted, too; and
        whether it was."""
        self._count = times.count if sampled else None if section is None else section.count
        """The samples of each motion."""
        self._endings = np.full(members, UNFINISHED, dtype=np.int8)
        self._failed: tuple[int, str] | None = None
        self._steps = 0
        self._drift = dict.fromkeys(prepared.recording.conserved, np.nan)
        self._unknown: dict[str, tuple[int, float]] = {}
        self._doubtful: dict[str, tuple[int, Happened]] = {}
        width = prepared.machine.program.rows + 2 * len(prepared.machine.program.observed)
        self._most = max(1, MEMORY // (8 * width * (self._count or 1)))

    def restore(self, outcome: EnsembleOutcome) -> None:
        """Continue where another run has stopped."""
        self._endings, self._failed, self._steps = outcome.endings, outcome.failed, outcome.steps
        self._unknown, self._doubtful = dict(outcome.unknown), dict(outcome.doubtful)
        drifts = {f"p_{name}": drift for name, drift in outcome.p_drift.items()}
        drifts |= {} if outcome.h_drift is None else {"h": outcome.h_drift}
        self._drift = {name: drifts.get(name, np.nan) for name in self._drift}

    def open(self, first: int, parameters: Array, states: Array) -> None:
        """Go on with the members from ``first``: their parameters (b, P) and states (b, rows)."""
        self._first, self._parameters, self._states = first, parameters, states
        self._missing = self.missing()
        self._batches: list[EndedMembers] = []
        self._gathered, self._due = 0, time.monotonic() + OFTEN

    def refuse(self, members: Sequence[int]) -> None:
        """Record members that do not begin, as their initial values do not satisfy the constraints."""
        index = np.intersect1d(np.array(members, dtype=np.int64) - self._first, self._missing)
        if len(index):
            batch = self._unfinished(index, Ending.INCONSISTENT)
            self._note(batch)
            self._write(batch)
            self._missing = self.missing()

    def missing(self) -> Index:
        """Those of the members from ``first`` that have not ended, counted from there."""
        unfinished = self._chosen & (self._endings == UNFINISHED)
        return np.flatnonzero(unfinished[self._first :][: len(self._states)])

    def accept(self, batch: EndedMembers) -> None:
        """Take members that have ended, counted among those that were missing at the beginning."""
        self._batches.append(replace(batch, index=self._missing[batch.index]))
        self._gathered += len(batch.index)
        if self._gathered >= self._most or time.monotonic() >= self._due:
            self.flush()

    def close(self) -> None:
        """Write the remaining members, with nan for those that have not ended."""
        self.flush()
        missing = self.missing()[: 0 if self._partial else None]
        for start in range(0, len(missing), self._most):
            self._write(self._unfinished(missing[start : start + self._most], Ending.INTERRUPTED))

    def _unfinished(self, index: Index, ending: Ending) -> EndedMembers:
        section = self._section is not None
        return EndedMembers.unfinished(index, ending, self._states.shape[1], self._count, section)

    def flush(self) -> None:
        """Write the members that have ended."""
        self._due = time.monotonic() + OFTEN
        if self._batches:
            batch = EndedMembers.joined(self._batches, self._alone)
            self._partial |= Ending.INTERRUPTED in batch.ending
            self._batches, self._gathered = [], 0
            if len(batch.index):
                self._note(batch)
                self._write(batch)

    def _note(self, batch: EndedMembers) -> None:
        """Keep how members ended."""
        index = batch.index + self._first
        self._endings[index] = [ENDINGS.index(ending) for ending in batch.ending]
        self._steps += int(batch.steps.sum())
        for member, ending, t, state in zip(index, batch.ending, batch.t, batch.state):
            if ending.status == "failed" and (self._failed is None or member < self._failed[0]):
                given = self._parameters[member - self._first], float(t), state
                end = End(ending, *given[1:], 0, 0, accelerations=accelerations(self._machine, *given))
                end = replace(end, cause=self._explain(int(member), end))
                self._failed = int(member), sentence(end, self._recording.coordinates, self._start)

    def _write(self, batch: EndedMembers) -> None:
        """Make datasets of members that have ended, and emit them."""
        if self._machine.program.parts > 1:
            self._write_exact(batch)
            return
        program, count = self._machine.program, len(batch.index)
        names, parameters = program.observed, self._parameters[batch.index]
        starts = self._states[batch.index, :, None]
        first = self._observe(parameters, np.array([self._start]), starts)
        times: Array | None
        if batch.samples is None:
            states, times = batch.state[:, :, None], batch.t[:, None]
        else:
            times = self._times if batch.times is None else batch.times
            states = batch.samples
        assert times is not None
        observed, n = self._observe(parameters, times, states), states.shape[2]
        first = np.repeat(first, n, axis=2)
        for k, log in enumerate(batch.logs):
            if log.changes:
                when = times if times is self._times else times[k]
                given = parameters[k], log.changes, starts[k], when, states[k]
                observed[k], first[k] = self._with_changes(*given)
        series = self._recording.series(
            states.transpose(1, 0, 2).reshape(program.rows, count * n),
            program.integrals,
            dict(zip(names, observed.transpose(1, 0, 2).reshape(len(names), count * n))),
            dict(zip(names, first.transpose(1, 0, 2).reshape(len(names), count * n))),
        )
        sampled = self._times is not None or batch.times is not None
        shape, known = (count, n) if sampled else (count,), batch.known(n)
        self._look_through(batch.index, series, known, np.broadcast_to(times.reshape(-1, n), known.shape))
        found: dict[str, Any] = {
            "t_end": batch.t,
            "steps": batch.steps,
            "status": np.array([ending.status.encode() for ending in batch.ending], dtype=STATUS),
            **({} if batch.times is None else {"crossings": batch.reached, "t": batch.times}),
            **{path: values.reshape(*shape, *values.shape[1:]) for path, values in series.items()},
        }
        for name in self._drift:
            row = names.index(name)
            with np.errstate(invalid="ignore"):  # where a quantity has no finite value, neither has its drift
                changes = np.abs(observed[:, row] - first[:, row])
            changes[np.isnan(changes) & known] = np.inf
            change = np.fmax.reduce(changes, axis=1)
            found[drift_path(name)] = change
            self._drift[name] = float(np.fmax.reduce(change, initial=self._drift[name]))
        self._emit(batch.index + self._first, {**found, **self._crossings(batch)})

    def _look_through(
        self, index: Index, series: Mapping[str, Array], known: NDArray[np.bool_], times: Array
    ) -> None:
        """Note the datasets (b n, ...) with samples that are not finite, of those that are ``known`` (b,
        n)."""
        places = np.flatnonzero(known)
        for path, values in series.items():
            first = first_unknown(values[places])
            if first is not None:
                member, t = int(index[places[first] // known.shape[1]]), float(times.flat[places[first]])
                found = self._first + member, t
                self._unknown[path] = min(found, self._unknown.get(path, found))

    def _write_exact(self, batch: EndedMembers) -> None:
        """The same of the only motion of a section, in numbers of several parts."""
        assert batch.samples is not None and batch.times is not None
        chunks: list[dict[str, Any]] = []
        samples = samples_of(self._prepared)(self._prepared, self._parameters[0], chunks.append)
        count = int(batch.reached[0])
        crossed = [one for log in batch.logs for one in log.crossings]
        times, lows = batch.times[0, :count], np.zeros(count)
        if crossed and self._section is not None and self._section.periods is None:
            lows = np.concatenate([one.low for one in crossed])[:count]
        for one in (change for log in batch.logs for change in log.changes):
            samples.change(replace(one, sample=one.sample + 1))
        states = np.concatenate([self._states[0][:, None], batch.samples[0][:, :count]], axis=1)
        samples.accept(np.array([self._start, *times]), states)
        h, momenta = samples.drifts()
        found = {f"p_{name}": drift for name, drift in momenta.items()} | ({} if h is None else {"h": h})
        self._drift = {name: found.get(name, np.nan) for name in self._drift}
        made = {path: rows[None, 1:] for path, rows in {**chunks[0], LOW_TIME: np.append(0.0, lows)}.items()}
        own = {path: rows[0] for path, rows in made.items() if path != "t" and not path.startswith(LOW)}
        self._look_through(batch.index, own, batch.known(count), batch.times[:, :count])
        status = np.array([ending.status.encode() for ending in batch.ending], dtype=STATUS)
        ended = {"t_end": batch.t, "steps": batch.steps, "status": status, "crossings": batch.reached}
        self._emit(batch.index + self._first, {**ended, **made})

    def _crossings(self, batch: EndedMembers) -> dict[str, Any]:
        """The datasets of the crossings of events, of all these members together."""
        for member, log in zip((batch.index + self._first).tolist(), batch.logs):
            for name, one in zip(log.names, log.happened):
                if one.doubtful and member <= self._doubtful.get(name, (member,))[0]:
                    self._doubtful[name] = member, one
        pairs = [(one, member) for log, member in zip(batch.logs, batch.index) for one in log.crossings]
        if not pairs or self._section is not None:  # a section's surface is an event, too
            return {}
        from lagrange_cli.integrate.event_log import crossing_datasets

        gathered, members = zip(*pairs)
        return crossing_datasets(self._prepared, gathered, [self._first + int(one) for one in members])

    def _observe(self, parameters: Array, times: Array, states: Array) -> Array:
        """The observed quantities (b, names, n) of states (b, rows, n) at times (n,), or at each member's (b,
        n)."""
        machine, n = self._machine, states.shape[2]
        constants = aligned(max(1, machine.program.constants))
        parameters = with_modes(machine.program, parameters)
        states, times = map(np.ascontiguousarray, (states, times))
        results = np.empty((len(states), len(machine.program.observed), n))
        if results.size:
            place, when = constants.ctypes.data, rows(times) if times.ndim == 2 else repeat(times.ctypes.data)
            for own, at, state, result in zip(rows(parameters), when, rows(states), rows(results)):
                machine.prepare(own, place)
                machine.observe(place, at, state, result, n, n)
        return results

    def _with_changes(
        self, parameters: Array, changes: Sequence[Change], start: Array, times: Array, states: Array
    ) -> tuple[Array, Array]:
        """The observed quantities of a member that actions have changed, and their reference values: (names,
        n)."""
        samples, n = Samples(self._prepared, parameters, lambda chunk: None), len(times)
        if self._times is None:  # the start comes before the crossings of a section, or the end
            section = self._section is not None
            changes = [replace(one, sample=one.sample + 1 if section else 1) for one in changes]
            times, states = np.array([self._start, *times]), np.concatenate([start, states], axis=1)
        for one in changes:
            samples.change(one)
        observed, first = samples.observe(times, states)
        rows = np.empty((2, len(observed), len(times)))  # of which there may be none
        for k, name in enumerate(observed):
            rows[0, k], rows[1, k] = observed[name], first[name]
        return rows[0, :, -n:], rows[1, :, -n:]

    def outcome(self) -> EnsembleOutcome:
        """The outcome of all members."""
        momenta = {name.removeprefix("p_"): drift for name, drift in self._drift.items() if name != "h"}
        return EnsembleOutcome(
            self._endings,
            self._failed,
            self._steps,
            self._drift.get("h"),
            momenta,
            self._recording.undetected,
            dict(sorted(self._unknown.items(), key=lambda one: one[1])),
            self._doubtful,
            self._recording.left_out,
            self._recording.undefined,
        )


def rows(array: Array) -> list[int]:
    """Where the rows of a contiguous array begin (all in one place, where they are empty)."""
    begin, stride = array.ctypes.data, array.strides[0]
    return [begin + number * stride for number in range(len(array))]


def drift_path(name: str) -> str:
    """The dataset of a conserved quantity's drift: that of ``p_theta`` is ``diagnostics/drift/p/theta``."""
    return f"diagnostics/drift/{name.replace('_', '/', 1) if name.startswith('p_') else name}"
