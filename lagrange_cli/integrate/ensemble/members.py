"""The shared data of threads that follow members in lanes: arrays, the queue, and which members have
ended."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from lagrange_cli.integrate.arrays import aligned
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.ensemble.method import EndedMembers, Kept, Section, Starts
from lagrange_cli.integrate.method import Unfit
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.compilation.machine import Machine
from lagrange_cli.native.interface import LANES, Stop
from lagrange_cli.native.members import (
    BEYOND,
    DIRECTION,
    HALT,
    LIMIT,
    NEXT,
    PATIENCE,
    SECTION,
    STROBE,
    lane_places,
)
from lagrange_cli.records import replace

MOMENT = 0.001
"""Seconds that a thread waits for room for more samples."""
MEMORY, LARGEST = 2**25, 2**28
"""Bytes of the samples of members on their way; up to the latter, where each lane needs room for one."""
PACK = "lanes"
"""The name of what lanes work on, where a motion is kept."""
PARTS = 4
"""The room for samples holds so many batches: members end in it while others are given away."""


class Members:
    """The arrays that ``@follow`` works on, and which of the members have been given away."""

    def __init__(self, machine: Machine, starts: Starts, threads: int, kept: bool = False) -> None:
        assert machine.follow is not None
        (count, rows), times, section = starts.states.shape, starts.times, starts.section
        sampled = starts.sampled or section is not None
        self._machine, self._follow, self._rows, self._times = machine, machine.follow, rows, times
        self._section, parameters = section, starts.parameters
        if section is not None and section.periods is not None:
            parameters = np.column_stack([parameters, section.periods])
        self._parameters, self._states = map(np.ascontiguousarray, (parameters, starts.states))
        self._wanted = times.chunk(0, times.count if starts.sampled else 0)
        self._count = len(self._wanted) if section is None else section.count
        height = rows if section is None else rows + 1
        size = 8 * height * self._count
        room = max(1, MEMORY // size, min(LANES * threads, LARGEST // size)) if sampled else count
        self._slots = min(room, count)
        self._samples = np.empty((self._slots, height, self._count)) if sampled else None
        self._results = np.empty((count, rows + BEYOND))
        self._reasons, self._given = np.zeros(count, dtype=np.int8), np.zeros(count, dtype=bool)
        self._queue = queue_of(self._slots, section)
        self._pack = aligned(machine.program.lanes) if kept else None
        self._packs: list[NDArray[np.float64]] = []
        """What the only motion is followed in, if it may be kept."""
        self._first = 0
        """The first member that has not been given away."""
        self.left: list[int] = []
        """Members that lanes do not bring to their ends."""
        self.done = 0

    @property
    def roomy(self) -> bool:
        """Whether all members may begin."""
        return bool(self._queue[LIMIT] == len(self._states))

    def halt(self) -> None:
        """Make all threads stop after their present step."""
        self._queue[HALT] = 1

    def work(self) -> None:
        """Integrate members until none is left: the work of a thread."""
        pack = aligned(self._machine.program.lanes) if self._pack is None else self._pack
        if not any(one is pack for one in self._packs):
            self._packs.append(pack)
        while not self._queue[HALT]:
            self._follow(
                pack.ctypes.data, self._parameters.ctypes.data, self._states.ctypes.data,
                self._queue.ctypes.data, self._times.start, self._times.stop, self._wanted.ctypes.data,
                self._count, self._results.ctypes.data, self._reasons.ctypes.data,
                None if self._samples is None else self._samples.ctypes.data, self._slots,
            )  # fmt: skip
            if self._queue[NEXT] >= len(self._states):
                return
            time.sleep(MOMENT)

    def parts(self) -> float:
        """How far those on their way have come, in parts of their motions, unless a number of crossings ends
        them. Threads go on in the meantime."""
        places, found = self._places, 0.0
        if self._section is not None:
            return found
        for pack in [*self._packs]:
            active = int(pack.view(np.int64)[places["active"]])
            times = pack[places["time"] : places["time"] + LANES].tolist()
            found += sum(self._times.part(t) for lane, t in enumerate(times) if active >> lane & 1)
        return found

    @property
    def _places(self) -> dict[str, int]:
        """Where the numbers of the first lane are."""
        kind = ""
        if self._section is not None:
            kind = SECTION if self._section.periods is None else STROBE
        return {
            name: LANES * place
            for name, place in lane_places(self._machine.program.state.width, kind).items()
        }

    def _numbers(self) -> NDArray[np.int64]:
        assert self._pack is not None
        return self._pack.view(np.int64)

    @property
    def steps(self) -> int:
        """The steps of the only motion."""
        return int(self._numbers()[self._places["steps"]])

    @property
    def on_the_way(self) -> bool:
        """Whether the only motion was halted before its end, and can go on."""
        return bool(self._reasons[0] == 1 + Stop.SAMPLES) and not self.done

    def go_on(self) -> None:
        """Let it."""
        self._reasons[0] = self._queue[HALT] = 0

    def kept(self) -> Kept:
        """Its snapshot, from which it can be continued."""
        assert self._pack is not None and self._samples is not None
        reached = int(self._numbers()[self._places["reached"]])
        return {PACK: self._pack.copy(), "states": self._samples[0, :, :reached].copy()}

    def restore(self, kept: Kept) -> None:
        """Continue it from there; raises ``Unfit``. No number in it leads beyond the arrays."""
        pack, samples, places = kept[PACK], kept.get("states"), self._places
        assert self._pack is not None and self._samples is not None
        fits = samples is not None and samples.ndim == 2 and len(samples) == self._samples.shape[1]
        if samples is None or not fits or pack.shape != self._pack.shape or samples.shape[1] > self._count:
            raise Unfit
        self._pack[:], self._samples[0, :, : samples.shape[1]] = pack, samples
        numbers = self._numbers()
        numbers[places["member"]], numbers[places["active"]] = 0, 1
        numbers[places["finishing"]] &= 1
        numbers[places["reached"]] = samples.shape[1]
        self._queue[NEXT] = 1

    def ended(self) -> Iterator[EndedMembers]:
        """Members that have ended since the last time; the room that their samples took is free then."""
        window = slice(self._first, int(self._queue[LIMIT]))
        index = np.flatnonzero((self._reasons[window] != 0) & ~self._given[window]) + self._first
        size = max(1, self._slots // PARTS)
        whole = (self._reasons[index] == 1 + Stop.END) | (self._reasons[index] == 1 + Stop.SAMPLES)
        self.left += index[~whole].tolist()
        self._given[index[~whole]] = True
        index = index[whole]
        for start in range(0, len(index), size):
            part = index[start : start + size]
            yield self._batch(part)
            self._given[part] = True
            self.done += len(part)
        waiting = np.flatnonzero(~self._given[window])
        self._first = self._first + int(waiting[0]) if len(waiting) else window.stop
        self._queue[LIMIT] = min(len(self._states), self._first + self._slots)

    def _batch(self, index: NDArray[np.int64]) -> EndedMembers:
        results, rows = self._results[index], self._rows
        steps, reached = (results[:, rows + 1 :].copy().view(np.int64)[:, i] for i in range(2))
        samples = None
        if self._samples is not None:
            samples = self._samples[index % self._slots]
            for one, good in zip(samples, reached):
                one[:, good:] = np.nan
        batch = EndedMembers(
            index=index,
            ending=[Ending.COMPLETE] * len(index),
            t=results[:, rows],
            state=results[:, :rows],
            steps=steps,
            samples=samples,
            reached=reached,
        )
        return batch if self._section is None else self._crossings(batch, self._section)

    def _crossings(self, batch: EndedMembers, section: Section) -> EndedMembers:
        """Members of a section: how each ended, and where."""
        assert batch.samples is not None
        states, times = batch.samples[:, :-1], batch.samples[:, -1]
        t, state, ending = batch.t.copy(), batch.state.copy(), list(batch.ending)
        for i, (member, reached) in enumerate(zip(batch.index, batch.reached)):
            if reached == section.count:
                t[i], state[i] = times[i, -1], states[i, :, -1]
            elif self._reasons[member] == 1 + Stop.SAMPLES:
                ending[i] = Ending.INTERRUPTED
            elif not close(t[i], self._times):
                ending[i] = Ending.NO_CROSSING
        return replace(batch, t=t, state=state, ending=ending, samples=states, times=times)


def close(t: float, times: Times) -> bool:
    """Whether a motion has reached its stop time, up to rounding."""
    return math.isclose(t, times.stop, rel_tol=1e-12, abs_tol=1e-12 * abs(times.start))


def queue_of(limit: int, section: Section | None) -> NDArray[np.int64]:
    """What threads share: up to which member they may begin, and what a section is taken by."""
    queue = np.array([0, limit, 0, 0, 0], dtype=np.int64)
    if section is not None:
        queue[DIRECTION:PATIENCE].view(np.float64)[0] = section.direction
        queue[PATIENCE] = section.patience
    return queue
