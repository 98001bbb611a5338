"""``@allow_directions`` of a system of families: accelerations by friction along vectors are known to the
rounding errors of the velocities whose difference gives its direction."""

from __future__ import annotations

from lagrange_cli.native.families.arrangement import Arrangement
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.families.spans import in_vectors
from lagrange_cli.native.families.vectors import DoubleVectors
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer
from lagrange_cli.native.state import Clock, StateLayout

HEAD = "define internal void @allow_directions(ptr %constants, ptr %state, ptr %errors) #0"


def allow_directions(arrangement: Arrangement, state: StateLayout) -> str:
    """The text of the function, which adds to the ``%errors`` at the rows of velocities; none where no
    friction acts along differences of velocities. (Steps on rates measure these errors.)"""
    errors, degrees = arrangement.blurred, arrangement.degrees
    if errors is None or arrangement.kind is not DoubleVectors:
        return ""
    f = Function(HEAD)
    vectors = DoubleVectors(f)
    base = arrangement.scratch(vectors)
    arrays = arrangement.state(f)
    totals = needed([errors], arrangement.slots, arrangement.lasting.fixed)
    arrays |= arrangement.arrays(vectors, base, totals)
    time = f.load("%state", state.at(Clock.TIME)) + f.load("%state", state.at(Clock.TIME_LOW))
    arrangement.evaluation(vectors, arrays, time).write(totals)
    target = f.place("%errors", degrees, "double")

    def add(i: Integer, lanes: int) -> None:
        error = f.magnitude(f.load_row(arrays[errors], i, lanes))
        f.store_row(f.load_row(target, i, lanes) + error, target, i)

    in_vectors(f, (f.count(0), f.count(degrees)), add)
    f.give()
    return f.text()
