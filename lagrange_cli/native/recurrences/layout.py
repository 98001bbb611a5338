"""Where the coefficients lie in memory: those of the state, of other series read again, and of *groups*.

The convolutions sum_m a[m] b[n-m] are summed side by side, a lane of a vector for each:
coefficient m of all their first operands is one vector in memory, and so is that of their second ones. Those
of different levels stand side by side, too: there n differs from lane to lane by what their operands are
shifted by. A vector is complete when the last of its lanes is known; so where that matters, the newest
coefficients are left out of it, and their terms added to each sum as numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from lagrange_cli.native.state import LANES, whole_vectors, width_of
from lagrange_cli.records import dataclass, replace
from lagrange_cli.series.program import SHORT, Op, SeriesProgram, needs, reciprocal

FIRST = 1
"""The first vector of a group."""
FEW = 6
"""Up to so many dot products the newest terms are numbers of their own; of more, these take longer than it
does to wait for all of a vector."""
MIXED = 4
"""Lanes of what is of different levels: to put eight together takes longer than it saves."""
NEAR = 2
"""By how many stages what stands side by side then may differ in how soon it is known."""
CARRIED = 3
"""So many stages long the coefficients that are read by themselves stay in registers. (A number that is
loaded from a vector in memory has to wait for all of it.)"""
PADDING = 8
"""Vectors of 0 before the coefficients of second operands: what a loop of so many stages reads too far."""


@dataclass(frozen=True)
class Dot:
    """sum_{m=1}^{n-1} w(m) a[m] b[n-m], n = k + ``level``, a part of series ``index``; w(m) = m if
    ``weighted``, else 1."""

    index: int
    level: int
    a: int
    b: int
    weighted: bool = False


@dataclass(frozen=True)
class DotGroup:
    """Dot products, a lane each; ``width`` lanes.

    Vector m of the first operands, at ``%work[first + width * m]``, and of the second ones, at
    ``%work[second + width * m]`` with zeros before vector 1, holds in each lane coefficient m + shift of the
    operand (``shifts``: of both). In stage k the vectors i and j with i + j = k + ``level`` meet: all terms
    of each sum but those of the coefficients 1 .. shift.
    """

    level: int
    dots: tuple[Dot, ...]
    shifts: tuple[tuple[int, int], ...]
    width: int
    first: int
    second: int


@dataclass(frozen=True)
class SeriesLayout:
    """Where things are in ``%work``.

    First the ``state``: coefficient m of q, v and the integrals, one after the other, at ``width * m``. Then
    the ``rows`` of other series, one after the other. Then the groups. Coefficients 0 are not stored.
    The first groups, ``motion`` of them, are those of the motion; the others are for integrals alone, which
    change neither how these are made nor how they are summed.
    """

    order: int
    state: dict[int, int]
    rows: dict[int, int]
    groups: tuple[DotGroup, ...]
    motion: int = 0

    @property
    def width(self) -> int:
        """Doubles from one coefficient of the state to the next."""
        return width_of(len(self.state))

    @property
    def doubles(self) -> int:
        """Size of ``%work``."""
        plain = whole_vectors((self.width + len(self.rows)) * (self.order + 1))
        parts = self.groups[: self.motion], self.groups[self.motion :]
        grouped = (sum(group.width * (2 * self.order + PADDING) for group in part) for part in parts)
        return plain + sum(whole_vectors(doubles) for doubles in grouped)

    def stride(self, series: int) -> int:
        """Doubles from one of its coefficients to the next."""
        return self.width if series in self.state else 1

    def slot(self, series: int, index: int = 0) -> int:
        """Where a coefficient is."""
        if series in self.state:
            return self.width * index + self.state[series]
        return (self.width + self.rows[series]) * (self.order + 1) + index


def arrange(program: SeriesProgram, order: int) -> SeriesLayout:
    """The layout for ``program`` with q's series to ``order``."""
    dots = list(dot_products(program))
    state = {index: row for row, index in enumerate(program.state)}
    own = [dot for dot in dots if dot.index < program.motion]
    motion = side_by_side(program, own)
    others = side_by_side(program, dots[len(own) :], lowest(program, motion) if motion else None)
    read = [*read_alone(program, dots), *read_apart([*motion, *others])]
    old = dict.fromkeys(index for index, ahead in read if program.series[index].level - ahead > CARRIED)
    rows = {index: row for row, index in enumerate(one for one in old if one not in state)}
    layout = SeriesLayout(order, state, rows, ())
    for groups in (motion, others):
        place, placed = layout.doubles, list[DotGroup]()
        for group in sorted(groups, key=lambda one: -one.width):  # so that all are aligned
            second = place + group.width * (order + PADDING)
            begin = FIRST * group.width
            placed.append(replace(group, first=place - begin, second=second - begin))
            place = second + group.width * order
        layout = replace(layout, groups=(*layout.groups, *placed), motion=len(motion))
    return layout


