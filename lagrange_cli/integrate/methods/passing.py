"""How a motion passes a singular configuration, where its constraints become dependent for an instant.

A parallelogram linkage passes through the horizontal: the motion is smooth there, but multipliers are not
determined, and close by they are lost in rounding. The series of a step has a pole there of the size of
rounding errors, so that no step leads beyond it. What leads beyond is the polynomial through the motion at
some distance before (at Chebyshev points: L. N. Trefethen, Approximation Theory and Approximation Practice,
2013, ch. 5). It is believed if one of a lower degree agrees with it, if it satisfies the constraints, and if
the accelerations behind the singular configuration are its own. Where there are switches or events, none of
their arguments may be 0 on it. (No such polynomial agrees with another one across a kink or a jump before.)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.polynomial import chebyshev

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.workspace import Workspace
from lagrange_cli.native.state import BEGINNING, Clock
from lagrange_cli.records import dataclass

DEGREE, LOWER = 14, 12
AWAY = 1 / 75
"""How far the polynomial leads beyond the singular time, as a part of the time that it is known on."""
HALVINGS, PART = 10, 1 / 64
"""It is known on as much of the time before as memory reaches back, and on half of it so many times; or else
down to this part of a usual step. On less than that it is not told from rounding."""
ROUNDED = 2.0**20
"""Nor is it on less than so many units in the last place of the time."""
KEPT = 8
"""So many memories of earlier times are kept. Close to a singular configuration, thousands of steps may lead
nowhere, and what is before them counts."""
AGREED, SATISFIED, ACCELERATED = 1e-10, 1e-9, 1e-5
"""How well the polynomials, the constraints and the accelerations must agree, relative to the motion."""
EXACT = 2.0**-46
"""Polynomials that agree so well differ by rounding."""
LOOKS = 65
"""Places where signs of arguments are looked at: of polynomials of degree ``DEGREE``."""
MOST_REPLAYED = 1 << 17
"""So many steps are taken again for all polynomials together. The longer the time is that one is known on,
the fewer it takes; those on shorter times are left out."""
UNASKED = 1 << 10
"""So many of them are taken before signals are asked for, so that a motion that is interrupted again and
again, and begins to pass anew each time, gets beyond most configurations."""
PROJECTIONS = 4
"""How often the state behind is moved to the constraints."""


@dataclass(frozen=True)
class Passage:
    """A polynomial for all rows of the state between ``start`` and ``stop``: Chebyshev coefficients
    (degree + 1, rows) on the interval before the singular time, from ``start`` to ``known``."""

    start: float
    known: float
    stop: float
    coefficients: Array
    error: float

    def _place(self, t: Array) -> Array:
        return (2.0 * t - self.start - self.known) / (self.known - self.start)

    def at(self, times: Array) -> Array:
        """The states (rows, n) at times."""
        return np.asarray(chebyshev.chebval(self._place(times), self.coefficients))

    def rates(self, t: float) -> Array:
        """The rates (rows,) at a time."""
        slopes = chebyshev.chebder(self.coefficients) * (2.0 / (self.known - self.start))
        return np.asarray(chebyshev.chebval(self._place(np.array(t)), slopes))


def passages(
    singular: float, longest: float, shortest: float, sampled: Callable[[Array], Array | None]
) -> list[Passage]:
    """Polynomials that lead beyond the ``singular`` time, that of the least estimated error first; of those
    with rounding errors alone, the longest: close behind the singular time, steps would lead nowhere.

    ``sampled`` gives the states (rows, n) at times before it, up to ``longest`` before, or None.
    """
    found, length = list[Passage](), longest
    while length > max(shortest, ROUNDED * np.spacing(abs(singular))):
        away = length * AWAY
        start, known = singular - length, singular - away
        made = [_fitted(start, known, degree, sampled) for degree in (DEGREE, LOWER)]
        fine, coarse = made
        if fine is not None and coarse is not None:
            stop = singular + away
            place = (2.0 * stop - start - known) / (known - start)
            ends = [chebyshev.chebval(place, one) for one in (fine, coarse)]
            scale = max(1e-300, float(np.max(np.abs(ends[0]))))
            error = float(np.max(np.abs(ends[0] - ends[1]))) / scale
            found.append(Passage(start, known, stop, fine, error))
        length /= 2.0
    agreed = (one for one in found if one.error <= AGREED)
    return sorted(agreed, key=lambda one: (max(one.error, EXACT), -one.stop))


def _fitted(
    start: float, known: float, degree: int, sampled: Callable[[Array], Array | None]
) -> Array | None:
    """The Chebyshev coefficients of the interpolant."""
    points = np.sort(chebyshev.chebpts1(degree + 1))
    states = sampled((start + known) / 2.0 + (known - start) / 2.0 * points)
    if states is None or not np.all(np.isfinite(states)):
        return None
    return np.asarray(np.linalg.solve(chebyshev.chebvander(points, degree), states.T))


def thinned(memories: tuple[Array, ...], time: int) -> tuple[Array, ...]:
    """At most ``KEPT`` of the memories, which have their times at the place ``time``: the first, the last,
    and those between that are spread most evenly in the logarithm of how long before the last they are."""
    if len(memories) <= KEPT:
        return memories
    t = [float(one[time]) for one in memories]
    spare = min(range(1, len(t) - 1), key=lambda i: (t[i + 1] - t[i - 1]) / (t[-1] - t[i - 1]))
    return (*memories[:spare], *memories[spare + 1 :])


def passed(
    space: Workspace,
    origins: Sequence[Array],
    end: float,
    pause: Callable[[float], int],
    *,
    limited: bool = False,
) -> tuple[Passage | None, bool]:
    """Move the motion beyond the singular configuration that it has stopped at, if what leads beyond is
    believed and ends before ``end``; and whether this end has ``limited`` the choice, or did so before.
    ``origins`` are the memories at earlier times, the earliest first. ``pause`` is given the time and says
    how many steps of the motion may be taken again at once, 0 if it is to end here."""
    layout, memory, singular = space.layout, space.memory.copy(), space.t
    longest = singular - float(origins[0][layout.time])
    usual = max(float(one[layout.at(Clock.STEP)]) for one in origins)
    shortest = usual * PART or longest * 0.5**HALVINGS

    left = MOST_REPLAYED

    def more(steps: int) -> int:
        nonlocal left
        left -= steps
        unasked = left - (MOST_REPLAYED - UNASKED)
        return unasked if unasked > 0 else min(left, pause(singular))

    def sampled(times: Array) -> Array | None:
        before = [one for one in origins if one[layout.time] <= times[0]]
        return space.again(before[-1], times, more)

    for way in passages(singular, longest, shortest, sampled):
        limited = limited or way.stop >= end
        if way.stop < end:
            space.memory[:] = memory
            _go(space, way)
            if _uneventful(space, way) and _believed(space, way):
                space.memory[layout.at(Clock.PROJECTIONS)] = memory[layout.at(Clock.PROJECTIONS)] + 1
                return way, limited
    space.memory[:] = memory
    return None, limited


def _go(space: Workspace, way: Passage) -> None:
    """To the end of a passage, as a motion begins."""
    layout, memory = space.layout, space.memory
    memory[layout.part(0)] = way.at(np.array([way.stop]))[:, 0]
    for rest in (layout.part(1), slice(layout.third, layout.third + layout.width)):
        memory[rest] = 0.0
    memory[[layout.at(one) for one in BEGINNING]] = 0.0
    memory[layout.time], memory[layout.at(Clock.TIME_LOW)] = way.stop, 0.0
    for _ in range(PROJECTIONS):
        space.project()


def _uneventful(space: Workspace, way: Passage) -> bool:
    """Whether no argument of a guard changes its sign on the way: those are rates of integrals."""
    program = space.machine.program
    if not program.guarded:
        return True
    first = space.layout.integrals.start
    rows = slice(first, first + program.rows_of_guards.arguments)
    signs = np.array([np.sign(way.rates(t)[rows]) for t in np.linspace(way.known, way.stop, LOOKS)])
    return bool(np.all(signs == signs[0]))


def _believed(space: Workspace, way: Passage) -> bool:
    """Whether the state there satisfies the constraints, and the accelerations are the equations' own."""
    layout = space.layout
    motion = way.at(np.array([way.stop]))[layout.motion, 0]
    moved, scale = np.abs(space.memory[layout.motion] - motion), float(np.max(np.abs(motion)))
    rates, due = space.rates()[layout.q], way.rates(way.stop)[layout.v]
    size = float(np.max(np.abs(due))) + scale
    satisfied = float(np.max(moved)) <= SATISFIED * scale
    return satisfied and float(np.max(np.abs(rates - due))) <= ACCELERATED * size


