"""Vectors that friction acts along and that come to rest: where one is so short that it is nothing but
rounding beside the velocities that it is made of, or in systems that have many of them, beside the fastest
velocity, it counts as 0. No step comes nearer.

Where one goes straight to 0, steps by series end there at once: friction keeps its direction on the way, and
what their terms show of it is rounding. Beyond, it has none, so that no series confirms the last of them.

Steps on rates end before. A vector u that they lead to 0, or past it so closely that their errors are larger,
is taken on to there if the way is so short that rates hardly change on it.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from lagrange_cli.native.guards import GuardRows
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import table
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.roots import NONE
from lagrange_cli.records import dataclass

WAY, LOOSER = 2.0**-24, 2.0**-6
"""How long it is at most, as part of the longest step: so much, or this part of the root of the tolerance.
The error of u is its square."""
ASIDE, ALLOWED = 2.0**-48, 0.25
"""How far u may be from 0 there, as part of the velocities that it is made of, or of what it loses in the
longest step: so much, or this part of the tolerance."""
RESOLVED = 2.0**-46
"""Both may be this part of the time, and of what u loses in it: nothing shorter is resolved."""
TINY, LITTLE = 2.0**-40, 32.0
"""A vector that becomes shorter may be 0 if it is no more than this part of the velocities that it is made
of, or so many times the tolerance: hardly anything of its direction is known, and steps would be as short as
their errors say, with friction to and fro."""
SHRINKS, SEEN = 0.5, 0.0625
"""In this step u becomes shorter, by at least this part of what its rate says, and the step is at least this
part of the way: rates of what hardly changes are rounding errors."""
NUMBERS = 5
"""Numbers of each vector in the table."""
FARTHER, FARTHEST = 1600.0, 4.0
"""The last terms of series may be so much larger than in other steps where a vector goes straight to 0: they
are rounding errors of its direction. Short steps may be so much longer."""
ROUNDS = 6
"""Better guesses."""
ENDS = 2.0**6
"""A way is short that fits into the last step so many times."""
STRAIGHT, SMALL = 2.0**-44, 2.0**-10
"""A vector goes straight to 0 if no more than this part of it is left there. It is small beside velocities
up to this part of them."""


@dataclass(frozen=True)
class Searched:
    """The guards, and where their arguments and modes are; up to which part of velocities a vector counts
    as 0."""

    rows: GuardRows
    lengths: Lengths
    layout: StateLayout
    part: float


def sliding(rows: GuardRows) -> list[int]:
    """The guards of vectors that friction acts along."""
    return [j for j in rows.vectors if rows.guards[j].multiplier]


def stopping_tables(rows: GuardRows) -> list[str]:
    """The numbers of those vectors, their first parts, the number of these, the coordinates that belong to
    them, and whether each is alone; and for each guard, which of them it is, from 1 on."""
    listed = sliding(rows)
    numbers, pivots = list[int](), list[int]()
    for j in listed:
        guard = rows.guards[j]
        numbers += [j, guard.beside, guard.parts, len(pivots), int(guard.alone)]
        pivots += guard.pivots
    places = {j: n for n, j in enumerate(listed, 1)}
    every = [places.get(j, 0) for j in range(rows.count)]
    tables = ("stopping", numbers), ("stopping_pivots", pivots), ("guard_vectors", every)
    return [table(*one) for one in tables] if listed else []


class Vector:
    """One of them, the ``i``-th in the table, in the step whose series are known."""

    def __init__(self, search: Searched, f: Function, i: Integer) -> None:
        self.search, self.f = search, f
        self.guard, self.first, self.count, self._pivot, self._alone = (
            f.load_integer("@stopping", i * NUMBERS + n) for n in range(NUMBERS)
        )

    @property
    def slides(self) -> Bit:
        """Whether friction acts along it."""
        place = self.guard + self.search.rows.mode(self.search.layout)
        return self.f.load("%state", place) > 0.0

    def part(self, k: Integer) -> Real:
        """A part of it."""
        return self.f.load(self._row(k), self.search.lengths.term)

    def rate(self, k: Integer) -> Real:
        """The rate of a part."""
        return self.f.load(self._row(k), 2 * self.search.lengths.term) * 2.0

    def later(self, k: Integer, t: Real) -> Real:
        """A part of it after a time."""
        return derivative_at(self.f, self.search.lengths, self._row(k), t)

    def time_left(self) -> Real:
        """When it is shortest if its rate is constant."""
        dot, square = self.total(self.part), self.total(self.rate)
        return -dot / square

    def nearer(self, t: Real) -> Real:
        """When it is across itself, from a time near then: by Newton's method."""
        f = self.f
        value, slope = f.variable(f.constant(0.0)), f.variable(f.constant(0.0))
        with f.loop(0, self.count) as k:
            now, row = self.part(k), self._row(k)
            value.set(f.fused(now, derivative_at(f, self.search.lengths, row, t), value.get()))
            slope.set(f.fused(now, derivative_at(f, self.search.lengths, row, t, 2), slope.get()))
        return t - value.get() / slope.get()

    def total(self, of: Callable[[Integer], Real]) -> Real:
        """The sum of something of each part times its rate."""
        f = self.f
        found = f.variable(f.constant(0.0))
        with f.loop(0, self.count) as k:
            found.set(f.fused(of(k), self.rate(k), found.get()))
        return found.get()

    def largest(self, of: Callable[[Integer], Real]) -> Real:
        """The largest size of something of each part."""
        f = self.f
        found = f.variable(f.constant(0.0))
        with f.loop(0, self.count, tested=False) as k:
            found.set(f.larger(found.get(), f.magnitude(of(k))))
        return found.get()

    def speed(self) -> Real:
        """The fastest of the velocities that it is made of."""
        return self.largest(lambda k: self.f.load("%state", self._place(k) + self.search.layout.degrees))

    def _place(self, k: Integer) -> Integer:
        return self.f.load_integer("@stopping_pivots", self._pivot + k)

    def _row(self, k: Integer) -> Pointer:
        return self.search.lengths.place(self.f, self.first + k)

    @property
    def alone(self) -> Bit:
        """Whether what holds it follows from other forces alone."""
        return self._alone.equals(1)


