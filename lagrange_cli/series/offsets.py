"""At which index each series is evaluated, and in which order.

At stage k of a step the coefficient a[k] of the accelerations is solved for. It enters q[k+2], so a
series that is differentiated twice in the equations is evaluated at index k+2 (``level`` 2), with q[k+2]
= 0 first and corrected afterwards; a plain force is evaluated at index k (level 0). ``order`` counts the
time derivatives of q in a series: what has level + order = 2 depends on a[k], linearly. This is the
bookkeeping of offsets in Nedialkov and Pryce (BIT 45, 2005), for mechanics.
"""

from __future__ import annotations

from collections.abc import Iterable

from lagrange_cli.series.program import FREE, Series, SeriesProgram, needs


def set_levels(
    series: list[Series],
    coordinates: list[int],
    velocities: list[int],
    roots: list[int],
    integrals: list[int],
) -> None:
    for indices, level in ((coordinates, 2), (velocities, 1), (roots, 0), (integrals, 1)):
        for index in indices:
            series[index].level = max(series[index].level, level)
    pending = [i for i, one in enumerate(series) if one.level > FREE]
    while pending:
        one = series[pending.pop()]
        for index, ahead in needs(one):
            if series[index].level < one.level + ahead:
                series[index].level = one.level + ahead
                pending.append(index)
    for one in series:
        if one.order >= 0 and one.level > FREE and one.level + one.order > 2:
            raise ValueError("the equations hold more than two time derivatives of a coordinate")


def sort(
    series: list[Series],
    coordinates: list[int],
    velocities: list[int],
    roots: list[int],
    integrals: list[int],
) -> SeriesProgram:
    """Drop what nothing needs and order the rest so that same-stage operands come first."""
    order: list[int] = []
    done: set[int] = set()
    starts = [
        *coordinates,
        *velocities,
        *roots,
        *integrals,
        *(i for i, s in enumerate(series) if s.level > FREE),
    ]
    for start in starts:
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
        tuple(series[i] for i in order), moved(coordinates), moved(velocities), moved(roots), moved(integrals)
    )
