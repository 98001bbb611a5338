"""What the acceptance of a step allows accelerations because of rounding.

``@allow_static`` is for forces that cancel at rest (see ``native.stepping.static_forces``),
``@allow_directions`` for friction along vectors, which is known to the rounding errors of the velocities
whose difference gives its direction, and ``@round_integrands`` for terms that cancel in integrands (see
``native.stepping.integrand_errors``).
"""

from __future__ import annotations

from collections.abc import Callable

from lagrange_cli.families.arrays import Total
from lagrange_cli.native.families.arrangement import Arrangement
from lagrange_cli.native.families.constraints.together_jet import solved_at_a_state
from lagrange_cli.native.families.evaluation import room
from lagrange_cli.native.families.joints.articulated import ArticulatedJet
from lagrange_cli.native.families.joints.balance import Balance
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.families.series_places import JetSetting
from lagrange_cli.native.families.spans import in_vectors
from lagrange_cli.native.families.vectors import DoubleVectors
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.state import Clock, StateLayout
from lagrange_cli.native.stepping.integrand_errors import keep
from lagrange_cli.native.stepping.rounding_errors import ROUND_INTEGRANDS
from lagrange_cli.native.stepping.static_forces import HEAD, UNITS
from lagrange_cli.native.stepping.step_size import ENDLESS

SHAKEN = "shaken"
"""The function that computes accelerations by rounding errors."""


def where_diagonal(arrangement: Arrangement, sizes: Total, unit: float) -> str:
    """The text of the function where M is diagonal, from the ``sizes`` of the errors of forces, in units of
    rounding of this size. Its arrays are the next ones in scratch; numbers are doubles, the high parts of
    others."""
    f, degrees = Function(HEAD), arrangement.degrees
    vectors = DoubleVectors(f)
    base = arrangement.scratch(vectors)
    arrays = arrangement.state(f)
    held, fixed = arrangement.held, arrangement.lasting.fixed
    first = needed([] if held is None else [held.square, held.right], arrangement.slots, fixed)
    totals = [one for one in needed([sizes], arrangement.slots, fixed) if one not in first]
    arrays |= arrangement.arrays(vectors, base, (*first, *totals))
    arrays.update(arrangement.placed_together(vectors, base, held))
    time = f.load("%state", arrangement.layout.at(Clock.TIME))
    evaluation = arrangement.evaluation(vectors, arrays, time)
    if held is not None:
        evaluation.write(first)
        scratch = arrangement.taken(vectors, base, room(arrangement.tabled.size))
        solved_at_a_state(evaluation, held, arrangement.tabled, arrangement.factors, scratch)
        totals = [one for one in totals if one not in held.found]
    evaluation.write(totals)
    errors, inverses = (evaluation.where(one) for one in (sizes, arrangement.lasting.inverses))

    def of(i: Integer, lanes: int) -> Real:
        return f.load_row(errors, i, lanes) * f.magnitude(f.load_row(inverses, i, lanes))

    allow(f, degrees, UNITS * unit, of)
    f.give()
    return f.text()


def of_joints(arrangement: Arrangement, shaken: Balance, setting: JetSetting, unit: float) -> str:
    """The same on chains and trees, from their accelerations by these errors, of doubles: with errors of one
    sign, and with signs that alternate. What one of them cancels, the other does not."""
    jet = ArticulatedJet(shaken, setting, SHAKEN)
    text = jet.write().text
    f, degrees, width = Function(HEAD), arrangement.degrees, arrangement.layout.width
    vectors = DoubleVectors(f)
    base = arrangement.scratch(vectors)
    sizes = width, degrees, jet.work
    state, largest, work = (arrangement.taken(vectors, base, room(one)) for one in sizes)
    signs = vectors.place(base, arrangement.places[arrangement.signs])
    with f.loop(0, degrees, tested=False) as i:
        f.store(f.load("%state", i), state, i)
        f.store(f.constant(0.0), state, i + degrees)
        f.store(f.constant(0.0), largest, i)
    rates = f.place(work, width + degrees, "double")
    for second in (0, 1):
        with f.loop(0, arrangement.signs.count, tested=False) as i:
            f.store(f.constant(1.0) - (i & 1).to_real() * (2.0 * second), signs, i)
        f.call(Bit, SHAKEN, f.pointer("%constants"), f.load("%state", arrangement.layout.at(Clock.TIME)),
               state, work)  # fmt: skip
        with f.loop(0, degrees, tested=False) as i:
            f.store(f.larger(f.magnitude(f.load(rates, i)), f.load(largest, i)), largest, i)
    allow(f, degrees, UNITS * unit, lambda i, lanes: f.load_row(largest, i, lanes))
    f.give()
    return text + f.text()


def allow(f: Function, degrees: int, units: float, of: Callable[[Integer, int], Real]) -> None:
    """Add so many units of the errors to what is allowed."""
    allowed = f.place("%errors", degrees, "double")

    def add(i: Integer, lanes: int) -> None:
        error = of(i, lanes) * units
        known = f.select(error < ENDLESS, error, f.zero(lanes))
        f.store_row(f.load_row(allowed, i, lanes) + known, allowed, i)

    in_vectors(f, degrees, add)


DIRECTIONS = "define internal void @allow_directions(ptr %constants, ptr %state, ptr %errors) #0"


def allow_directions(arrangement: Arrangement, errors: Total, state: StateLayout) -> str:
    """The text of the function, which adds the ``errors`` of accelerations to the ``%errors`` at the rows of
    velocities."""
    f, degrees = Function(DIRECTIONS), arrangement.degrees
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

    in_vectors(f, degrees, add)
    f.give()
    return f.text()


def of_integrands(arrangement: Arrangement, sizes: Total, unit: float) -> str:
    """The text of the function, from the ``sizes`` of the errors of integrands, in units of rounding of this
    size, in doubles."""
    f, system, fixed = Function(ROUND_INTEGRANDS), arrangement.system, arrangement.lasting.fixed
    vectors = DoubleVectors(f)
    base = arrangement.scratch(vectors)
    arrays = arrangement.state(f)
    if not system.accelerations.terms:
        arrays[system.accelerations] = f.place("%rates", arrangement.degrees, "double")
    totals = needed([sizes], arrangement.slots, [*fixed, *arrays])
    arrays |= arrangement.arrays(vectors, base, totals)
    t, low = f.reals("t", "low")
    evaluation = arrangement.evaluation(vectors, arrays, t + low)
    evaluation.write(totals)
    found, first = evaluation.where(sizes), arrangement.layout.integrals.start

    def add(i: Integer, lanes: int) -> None:
        keep(f, f.load_row(found, i, lanes), unit, i + first, lanes)

    in_vectors(f, sizes.count, add)
    f.give()
    return f.text()
