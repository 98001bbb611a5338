"""Rounding errors of integrands: how much these change where the state does by what counts as rounding.

Where forces cancel, as those of a spring at rest, an integrand is nothing but rounding errors. No series
agrees with these, however short. Where large terms cancel whatever the state is, as those of a fast spin in
the torque on a top, small changes of the state show nothing but rounding: they are not in proportion, while
larger ones are. A force that holds a motion, as dry friction does, cancels others however
the state changes: it is as large as what the integrand changes by where it is let go.
"""

from __future__ import annotations

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Pointer, Real
from lagrange_cli.native.stepping.lengths import Row
from lagrange_cli.native.stepping.parts import ALLOWED, ENDED, KNOWN, RATES, StepParts
from lagrange_cli.native.stepping.quadratures import ROUNDING
from lagrange_cli.native.stepping.step_size import ENDLESS
from lagrange_cli.native.stepping.sums import HighLow

WAYS = 4
"""The state is changed in so many ways: in one of them an integrand may be the same by chance."""
SPREAD, STRIDE, RANGE = 40503, 24862, 2**16
"""The multiple of a row's number that tells, within this range, by how much the row is changed, and how much
more it is from one way to the next: the golden ratio spreads these (D. E. Knuth, The Art of Computer
Programming, vol. 3, sec. 6.4)."""
LINEAR = 0.25
"""A change that is not in proportion, up to this part of it, is that of a jump, or of a pole; or else of
rounding errors of terms that cancel whatever the state is."""
WIDER = 2.0**12
"""It is of these where changes of the state so many times as large are in proportion: there is no jump."""
OFTEN = 16.0
"""Then the few changes are random ones: the next may be so many times as large."""
SLOW, SLOWEST = 2.0**-20, 2.0**-100
"""The part of a velocity by which it is changed for a direction, and that of one at rest."""
ROUND_INTEGRANDS = (
    "define internal void @round_integrands"
    "(ptr %constants, double %t, double %low, ptr %state, ptr %rates, ptr %errors) #0"
)
"""The function of ``integrand_errors``. At the rows of velocities, ``%rates`` are accelerations. At those of
integrals, ``%errors`` become at least the rounding errors of terms that cancel in integrands."""
SMOOTH = ENDED + 1
"""The array in which it is marked where they are."""


def measure_rounding(parts: StepParts, place: HighLow) -> None:
    """Write down the rounding errors of the integrands at a ``place`` of the step, where the series are."""
    f, own, size = parts.f, parts.own, 0.5 * parts.bounds.rounding
    beyond = parts.sums.beyond
    with own.velocities(f) as row:
        row.put(row.series(parts.at.there)[1], parts.array(RATES))
        if beyond:
            row.put(row.series(parts.at.there)[1 + beyond], parts.array(ENDED))
    with f.loop(0, WAYS, tested=False) as way, f.loop(0, 2, tested=False) as turn:
        wide = turn.equals(0)
        for array in (ALLOWED, KNOWN):
            _change(parts, way, f.select(wide, f.constant(size * WIDER), f.constant(size)))
            parts.expand(place)
            with own.velocities(f) as row:
                change = row.series(parts.at.there)[1] - row.at(parts.array(RATES))
                if beyond:
                    change = change + (row.series(parts.at.there)[1 + beyond] - row.at(parts.array(ENDED)))
                row.put(change, parts.array(array))
        with own.velocities(f) as row:
            half, whole = (row.at(parts.array(one)) for one in (ALLOWED, KNOWN))
            change, before = f.magnitude(whole), row.at(parts.array(ROUNDING))
            narrow = ~f.splat(wide, own.lanes)
            steady = f.magnitude((whole - half) - half) <= change * LINEAR
            rough = ~steady & row.at(parts.array(SMOOTH)).equals(1.0) & (change < ENDLESS)
            found = f.larger(f.select(rough, change * OFTEN, change), before)
            row.put(f.select(narrow & (steady | rough), found, before), parts.array(ROUNDING))
            one = f.splat(f.constant(1.0), own.lanes)
            row.put(f.select(steady, one, f.zero(own.lanes)), parts.array(SMOOTH))
        parts.go(place)
    if parts.round_at:
        _keep_terms(parts, place)
    if parts.let_go:
        for side in (1.0, -1.0):  # of these changes one may be 0 by chance
            with parts.let_go(side):
                _set_off(parts)
                parts.expand(place)
            with own.velocities(f) as row:
                change = f.magnitude(row.series(parts.at.there)[1] - row.at(parts.array(RATES))) * size
                before = row.at(parts.array(ROUNDING))
                larger = (change > before) & (change < ENDLESS)
                row.put(f.select(larger, change, before), parts.array(ROUNDING))
            parts.go(place)


