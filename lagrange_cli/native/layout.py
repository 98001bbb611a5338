"""Where the coefficients lie in memory: those of the state, of other series read again, and of *groups*.

The convolutions sum_m a[m] b[n-m] of one level are summed side by side, a lane of a vector for each:
coefficient m of all their first operands is one vector in memory, and so is that of their second ones.
"""

from __future__ import annotations

from collections.abc import Iterable

from lagrange_cli.mechanics.series import SHORT, Op, SeriesProgram, needs, reciprocal
from lagrange_cli.native.interface import LANES, width_of
from lagrange_cli.records import dataclass

FIRST = 2
"""The first coefficient of a group that is kept in memory."""
PADDING = 8
"""Vectors of 0 before the coefficients of second operands: what a loop of so many stages reads too far."""


@dataclass(frozen=True)
class Dot:
    """sum_{m=1}^{n-1} w(m) a[m] b[n-m], a part of series ``index``; w(m) = m if ``weighted``, else 1."""

    index: int
    a: int
    b: int
    weighted: bool = False


@dataclass(frozen=True)
class Group:
    """Dot products of series of one ``level``, a lane each; ``width`` lanes.

    Coefficient m >= 2 of the first operands is the vector at ``%work[first + width * m]``, of the others at
    ``%work[second + width * m]``; there are zeros before the latter. Coefficients 1 stay in registers.
    """

    level: int
    dots: tuple[Dot, ...]
    width: int
    first: int
    second: int


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
    parts: list[tuple[int, int, tuple[Dot, ...]]] = []
    for level in sorted({program.series[dot.index].level for dot in dots}):
        same = [dot for dot in dots if program.series[dot.index].level == level]
        for start in range(0, len(same), LANES):
            part = tuple(same[start : start + LANES])
            parts.append((next(w for w in (2, 4, 8) if w >= len(part)), level, part))
    groups: list[Group] = []
    for width, level, part in sorted(parts, key=lambda one: -one[0]):  # so that all are aligned
        second = place + width * (order + PADDING)
        groups.append(Group(level, part, width, place - FIRST * width, second - FIRST * width))
        place = second + width * order
    return Layout(order, state, rows, tuple(groups))


def dot_products(program: SeriesProgram) -> Iterable[Dot]:
    """The convolutions whose operands both go on, in order; a power needs two, its reciprocal one."""
    for index, one in enumerate(program.series):
        if one.op is Op.MULTIPLY and all(program.series[a].degree > SHORT for a in one.arguments):
            a, b = one.arguments
            yield Dot(index, a, b)
        elif one.op is Op.POWER and program.series[one.arguments[0]].degree > SHORT:
            yield Dot(index, index, one.arguments[0])
            if not reciprocal(one.data):
                yield Dot(index, index, one.arguments[0], weighted=True)


def read_alone(program: SeriesProgram, dots: list[Dot]) -> list[int]:
    """Series of which something is read by itself after its stage."""
    series = program.series
    listed = [index for index in program.residual if series[index].level > 0]
    for dot in dots:
        listed += [i for i in (dot.a, dot.b) if series[i].level > series[dot.index].level]
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
