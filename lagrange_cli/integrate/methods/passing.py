"""How a motion passes a singular configuration, where its constraints become dependent for an instant.

A parallelogram linkage passes through the horizontal: the motion is smooth there, but multipliers are not
determined, and close by they are lost in rounding. The series of a step has a pole there of the size of
rounding errors, so that no step leads beyond it. What leads beyond is a polynomial through the motion at some
distance before (``leading``). It is believed if one of a lower degree agrees with it, if it satisfies the
constraints, and if the accelerations behind the singular configuration are its own. Where there are switches
or events, none of their arguments may be 0 on it. (No such polynomial agrees with another one across a kink
or a jump before.)
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import count, takewhile

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.methods.crawling import LITTLE, digits_lost
from lagrange_cli.integrate.methods.leading import CHOICES, Passage, passages
from lagrange_cli.integrate.workspace import Workspace
from lagrange_cli.native.state import BEGINNING, Clock

HALVINGS, PART = 10, 1 / 64
"""It is known on as much of the time before as memory reaches back, and on half of it so many times; or else
down to this part of a usual step. On less than that it is not told from rounding."""
ROUNDED = 2.0**20
"""Nor is it on less than so many units in the last place of the time."""
KEPT = 8
"""So many memories of earlier times are kept. Close to a singular configuration, thousands of steps may lead
nowhere, and what is before them counts."""
COARSER, AS_WELL = 1000, 10
"""Polynomials need not agree better than to so many times the tolerance of steps; those that agree to so many
times that are as good as each other."""
SATISFIED, ACCELERATED = 10, 1e5
"""The constraints and the accelerations must agree with them to so many times what they agree to."""
LOOKS = 65
"""Places where signs of arguments are looked at: of smooth motions."""
MOST_REPLAYED = 1 << 17
"""So many steps are taken again for all polynomials together. The longer the time is that one is known on,
the fewer it takes; those on shorter times are left out."""
UNASKED = 1 << 10
"""So many of them are taken before signals are asked for, so that a motion that is interrupted again and
again, and begins to pass anew each time, gets beyond most configurations."""
FIRST_LOOK = 4
"""Marks, each of so many steps as ``MARK``, before a motion is looked at."""
LOST = 2.0**18
"""Relative errors of coordinates that are multiplied by so much, in the accelerations, say that a singular
configuration is near where steps are short; by the square of that, that it is there."""
CLOSER = 5
"""So many times the time of a singular configuration is found to an eighth of what it was known to."""
PROJECTIONS = 4
"""How often the state behind is moved to the constraints."""


def ways(
    space: Workspace,
    longest: float,
    shortest: float,
    sampled: Callable[[Array], Array | None],
    tolerance: float,
) -> Iterator[Passage]:
    """Polynomials that lead beyond the singular time and with which lower degrees agree: that of the least
    estimated error first; of those with errors of rounding, or of steps within the ``tolerance``, the
    longest. (Close behind the singular time, steps would lead nowhere.)"""
    parts = space.machine.program.parts
    agreed, exact = agreement(parts, tolerance), max(CHOICES[parts].rounding, AS_WELL * tolerance)
    singular = space.t
    for part in CHOICES[parts].away:
        fitted = passages(singular, lengths(singular, longest, shortest), sampled, parts, part)
        found = [one for one in fitted if one.error <= agreed]
        yield from sorted(found, key=lambda one: (max(one.error, exact), -one.stop))


def agreement(parts: int, tolerance: float) -> float:
    """How well lower degrees must agree, relative to the motion."""
    return max(CHOICES[parts].agreed, COARSER * tolerance)


def lengths(singular: float, longest: float, shortest: float) -> Iterator[float]:
    """The times before the singular one that polynomials are fitted to."""
    least = max(shortest, ROUNDED * np.spacing(abs(singular)))
    return takewhile(lambda one: one > least, (longest * 0.5**k for k in count()))


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
    most: int,
    sure: bool,
    tolerance: float,
    limited: bool = False,
) -> tuple[tuple[Passage, float] | None, bool]:
    """Move the motion beyond the singular configuration that it has stopped at, if what leads beyond is
    believed and ends before ``end``: on what way, and when that is singular; and whether this end has
    ``limited`` the choice, or did so before.
    ``origins`` are the memories at earlier times, the earliest first. ``pause`` is given the time and says
    how many steps of the motion may be taken again at once, 0 if it is to end here; in all, ``most`` are.
    Ways come first on which accelerations lose so many digits that the configuration is there; other ones
    are taken only if it is ``sure`` that there is one. Steps were taken within a relative ``tolerance``."""
    layout, memory, singular = space.layout, space.memory.copy(), space.t
    longest = singular - float(origins[0][layout.time])
    usual = max(float(one[layout.at(Clock.STEP)]) for one in origins)
    shortest = usual * PART or longest * 0.5**HALVINGS
    left, agreed = most, agreement(space.machine.program.parts, tolerance)

    def more(steps: int) -> int:
        nonlocal left
        left -= steps
        unasked = left - (most - UNASKED)
        return unasked if unasked > 0 else min(left, pause(singular))

    def sampled(times: Array) -> Array | None:
        before = [one for one in origins if one[layout.time] <= times[0]]
        return space.again(before[-1], times, more)

    other: tuple[Passage, float] | None = None
    for way in ways(space, longest, shortest, sampled, tolerance):
        limited = limited or way.stop >= end
        if way.stop < end:
            space.memory[:] = memory
            _go(space, way)
            time, lost = where(space, way, singular)
            if _uneventful(space, way) and _believed(space, way, agreed):
                if lost > LOST**2:
                    return (way, time), limited
                other = other or (way, time)
    space.memory[:] = memory
    if other is None or not sure:
        return None, limited
    _go(space, other[0])
    return other, limited


def _go(space: Workspace, way: Passage) -> None:
    """To the end of a passage, as a motion begins."""
    layout, memory = space.layout, space.memory
    for rest in (layout.part(1), slice(layout.third, layout.third + layout.width)):
        memory[rest] = 0.0
    for part, values in enumerate(np.split(way.at(np.array([way.stop]))[:, 0], layout.parts)):
        memory[layout.part(part)] = values
    memory[[layout.at(one) for one in BEGINNING]] = 0.0
    memory[layout.time], memory[layout.at(Clock.TIME_LOW)] = way.stop, 0.0
    projections = memory[layout.at(Clock.PROJECTIONS)]
    for _ in range(PROJECTIONS):
        space.project()
    memory[layout.at(Clock.PROJECTIONS)] = projections + 1


def _uneventful(space: Workspace, way: Passage) -> bool:
    """Whether no argument of a guard changes its sign on the way: those are rates of integrals."""
    program = space.machine.program
    if not program.guarded:
        return True
    first = space.layout.integrals.start
    rows = slice(first, first + program.rows_of_guards.arguments)
    signs = np.array([np.sign(way.rates(t)[rows]) for t in np.linspace(way.known, way.stop, LOOKS)])
    return bool(np.all(signs == signs[0]))


def _believed(space: Workspace, way: Passage, agreed: float) -> bool:
    """Whether the state there satisfies the constraints, and the accelerations are the equations' own, as far
    as lower degrees have ``agreed``."""
    layout = space.layout
    motion = way.at(np.array([way.stop]))[layout.motion, 0]
    moved, scale = np.abs(space.memory[layout.motion] - motion), float(np.max(np.abs(motion)))
    rates, due = space.rates()[layout.q], way.rates(way.stop)[layout.v]
    size = float(np.max(np.abs(due))) + scale
    satisfied = float(np.max(moved)) <= SATISFIED * agreed * scale
    return satisfied and float(np.max(np.abs(rates - due))) <= ACCELERATED * agreed * size


def where(space: Workspace, way: Passage, before: float) -> tuple[float, float]:
    """The time of the singular configuration on the way, after ``before``: where accelerations lose most
    digits, and how many times larger relative errors are there."""
    memory, layout, (low, high) = space.memory.copy(), space.layout, (before, way.stop)
    for _ in range(CLOSER):
        times = np.linspace(low, high, 17)
        lost = []
        for t, state in zip(times, way.at(times)[: layout.rows].T, strict=True):
            space.memory[layout.part(0)], space.memory[layout.time] = state, t
            lost.append(digits_lost(space))
        lost = np.nan_to_num(lost, nan=np.inf).tolist()
        best = int(np.argmax(lost))
        low, high = times[max(best - 1, 0)], times[min(best + 1, 16)]
    space.memory[:] = memory
    return float(times[best]), lost[best]


MARK = 256
"""After so many steps the memory is kept: neither a clock nor samples decide from where a singular
configuration is passed."""


class EarlierTimes:
    """The last ``memories`` of a workspace that are kept, since a ``singular`` configuration was passed; and
    the times when that was."""

    def __init__(self, space: Workspace, tolerance: float) -> None:
        self.space, self.memories, self.singular = space, tuple[Array, ...](), tuple[float, ...]()
        self._tolerance = tolerance

    def keep(self, steps: int) -> None:
        """Keep the memory, if that is due after so many steps."""
        place = self.space.layout.time
        due = steps % MARK == 0 and self.memories[-1:] and self.memories[-1][place] != self.space.t
        if due or not self.memories:
            self.memories = thinned((*self.memories, self.space.memory.copy()), place)

    def steps_to_mark(self, steps: int) -> int:
        """How many steps there are, after ``steps``, until a memory may be due."""
        return MARK - steps % MARK

    def near(self, steps: int) -> bool:
        """Whether the motion may be just before a singular configuration, after so many steps: since the last
        one, half of them have hardly advanced, at this pace, and accelerations lose digits. That is looked at
        after 2^k steps, as the state tells by how often it was moved to the constraints."""
        if steps % MARK or not self.memories:
            return False
        memory, first, last = self.space.memory, self.memories[0], self.memories[-1]
        place, counted = self.space.layout.time, self.space.layout.at(Clock.PROJECTIONS)
        marks = int(memory[counted] - first[counted]) // MARK
        if marks < FIRST_LOOK or marks & (marks - 1):
            return False
        progress = abs(memory[place] - last[place]) * marks / 2
        elapsed = abs(memory[place] - first[place])
        return bool(progress <= LITTLE * elapsed) and digits_lost(self.space) > LOST

    def passed(
        self, wanted: Array, stop: float, pause: Callable[[float], int], steps: int | None, *, limited: bool
    ) -> tuple[Array | None, bool]:
        """Pass a singular configuration that the motion has stopped at or, after so many ``steps``, may be
        ``near``: the samples (rows, n) on the way, or None where that is impossible or is not to be done
        (``pause``, see ``passing.passed``); and whether the stop time has influenced the motion, as it has
        before if it is ``limited``."""
        before, place = self.space.t, self.space.layout.time
        origins = [one for one in self.memories if one[place] < before]
        if not origins:
            return None, limited
        most, sure = MOST_REPLAYED if steps is None else min(steps, MOST_REPLAYED), steps is None
        given, tolerance = (self.space, origins, stop, pause), self._tolerance
        found, limited = passed(*given, most=most, sure=sure, tolerance=tolerance, limited=limited)
        if found is None:
            return None, limited
        way, time = found
        self.singular, self.memories = (*self.singular, time), ()
        return way.at(wanted[wanted <= way.stop]), limited
