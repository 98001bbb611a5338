"""The step size from the coefficients of the velocities (A. Jorba and M. Zou 2005, eq. 3-8).

The radius of convergence is estimated from the last coefficients, and h = radius / e^2 at the order that fits
the tolerance. Each velocity is measured against its own size or its change within a step (by its first three
terms), whichever is largest, so that units and mixed scales do not matter.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from decimal import Context, Decimal
from functools import reduce

from lagrange_cli.native.interface import STEPPING
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function, exp2_roughly, log2_roughly, upper_half
from lagrange_cli.native.llvm.text import constant
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.stepping.lengths import Lengths, Row, RowSeries
from lagrange_cli.records import dataclass

LAST_TERM = 0.01
"""Far enough below the tolerance that truncation, which adds up, stays below rounding, which does not."""
BLOCKS = 8
"""Blocks, one for each lane of a vector, in which the coefficients that determine the step are compared."""
LOWEST_TERM = 4
"""The first coefficient that tells the range of the series rather than the present speed of the motion."""
FAINT = 2.0**-900
"""If the last coefficient other than 0 is below this, further ones may have underflowed."""
SLACK = 4
"""Binary orders by which the lower coefficients may exceed what the radius of convergence allows.

They serve to find series with gaps, and are often larger than the last coefficients suggest.
"""
FEW_TERMS = 8
"""From this order of the velocities on, the last coefficient is not used, so that the step is known early."""
LARGEST = 2.0**1023
"""In place of the inverse of a size that has no inverse: that of what has almost decayed to nothing."""
LARGEST_GUESS = 1e60
"""No change of a velocity is measured over longer times."""
LEAP = 4.0
"""A step that is so many times as long as the previous one is a cautious one."""
ENDLESS = float("inf")
CLEARLY, DENORMAL = 0.06, 2.0**-1020
"""Logarithms of roots differ by more than rough ones may be wrong; those of smaller numbers are not known."""
DIGITS = Context(prec=40)
"""Python's own decimals: their powers are the same everywhere, unlike the C library's."""
ARGUMENTS = "ptr noalias %state, ptr noalias %work"


@dataclass(frozen=True)
class StepSize:
    """Writes the functions that ``advance`` and ``follow`` take their steps from.

    The last term of a velocity's series is kept below ``LAST_TERM * tolerance`` of the velocity's size.
    Velocities of a size up to ``rest`` do not count. Where time has a unit of its own in the series, none
    ``fades``: no coefficient underflows. The names of the functions begin with ``prefix``.
    """

    lengths: Lengths
    tolerance: float
    rest: float = 0.0
    fades: bool = True
    prefix: str = ""
    uncertain: tuple[int, float] | None = None
    """Where behind the state there is how much of each rate is rounding, if it is known, and how often that
    is to be counted: rates are no more precise than that."""

    @property
    def safety(self) -> float:
        """The step's part of the radius of convergence."""
        base, exponent = Decimal(LAST_TERM * self.tolerance), Decimal(1.0 / self.lengths.top)
        return float(DIGITS.power(base, exponent))

    def functions(self) -> list[Function]:
        """All of them."""
        return [self.step_size(), self.cautious_step(), *([self.faded()] if self.fades else [])]

    def function(self, head: str) -> Function:
        """One that gives numbers of each motion."""
        return Function(head.replace("@", f"@{self.prefix}"), self.lengths.motions)

    def sizes(self, row: Row, c: RowSeries, h: Real, in_time: Real | None = None) -> Real:
        """The largest of a velocity and the next three terms of its series over a step of ``h``; ``in_time``,
        where the series has another unit."""
        f = row.f
        size = f.magnitude(c[3]) * h
        for m in (2, 1):
            size = f.larger(size, f.magnitude(c[m])) * h
        if self.uncertain:
            shift, times = self.uncertain
            size = f.larger(size, row.at("%state", shift) * (in_time or h) * times)
        return f.larger(row.floored(f.magnitude(row.at("%state"))), size)

    def heard(self, row: Row) -> Bit:
        """Whether steps are chosen by a row; rows that are no longer numbers are ignored."""
        state = row.at("%state")
        return (
            row.moving(state.equals(state)) if self.lengths.followed[1] else row.among(*self.lengths.leading)
        )

    def step_size(self) -> Function:
        """``@step_size(state, work, h)``: the step, where sizes are measured over ``h``; and a number that is
        not finite where a coefficient is not.

        The root of a number is 2^(log2 / m): its logarithm is read off its bits (to 0.09), the power is an
        exponent and a parabola (to 0.3 percent). The step needs no more, and this gives the same bits on
        every machine.
        """
        lengths, top = self.lengths, self.lengths.top
        f = self.function(f"define internal {{ REAL, REAL }} @step_size({ARGUMENTS}, REAL %h) #0")
        blocks = split_terms(top)
        met, greatest = self.compared(f, Real(f, "%h"))
        slopes, offsets = [2.0**-20 / block[0] for block in blocks], [offset_of(b, top) for b in blocks]
        if lengths.motions == 1:  # a lane for each block
            together = f.joined([*greatest, *[greatest[-1]] * (BLOCKS - len(greatest))])
            filled = [[*x, *[x[-1]] * (BLOCKS - len(x))] for x in (slopes, offsets)]
            exponents = [exponent(f, together, *(f.vector(x) for x in filled))]
            exponents = [f.reduce("fmax", exponents[0])]
            largest = f.reduce("fmax", together)
        else:
            given = (map(f.constant, one) for one in (slopes, offsets))
            exponents = [exponent(f, *one) for one in zip(greatest, *given)]
            largest = reduce(f.larger, greatest)
        step = exp2_roughly(-reduce(f.larger, exponents)) * self.safety
        step = f.select(largest.equals(0.0), ENDLESS, step)
        result = f.variable(step)
        if self.fades:
            fading = (greatest[0] > 0.0) & greatest[-1].equals(0.0)
            with f.when(f.any(fading)):
                less = f.call(Real, f"{self.prefix}faded", f.pointer("%work"))
                result.set(f.select(fading, step * less, step))
        f.give(result.get(), met)
        return f

    def compared(
        self, f: Function, span: Real, rows: tuple[Integer, Integer] | None = None
    ) -> tuple[Real, list[Real]]:
        """What is not finite where a coefficient is not, and for each block the largest coefficient for its
        velocity: of all velocities, or of those in some ``rows``."""
        lengths, top = self.lengths, self.lengths.top
        h, reach = lengths.wide(f, span), lengths.wide(f, span * (1.0 / self.safety))
        blocks = split_terms(top)
        zero = f.zero(lengths.lanes)
        total, most = f.variable(zero), [f.variable(zero) for _ in blocks]
        with lengths.velocities(f, rows) as row:
            c = row.series()
            size = self.sizes(row, c, h)
            moving = row.moving(size > self.rest)
            if lengths.followed[1]:
                moving = moving & self.heard(row)
            inverse = f.smaller(lengths.wide(f, f.constant(1.0)) / size, lengths.wide(f, f.constant(LARGEST)))
            inverse = f.select(moving, inverse, zero)
            for block, so_far in zip(blocks, most):
                largest = f.magnitude(c[block[-1]])
                for m in reversed(block[:-1]):
                    largest = f.larger(largest * reach, f.magnitude(c[m]))
                so_far.set(f.larger(so_far.get(), largest * inverse))
            one = size + f.magnitude(c[top])
            if lengths.apart:  # every other one of the velocities may be 0, while integrals have the rest
                one = row.only(self.heard(row), one + f.magnitude(c[top - 1]))
            total.set(total.get() + one)
        met = lengths.gather(f, "fadd", total.get())
        return met, [lengths.gather(f, "fmax", one.get()) for one in most]

    def cautious_step(self) -> Function:
        """``@cautious_step(state, work, h)``: a step after a much shorter one, or the first step. It is
        bounded by every coefficient from ``LOWEST_TERM`` on, since the last two may vanish by chance or by
        symmetry."""
        lengths = self.lengths
        f = self.function(f"define internal REAL @cautious_step({ARGUMENTS}, REAL %h) #0")
        h, endless = lengths.wide(f, Real(f, "%h")), f.constant(ENDLESS)
        least, logarithm = f.variable(endless), f.variable(f.constant(ENDLESS))
        with f.loop(LOWEST_TERM, lengths.top + 1, tested=False) as m:
            ratio = f.variable(lengths.wide(f, endless))
            with lengths.velocities(f) as row:
                c = row.series()
                size, one = self.sizes(row, c, h), f.magnitude(c[m])
                counts = row.moving((one > 0.0) & (size > self.rest))
                if lengths.apart or lengths.floor:  # what is so small yet that the ratio underflows
                    counts = counts & (size / one > 0.0)
                ratio.set(f.smaller(ratio.get(), f.select(counts, size / one, lengths.wide(f, endless))))
            found = lengths.gather(f, "fmin", ratio.get())
            with self.perhaps_least(f, found, m, logarithm):
                least.set(f.smaller(least.get(), self.root(f, found, m.to_real())))
        f.give(least.get() * self.safety)
        return f

    @contextmanager
    def perhaps_least(self, f: Function, x: Real, m: Integer, least: Variable[Real]) -> Iterator[None]:
        """What is done where x^(1/m) may be less than others, the logarithm of the least of which is known
        roughly: to compute a root takes longer."""
        if self.lengths.motions > 1:
            yield
            return
        found = log2_roughly(x) / m.to_real()
        with f.when(~(found > least.get() + CLEARLY) | (x < DENORMAL)):
            least.set(f.smaller(found, least.get()))
            yield

    def shortened_step(self) -> Function:
        """``@shortened_step(state, work, h)``: where the higher coefficients overflow close to a singularity,
        a step with the finite ones only; the others are set to 0. It is 0 if fewer than ``STEPPING`` are
        left."""
        lengths, order = self.lengths, self.lengths.order
        f = self.function(f"define internal REAL @shortened_step({ARGUMENTS}, REAL %h) #0")
        end = f.variable(f.count(1))
        with f.section() as found, f.forever():
            total = f.variable(f.zero(lengths.lanes))
            with lengths.stored(f) as row:
                one = f.magnitude(row.series()[end.get()])
                counts = self.heard(row) if lengths.followed[1] else row.among(0, 2 * lengths.degrees)
                total.set(total.get() + row.only(counts, one))
            with f.when(~(lengths.gather(f, "fadd", total.get()) < ENDLESS)):
                found.leave()
            end.set(end.get() + 1)
            with f.when(end.get() > order):
                found.leave()
        with f.when(end.get() <= STEPPING):
            f.give(f.constant(0.0))
        with f.loop(end.get(), order + 1) as m, lengths.stored(f) as row:
            row.series().put(f.zero(lengths.lanes), m)
        step = f.call(
            Real, f"{self.prefix}cautious_step", f.pointer("%state"), f.pointer("%work"), Real(f, "%h")
        )
        f.give(step * self.fewer(f, (end.get() - 2).to_real()))
        return f

    def faded(self) -> Function:
        """``@faded(work)``: the factor for a step if higher coefficients of the velocities have underflowed,
        so that only the lower ones limit it. It is 1 if most coefficients are there, or if the higher ones
        are 0 for another reason."""
        lengths, top = self.lengths, self.lengths.top
        f = self.function("define internal REAL @faded(ptr noalias %work) #0")
        last, faintest = f.variable(f.constant(2.0)), f.variable(f.constant(0.0))
        with f.loop(2, top + 1, tested=False) as m:
            total = f.variable(f.zero(lengths.lanes))
            with lengths.velocities(f) as row:
                total.set(total.get() + row.only_velocities(f.magnitude(row.series()[m])))
            size = lengths.gather(f, "fadd", total.get())
            there = size > 0.0
            last.set(f.select(there, f.splat(m.to_real(), lengths.motions), last.get()))
            faintest.set(f.select(there, size, faintest.get()))
        counts = (faintest.get() < FAINT) & (last.get() < float(2 * top // 3))
        f.give(f.select(counts, self.fewer(f, last.get()), 1.0))
        return f

    def fewer(self, f: Function, top: Real) -> Real:
        """The factor for a step that ends with this order of the velocities instead of the last one."""
        base, exponent = LAST_TERM * self.tolerance, 1.0 / top - 1.0 / self.lengths.top
        if self.lengths.motions == 1:
            return f.function("pow", f.constant(base), exponent)
        return exp2_roughly(exponent * math.log2(base))

    def root(self, f: Function, x: Real, m: Real) -> Real:
        """x^(1/m); roughly, where it is computed for many motions."""
        inverse = 1.0 / f.splat(m, self.lengths.motions)
        if self.lengths.motions == 1:
            return f.function("pow", x, inverse)
        return f.select(x < ENDLESS, exp2_roughly(log2_roughly(x) * inverse), x)


def chosen_step(
    f: Function, previous: Real, places: tuple[Pointer, Pointer], live: Bit | None = None
) -> tuple[Real, Real]:
    """The step after one of the length ``previous`` (0 at first), and what is not finite where a coefficient
    is not.

    Sizes are measured over the previous step; at first, over what a step of 1 leads to. A step that is much
    longer is a cautious one. Only ``live`` motions matter.
    """
    one = f.constant(1.0)
    first = previous.equals(0.0)
    over = f.select(first, one, previous)
    usual, met = f.parts((Real, Real), "step_size", *places, over)
    unsure = first | (usual > over * LEAP)
    unsure = unsure if live is None else unsure & live
    h, total = f.variable(usual), f.variable(met)
    with f.when(f.any(unsure)):
        longest = f.constant(LARGEST_GUESS)
        again, more = f.parts((Real, Real), "step_size", *places, f.smaller(usual, longest))
        guess = f.select(first, f.smaller(again, longest), previous)
        h.set(f.select(unsure, f.call(Real, "cautious_step", *places, guess), usual))
        total.set(f.select(first, met + more, met))
    return h.get(), total.get()


def split_terms(top: int) -> list[list[int]]:
    """The coefficients that determine the step, in at most ``BLOCKS`` blocks."""
    terms = list(range(LOWEST_TERM, top if top >= FEW_TERMS else top + 1))
    size = -(-len(terms) // BLOCKS)
    return [terms[start : start + size] for start in range(0, len(terms), size)]


def offset_of(block: list[int], top: int) -> float:
    """A correction to 1/m of a coefficient's logarithm, m the first of its block: its bits count from
    2^-1023."""
    return (-1023.0 - (SLACK if block[-1] < 0.75 * top else 0)) / block[0]


def exponent(f: Function, largest: Real, slope: Real, offset: Real) -> Real:
    """log2 of the inverse radius of convergence; it does not count where the coefficients are 0."""
    found = f.fused(upper_half(largest), slope, offset)
    return f.select(largest > 0.0, found, f.splat(Real(f, constant("double", 1, -1000.0), 1), largest.lanes))
