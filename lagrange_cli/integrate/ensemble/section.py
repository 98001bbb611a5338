"""Sections of motions that are not followed in lanes: one after another, or one in each thread.

The surface is the last event of the program, whose crossings are recorded; what other events do counts.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.ensemble.method import Batch, MemberLog, Section, Starts
from lagrange_cli.integrate.ensemble.one_by_one import OneByOne
from lagrange_cli.integrate.events import Change, Crossings
from lagrange_cli.integrate.method import CheckpointSink
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import replace
from lagrange_cli.spec.spec import SURFACE

FAR = 2.0**40
"""A motion without a stop time ends here, and in units of its start."""


class SectionLog(MemberLog):
    """Crossings of the last event, of which ``count`` are enough; and the changes before each."""

    def __init__(self, names: tuple[str, ...], section: Section) -> None:
        super().__init__(names)
        self._surface, self._section = len(names) - 1, section
        self.found = 0
        self._steps = self._since = 0

    def crossed(self, crossings: Crossings) -> None:
        own = crossings.events == self._surface
        if own.any():
            taken = {name: getattr(crossings, name)[own] for name in ("events", "t", "low", "grazing")}
            self.crossings.append(Crossings(states=crossings.states[own], **taken))
            self.found += int(own.sum())
            self._since = self._steps

    def changed(self, change: Change) -> None:
        self.changes.append(replace(change, sample=self.found))

    def stepped(self, steps: int) -> bool:
        """So many steps have been taken; no snapshot is wanted."""
        self._steps = steps
        return False

    @property
    def enough(self) -> bool:
        """Whether all crossings have been found."""
        return self.found >= self._section.count

    @property
    def lost(self) -> bool:
        """Whether there has been none for too many steps."""
        return self._steps - self._since > self._section.patience

    def samples(self, rows: int) -> tuple[Array, Array]:
        """Times (n,) and states (rows, n), nan behind the last crossing."""
        count = self._section.count
        times, states = np.full(count, np.nan), np.full((rows, count), np.nan)
        if self.crossings:
            t, found = (np.concatenate([getattr(one, name) for one in self.crossings])[:count]
                        for name in ("t", "states"))  # fmt: skip
            times[: len(t)], states[:, : len(t)] = t, found.T
        return times, states


class SectionOneByOne(OneByOne):
    """Follows one member after another through a section. The last of ``events`` is the surface."""

    def _one(self, member: int, starts: Starts, interrupt: Callable[[float], bool]) -> Batch:
        section = starts.section
        assert section is not None
        if section.periods is not None:
            return self._strobed(member, starts, float(section.periods[member]), interrupt)
        state, log, cut = starts.states[member], SectionLog(self.events, section), False

        def stop(t: float) -> bool:
            nonlocal cut
            cut = interrupt(t)
            return cut or log.enough or log.lost

        times, steps = until(starts.times), CheckpointSink(None, log.stepped, lambda snapshot: None)
        given = starts.parameters[member], state, times, lambda when, chunk: None, stop
        end = self.method.follow(*given, steps, log)
        when, states = log.samples(len(state))
        endless = math.isinf(starts.times.stop)
        t, at, ending = end.t, end.state, end.ending
        if log.enough:
            t, at, ending = float(when[-1]), states[:, -1], Ending.COMPLETE
        elif not cut and (ending is Ending.INTERRUPTED or (endless and ending is Ending.COMPLETE)):
            ending = Ending.NO_CROSSING
        return self._batch(member, ending, t, at, end.steps, when, states, log)

    def _strobed(
        self, member: int, starts: Starts, period: float, interrupt: Callable[[float], bool]
    ) -> Batch:
        section, state, log = starts.section, starts.states[member], MemberLog(self.events)
        assert section is not None
        start, step = starts.times.start, math.copysign(period, starts.times.stop - starts.times.start)
        room = (starts.times.stop - start) / step
        count = section.count if room >= section.count else math.floor(room)
        times = (
            Times(start, start + count * step, count + 1, step) if count else replace(starts.times, count=1)
        )
        samples, reached = np.full((len(state), section.count + 1), np.nan), 0

        def keep(when: Array, chunk: Array) -> None:
            nonlocal reached
            samples[:, reached : reached + len(when)] = chunk
            reached += len(when)

        end = self.method.follow(starts.parameters[member], state, times, keep, interrupt, events=log)
        if not count:
            samples[:], reached = np.nan, 1
        log.changes = [replace(one, sample=max(0, one.sample - 1)) for one in log.changes]
        when = np.full(section.count, np.nan)
        when[: reached - 1] = times.chunk(1, section.count)[: reached - 1]
        return self._batch(member, end.ending, end.t, end.state, end.steps, when, samples[:, 1:], log)

    def _batch(
        self,
        member: int,
        ending: Ending,
        t: float,
        state: Array,
        steps: int,
        times: Array,
        samples: Array,
        log: MemberLog,
    ) -> Batch:
        return Batch(
            index=np.array([member], dtype=np.int64),
            ending=[ending],
            t=np.array([t]),
            state=state[None],
            steps=np.array([steps], dtype=np.int64),
            samples=samples[None],
            reached=np.array([np.count_nonzero(~np.isnan(times))], dtype=np.int64),
            logs=[log] if len(self.events) > (SURFACE in self.events) else [],
            times=times[None],
        )


def until(times: Times) -> Times:
    """The times of a motion that ends where none is asked for, too."""
    stop = times.stop
    if math.isinf(stop):
        stop = times.start + math.copysign(FAR * max(1.0, abs(times.start)), stop)
    return Times(times.start, stop, 1, stop - times.start)