def measure_later(parts: StepParts, step: HighLow) -> None:
    """No integrand counts as known better than to rounding of what it is in the middle of the ``step`` and at
    its end. One that grows from nothing as t^4 is at first nothing but rounding errors of terms that cancel,
    which do not matter to the integral. In one place alone it may be close to a pole."""
    f, own = parts.f, parts.own
    for middle in (True, False):
        place = (step[0] * 0.5, step[1] * 0.5) if middle else step
        parts.go(place)
        with own.velocities(f) as row:
            size, before = f.magnitude(parts.rate(row)[0]), row.at(parts.array(ROUNDING))
            if middle:
                row.put(size, parts.array(ALLOWED))
                continue
            least = f.smaller(size, row.at(parts.array(ALLOWED)))
            error = parts.of_series(least) * parts.bounds.rounding
            row.put(f.select(least < ENDLESS, f.larger(error, before), before), parts.array(ROUNDING))


def round_integrands(f: Function, time: HighLow, state: Pointer, rates: Pointer, errors: Pointer) -> None:
    """A call of that function."""
    f.call(None, "round_integrands", f.pointer("%constants"), *time, state, rates, errors)


def _keep_terms(parts: StepParts, place: HighLow) -> None:
    """Keep the rounding errors of terms that cancel in integrands at a ``place`` of the step, where series
    are."""
    assert parts.round_at
    f, own, rates, errors = parts.f, parts.own, parts.array(KNOWN), parts.array(ALLOWED)
    with parts.lengths.velocities(f) as row:
        row.put(parts.rate(row)[0], rates)
    with own.velocities(f) as row:
        row.put(f.zero(own.lanes), errors)
    parts.round_at(place, rates, errors)
    with own.velocities(f) as row:
        error, before = parts.of_series(row.at(errors)), row.at(parts.array(ROUNDING))
        row.put(f.larger(error, before), parts.array(ROUNDING))


def learn_rounding(parts: StepParts) -> None:
    """Write down what the integrands are off by at the end of a part that was not accepted. What they are
    computed from may be rounded by more than the state is, as the depth of a contact is by parts of a
    diameter: changes of the state do not show that."""
    f, own = parts.f, parts.own
    with own.velocities(f) as row:
        apart = f.magnitude(parts.rate(row)[0] - row.at(parts.array(RATES)))
        missed = (apart > row.at(parts.array(ALLOWED))) & (apart < ENDLESS)
        before = row.at(parts.array(ROUNDING))
        found = f.larger(parts.of_series(apart) * OFTEN, before)
        row.put(f.select(missed, found, before), parts.array(ROUNDING))


def _set_off(parts: StepParts) -> None:
    """Give what is at rest a direction, in which friction along a vector acts as soon as it is let go."""
    f = parts.f
    with parts.lengths.each(f) as row:
        old = row.at(parts.at.arrays)
        new = old + set_off(f, row, old)
        row.put(f.select(row.among(*parts.own.leading), old, new), parts.at.arrays)


def set_off(f: Function, row: Row, old: Real) -> Real:
    """Changes of what is ``old`` that are small, and apart for all rows: none of their combinations is 0."""
    return share(f, row, f.count(0)) * (f.magnitude(old) * SLOW + SLOWEST)


def _change(parts: StepParts, way: Integer, size: Real) -> None:
    """Change coordinates and velocities by up to this part of them, in their last parts."""
    f, last = parts.f, parts.low if parts.sums.beyond else 0
    with parts.lengths.each(f) as row:
        old = row.at(parts.at.arrays, last)
        new = old + row.at(parts.at.arrays) * share(f, row, way) * parts.lengths.wide(f, size)
        row.put(f.select(row.among(*parts.own.leading), old, new), parts.at.arrays, last)


def share(f: Function, row: Row, way: Integer) -> Real:
    """Numbers from -1 to 1: by what parts of the greatest change rows are changed."""
    number = row.beyond(0)
    spread = (number * f.splat(way * STRIDE + SPREAD, number.lanes)) & (RANGE - 1)
    return spread.to_real() * (2.0 / RANGE) - 1.0
