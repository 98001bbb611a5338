"""Integrals over a short part where a step begins or ends with a power law in the integrand."""

from __future__ import annotations

import math

from lagrange_cli.native.stepping.parts import ALLOWED, ENDED, KNOWN, RATES, StepPart, StepParts, choice
from lagrange_cli.native.stepping.step_size import ENDLESS

FARTHER, WEAKEST, BENT, TERMS = 4.0, 0.264, 2.0**-10, 20
"""How many times as far away a power law is looked at; this to its exponent, below which the integral is
hardly finite; how far off the last place may be; terms of a logarithm."""
EVENLY = 2.0**-30
"""A quantity that changes by at most this fraction of itself counts as constant."""


def follow_powers(parts: StepParts, part: StepPart) -> None:
    """The integrals at the end of a short part where the step begins or ends, if integrands are a + b r^p
    at the distance r from there; these are ``KNOWN``. The series are those at the end of the part.

    With f1, f2 and f3 at r, 4 r and 16 r, q = (f3 - f2)/(f2 - f1) = 4^p, and f4 at 64 r tells whether
    that is so. The integral within r is r (f1 + (f2 - f1) p/((1 - q) (1 + p))), where log(q) = 2 z (1 +
    z^2/3 + ...) with z = (q - 1)/(q + 1).
    """
    f, own, h = parts.f, parts.own, part.h[0]
    zero, one = f.zero(own.lanes), f.splat(f.constant(1.0), own.lanes)
    begins = part.start[0].equals(0.0)
    with own.velocities(f) as row:
        row.put(f.select(begins, parts.rate(row)[0], row.at(parts.array(RATES))), parts.array(RATES))
    for times, array in zip((FARTHER, FARTHER**2, FARTHER**3), (ALLOWED, KNOWN, None)):
        away = h * (times - 1.0)
        place = f.select(begins, part.end[0] + away, part.start[0] - away)
        parts.go((place, f.constant(0.0)))
        if array is not None:
            with own.velocities(f) as row:
                row.put(parts.rate(row)[0], parts.array(array))
    with own.velocities(f) as row:
        fourth = parts.rate(row)[0]
        first, second, third = (row.at(parts.array(one)) for one in (RATES, ALLOWED, KNOWN))
        change, size = second - first, f.magnitude(first)
        q = (third - second) / change
        z = (q - 1.0) / (q + 1.0)
        series = zero
        for k in reversed(range(TERMS)):
            series = series * z * z + 1.0 / (2 * k + 1)
        unit = 2.0 / math.log(FARTHER)
        power = z * series * unit
        even = f.magnitude(change) <= size * EVENLY
        bent = first - change * series * unit / ((q + 1.0) * (power + 1.0))
        integral = f.select(even, first, bent) * own.wide(f, h)
        follows = f.magnitude((fourth - third) - (third - second) * q) <= f.magnitude(fourth - third) * BENT
        known = (size < ENDLESS) & (even | (follows & (q > WEAKEST) & (q < ENDLESS)))
        known = row.moving(known)
        old = row.at(parts.at.arrays), row.at(parts.at.arrays, parts.low)
        ended = row.at(parts.array(ENDED)), row.at(parts.array(ENDED), parts.low)
        new = parts.sums.sum(f, old, (integral, zero))
        parts.put(row, choice(f, known, new, ended), parts.array(ENDED))
        row.put(f.select(size < ENDLESS, size, zero), parts.array(ALLOWED))
        row.put(f.select(known, one, zero), parts.array(KNOWN))
    parts.go(part.end)
