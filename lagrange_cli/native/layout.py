"""Where the coefficients lie in memory: those of the state, of other series read again, and of *groups*.

The convolutions sum_m a[m] b[n-m] are summed side by side, a lane of a vector for each:
coefficient m of all their first operands is one vector in memory, and so is that of their second ones. Those
of different levels stand side by side, too: there n differs from lane to lane by what their operands are
shifted by.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from operator import lt

from lagrange_cli.mechanics.series import SHORT, Op, SeriesProgram, needs, reciprocal
from lagrange_cli.native.interface import LANES, width_of
from lagrange_cli.records import dataclass

FIRST = 2
"""The first coefficient of a group that is kept in memory."""
SHIFTS = ((0, 0), (1, 0), (1, 1))
"""By how much both operands of a dot product are shifted that is so many levels above its group's: they are
known when the vector is stored, or were one stage before."""
MIXED = 4
"""Lanes of what is of different levels: to put eight together takes longer than it saves."""
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
class Group:
    """Dot products, a lane each; ``width`` lanes. ``level`` is the lowest of theirs.

    Coefficient m of the first operands is in vector m - shift; vector m >= 2 of these is at
    ``%work[first + width * m]``, of the others at ``%work[second + width * m]``; there are zeros before the
    latter. Coefficients 1 and vectors 1 stay in registers.
    """

    level: int
    dots: tuple[Dot, ...]
    width: int
    first: int
    second: int

    @property
    def shifts(self) -> list[tuple[int, int]]:
        """Of each dot product, by how much its first and its second operand are shifted."""
        return [SHIFTS[dot.level - self.level] for dot in self.dots]

    @property
    def lagging(self) -> tuple[bool, bool]:
        """Whether vectors of first, and of second operands hold what is not newest."""
        levels = [dot.level - self.level for dot in self.dots]
        first, second = (any(map(lt, side, levels)) for side in zip(*self.shifts))
        return first, second

    @property
    def shifted(self) -> tuple[bool, bool]:
        """Whether any first, and whether any second operand is shifted: then vector 1 counts, too."""
        first, second = (max(side) > 0 for side in zip(*self.shifts))
        return first, second


@dataclass(frozen=True)
class Layout:
    """Where things are in ``%work``.

    First the ``state``: coefficient m of q, v and the integrals, one after the other, at ``width * m``. Then
    the ``rows`` of other series, one after the other. Then the groups. Coefficients 0 are not kept.
    """

    order: int
    state: dict[int, int]
    rows: dict[int, int]
    groups: tuple[Group, ...]

    @property
    def width(self) -> int:
        """Doubles from one coefficient of the state to the next."""
        return width_of(len(self.state))

    @property
    def doubles(self) -> int:
        """Size of ``%work``."""
        plain = LANES * -(-(self.width + len(self.rows)) * (self.order + 1) // LANES)
        grouped = sum(group.width * (2 * self.order + PADDING) for group in self.groups)
        return plain + LANES * -(-grouped // LANES)

    def stride(self, series: int) -> int:
        """Doubles from one of its coefficients to the next."""
        return self.width if series in self.state else 1

    def slot(self, series: int, index: int = 0) -> int:
        """Where a coefficient is."""
        if series in self.state:
            return self.width * index + self.state[series]
        return (self.width + self.rows[series]) * (self.order + 1) + index


def arrange(program: SeriesProgram, order: int) -> Layout:
    """The layout for ``program`` with q's series to ``order``."""
    dots = list(dot_products(program))
    listed = [*program.coordinates, *program.velocities, *program.integrals]
    state = {index: row for row, index in enumerate(listed)}
    rows = {
        index: row for row, index in enumerate(one for one in read_alone(program, dots) if one not in state)
    }
    place = Layout(order, state, rows, ()).doubles
    parts = [(next(w for w in (2, 4, 8) if w >= len(part)), part) for part in side_by_side(dots)]
    groups: list[Group] = []
    for width, part in sorted(parts, key=lambda one: -one[0]):  # so that all are aligned
        second = place + width * (order + PADDING)
        groups.append(Group(part[0].level, part, width, place - FIRST * width, second - FIRST * width))
        place = second + width * order
    return Layout(order, state, rows, tuple(groups))


def side_by_side(dots: Sequence[Dot]) -> list[tuple[Dot, ...]]:
    """Up to eight of one level at a time; where up to four are left, with those of levels near theirs."""
    found: list[tuple[Dot, ...]] = []
    few: list[Dot] = []
    for level in sorted({dot.level for dot in dots}):
        same = tuple(dot for dot in dots if dot.level == level)
        parts = [same[start : start + LANES] for start in range(0, len(same), LANES)]
        found += [part for part in parts if len(part) > MIXED]
        few += [dot for part in parts if len(part) <= MIXED for dot in part]
    while few:
        near = tuple(dot for dot in few if dot.level - few[0].level < len(SHIFTS))[:MIXED]
        found.append(near)
        few = few[len(near) :]
    return found


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


def read_alone(program: SeriesProgram, dots: list[Dot]) -> list[int]:
    """Series of which something is read by itself after its stage."""
    series = program.series
    listed = [index for index in program.residual if series[index].level > 0]
    for dot in dots:
        listed += [i for i in (dot.a, dot.b) if series[i].level > dot.level]
    together = {dot.index for dot in dots}
    for index, one in enumerate(series):
        if one.op in (Op.MULTIPLY, Op.POWER) and index not in together:
            listed += [*one.arguments, *([index] if one.op is Op.POWER else [])]
        listed += [i for i, ahead in needs(one) if series[i].level > one.level + ahead]
    stored = {index for index, one in enumerate(series) if one.degree > SHORT}
    for one in series:  # short ones whose product is not: a loop may begin where both still count
        if one.op is Op.MULTIPLY and one.degree > SHORT and stored.isdisjoint(one.arguments):
            stored |= {*one.arguments}
    return [index for index in dict.fromkeys(listed) if index in stored]
