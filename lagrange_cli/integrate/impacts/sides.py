"""The sides of events in the memory of a motion's state, and what is known of their arguments there."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from lagrange_cli.decimals import decimal
from lagrange_cli.integrate.arrays import at_one_state, at_states, largest_of
from lagrange_cli.integrate.events import parameters_in
from lagrange_cli.integrate.guards.latest import Latest
from lagrange_cli.integrate.guards.modes import ROUNDING
from lagrange_cli.integrate.impacts.impulses import Impulses
from lagrange_cli.native.state import Clock

SAME = 2.0**-46
"""Zeros within this part of the time, or of a step, are at the same time."""
JUMP = 2.0**-20
"""An argument on the wrong side that is this part of its change in a step has not been 0 just now."""
TREMBLES = 2.0**-8
"""The same where nothing jumps: it is rounded, as where the motion rests."""
KNOWN = 4
"""What actions set is kept for so many states."""
COUPLED = 1.0
"""Impulses of constraints leave this part of the rounding errors of the largest velocity in all others: they
add up along chains."""

T = TypeVar("T")

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.integrate.guards.settling import Settling


class Sides:
    """The sides of events, which are modes, and actions on the state.

    Where an argument is not 0, its event is on the side of its sign; where it is 0, on the side that the
    motion leads to. ``outer`` are the rows of q, v and the integrals.
    """

    def __init__(self, settling: Settling, outer: NDArray[np.intp]) -> None:
        program = settling.machine.program
        self.settling, self.memory, self.program, self.outer = settling, settling.memory, program, outer
        self.layout, self.guards = program.inner, program.rows_of_guards
        starts = range(0, program.parts * self.layout.width, self.layout.width)
        self.places = np.concatenate([start + outer for start in starts])
        """Those rows in the memory, of all parts."""
        self.first = len(program.guards)
        """The guard of the first event."""
        self.modes = settling.modes[self.first : self.first + len(program.events)]
        """The sides of all events."""
        self.marks = settling.marks[self.first : self.first + len(program.events)]
        """The marks of all events."""
        self.directions = np.array([one[0] for one in program.events])
        """Those in which their arguments' signs must change; 0 for any."""
        self.chosen = np.full(len(program.events), np.nan)
        """When the side of each event was chosen last: not by crossing 0."""
        self._known = Latest["Array"](KNOWN)
        self._present = Latest[dict[str, Any]](KNOWN)
        self.sets: dict[int, list[tuple[int, int]]] = {}
        """By events with actions: the numbers and places of what they set."""
        for i, (event, place) in enumerate(program.changed):
            self.sets.setdefault(event, []).append((i, place))

    @property
    def now(self) -> float:
        """The time, without its low part."""
        return float(self.memory[self.layout.time])

    def side(self, event: int) -> float:
        """1 or -1; 0 where the motion rests at the event."""
        return float(self.modes[event])

    def at_zero(self, event: int) -> bool:
        """Whether its argument is 0 now."""
        return bool(self.settling.marks[event + self.first] > 0.0)

    def leaves_zero(self, event: int, near: float) -> bool:
        """Whether its argument moves away from 0 to the side where it is already. Shortly after it was 0, as
        when another event happens at almost the same time, rounding does not tell its value from 0: it may
        be so ``near``. (Where an action has put it beyond 0 by more, it does not come back.)"""
        value, rate = (self.coefficients(event)[:2] * self.side(event)).tolist()
        if not rate > 0.0:
            return False
        noise = ROUNDING * self.sizes()[event]
        return bool(value >= -max(noise[0], near) and rate > noise[1])

    def together(self, event: int) -> list[int]:
        """The other events whose arguments become 0 at the same time as that of an ``event``, from either
        side."""
        now, rates = self._at_zero_now()
        return _others(event, now & (rates * self.modes < 0.0) & (self.marks == 0.0))

    def passed(self, event: int, times: Array) -> list[int]:
        """The other events whose arguments have just passed 0, but which have not acted: they did so last at
        these ``times``."""
        now, rates = self._at_zero_now()
        return _others(event, now & (rates * self.modes > 0.0) & (self.marks > 0.0) & ~self.at_once(times))

    def at_once(self, times: Array) -> Any:
        """Which times are not told from now."""
        return np.abs(self.now - times) <= SAME * max(abs(self.now), self.settling.length())

    def _at_zero_now(self) -> tuple[NDArray[np.bool_], Array]:
        """Which arguments of events are 0, as far as times can be told; and their rates."""
        values, rates = self.all_coefficients()[:, :2].T
        time = SAME * max(abs(self.now), self.settling.length())
        return np.abs(values) <= np.abs(rates) * time, rates

    def has_jumped(self, event: int, length: float, near: float) -> bool:
        """Whether its argument, which is beyond 0, jumps, as over the cut of atan2, or trembles by rounding:
        it is off by more than is ``near`` 0, and than it changes in a step of this ``length``."""
        value, *others = np.abs(self.coefficients(event)).tolist()
        part = JUMP if self.guards.guards[event + self.first].jumps else TREMBLES
        changes = part * sum(one * length**k for k, one in enumerate(others, 1))
        return bool(value > max(ROUNDING * self.sizes()[event, 0], near, changes))

    def coefficients(self, event: int) -> Array:
        """The first ones of its argument's series, from the value on."""
        return self.settling.coefficients_of(self.guards.guards[event + self.first].row)[0]

    def all_coefficients(self) -> Array:
        """The coefficients of every event's argument (events, coefficients)."""
        row = self.guards.guards[self.first].row
        return self.settling.coefficients_between(row, row + len(self.program.events))

    def switches(self) -> Array:
        """The values of the arguments of switches."""
        first = self.guards.first
        return self.settling.coefficients_between(first, first + self.settling.count)[:, 0]

    def state(self, memory: Array) -> Array:
        """The rows outside, of all parts."""
        rows: Array = memory[self.places]
        return rows

    def parameters(self) -> Array:
        """The parameters of the run, of all parts: actions may have changed them."""
        return parameters_in(self.program, self.memory)

    def largest_velocity(self) -> float:
        """That of all coordinates; what forces of contact have added up to is none."""
        n = self.program.degrees
        return largest_of(self.memory[self.outer[n : 2 * n]])

    def flip(self, event: int) -> None:
        """The motion has passed to its other side."""
        self.settling.modes[event + self.first] *= -1.0
        self.settling.mark([event + self.first])

    def act_on(self, state: Array) -> tuple[Array, Array]:
        """What actions set, were they all done now (parts, values), and the sizes of arguments
        (events, 2)."""
        rows = self._acted(state)
        return rows[:, : len(self.program.changed)], self._sizes(rows)

    def sizes_then(self, memory: Array) -> Array:
        """The sizes of arguments (events, 2) in the memory of an earlier state: parameters may have been
        others."""
        settings, constants = memory[self.layout.settings].copy(), np.empty_like(self.settling.constants)
        self.settling.machine.prepare(settings.ctypes.data, constants.ctypes.data)
        when = memory[[self.layout.at(part) for part in (Clock.TIME, Clock.TIME_LOW)]]
        return self._sizes(self._act(constants, when, self.state(memory)))

    def _sizes(self, rows: Array) -> Array:
        """The sizes of arguments (events, 2) among what ``@act`` computes."""
        count, events = len(self.program.changed), len(self.program.events)
        return rows[0, count : count + 2 * events].reshape(events, 2)

    def act_now(self) -> tuple[Array, Array]:
        """The same in the present state."""
        return self.at_present("actions", lambda: self.act_on(self.state(self.memory)))

    def at_present(self, name: str, compute: Callable[[], T]) -> T:
        """What ``compute`` finds out about the present state, under a ``name``: once, as long as nothing
        changes on which series depend. It must not be changed."""
        found = self._present.of(self.settling.given(), dict)
        if name not in found:
            found[name] = compute()
        known: T = found[name]
        return known

    def speeds(self, states: Array) -> Array | None:
        """The rates of the arguments of impacts in some states (rows, n) at the present time: (impacts, n).
        None where code does not compute them."""
        settling, program = self.settling, self.program
        function, count = settling.machine.speeds, len(program.slowing)
        if function is None:
            return None
        settling.prepare()
        if program.parts == 1:
            return at_states(function, settling.constants, self.now, states, count)
        when, count = self._when(), count * program.parts
        each = [at_one_state(function, settling.constants, when, one, count) for one in states.T.copy()]
        return np.stack(each, axis=1)[: len(program.slowing)]

    def sizes(self) -> Array:
        """The sizes of arguments now (events, 2)."""
        return self.act_now()[1]

    def least_sizes(self) -> Array:
        """The sizes of values and rates (2,) whose rounding errors all events may have: where constraints
        couple coordinates and velocities, those of the largest."""
        if not self.program.constraints:
            return np.zeros(2)
        return self.at_present("least sizes", self._largest)

    def _largest(self) -> Array:
        places = self.outer[: self.program.degrees]
        return COUPLED * np.array([largest_of(self.memory[places]), self.largest_velocity()])

    def _masses(self) -> Array:
        """The present values of the masses that actions change."""
        rows = self._acted(self.state(self.memory))
        return rows[0, rows.shape[1] - len(self.program.masses) :]

    def without_mass(self) -> str:
        """The first mass that actions have made 0 or negative, or nothing."""
        masses = zip(self.program.masses, self._masses()) if self.program.masses else ()
        for name, mass in masses:
            if not mass > 0.0:
                body, _, axes = name.partition(" ")
                if axes:  # a part of its inertia
                    return f"the moments of inertia of {body!r} those of no body"
                return f"the mass of {name!r} {decimal(mass)}"
        return ""

    def _when(self) -> Array:
        """The present time, and its low part."""
        return self.memory[[self.layout.at(part) for part in (Clock.TIME, Clock.TIME_LOW)]]

    def _acted(self, state: Array) -> Array:
        """All that ``@act`` computes (parts, values)."""
        when = self._when()
        given = np.concatenate([when, self.memory[self.layout.settings], state])
        return self._known.of(given.tobytes(), lambda: self._computed(when, state))

    def _computed(self, when: Array, state: Array) -> Array:
        self.settling.prepare()
        return self._act(self.settling.constants, when, state)

    def _act(self, constants: Array, when: Array, state: Array) -> Array:
        act, program = self.settling.machine.act, self.program
        assert act is not None
        found = at_one_state(act, constants, when, state, program.parts * program.acted)
        return found.reshape(program.parts, -1)

    def put(self, event: int, values: Array) -> bool:
        """Set what an action sets to ``values``, which ``act_on`` gave; whether these are finite."""
        program, layout, memory = self.program, self.layout, self.memory
        width, motion = self.guards.parameters + self.guards.count, 2 * program.degrees
        chosen = self.sets[event]
        if not np.all(np.isfinite(values[:, [i for i, _ in chosen]])):
            return False
        for i, place in chosen:
            if place < motion:
                row = int(self.outer[place])
                memory[[row, layout.width + row, layout.third + row]] = 0.0
                memory[[part * layout.width + row for part in range(program.parts)]] = values[:, i]
            else:
                first = layout.settings.start + place - motion
                memory[[first + part * width for part in range(program.parts, program.given)]] = 0.0
                memory[[first + part * width for part in range(program.parts)]] = values[:, i]
        self.begin_anew()
        return True

    def move(self, rows: NDArray[np.intp], changes: Array, nothing: Array | float) -> None:
        """Add ``changes`` to what is at some rows of the memory, with all digits: arguments of events are
        computed from these. What is left is 0 up to ``nothing``."""
        layout, moved = self.layout, changes != 0.0
        rows, changes = rows[moved], changes[moved]
        high, low = self.memory[rows], self.memory[layout.width + rows]
        total = high + changes
        low += (high - (total - (total - high))) + (changes - (total - high))
        none = np.abs(total) <= np.broadcast_to(nothing, moved.shape)[moved]
        total[none] = low[none] = 0.0
        self.memory[rows], self.memory[layout.width + rows] = total, low
        self.memory[layout.third + rows] = 0.0

    def turns(self, event: int, new: Array) -> bool:
        """Whether an action that sets ``new`` values turns the motion back to the side it came from."""
        velocities = range(self.program.degrees, 2 * self.program.degrees)
        own, memory = self.sets.get(event, ()), self.memory.copy()
        if not own or not all(place in velocities for _, place in own):
            return False
        before = float(self.coefficients(event)[1])
        turns = self.put(event, new) and not before * float(self.coefficients(event)[1]) > 0.0
        self.memory[:] = memory
        self.settling.prepare()
        return turns

    def changes_nothing(self, event: int, new: Array) -> bool:
        """Whether an action sets values that are already there."""
        own = self.sets.get(event, ())
        there = np.concatenate([self.state(self.memory), self.parameters()])
        motion, rows = 2 * self.program.degrees, self.program.rows * self.program.parts
        places = [place if place < motion else rows + place - motion for _, place in own]
        return bool(own) and bool(np.array_equal(new[0, [i for i, _ in own]], there[places]))

    def close(self, event: int) -> bool:
        """Let the forces of constraint act after an action; whether that leads to the constraints."""
        return Impulses(self.settling).close(event, self.outer, self.sets[event])

    def begin_anew(self) -> None:
        """Forget what was known of the motion before: momenta follow from velocities."""
        layout = self.layout
        for start in (0, layout.width, layout.third):
            self.memory[start + layout.cyclic_momenta.start : start + layout.cyclic_momenta.stop] = 0.0
        self.settling.begin_steps()
        self.settling.prepare()

    def choose_side(self, event: int, values: Array, noise: float, rate: float) -> bool:
        """The side of an event at the state as it is. Its argument's coefficients are ``values``, and up to
        ``noise`` it is 0; its rate's terms are as large as ``rate``. Returns whether it does not stay 0."""
        settling, j = self.settling, event + self.first
        settling.marks[j], self.chosen[event] = 0.0, self.now
        leads: float | None = float(values[0])
        if not abs(values[0]) > noise:
            settling.mark([j])
            leads = next(self.counting(values, rate), None)
        settling.modes[j] = 1.0 if (-settling.modes[j] if leads is None else leads) > 0.0 else -1.0
        return leads is not None

    def counting(self, values: Array, rate: float) -> Iterator[float]:
        """The ``values`` of an argument's coefficients behind the first that are more than rounding, where
        the terms of its rate are as large as ``rate``; the series was computed just now."""
        speed = self.largest_velocity()
        scale = self.settling.scale() * (rate / speed if min(rate, speed) > 0.0 else 1.0)
        sizes = [rate, *np.fmax(scale[1:-1], scale[2:])]
        return (float(one) for one, size in zip(values[1:], sizes) if not abs(one) <= ROUNDING * size)


def _others(event: int, chosen: NDArray[np.bool_]) -> list[int]:
    """The chosen ones beside an event."""
    return [e for e in np.flatnonzero(chosen).tolist() if e != event]
