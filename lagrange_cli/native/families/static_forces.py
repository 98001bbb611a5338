"""``@allow_static`` of systems of families whose M is diagonal (see ``native.stepping.static_forces``)."""

from __future__ import annotations

from lagrange_cli.families.arrays import Array, Total
from lagrange_cli.native.families.arrangement import Arrangement
from lagrange_cli.native.families.evaluation import room
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.families.spans import in_vectors
from lagrange_cli.native.families.vectors import DoubleVectors
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Pointer
from lagrange_cli.native.state import Clock
from lagrange_cli.native.stepping.static_forces import HEAD, UNITS
from lagrange_cli.native.stepping.step_size import ENDLESS


def allow_static(arrangement: Arrangement, sizes: Total, unit: float) -> str:
    """The text of the function, from the ``sizes`` of the errors of forces, in units of rounding of this
    size. Its arrays are the next ones in scratch; numbers are doubles, the high parts of others."""
    f, system, degrees = Function(HEAD), arrangement.system, arrangement.degrees
    vectors = DoubleVectors(f)
    base = arrangement.scratch(vectors)
    arrays: dict[Array, Pointer] = {
        system.q: f.pointer("%state"),
        system.v: f.place("%state", degrees, "double"),
    }
    totals = needed([sizes], arrangement.slots, arrangement.lasting.fixed)
    for total in totals:
        arrays[total] = vectors.place(base, arrangement.size)
        arrangement.size += room(total.count)
    time = f.load("%state", arrangement.layout.at(Clock.TIME))
    evaluation = arrangement.evaluation(vectors, arrays, time)
    evaluation.write(totals)
    errors, inverses = (evaluation.where(one) for one in (sizes, arrangement.lasting.inverses))
    allowed = f.place("%errors", degrees, "double")

    def add(i: Integer, lanes: int) -> None:
        error = f.load_row(errors, i, lanes) * f.magnitude(f.load_row(inverses, i, lanes)) * (UNITS * unit)
        known = f.select(error < ENDLESS, error, f.zero(lanes))
        f.store_row(f.load_row(allowed, i, lanes) + known, allowed, i)

    in_vectors(f, (f.count(0), f.count(degrees)), add)
    f.give()
    return f.text()
