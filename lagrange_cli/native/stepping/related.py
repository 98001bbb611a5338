"""What is nothing beside the largest of its family, and what it is measured by: velocities, and integrals.

Far down the tail of a wave, coordinates and velocities are 1e-50 of those of its head, and grow as high
powers of the time: only in very short steps are their series small beside themselves. They are measured by
the rounding error of the fastest velocity in the family instead. Their errors are then
below its square, so that also the momentum of a member with 2^60 times the mass is known to many digits.
The integrals of forces, in the balances of momenta, are measured by that of the largest one likewise.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, TypeAlias

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Index, Pointer, Real
from lagrange_cli.native.stepping.lengths import Lengths, Row
from lagrange_cli.native.stepping.step_size import ENDLESS

if TYPE_CHECKING:
    from lagrange_cli.expression.node import Node
    from lagrange_cli.model.model import Model

Place: TypeAlias = tuple[Pointer | str, int]

FAINT = 2.0**-52
"""The part of the fastest velocity."""
HARDLY_SEEN = 0.125
"""The part of the largest integral by which others are measured where sizes are those after a step: errors
are less than the rounding error of the largest one."""
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


def one_by_one(f: Function, families: Iterable[tuple[int, int]]) -> Iterator[tuple[Index, int]]:
    """The first number of each of the ``families``, and how many it has. What is written for those of one
    size that follow one another is written once, in a loop."""
    runs = list[tuple[int, int, int]]()
    for first, count in families:
        if runs and count == runs[-1][2] and first == runs[-1][1]:
            runs[-1] = runs[-1][0], first + count, count
        else:
            runs.append((first, first + count, count))
    for first, last, count in runs:
        if last == first + count:
            yield first, count
            continue
        with f.loop(first, last, count, tested=False) as one:
            yield one, count


def write_floors(
    f: Function, lengths: Lengths, related: Sequence[tuple[int, int]],
    size: Callable[[Row], Real] | None = None, work: Pointer | str = "%work",
) -> None:  # fmt: skip
    """Write down the least that velocities are measured by, where ``Lengths.floor`` is."""
    write_fastest(f, lengths, related, lengths.floor, f.constant(FAINT), size, work)


def write_fastest(
    f: Function, lengths: Lengths, related: Sequence[tuple[int, int]], place: int, part: Real,
    size: Callable[[Row], Real] | None = None, work: Pointer | str = "%work", *, least: bool = False,
) -> None:  # fmt: skip
    """Write this ``part`` of the fastest velocity of its family to the row of each velocity, from a ``place``
    in ``%work`` on; and of the largest integral, whose numbers go on behind those of velocities. How large
    they are is their ``size``, or that of the numbers in the state. What is there is replaced, or where it is
    to be the ``least``, made larger."""
    for number, count in one_by_one(f, related):
        fastest, first = f.variable(f.zero(lengths.lanes)), number + lengths.degrees
        start, last = lengths.vector(first), first + count
        with lengths.each(f, start, last) as row:
            speed = size(row) if size else f.magnitude(row.at("%state"))
            speed = row.only(row.among(first, count), speed)
            fastest.set(f.larger(fastest.get(), speed))
        found = lengths.wide(f, lengths.gather(f, "fmax", fastest.get()) * part)
        with lengths.each(f, start, last) as row:
            before = row.at(work, place)
            new = f.larger(found, before) if least else found
            row.put(f.select(row.among(first, count), new, before), work, place)


def write_coupled(
    f: Function, lengths: Lengths, coupled: Sequence[tuple[int, int]], rates: Place, errors: Place,
    rounding: float,
) -> None:  # fmt: skip
    """Let no error of accelerations that are found together be less than this part of the largest one: where
    bodies are joined, one that is 0 is a difference of others. Rates, and errors, are in an array, behind
    the rows of velocities by so many."""
    (found, behind), (known, place), part = rates, errors, f.constant(rounding)

    def size(row: Row) -> Real:
        rate = f.magnitude(row.at(found, behind))
        return row.only(rate < ENDLESS, rate)

    write_fastest(f, lengths, coupled, place, part, size, known, least=True)


def allow_rounding(lengths: Lengths, coupled: Sequence[tuple[int, int]], rounding: float) -> list[Function]:
    """``@allow_rounding(rates, allowed)``, if there is anything ``coupled``: the errors of accelerations that
    are allowed, made as large as those of rounding."""
    if not coupled:
        return []
    f = Function("define internal void @allow_rounding(ptr noalias %rates, ptr noalias %allowed) #0")
    places = (f.pointer("%rates"), 0), (f.pointer("%allowed"), 0)
    write_coupled(f, lengths, coupled, *places, rounding)
    f.give()
    return [f]
