"""Sections of motions that are not followed in lanes: one after another, or one in each thread.

The surface is the last event of the program, whose crossings are recorded; other events act as usual.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.checkpoint import Checkpointing
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.ensemble.method import EndedMembers, Kept, MemberLog, SampleRows, Section, Starts
from lagrange_cli.integrate.events import Change, Crossings
from lagrange_cli.integrate.method import (
    CheckpointSink,
    End,
    Interrupt,
    Method,
    Observer,
    Snapshot,
    Start,
    Unfit,
)
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import replace

EVERY = 256
"""Whether a motion has crossed often enough is checked at multiples of so many steps."""
FAR = 2.0**40
"""A motion without a stop time ends here, and in units of its start."""


class SectionLog(MemberLog):
    """Finds the samples of a section (rows, n), and knows when there are enough. ``due`` tells whether a
    snapshot is wanted after so many steps. If ``every`` is not 0, that is checked at its multiples."""

    every = 0

    def __init__(
        self, names: tuple[str, ...], rows: int, section: Section, due: Callable[[int], bool]
    ) -> None:
        super().__init__(names)
        self._rows, self._section, self._due = rows, section, due

    def sampled(self, times: Array, states: Array) -> None:
        """The motion has come to sample times."""

    def stepped(self, steps: int) -> bool:
        """So many steps have been taken; whether a snapshot is wanted."""
        return self._due(steps)

    @property
    def over(self) -> bool:
        """Whether the motion is to end here."""
        return False

    def kept(self) -> dict[str, Array]:
        """What has been found so far."""
        return kept_changes(self.changes)

    def restore(self, kept: Kept, samples: int) -> None:
        """Go on with it after so many samples; raises ``Unfit``."""
        self.changes = restored_changes(kept, self._rows)

    @abstractmethod
    def samples(self) -> tuple[Array, Array]:
        """Times (n,) and states (rows, n), nan behind the last sample."""

    def ended(self, end: End, *, endless: bool) -> End:
        """How a motion that nothing else has ended is said to end; ``endless`` if it had no stop time."""
        return end


class CrossingLog(SectionLog):
    """The crossings of the last event."""

    every, in_turn = EVERY, True

    def __init__(self, names: tuple[str, ...], *given: Any) -> None:
        super().__init__(names, *given)
        self._surface, self.found = len(names) - 1, 0
        self._steps = self._since = self._seen = 0

    def crossed(self, crossings: Crossings) -> None:
        own = crossings.events == self._surface
        if own.any():
            names = "events", "t", "low", "grazing", "errors"
            taken = {name: getattr(crossings, name)[own] for name in names}
            self.crossings.append(Crossings(states=crossings.states[own], **taken))
            self.found += int(own.sum())

    def changed(self, change: Change) -> None:
        self.changes.append(replace(change, sample=self.found))

    def stepped(self, steps: int) -> bool:
        self._steps = steps
        if self._asked and self.found > self._seen:
            self._since, self._seen = steps, self.found
        return super().stepped(steps)

    @property
    def _asked(self) -> bool:
        """Whether to check now if the motion goes on. Compiled code returns when some time has passed, so
        this is checked at certain steps only: else the end would depend on the time."""
        return self._steps % EVERY == 0

    @property
    def _enough(self) -> bool:
        return self.found >= self._section.count

    @property
    def over(self) -> bool:
        """Whether all have been found, or there has been none for too many steps."""
        return self._asked and (self._enough or self._steps - self._since > self._section.patience)

    def kept(self) -> dict[str, Array]:
        count = np.array([self._steps, self._since, self._seen], dtype=np.float64)
        found = {"t": np.zeros(0), "low": np.zeros(0), "states": np.zeros((0, 0))}
        if self.crossings:
            found = {name: np.concatenate([getattr(one, name) for one in self.crossings]).T for name in found}
        return {"counts": count, **found, **super().kept()}

    def restore(self, kept: Kept, samples: int) -> None:
        counts, t, low, states = (array_of(kept, name) for name in ("counts", "t", "low", "states"))
        if counts.shape != (3,) or t.ndim != 1 or low.shape != t.shape:
            raise Unfit
        if len(t) and states.shape != (self._rows, len(t)):
            raise Unfit
        self._steps, self._since, self._seen = (whole(x) for x in counts)
        self.found = len(t)
        if self.found:
            surface, none = np.full(self.found, self._surface), np.zeros(self.found, dtype=bool)
            self.crossings = [Crossings(surface, t, low, states.T, none, np.zeros(self.found))]
        super().restore(kept, samples)

    def samples(self) -> tuple[Array, Array]:
        count = self._section.count
        times, states = np.full(count, np.nan), np.full((self._rows, count), np.nan)
        if self.crossings:
            t, found = (np.concatenate([getattr(one, name) for one in self.crossings])[:count]
                        for name in ("t", "states"))  # fmt: skip
            times[: len(t)], states[:, : len(t)] = t, found.T
        return times, states

    def ended(self, end: End, *, endless: bool) -> End:
        if self._enough:  # else it has not come to the step at which it ends
            when, states = self.samples()
            return replace(end, t=float(when[-1]), state=states[:, -1], ending=Ending.COMPLETE)
        without = end.ending is Ending.INTERRUPTED or (endless and end.ending is Ending.COMPLETE)
        return replace(end, ending=Ending.NO_CROSSING) if without else end


class StrobeLog(SectionLog):
    """The states at ``times``, of which the first is the start: it is no sample of the section."""

    def __init__(self, times: Times, *given: Any) -> None:
        super().__init__(*given)
        self._times = times.chunk(1, self._section.count)
        self._found = SampleRows(self._rows, self._section.count + 1)
        self.sampled = self._found.take  # type: ignore[method-assign]

    def changed(self, change: Change) -> None:
        self.changes.append(replace(change, sample=max(0, change.sample - 1)))

    def kept(self) -> dict[str, Array]:
        return {"states": self._found.rows[:, 1 : self._found.reached], **super().kept()}

    def restore(self, kept: Kept, samples: int) -> None:
        states = array_of(kept, "states")
        if states.shape != (self._rows, max(0, samples - 1)):
            raise Unfit
        self._found.rows[:, 1 : 1 + states.shape[1]], self._found.reached = states, samples
        super().restore(kept, samples)

    def samples(self) -> tuple[Array, Array]:
        reached = self._times[: max(0, self._found.reached - 1)]
        when = np.full(self._section.count, np.nan)
        when[: len(reached)] = reached
        return when, self._found.rows[:, 1:]


def through_section(
    method: Method,
    names: tuple[str, ...],
    starts: Starts,
    member: int,
    checkpointing: Checkpointing[Kept],
    interrupt: Interrupt,
) -> EndedMembers:
    """Follow a member through a section; ``names`` are those of the events. Raises ``Unfit``."""
    state, section, begin, cut = starts.states[member], starts.section, checkpointing.begin, False
    assert section is not None
    given = names, len(state), section, checkpointing.due
    if section.periods is None:
        times = until(starts.times)
        log: SectionLog = CrossingLog(*given)
    else:
        times = periodic(starts.times, float(section.periods[member]), section.count)
        log = StrobeLog(times, *given)
    begun = None
    if begin is not None:
        begun = restored_snapshot(begin, times)
        log.restore(begin, begun.samples)

    def keep(snapshot: Snapshot) -> None:
        checkpointing.keep({**kept_snapshot(snapshot), **log.kept()}, snapshot.steps)

    def stop(t: float) -> bool:
        nonlocal cut
        cut = interrupt(t) and not log.over
        return cut or log.over

    checkpoints = CheckpointSink(begun, log.stepped, keep, every=log.every)
    observer = Observer(log.sampled, stop, log, checkpoints)
    end = method.follow(Start(starts.parameters[member], state, times), observer)
    cut = cut and end.ending is Ending.INTERRUPTED
    if cut and end.snapshot is not None:
        keep(end.snapshot)
    if not cut:
        end = log.ended(end, endless=math.isinf(starts.times.stop))
    when, states = log.samples()
    batch = EndedMembers.one(member, end, int(np.count_nonzero(~np.isnan(when))), states, [log])
    return replace(batch, times=when[None])


def array_of(kept: Kept, name: str) -> Array:
    """One of what was kept; raises ``Unfit``."""
    found = kept.get(name)
    if found is None or found.dtype != np.float64:
        raise Unfit
    return found


def whole(number: float) -> int:
    """A whole number; raises ``Unfit``."""
    if not (0.0 <= number < 2.0**53 and number == int(number)):
        raise Unfit
    return int(number)


def kept_snapshot(snapshot: Snapshot) -> dict[str, Array]:
    """A method's snapshot as arrays."""
    numbers = (snapshot.t, snapshot.steps, snapshot.samples, snapshot.limited, *snapshot.actions)
    singular = {"singular": np.array(snapshot.singular)} if snapshot.singular else {}
    return {**snapshot.arrays, "snapshot": np.array(numbers, dtype=np.float64), **singular}


