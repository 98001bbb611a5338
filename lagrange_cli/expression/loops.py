"""The values that the indices of loops and keys take.

Where they are many and have conditions, they are found together (see ``index_loops``).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import groupby
from typing import TypeVar

from lagrange_cli.expression.indices import Indices, Unsuited, counted, holds, integer
from lagrange_cli.expression.syntax import Axis, ExpressionError, Loop, Sum, Tree

MANY = 64
"""Values of an index from which on they are examined together."""
Rows = list[list[int]]
Ranges = tuple[range, ...]
One = TypeVar("One", Axis, Loop)


def narrowed(loop: Sum, indices: Indices) -> Sequence[int]:
    """The values of a loop's index, in order; where they are many, without those that do not satisfy its
    conditions, or for which a loop within it has no rounds."""
    values = counted(loop, indices)
    inside: Tree = loop
    conditions = False
    while isinstance(inside, Sum):
        conditions = conditions or bool(inside.conditions)
        inside = inside.body
    if conditions and len(values) >= MANY:
        from lagrange_cli.expression.index_loops import values_of

        with suppress(Unsuited):
            return values_of(loop, indices)
    return values


def met(loop: Axis | Loop, indices: Indices) -> bool:
    """Whether the conditions of a loop hold."""
    return all(holds(one, indices) for one in loop.conditions)


def repeated(loops: Sequence[Loop], indices: Indices, most: int) -> Iterator[dict[str, int]]:
    """The values of the loops' indices, one after the other: an empty mapping where there are no loops.

    Raises:
        ExpressionError: where a range is none, or where there are more than ``most`` values of all loops.
    """
    names = [one.index for one in loops]
    found = together(loops, indices, most)
    if found is not None:
        yield from (dict(zip(names, row)) for row in found)
        return
    steps = 0

    def run(k: int, own: dict[str, int]) -> Iterator[dict[str, int]]:
        nonlocal steps
        if k == len(loops):
            yield own
            return
        for value in counted(loops[k], {**indices, **own}):
            steps += 1
            if steps > most:
                raise ExpressionError(loops[k].span, f"more than {most} repetitions", "shorten the ranges")
            inner = {**own, loops[k].index: value}
            if met(loops[k], {**indices, **inner}):
                yield from run(k + 1, inner)

    yield from run(0, {})


def together(loops: Sequence[One], indices: Indices, most: int) -> Rows | None:
    """The values of the indices of loops or keys, found together; None where there is no need to, or where
    that cannot be."""
    if not any(one.conditions for one in loops) or not any(is_long(one, indices) for one in loops):
        return None
    from lagrange_cli.expression.index_loops import places

    with suppress(Unsuited):
        found = places(loops, indices)
        if len(found) <= most:
            rows: Rows = found.tolist()
            return rows
    return None


def is_long(loop: Axis | Loop, indices: Indices) -> bool:
    """Whether its index is known to take many values, whatever those of others are."""
    with suppress(ExpressionError):
        return bool(loop.index) and len(counted(loop, indices)) >= MANY
    return False


def grids(axes: Sequence[Axis], indices: Indices, most: int) -> list[Ranges]:
    """The places of the members that a key stands for, in ascending order, as few grids: those of
    ``range(i)`` are one for each i. Raises as ``places``."""
    found = together(axes, indices, most)
    if found is not None:
        return grids_of(sorted(found)) if found else []
    steps = 0

    def run(k: int, known: Indices) -> list[Ranges]:
        nonlocal steps
        if k == len(axes):
            return [()]
        axis = axes[k]
        if not axis.index:
            value = integer(axis.bounds[0], known)
            return [(range(value, value + 1), *tail) for tail in run(k + 1, known)]
        values = counted(axis, known)
        steps += len(values)
        if steps > most:
            raise ExpressionError(axis.span, f"more than {most} repetitions", "shorten the ranges")
        values = values if values.step > 0 else values[::-1]
        found = [values] if values else []
        if axis.conditions:
            found = runs([i for i in values if met(axis, {**known, axis.index: i})])
        if k + 1 == len(axes):
            return [(one,) for one in found]
        return joined([(i, run(k + 1, {**known, axis.index: i})) for one in found for i in one])

    return run(0, indices)


def grids_of(places: Rows) -> list[Ranges]:
    """Places in ascending order as few grids."""
    if len(places[0]) == 1:
        return [(one,) for one in runs([i for (i,) in places])]
    begins = groupby(places, lambda place: place[0])
    return joined([(i, grids_of([rest for _, *rest in own])) for i, own in begins])


def joined(rows: Sequence[tuple[int, list[Ranges]]]) -> list[Ranges]:
    """The grids of places whose first numbers ascend, each with the grids of what follows."""
    alike = groupby((row for row in rows if row[1]), lambda row: row[1])
    return [(one, *tail) for tails, own in alike for one in runs([i for i, _ in own]) for tail in tails]


def runs(values: Sequence[int]) -> list[range]:
    """Ascending numbers as few ranges."""
    found: list[range] = []
    first = 0
    while first < len(values):
        step = values[first + 1] - values[first] if first + 1 < len(values) else 1
        last = first
        while last + 1 < len(values) and values[last + 1] - values[last] == step:
            last += 1
        found.append(range(values[first], values[last] + step, step))
        first = last + 1
    return found


def places(
    axes: Sequence[Axis], indices: Indices, most: int
) -> Iterator[tuple[tuple[int, ...], dict[str, int]]]:
    """The places of the members that a key stands for, each with the values of the indices in it.

    Raises:
        ExpressionError: where an index or a range is none, or where there are more than ``most``.
    """
    loops = [Loop(one.index, one.bounds, one.conditions, one.span) for one in axes if one.index]
    for own in repeated(loops, indices, most):
        known = {**indices, **own}
        yield tuple(own[one.index] if one.index else integer(one.bounds[0], known) for one in axes), own
