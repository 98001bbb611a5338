"""The least that velocities of a family's members are measured by.

What moves much less than others of its family, as the tail of a wave, is not followed to its own digits, but
to those of the fastest ones: errors of its velocity may be so large that neither they nor those of its
momentum, as parts of the largest ones in the family, are seen.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lagrange_cli.native.families.tables import before
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Pointer
from lagrange_cli.native.stepping.related import FAINT, one_by_one
from lagrange_cli.spec.content import groups_of
from lagrange_cli.spec.whole import WrittenFamily

if TYPE_CHECKING:
    from lagrange_cli.spec.spec import Spec

FLOORS = "define internal void @floors(ptr noalias %constants, ptr noalias %state, ptr noalias %floors) #0"
PART = 0.125
"""Of the largest velocity, or of that which gives a member the largest momentum."""


def write_floors(f: Function, spec: Spec, masses: Pointer, inverses: Pointer, *, bound: bool = False) -> None:
    """The body of the function: floors are at the rows of the velocities; ``inverses`` are those of
    ``masses``. Where coordinates are ``bound``, constraints may hold all of a family: all that moves there
    are rounding errors of others."""
    degrees, zero, families = len(spec.coordinates), f.zero(LANES), related(spec)
    if sum(count for _, count in families) < degrees:
        with f.loop(0, degrees, LANES, tested=False) as i:
            f.store_row(zero, "%floors", i + degrees)
    for first, count in one_by_one(f, families):
        speed, momentum, last = f.variable(zero), f.variable(zero), first + count
        with f.loop(first, last, LANES, tested=False) as i:
            v = f.magnitude(f.load_row("%state", i + degrees, LANES))
            p = v * f.magnitude(f.load_row(masses, i, LANES))
            inside = before(f, i, last)
            for most, value in ((speed, v), (momentum, p)):
                most.set(f.larger(most.get(), f.select(inside, value, zero)))
        v, p = (f.splat(f.reduce("fmax", one.get()) * PART, LANES) for one in (speed, momentum))
        with f.loop(first, last, LANES, tested=False) as i:
            least = f.smaller(v, p * f.magnitude(f.load_row(inverses, i, LANES)))
            f.store_row(f.select(before(f, i, last), least, zero), "%floors", i + degrees)
    if bound:
        fastest = f.variable(zero)
        with f.loop(0, degrees, LANES, tested=False) as i:
            v = f.magnitude(f.load_row("%state", i + degrees, LANES))
            fastest.set(f.larger(fastest.get(), f.select(before(f, i, degrees), v, zero)))
        least = f.splat(f.reduce("fmax", fastest.get()) * FAINT, LANES)
        with f.loop(0, degrees, LANES, tested=False) as i:
            known = f.larger(f.load_row("%floors", i + degrees, LANES), least)
            f.store_row(f.select(before(f, i, degrees), known, zero), "%floors", i + degrees)
    f.give()


def runs(spec: Spec) -> list[tuple[int, bool]]:
    """How many coordinates follow one another that are of one family, or of none; and whether they are."""
    families, found = spec.coordinate_families, list[tuple[int, bool]]()
    for one in groups_of(spec.coordinates):
        name, count = one.name, len(one) if isinstance(one, WrittenFamily) else 1
        if found and name not in families and not found[-1][1]:
            found[-1] = found[-1][0] + count, False
        else:
            found.append((count, name in families))
    return found


def related(spec: Spec, fewest: int = 1) -> list[tuple[int, int]]:
    """The first coordinate of each family of some members, and their number."""
    found, first = list[tuple[int, int]](), 0
    for count, of_family in runs(spec):
        if of_family and count >= fewest:
            found.append((first, count))
        first += count
    return found
