"""How long Gauss-Radau steps should be: by the last terms of their polynomials, and by poles nearby."""

from __future__ import annotations

import math

from lagrange_cli.native.llvm.function import Function, exp2_roughly, log2_roughly
from lagrange_cli.native.llvm.vector import Bit, Real
from lagrange_cli.native.rates.gauss_radau_nodes import TERMS
from lagrange_cli.native.rates.gauss_radau_sizes import GaussRadauSizes
from lagrange_cli.native.rates.places import LEAST, NEARER
from lagrange_cli.native.rates.trials import LARGEST, SMALLEST

LAST_TERM = 1e-9
"""What the last term of the rates may add to a velocity, relative to it, at full double precision: the error
at the end of a step is of twice the order (Rein and Spiegel, sec. 2.3)."""
SENSITIVITY = {TERMS - 3: 51100.0, TERMS - 2: 38800.0, TERMS - 1: 11600.0}
"""What rounding errors of rates change a term by at most, as multiples of them."""
ROUNDED, SMOOTH, BETWEEN = 5.0, 200.0, 1 / 3
"""How many times as large as the last term the third last one is by rounding errors of rates, and in a step
of the right length at full double precision. Rates are rounded where it is less than the first times this
power of the ratio between these."""
NO_LONGER = 1.25
"""If a step whose rates are rounded should be longer by no more than this, these errors are measured."""


class GaussRadauLengths(GaussRadauSizes):
    """By what factor a step should have been longer."""

    def _factor(self, f: Function) -> tuple[Real, Bit, Bit]:
        """By what the step should be longer, by its last two terms; whether all rates are finite; and whether
        rounding may have shortened it."""
        lanes, last = self.lengths.lanes, TERMS - 1
        zero, one = f.zero(lanes), f.splat(f.constant(1.0), lanes)
        unseen = f.splat(f.constant(self._last_term / SENSITIVITY[last]), lanes)
        plain, known, level = ({k: f.variable(zero) for k in range(last - 2, last + 1)} for _ in range(3))
        total = f.variable(zero)
        with self._each(f, self._count) as i:
            # a velocity that begins at 0, without an acceleration, is measured by what it becomes
            grown = one / f.magnitude(self._term(f, self.terms, 0, i))
            scale = f.smaller(f.load_row("%work", i + self.scale, lanes), grown)
            errors = self.rounding.of(f, i)
            rough = f.smaller(scale, unseen / errors)
            for k in plain:
                b = f.magnitude(self._term(f, self.terms, k, i))
                rest = f.larger(f.fused(errors, -SENSITIVITY[k], b), zero)
                for largest, size in (
                    (plain[k], b * scale),
                    (known[k], rest * scale),
                    (level[k], rest * rough),
                ):
                    largest.set(f.larger(size, largest.get()))
            moving = self._among(f, i, self.lengths.degrees)
            total.set(total.get() + f.select(moving, b, zero))
        finite = f.reduce("fadd", total.get(), f.constant(0.0)) < math.inf
        flat = f.reduce("fmax", plain[last - 2].get()) < f.reduce("fmax", plain[last].get()) * self._flat
        goal, exponents = math.log2(self._last_term), list[Real]()
        for k in (last - 1, last):
            most = f.reduce("fmax", f.select(flat, level[k].get(), known[k].get()))
            size = log2_roughly(f.smaller(most, f.constant(LARGEST)))
            exponents.append((size * -1.0) * (1.0 / (k + 1)) + goal / TERMS)
        factor = exp2_roughly(f.smaller(*exponents))
        return factor, finite, (factor < LEAST) | ((factor < NO_LONGER) & flat)

    def _approached(self, f: Function, t: Real, h: Real) -> Real:
        """By what the step should be longer, by how near it may bring the motion to a pole."""
        at, lanes, degrees = self._places, self.lengths.lanes, self.lengths.degrees
        square = f.splat(h * h, lanes)
        with self._each(f, degrees) as i:
            bound = f.magnitude(self._term(f, at.begin, 0, i)) * 0.5
            for k in range(TERMS):
                b = f.magnitude(self._term(f, self.terms, k, i))
                bound = f.fused(b, 1.0 / ((k + 2) * (k + 3)), bound)
            f.store_row(bound * square, "%work", i + at.spare)
        bounds = f.place("%work", at.spare, "double")
        part = f.call(Real, "approach", f.pointer("%constants"), t, f.pointer("%state"), bounds, h)
        return f.constant(NEARER) / f.larger(part, f.constant(SMALLEST))

    @property
    def _last_term(self) -> float:
        looser: float = max(1.0, self.given.tolerance * 2.0**52) ** (TERMS / (2 * TERMS + 1))
        return LAST_TERM * looser

    @property
    def _flat(self) -> float:
        """Rates are rounded where the third last term is less than the last one times this."""
        smooth: float = SMOOTH * (LAST_TERM / self._last_term) ** (2 / TERMS)
        factor: float = (smooth / ROUNDED) ** BETWEEN
        return ROUNDED * factor