MARK = 256
"""After so many steps the memory is kept: neither a clock nor samples decide from where a singular
configuration is passed."""


class EarlierTimes:
    """The last ``memories`` of a workspace that are kept, since a ``singular`` configuration was passed; and
    the times when that was."""

    def __init__(self, space: Workspace) -> None:
        self.space, self.memories, self.singular = space, tuple[Array, ...](), tuple[float, ...]()

    def keep(self, steps: int) -> None:
        """Keep the memory, if that is due after so many steps."""
        place = self.space.layout.time
        due = steps % MARK == 0 and self.memories[-1:] and self.memories[-1][place] != self.space.t
        if due or not self.memories:
            self.memories = thinned((*self.memories, self.space.memory.copy()), place)

    def steps_to_mark(self, steps: int) -> int:
        """How many steps there are, after ``steps``, until a memory may be due."""
        return MARK - steps % MARK

    def passed(
        self, wanted: Array, stop: float, pause: Callable[[float], int], *, limited: bool
    ) -> tuple[Array | None, bool]:
        """Pass a singular configuration: the samples (rows, n) on the way, or None where that is impossible
        or is not to be done (``pause``, see ``passing.passed``); and whether the stop time has influenced the
        motion, as it has before if it is ``limited``."""
        singular, place = self.space.t, self.space.layout.time
        origins = [one for one in self.memories if one[place] < singular]
        if not origins:
            return None, limited
        way, limited = passed(self.space, origins, stop, pause, limited=limited)
        if way is None:
            return None, limited
        self.singular, self.memories = (*self.singular, singular), ()
        return way.at(wanted[wanted <= way.stop]), limited
