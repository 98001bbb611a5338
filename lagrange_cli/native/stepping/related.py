"""What is nothing beside the largest of its family, and what it is measured by: velocities, and integrals.

Far down the tail of a wave, coordinates and velocities are 1e-50 of those of its head, and grow as high
powers of the time: only in very short steps are their series small beside themselves. They are measured by
the rounding error of the fastest velocity in the family instead. Their errors are then
below its square, so that also the momentum of a member with 2^60 times the mass is known to many digits.
The integrals of forces, in the balances of momenta, are measured by that of the largest one likewise.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import TYPE_CHECKING

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Pointer, Real
from lagrange_cli.native.stepping.lengths import Lengths

if TYPE_CHECKING:
    from lagrange_cli.expression.node import Node
    from lagrange_cli.model.model import Model

FAINT = 2.0**-52
"""The part of the fastest velocity."""
FEWEST = 4
"""Families of fewer members have no tail."""


def related(model: Model[Node], fewest: int = FEWEST) -> list[tuple[int, int]]:
    """The first coordinate of each family of some members, and their number."""
    return of_names((str(q.data) for q in model.q), fewest=fewest)


def of_names(names: Iterable[str], first: int = 0, fewest: int = FEWEST) -> list[tuple[int, int]]:
    """The same of anything whose ``names`` follow one another from the number ``first`` on."""
    found = list[tuple[int, int]]()
    for _, members in groupby(name.partition("[")[0] for name in names):
        count = sum(1 for _ in members)
        if count >= fewest:
            found.append((first, count))
        first += count
    return found


def write_floors(
    f: Function, lengths: Lengths, related: Sequence[tuple[int, int]],
    state: Pointer | str = "%state", work: Pointer | str = "%work", over: Real | None = None,
) -> None:  # fmt: skip
    """Write down the least that velocities are measured by, where ``Lengths.floor`` is."""
    write_fastest(f, lengths, related, lengths.floor, f.constant(FAINT), state, work, over)


def write_fastest(
    f: Function, lengths: Lengths, related: Sequence[tuple[int, int]], place: int, part: Real,
    state: Pointer | str = "%state", work: Pointer | str = "%work", over: Real | None = None,
) -> None:  # fmt: skip
    """Write this ``part`` of the fastest velocity of its family to the row of each velocity, from a ``place``
    in ``%work`` on; and of the largest integral, whose numbers go on behind those of velocities. What rests
    yet is as large as it will be after a time ``over``, where that is given."""
    for first, count in related:
        fastest, last = f.variable(f.zero(lengths.lanes)), first + count
        first += lengths.degrees
        last += lengths.degrees
        start = lengths.vector(first)
        with lengths.each(f, start, last) as row:
            speed = f.magnitude(row.at(state))
            if over is not None:
                speed = f.larger(speed, f.magnitude(row.series(work)[1]) * lengths.wide(f, over))
            speed = row.only(row.among(first, count), speed)
            fastest.set(f.larger(fastest.get(), speed))
        least = lengths.wide(f, lengths.gather(f, "fmax", fastest.get()) * part)
        with lengths.each(f, start, last) as row:
            before = row.at(work, place)
            row.put(f.select(row.among(first, count), least, before), work, place)