def derivative_at(f: Function, lengths: Lengths, row: Pointer, h: Real, which: int = 1) -> Real:
    """The first derivative of an integral after a time, or another one."""
    end = f.constant(0.0)
    for m in reversed(range(which, lengths.order)):
        end = f.fused(end, h, f.load(row, m * lengths.term) * float(math.perm(m, which)))
    return end


def fastest_of_all(search: Searched, f: Function) -> Real:
    """The fastest velocity."""
    lengths, found = search.lengths, f.variable(f.zero(search.lengths.lanes))
    with lengths.velocities(f) as row:
        found.set(f.larger(found.get(), row.only_velocities(f.magnitude(row.at("%state")))))
    return lengths.gather(f, "fmax", found.get())


def first_stopped(search: Searched, f: Function, earliest: Variable[Real], which: Variable[Integer]) -> None:
    """Set the ``earliest`` time to 0 where one of them is 0 but for rounding, and becomes shorter."""
    lengths, listed = search.lengths, sliding(search.rows)
    if not listed:
        return
    some = any(search.rows.guards[j].alone for j in listed)
    fastest = fastest_of_all(search, f) if some else f.constant(0.0)
    with f.loop(0, len(listed), tested=False) as i:
        vector = Vector(search, f, i)
        with f.when(vector.slides):
            near = f.select(vector.alone, fastest, vector.speed()) * search.part
            change = f.load(lengths.place(f, f.load_integer("@guard_rows", vector.guard)), 2 * lengths.term)
            with f.when((vector.largest(vector.part) <= near) & (change <= 0.0)):
                earliest.set(f.constant(0.0))
                which.set(vector.guard)


