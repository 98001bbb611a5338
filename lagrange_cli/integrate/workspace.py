"""``Workspace``: the arrays of one motion that compiled code works on, and the calls of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.arrays import Array, beside_one_another
from lagrange_cli.native.compilation.machine import Machine
from lagrange_cli.native.guards import INFO
from lagrange_cli.native.interface import Interface, Stop
from lagrange_cli.native.state import LANES, Clock

if TYPE_CHECKING:
    from numpy.typing import NDArray

MOST_STEPS = 1 << 40
"""More than are ever taken at once."""


class Workspace:
    """``memory`` is what the motion goes on from (see ``native.state``), ``work`` and ``trial`` are scratch,
    ``info`` is what calls tell; ``samples`` (rows, size + LANES) holds what ``advance`` has made."""

    def __init__(self, machine: Machine, state: Array, start: float, size: int) -> None:
        program = machine.program
        self.machine, self.layout, self.outer = machine, program.inner, outer_rows(program)
        rows, columns = program.parts * self.layout.rows, size + LANES
        self.constants, self.memory, self.work, self.trial, samples = beside_one_another(
            max(1, program.constants), self.layout.memory, program.work, program.trial, rows * columns
        )
        self.info = np.zeros(INFO, dtype=np.int64)
        for part, given in enumerate(state.reshape(program.parts, -1)):
            self.memory[self.layout.part(part)][self.outer] = given
        self.memory[self.layout.time] = start
        self.samples = samples.reshape(rows, columns)
        self._spare: Array | None = None
        self.accelerated = Accelerated(machine, self.constants, self.memory, self.work)
        self.resume: Callable[[], None] = lambda: None
        """Called when ``memory`` has become that of another time: constants may depend on modes in it."""

    @property
    def t(self) -> float:
        """The time reached."""
        return float(self.memory[self.layout.time])

    @property
    def state(self) -> Array:
        """q, v and the integrals at that time."""
        return np.array(self.memory[self.layout.part(0)][self.outer])

    @property
    def whole_state(self) -> Array:
        """All rows that steps have, of every part."""
        return np.concatenate(
            [self.memory[self.layout.part(part)] for part in range(self.machine.program.parts)]
        )

    def passed(self, times: Array) -> NDArray[np.bool_]:
        """Which of some instants are not after the time reached."""
        return np.asarray(times - self.t - self.memory[self.layout.at(Clock.TIME_LOW)] <= 0)

    def rates(self) -> Array:
        """The rates of velocities and integrals at the state reached."""
        rates, _ = self.accelerated.rates(self.machine)
        return np.array(rates)

    def advance(self, stop: float, wanted: Array, done: int, count: int, last: bool, pause: int) -> Stop:
        """Step until ``stop``, or until ``count`` of the ``wanted`` samples from the one numbered ``done``
        are taken, or ``pause`` steps are; why it ended. ``wanted`` has LANES more instants, which are nan."""
        assert self.machine.advance is not None
        return Stop(
            self.machine.advance(
                self.constants.ctypes.data, self.memory.ctypes.data, self.work.ctypes.data,
                self.trial.ctypes.data, stop, wanted.ctypes.data + 8 * done, count,
                self.samples.ctypes.data + 8 * done, self.samples.shape[1], last, pause,
                self.info.ctypes.data,
            )
        )  # fmt: skip

    def project(self) -> None:
        """Move the state to the constraints."""
        assert self.machine.project is not None
        self.machine.project(self.constants.ctypes.data, self.memory.ctypes.data)

    def again(self, origin: Array, times: Array, more: Callable[[int], int]) -> Array | None:
        """The states (rows of every part, n) at times, from the memory ``origin`` on; None if the motion does
        not reach the last of them. ``more`` is told how many steps were taken since it was asked last,
        and says how many may be: 0 ends the way."""
        info, samples, memory = self.info.copy(), self.samples, self.memory.copy()
        self.memory[:] = origin
        self.resume()
        self.samples = np.empty((len(samples), len(times) + LANES))
        wanted, stop, done, pause = padded(times), Stop.PAUSE, 0, more(0)
        while stop is Stop.PAUSE and pause > 0:
            self.info[:] = 0
            stop = self.advance(float(times[-1]), wanted, done, len(times) - done, True, pause)
            done, pause = done + int(self.info[0]), more(int(self.info[1]))
        found = self.samples[:, : len(times)]
        complete = stop is Stop.END and done == len(times)
        self.memory[:], self.info[:], self.samples = memory, info, samples
        self.resume()
        return found if complete else None

    def between(self, origin: Array, wanted: Array) -> Array:
        """The states (rows of every part, n) at those of the ``wanted`` times that the motion has passed
        since the memory ``origin``, on a way along which rates are constant but for rounding."""
        from lagrange_cli.native.numbers.error_free import two_sum

        layout, parts = self.layout, self.machine.program.parts
        begin, end = (one[[layout.time, layout.at(Clock.TIME_LOW)]] for one in (origin, self.memory))
        length = float((end - begin).sum())
        passed = (wanted - begin[0]) - begin[1]
        s = passed[passed < length] / length
        lows = [layout.part(1), slice(layout.third, layout.third + layout.rows)][:parts]
        change = self.memory[layout.part(0)] - origin[layout.part(0)]
        for low in lows:
            change = change + (self.memory[low] - origin[low])
        moved = np.outer(change, s)
        moved[layout.q] -= np.outer(change[layout.v] * (length / 2), s * (1 - s))
        high, rest = (origin[layout.part(part)][:, None] for part in (0, 1))
        found, error = two_sum(high, moved)
        return np.concatenate([found + (error + rest)] if parts == 1 else two_sum(found, error + rest))

    def taken(self, done: int) -> Array:
        """The first samples: rows q, v and the integrals, of every part."""
        samples = self.samples[:, :done]
        if len(self.outer) == self.layout.rows:
            return samples
        parts = self.machine.program.parts
        rows = samples.reshape(parts, self.layout.rows, done)[:, self.outer]
        return np.ascontiguousarray(rows.reshape(parts * len(self.outer), done))

    def swap(self) -> None:
        """Leave ``samples`` as they are until the next ``swap``: go on in other memory."""
        spare = np.empty_like(self.samples) if self._spare is None else self._spare
        self.samples, self._spare = spare, self.samples


class Accelerated:
    """The rates of velocities and integrals at the state in the ``memory``. Their series is left in ``work``.
    (Addresses of arrays are asked for once.)"""

    def __init__(self, machine: Machine, constants: Array, memory: Array, work: Array) -> None:
        program, layout = machine.program, machine.program.inner
        self._memory, self._single, self._time = memory, work[: program.single], layout.time
        self._rates, self._constants = np.empty(layout.rows), constants
        arrays = constants, memory, work, self._rates
        self._first, *self._others = (one.ctypes.data for one in arrays)

    def rates(self, machine: Machine) -> tuple[Array, bool]:
        """The rates, until they are asked for again, and whether masses are regular."""
        self._single[:] = 0.0  # what is not finite would spread
        regular = machine.accelerate(self._first, float(self._memory[self._time]), *self._others)
        return self._rates, bool(regular)


def padded(wanted: Array) -> Array:
    """Instants of samples as ``advance`` takes them."""
    return np.concatenate([wanted, np.full(LANES, np.nan)])


def outer_rows(program: Interface) -> NDArray[np.intp]:
    """The rows of q, v and the integrals among those that steps have."""
    inner, own = program.inner, program.degrees
    integrals = np.arange(inner.integrals.start + program.arguments, inner.rows)
    return np.concatenate([np.arange(own), inner.degrees + np.arange(own), integrals])
