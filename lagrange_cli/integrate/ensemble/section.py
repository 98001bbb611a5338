"""Sections of motions that are not followed in lanes: one after another, or one in each thread.

The surface is the last event of the program, whose crossings are recorded; other events act as usual.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.checkpoint import Checkpointing
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.ensemble.method import EndedMembers, Kept, MemberLog, Section, Starts
from lagrange_cli.integrate.ensemble.one_by_one import OneByOne
from lagrange_cli.integrate.events import Change, Crossings
from lagrange_cli.integrate.method import CheckpointSink, Observer, Snapshot, Unfit
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import dataclass, replace

EVERY = 256
"""Whether a motion has crossed often enough is checked at multiples of so many steps."""
FAR = 2.0**40
"""A motion without a stop time ends here, and in units of its start."""


class SectionLog(MemberLog):
    """Crossings of the last event, of which ``count`` are enough; and the changes before each."""

    def __init__(self, names: tuple[str, ...], section: Section, due: Callable[[int], bool]) -> None:
        super().__init__(names)
        self._surface, self._section, self._due = len(names) - 1, section, due
        self.found = 0
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
        """So many steps have been taken; whether a snapshot is wanted."""
        self._steps = steps
        if self._asked and self.found > self._seen:
            self._since, self._seen = steps, self.found
        return self._due(steps)

    @property
    def _asked(self) -> bool:
        """Whether to check now if the motion goes on. Compiled code returns when some time has passed, so
        this is checked at certain steps only: else the end would depend on the time."""
        return self._steps % EVERY == 0

    @property
    def enough(self) -> bool:
        """Whether all crossings have been found."""
        return self.found >= self._section.count

    @property
    def over(self) -> bool:
        """Whether all have been found, or there has been none for too many steps."""
        return self._asked and (self.enough or self._steps - self._since > self._section.patience)

    def kept(self) -> dict[str, Array]:
        """The crossings found so far."""
        count = np.array([self._steps, self._since, self._seen], dtype=np.float64)
        found = {"t": np.zeros(0), "low": np.zeros(0), "states": np.zeros((0, 0))}
        if self.crossings:
            found = {name: np.concatenate([getattr(one, name) for one in self.crossings]).T for name in found}
        return {"counts": count, **found, **kept_changes(self.changes)}

    def restore(self, kept: Kept, rows: int) -> None:
        """Go on with it; raises ``Unfit``."""
        counts, t, low, states = (array_of(kept, name) for name in ("counts", "t", "low", "states"))
        if (
            counts.shape != (3,)
            or t.ndim != 1
            or low.shape != t.shape
            or (len(t) and states.shape != (rows, len(t)))
        ):
            raise Unfit
        self._steps, self._since, self._seen = (whole(x) for x in counts)
        self.found = len(t)
        if self.found:
            surface, none = np.full(self.found, self._surface), np.zeros(self.found, dtype=bool)
            self.crossings = [Crossings(surface, t, low, states.T, none, np.zeros(self.found))]
        self.changes = restored_changes(kept, rows)

    def samples(self, rows: int) -> tuple[Array, Array]:
        """Times (n,) and states (rows, n), nan behind the last crossing."""
        count = self._section.count
        times, states = np.full(count, np.nan), np.full((rows, count), np.nan)
        if self.crossings:
            t, found = (np.concatenate([getattr(one, name) for one in self.crossings])[:count]
                        for name in ("t", "states"))  # fmt: skip
            times[: len(t)], states[:, : len(t)] = t, found.T
        return times, states


@dataclass(frozen=True)
class SectionOneByOne(OneByOne):
    """Follows one member after another through a section. The last of ``events`` is the surface. The only
    motion may have checkpoints, by ``checkpointing``."""

    checkpointing: Checkpointing[Kept] | None = None

    def _one(self, member: int, starts: Starts, interrupt: Callable[[float], bool]) -> EndedMembers:
        section = starts.section
        assert section is not None
        if section.periods is not None:
            return self._strobed(member, starts, float(section.periods[member]), interrupt)
        checkpointing = self.checkpointing
        begin, due = (None, never) if checkpointing is None else (checkpointing.begin, checkpointing.due)
        state, log, cut = starts.states[member], SectionLog(self.events, section, due), False
        if begin is not None:
            log.restore(begin, len(state))

        def keep(snapshot: Snapshot) -> None:
            if checkpointing is not None:
                checkpointing.keep({**kept_snapshot(snapshot), **log.kept()}, snapshot.steps)

        def stop(t: float) -> bool:
            nonlocal cut
            cut = interrupt(t) and not log.over
            return cut or log.over

        times = until(starts.times)
        steps = CheckpointSink(self._begun(begin, times), log.stepped, keep, every=EVERY)
        observer = Observer(interrupt=stop, events=log, checkpoints=steps)
        end = self.method.follow(starts.parameters[member], state, times, observer)
        cut = cut and end.ending is Ending.INTERRUPTED
        if cut and end.snapshot is not None:
            keep(end.snapshot)
        when, states = log.samples(len(state))
        endless = math.isinf(starts.times.stop)
        t, at, ending = end.t, end.state, end.ending
        if log.enough and not cut:  # else it has not come to the step at which it ends
            t, at, ending = float(when[-1]), states[:, -1], Ending.COMPLETE
        elif not cut and (ending is Ending.INTERRUPTED or (endless and ending is Ending.COMPLETE)):
            ending = Ending.NO_CROSSING
        return self._batch(member, ending, t, at, end.steps, when, states, log)

    def _strobed(
        self, member: int, starts: Starts, period: float, interrupt: Callable[[float], bool]
    ) -> EndedMembers:
        section, state, log = starts.section, starts.states[member], MemberLog(self.events)
        assert section is not None
        checkpointing = self.checkpointing
        begin, due = (None, never) if checkpointing is None else (checkpointing.begin, checkpointing.due)
        start, step = starts.times.start, math.copysign(period, starts.times.stop - starts.times.start)
        room = (starts.times.stop - start) / step
        count = section.count if room >= section.count else math.floor(room)
        times = (
            Times(start, start + count * step, count + 1, step) if count else replace(starts.times, count=1)
        )
        samples, reached = np.full((len(state), section.count + 1), np.nan), 0

        def accept(when: Array, chunk: Array) -> None:
            nonlocal reached
            samples[:, reached : reached + len(when)] = chunk
            reached += len(when)

        def keep(snapshot: Snapshot) -> None:
            if checkpointing is not None:
                so_far = {"states": samples[:, 1:reached], **kept_changes(log.changes)}
                checkpointing.keep({**kept_snapshot(snapshot), **so_far}, snapshot.steps)

        begun = self._begun(begin, times)
        if begin is not None and begun is not None:
            states = array_of(begin, "states")
            reached = begun.samples
            if states.shape != (len(state), max(0, reached - 1)):
                raise Unfit
            samples[:, 1 : 1 + states.shape[1]] = states
            log.changes = restored_changes(begin, len(state))
        steps = CheckpointSink(begun, due, keep)
        observer = Observer(accept, interrupt, log, steps)
        end = self.method.follow(starts.parameters[member], state, times, observer)
        if end.ending is Ending.INTERRUPTED and end.snapshot is not None:
            keep(end.snapshot)
        if not count:
            samples[:], reached = np.nan, 1
        log.changes = [replace(one, sample=max(0, one.sample - 1)) for one in log.changes]
        when = np.full(section.count, np.nan)
        when[: reached - 1] = times.chunk(1, section.count)[: reached - 1]
        return self._batch(member, end.ending, end.t, end.state, end.steps, when, samples[:, 1:], log)

    def _begun(self, begin: Kept | None, times: Times) -> Snapshot | None:
        """The start of a motion from a checkpoint; raises ``Unfit``."""
        return None if begin is None else restored_snapshot(begin, times)

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
    ) -> EndedMembers:
        return EndedMembers(
            index=np.array([member], dtype=np.int64),
            ending=[ending],
            t=np.array([t]),
            state=state[None],
            steps=np.array([steps], dtype=np.int64),
            samples=samples[None],
            reached=np.array([np.count_nonzero(~np.isnan(times))], dtype=np.int64),
            logs=[log],
            times=times[None],
        )


def never(steps: int) -> bool:
    """No snapshot is wanted."""
    return False


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