def first_straight(search: Searched) -> Function:
    """``@first_straight(state, work, h, last, usual)``: when the first vector is 0 that goes straight there,
    in a step that may be somewhat longer than ``h``; its guard; and whether the way there is short: a small
    part of the ``last`` step, or of the time in which velocities change. Steps are ``usual`` long."""
    given = "ptr %state, ptr %work, double %h, double %last, double %usual"
    f = Function(f"define internal {{ double, i64, i1 }} @first_straight({given}) #0")
    h, last, usual = f.reals("h", "last", "usual")
    rows, lengths = search.rows, search.lengths
    earliest, which = f.variable(f.constant(NONE)), f.variable(f.count(0))
    short, farther = f.variable(f.never(1)), f.constant(FARTHER ** (1.0 / lengths.top))
    fastest, passed = fastest_of_all(search, f), f.magnitude(f.load("%state", search.layout.time))
    with f.loop(0, len(sliding(rows)), tested=False) as i:
        vector = Vector(search, f, i)
        time = f.variable(vector.time_left())
        with f.when(vector.slides & (time.get() > 0.0) & (time.get() <= h * FARTHEST)):
            for _ in range(ROUNDS):
                time.set(vector.nearer(time.get()))
            t, speed = time.get(), vector.speed()
            now, end = (vector.largest(one) for one in (vector.part, lambda k: vector.later(k, t)))
            brief = (now <= speed * SMALL) | (t * ENDS <= last)
            rate = vector.largest(vector.rate)
            others = f.select(vector.alone, fastest, f.smaller(fastest, rate * passed))
            moved = f.larger(f.larger(speed, rate * usual), others)
            straight = end <= f.larger(now * STRAIGHT, moved * search.part)
            most = h * f.select(brief, f.constant(FARTHEST), farther)
            with f.when(straight & (t > 0.0) & (t <= most) & (t < earliest.get())):
                earliest.set(t)
                which.set(vector.guard)
                short.set(brief)
    f.give(earliest.get(), which.get(), short.get())
    return f


def first_reached(
    search: Searched, f: Function, tolerance: float, longest: int,
    earliest: Variable[Real], which: Variable[Integer],
) -> None:  # fmt: skip
    """The same of steps on rates where one of them is about to be 0. The ``longest`` step is in the state."""
    lengths, layout, listed = search.lengths, search.layout, sliding(search.rows)
    if not listed:
        return
    zero = f.constant(0.0)
    step, t = f.load("%state", longest), f.magnitude(f.load("%state", layout.time))
    most = f.larger(step * max(WAY, LOOSER * math.sqrt(tolerance)), t * RESOLVED)
    with f.loop(0, len(listed), tested=False) as i:
        vector = Vector(search, f, i)
        fastest, speed, left = vector.largest(vector.rate), vector.speed(), vector.time_left()
        row = lengths.place(f, f.load_integer("@guard_rows", vector.guard))
        end = derivative_at(f, lengths, row, Real(f, "%h"))
        part = f.smaller(f.constant(1.0), Real(f, "%h") / left)
        shrinks = (end <= f.load(row, lengths.term) * (1.0 - part * SHRINKS)) & (part >= SEEN)
        tiny = vector.largest(vector.part) <= speed * max(TINY, LITTLE * tolerance)
        with f.when(vector.slides & tiny & (left >= 0.0)):
            earliest.set(zero)
            which.set(vector.guard)
        with f.when(vector.slides & shrinks & (left >= 0.0) & (left <= most)):
            aside = vector.largest(lambda k: f.fused(vector.rate(k), left, vector.part(k)))
            scale = f.larger(speed, fastest * step) * max(ASIDE, ALLOWED * tolerance)
            with f.when(aside <= f.larger(scale, fastest * t * RESOLVED)):
                earliest.set(zero)
                which.set(vector.guard)
