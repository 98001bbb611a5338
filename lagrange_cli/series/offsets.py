"""At which index each series is evaluated, and in which order.

At stage k of a step the coefficient a[k] of the accelerations is solved for. It enters q[k+2], so a
series that is differentiated twice in the equations is evaluated at index k+2 (``level`` 2), with q[k+2]
= 0 first and corrected afterwards; a plain force is evaluated at index k (level 0). ``order`` counts the
time derivatives of q in a series: what has level + order = 2 depends on a[k], linearly. So do the
multipliers of constraints, which are solved for together with a[k]: level 0, order 2. This is the
bookkeeping of offsets in Nedialkov and Pryce (BIT 45, 2005), for mechanics.
"""

from __future__ import annotations

from collections.abc import Iterable

from lagrange_cli.records import replace
from lagrange_cli.series.program import FREE, SHORT, Op, Series, SeriesProgram, needs


def set_levels(series: list[Series], starts: Iterable[tuple[Iterable[int], int]]) -> None:
    """Set the levels that ``starts``, series with their levels, call for: the least ones."""
    for indices, level in starts:
        for index in indices:
            series[index].level = max(series[index].level, level)
    pending = [i for i, one in enumerate(series) if one.level > FREE]
    while pending:
        one = series[pending.pop()]
        for index, ahead in needs(one):
            if series[index].level < one.level + ahead:
                series[index].level = one.level + ahead
                pending.append(index)
    check_order(series)


def set_levels_beside(series: list[Series], integrals: Iterable[int], apart: bool) -> None:
    """Set the levels of series that ``integrals`` alone need, after those of the motion.

    Series that the motion needs, too, but at a later stage, are copied: else they would be rounded
    differently than without the integrals. That is so where a series would depend on the accelerations of its
    stage or, if convolutions are summed side by side (``apart``), wherever it has any.
    """
    settled = [one.level for one in series]
    products = [one.level for one in series if one.op in (Op.MULTIPLY, Op.POWER) and one.level > FREE]
    least = min([0, *products]) if products else FREE + 1
    copies: dict[int, int] = {}
    pending: list[int] = []

    def need(index: int, level: int) -> None:
        if index < len(settled) and settled[index] > FREE:
            one = series[index]
            if level <= one.level:
                return
            if level + one.order == 2 or (apart and one.degree > SHORT):
                if index not in copies:
                    copies[index] = len(series)
                    series.append(replace(one, level=FREE))
                index = copies[index]
        level = max(level, least) if level > FREE else level  # loops begin where those of the motion do
        if series[index].level < level:
            series[index].level = level
            pending.append(index)

    for index in integrals:
        need(index, 1)
    while pending:
        one = series[pending.pop()]
        for index, ahead in needs(one):
            need(index, one.level + ahead)
    for number, one in enumerate(series):
        if copies and one.level > FREE and (number >= len(settled) or settled[number] == FREE):
            early = {
                i: copies[i] for i, ahead in needs(one) if i in copies and series[i].level < one.level + ahead
            }
            one.arguments = tuple(early.get(i, i) for i in one.arguments)
            one.sources = tuple(early.get(i, i) for i in one.sources)
    check_order(series)


def check_order(series: Iterable[Series]) -> None:
    """Raise ``ValueError`` where the equations cannot be solved in this way."""
    for one in series:
        if one.order >= 0 and one.level > FREE and one.level + one.order > 2:
            raise ValueError("the equations hold more than two time derivatives of a coordinate")


def sort(
    series: list[Series],
    coordinates: list[int],
    velocities: list[int],
    multipliers: list[int],
    roots: list[int],
    integrals: list[int],
    own: int,
    motion: Iterable[int],
    dependent: tuple[int, ...] = (),
) -> SeriesProgram:
    """Drop unused series and order the rest so that same-stage operands come first, and those of the
    ``motion`` before all else, with the first ``own`` integrals."""
    order: list[int] = []
    done: set[int] = set()
    first = [*coordinates, *velocities, *multipliers, *roots, *integrals[:own], *motion]
    last = [*integrals[own:], *(i for i, s in enumerate(series) if s.level > FREE)]
    for start in (*first, *last):
        stack = [(start, False)]
        while stack:
            index, ready = stack.pop()
            if ready:
                order.append(index)
            elif index not in done:
                done.add(index)
                stack.append((index, True))
                one = series[index]
                same = [i for i, ahead in needs(one) if series[i].level == one.level + ahead]
                stack += [(i, False) for i in same if i not in done]
    place = {index: i for i, index in enumerate(order)}

    def moved(indices: Iterable[int]) -> tuple[int, ...]:
        return tuple(place[i] for i in indices)

    for index in order:
        one = series[index]
        one.arguments, one.sources = moved(one.arguments), moved(one.sources)
    return SeriesProgram(
        tuple(series[i] for i in order),
        moved(coordinates),
        moved(velocities),
        moved(roots),
        moved(integrals),
        multipliers=moved(multipliers),
        motion=max((place[i] + 1 for i in first), default=0),
        dependent=dependent,
    )