def lowest(program: SeriesProgram, groups: Iterable[DotGroup]) -> int:
    """The lowest level of a motion's convolutions, and of their ``groups``; 0 at most."""
    series = program.series[: program.motion]
    levels = [one.level for one in series if one.op in (Op.MULTIPLY, Op.POWER)]
    return min([0, *levels, *(group.level for group in groups)])


def side_by_side(program: SeriesProgram, dots: Sequence[Dot], least: int | None = None) -> list[DotGroup]:
    """Up to eight of one level at a time; where up to four are left, with those of levels near theirs.

    No group has a level below ``least``.
    """
    found: list[DotGroup] = []
    few: list[Dot] = []
    for level in sorted({dot.level for dot in dots}):
        same = [dot for dot in dots if dot.level == level]
        for part in (same[start : start + LANES] for start in range(0, len(same), LANES)):
            if len(part) > MIXED:
                found.append(grouped(program, part, least))
            else:
                few += part
    few.sort(key=lambda dot: settled(program, dot))
    while few:
        latest = settled(program, few[0]) + NEAR
        near = [dot for dot in few[:MIXED] if settled(program, dot) <= latest]
        few = few[len(near) :]
        found.append(grouped(program, near, least))
    return found


def grouped(program: SeriesProgram, dots: Sequence[Dot], least: int | None) -> DotGroup:
    """These, side by side.

    If they are few or of different levels, their vectors hold nothing newer than what was known two stages
    before: no lane waits for what only another one needs.
    """
    levels = {dot.level for dot in dots}
    waiting = len(dots) > FEW and len(levels) == 1
    level = min(levels) if waiting else min(settled(program, dot) for dot in dots)
    level = level if least is None else max(level, least)
    shifts = tuple(shifted(program, dot, dot.level - level) for dot in dots)
    return DotGroup(level, tuple(dots), shifts, next(w for w in (2, 4, 8) if w >= len(dots)), 0, 0)


def settled(program: SeriesProgram, dot: Dot) -> int:
    """The highest level of a group in whose vectors the newest coefficients of this one are not."""
    return dot.level - sum(newest(program, dot))


def newest(program: SeriesProgram, dot: Dot) -> tuple[bool, bool]:
    """Whether coefficient n-1 of the second, and of the first operand is of the stage just before.

    Then coefficient 1 of the other is not to be in a vector.
    """
    a, b = (program.series[index].level == dot.level for index in (dot.a, dot.b))
    return b, a


def shifted(program: SeriesProgram, dot: Dot, total: int) -> tuple[int, int]:
    """The shifts of both operands of a dot product, of which the sum is ``total``."""
    first, second = map(int, newest(program, dot)) if total else (0, 0)
    if first + second > total:  # one of the newest is in a vector
        second = 0
    while first + second < total:
        first, second = (first + 1, second) if first <= second else (first, second + 1)
    return first, second


def read_apart(groups: Iterable[DotGroup]) -> Iterable[tuple[int, int]]:
    """(series, ahead): coefficients k + ahead that the groups read by themselves in stage k."""
    for group in groups:
        for dot, (first, second) in zip(group.dots, group.shifts):
            yield from ((dot.a, group.level + first), (dot.b, group.level + second))
            yield from ((dot.b, dot.level - m) for m in range(1, first + 1))
            yield from ((dot.a, dot.level - m) for m in range(1, second + 1))


def dot_products(program: SeriesProgram) -> Iterable[Dot]:
    """The convolutions whose operands both go on, in order; a power needs two, its reciprocal one."""
    for index, one in enumerate(program.series):
        if one.op is Op.MULTIPLY and all(program.series[a].degree > SHORT for a in one.arguments):
            a, b = one.arguments
            yield Dot(index, one.level, a, b)
        elif one.op is Op.POWER and program.series[one.arguments[0]].degree > SHORT:
            yield Dot(index, one.level, index, one.arguments[0])
            if not reciprocal(one.data):
                yield Dot(index, one.level, index, one.arguments[0], weighted=True)


def read_alone(program: SeriesProgram, dots: list[Dot]) -> Iterable[tuple[int, int]]:
    """(series, ahead): coefficients k + ahead that are read by themselves in stage k, but for the newest."""
    series = program.series
    listed = [(index, 0) for index in program.residual]
    for dot in dots:
        listed += [(i, dot.level) for i in (dot.a, dot.b)]
    together = {dot.index for dot in dots}
    for index, one in enumerate(series):
        if one.op in (Op.MULTIPLY, Op.POWER) and index not in together:
            listed += [
                (i, one.level - SHORT) for i in (*one.arguments, *([index] if one.op is Op.POWER else []))
            ]
        listed += [(i, one.level + ahead) for i, ahead in needs(one)]
    stored = {index for index, one in enumerate(series) if one.degree > SHORT}
    for one in series:  # short ones whose product is not: a loop may begin where both still count
        if one.op is Op.MULTIPLY and one.degree > SHORT and stored.isdisjoint(one.arguments):
            stored |= {*one.arguments}
    return [(i, ahead) for i, ahead in listed if i in stored and ahead < series[i].level]
