"""Quadratures (action, ledgers) beside a motion: what their series require of its steps.

The motion decides on its steps without them. Within a step it is known, by the step's polynomials. Where an
integrand changes faster than these, or where the next series does not confirm its predicted value, the step
is divided (``division``).
"""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Pointer, Real
from lagrange_cli.native.stepping.acceptance import PredictionBounds, accepted
from lagrange_cli.native.stepping.lengths import Lengths, Row
from lagrange_cli.native.stepping.related import write_floors
from lagrange_cli.native.stepping.step_size import ENDLESS, LARGEST_GUESS, StepSize
from lagrange_cli.records import replace

ENOUGH = 4.0
"""A step is divided if the last terms of a series exceed so many times the tolerance."""
ROUNDS = 16
"""Computations of a step at most, until sizes are measured over about its length."""

ROUNDING = 7
"""The array in which the parts of a step have the rounding errors of integrands, as terms of their series
(``parts.StepArrays``)."""

FADING = 0.875
"""Rounding errors of one step count for so much in the next one."""


class Quadratures:
    """Writes what the quadratures of a motion take: ``count`` rows of ``lengths`` from ``first`` on.

    Low parts of coefficients are ``beyond`` doubles behind, if they have any: then time has a unit of its
    own in the series. Integrands up to ``rest`` do not count. Their rounding errors, where they were measured
    in steps before, are ``known`` so many rows behind them in the state, if that is not 0. Those that are
    ``related`` are measured by the largest one, too (``related``).
    """

    def __init__(
        self, lengths: Lengths, first: int, count: int, tolerance: float, bounds: PredictionBounds,
        *, beyond: int = 0, rest: float = 0.0, known: int = 0, related: Sequence[tuple[int, int]] = (),
    ) -> None:  # fmt: skip
        self.lengths, self.bounds, self.tolerance, self._beyond = lengths, bounds, tolerance, beyond
        self.own = replace(
            lengths, followed=(first, count), apart=True, floor=lengths.floor if related else 0
        )
        self.known, self._related = known, related if lengths.floor else ()
        sizes, often = (
            StepSize(self.own, tolerance, rest, fades=not beyond, prefix="integral_"),
            1.0 / bounds.rounding,
        )
        self.sizes = replace(sizes, uncertain=(known, often)) if known else sizes
        self._within = replace(sizes, uncertain=(ROUNDING * lengths.width, often))

    def functions(self) -> list[Function]:
        """What its instructions call."""
        shortened = [] if self._beyond else [self._within.shortened_step()]
        agreeing = accepted(self.own, self._beyond, "integrals_accepted")
        return [*self._within.functions(), *shortened, self.length(), self.rough(), agreeing]

    def nothing(self, f: Function, h: Real) -> Real:
        """The error of an integrand that is always allowed: where it is proven, its negligible values before
        a pulse do not matter."""
        if not self.sizes.rest:
            return f.constant(0.0)
        return self.bounds.nothing(f, h)

    def measure(self, f: Function, state: Pointer, work: Pointer, left: Real | None = None) -> None:
        """Write down what integrals are measured by at least, beside the largest one of their family, as it
        is or will be after what is ``left`` of a step."""
        if not self._related:
            return

        def size(row: Row) -> Real:
            one = f.magnitude(row.at(state))
            if left is None:
                return one
            return f.larger(one, f.magnitude(row.series(work)[1]) * row.lengths.wide(f, left))

        write_floors(f, self.lengths, self._related, size, work)

    def allow(self, f: Function, allowed: Pointer) -> None:
        """Add the known rounding errors to what integrands may be off by after a step; they are less and less
        certain."""
        if not self.known:
            return
        with self.own.velocities(f) as row:
            error = row.at("%state", self.known)
            row.put(row.at(allowed) + error, allowed)
            row.put(f.select(row.among(*self.own.leading), error * FADING, error), "%state", self.known)

    def length(self) -> Function:
        """``@integral_length(state, work, over)``: the step that the integrals' series ask for, at most
        ``over``; 0 where too few coefficients are finite."""
        f = Function("define internal double @integral_length(ptr %state, ptr %work, double %over) #0")
        over, one = f.smaller(Real(f, "%over"), LARGEST_GUESS), f.constant(1.0)
        places = f.pointer("%state"), f.pointer("%work")
        h, met = f.variable(over), f.variable(one)
        with f.section() as settled, f.loop(0, ROUNDS, tested=False):
            before = h.get()
            found, total = f.parts((Real, Real), "integral_step_size", *places, before)
            h.set(f.smaller(found, over))
            met.set(total)
            with f.when(~((h.get() < before * 0.5) | (h.get() > before * 2.0))):
                settled.leave()
        finite = met.get() < ENDLESS
        if self._beyond:
            f.give(f.select(finite, h.get(), 0.0))
            return f
        with f.when(~finite):
            fewer = f.call(Real, "integral_shortened_step", *places, h.get())
            h.set(f.smaller(fewer, over))
        f.give(h.get())
        return f

    def rough(self) -> Function:
        """``@rough(state, work, h)``: whether the last terms of an integral's series over ``h`` matter, or
        are not finite; the same length ``in_time`` follows, where the series has another unit."""
        more = ", REAL %in_time" if self._beyond else ""
        head = f"define internal BIT @rough(ptr %state, ptr %work, REAL %h{more}) #0"
        f = Function(head, self.lengths.motions)
        lengths, top, h = self.own, self.own.top, Real(f, "%h")
        wide, least = lengths.wide(f, h), lengths.wide(f, f.constant(ENOUGH * self.tolerance))
        powers, rest = {1: h}, top - 1
        while 2 * max(powers) <= rest:
            powers[2 * max(powers)] = powers[max(powers)] * powers[max(powers)]
        halves, total = [f.constant(1.0), f.constant(1.0)], 0
        for exponent in sorted(powers, reverse=True):  # two factors: their product may overflow
            if total + exponent <= rest:
                halves[total > 0] = halves[total > 0] * powers[exponent]
                total += exponent
        first, second = (lengths.wide(f, one) for one in halves)
        bad, zero = f.variable(f.never(lengths.lanes)), f.zero(lengths.lanes)
        with lengths.velocities(f) as row:
            c = row.series()
            last = f.magnitude(c[top]) * wide + f.magnitude(c[top - 1])
            last = f.select(last.equals(zero), zero, (last * first) * second)
            size = self.sizes.sizes(row, c, wide, Real(f, "%in_time") if self._beyond else None)
            bad.set(bad.get() | (self.sizes.heard(row) & ~(last <= size * least)))
        f.give(lengths.of_motions(f, bad.get()))
        return f