def restored_snapshot(kept: Kept, times: Times) -> Snapshot:
    """The same of arrays; raises ``Unfit``."""
    memory, numbers = array_of(kept, "memory"), array_of(kept, "snapshot")
    marks = tuple(array_of(kept, "marks")) if "marks" in kept else ()
    if memory.ndim != 1 or numbers.ndim != 1 or len(numbers) < 4 or not np.isfinite(numbers[:4]).all():
        raise Unfit
    t, steps, samples, limited, *actions = numbers.tolist()
    if not min(times.start, times.stop) <= t <= max(times.start, times.stop) or samples > times.count:
        raise Unfit
    singular = tuple(array_of(kept, "singular").tolist()) if "singular" in kept else ()
    return Snapshot(memory, t, whole(steps), whole(samples), bool(limited), tuple(actions), marks, singular)


def kept_changes(changes: Sequence[Change]) -> dict[str, Array]:
    """What actions have changed, as arrays: a row for each."""
    when = [(one.sample, one.t) for one in changes]
    states = [np.concatenate([one.before, one.after]) for one in changes]
    parameters = [np.concatenate(one.parameters) for one in changes]
    found = {"changed_at": when, "changed_states": states, "changed_parameters": parameters}
    return {name: np.array(rows, dtype=np.float64) for name, rows in found.items() if rows}


def restored_changes(kept: Kept, rows: int) -> list[Change]:
    """The same of arrays; raises ``Unfit``."""
    if "changed_at" not in kept:
        return []
    when, states, parameters = (array_of(kept, f"changed_{one}") for one in ("at", "states", "parameters"))
    if when.shape != (len(when), 2) or states.shape != (len(when), 2 * rows) or len(parameters) != len(when):
        raise Unfit
    middle = parameters.shape[1] // 2
    return [
        Change(whole(sample), float(t), state[:rows], state[rows:], (own[:middle], own[middle:]))
        for (sample, t), state, own in zip(when, states, parameters)
    ]


def until(times: Times) -> Times:
    """The times of a motion, also without a stop time."""
    stop = times.stop
    if math.isinf(stop):
        stop = times.start + math.copysign(FAR * max(1.0, abs(times.start)), stop)
    return Times(times.start, stop, 1, stop - times.start)


def periodic(times: Times, period: float, count: int) -> Times:
    """The start, and so many multiples of a period behind it, as far as they come before the stop."""
    step = math.copysign(period, times.stop - times.start)
    room = (times.stop - times.start) / step
    count = count if room >= count else math.floor(room)
    if not count:
        return replace(times, count=1)
    return Times(times.start, times.start + count * step, count + 1, step)
