"""The equations of the stages of Radau IIA steps, and Newton's method for them.

E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., 1996, sec. IV.8. Iterations are
in numbers in which the stages are not coupled: one real and one complex linear system each.

The unknowns are increments of velocities at the stages, v(t + c_i h) - v(t) = z_i. Increments of coordinates
follow, h (c_i v + sum_j a_ij z_j), and so do those of integrals, which the motion does not depend on.
"""

from __future__ import annotations

import math

from lagrange_cli.native.llvm.function import Function, exp2_roughly, log2_roughly
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.rates.implicit import BEYOND, THETA, ImplicitSteps, areas
from lagrange_cli.native.rates.places import HEAD, NEARER, span_of, wide_of
from lagrange_cli.native.rates.radau_constants import (
    COMPLEX,
    NODES,
    PARTS,
    POLYNOMIAL,
    REAL,
    STAGES,
    VALUES,
    WEIGHTS,
)
from lagrange_cli.native.rates.trials import SMALLEST
from lagrange_cli.native.state import StateLayout, whole_vectors
from lagrange_cli.native.stepping.given import Given
from lagrange_cli.native.stepping.polynomial import weighed

ROUNDS = 7
"""Newton iterations at most."""
AHEAD = 16.0
"""A step that is longer than the one before by more than this factor begins without its polynomials."""
DIVERGED, UNSOUND = 0.0, -1.0
RAISED = tuple(k * (k + 1) ** (-1 - 1 / k) if k else 0.0 for k in range(STAGES))
"""How far s^(k + 1) is from s at most, for s from 0 to 1."""
LIFTED = tuple(k * (k + 1) ** (-1 - 1 / k) / (k + 1) for k in range(1, STAGES + 1))
"""The same of its integral: s^(k + 1)/(k + 1), and so much of s."""


class CollocationSteps(ImplicitSteps):
    """Steps whose stages are found by Newton's method."""

    growth = REAL, COMPLEX

    @staticmethod
    def own_areas(given: Given) -> dict[str, int]:
        span = span_of(given.state)
        of_stages = {f"{name}{k}": span for name in ("z", "w", "f") for k in range(STAGES)}
        return {**areas(given), **of_stages, "shares": wide_of(given.state)}

    @staticmethod
    def carried(layout: StateLayout) -> int:
        return BEYOND + layout.width + STAGES * whole_vectors(layout.degrees, 1)

    def helpers(self) -> list[Function]:
        return [*super().helpers(), self._stages(), self._collocate()]

    def rows(self, f: Function, area: str, i: Integer) -> list[Real]:
        """What an area has of all stages at some rows."""
        return [self.row(f, f"{area}{k}", i) for k in range(STAGES)]

    def terms(self, layout: StateLayout) -> tuple[int, ...]:
        """Where in the state the polynomials of velocities are carried, from the linear term on."""
        first, each = layout.carried_at + BEYOND + layout.width, whole_vectors(layout.degrees, 1)
        return tuple(first + k * each for k in range(STAGES))

    def _stages(self) -> Function:
        """``@stages(.., h)``: the rates at the stages, and whether all are regular."""
        f = Function(f"define internal i1 @stages{HEAD}, double %h) #0")
        h, layout, lanes = Real(f, "%h"), self.state, self.lengths.lanes
        degrees, wide, now = layout.degrees, f.splat(h, lanes), self.now(f)
        regular = Bit(f, "true")

        def lows(i: Integer) -> Real:
            return f.load_row("%state", i + layout.width, lanes)

        for k, (node, weights) in enumerate(zip(NODES, WEIGHTS)):
            with f.loop(0, degrees, lanes, tested=False) as i:
                v = f.load_row("%state", i + degrees, lanes)
                rest = f.fused(wide * node, lows(i + degrees), lows(i))
                inner = f.fused(v, node, weighed(f, self.rows(f, "z", i), weights))
                self.put_state(f, i, wide * inner, rest)
            with f.loop(0, degrees, lanes, tested=False) as i:
                self.put_state(f, i + degrees, self.row(f, f"z{k}", i), lows(i + degrees))
            self.put_integrals(f)
            rates, good = self.node(f, now + h * node)
            f.copy_rows((rates, 0), ("%work", self.areas[f"f{k}"]), self._count, lanes)
            regular = regular & good
        self.spend(f, f.constant(float(STAGES)))
        f.give(regular)
        return f

    def put_integrals(self, f: Function) -> None:
        """The integrals are where they were; rates do not depend on them."""
        first, lanes = 2 * self.state.degrees, self.lengths.lanes
        if self.state.rows > first:
            with f.loop(first, self.state.rows, lanes, tested=False) as i:
                self.put_state(f, i, f.zero(lanes), f.load_row("%state", i + self.state.width, lanes))

    # Newton's method

    def _collocate(self) -> Function:
        """``@collocate(.., h, ratio)``: the increments, and how many iterations they took; ``DIVERGED`` or
        ``UNSOUND`` where there are none."""
        f = Function(f"define internal double @collocate{HEAD}, double %h, double %ratio) #0")
        h, layout = Real(f, "%h"), self.state
        tolerance = self.given.tolerance
        goal = max(10 * 2.0**-52 / tolerance, min(0.03, math.sqrt(tolerance)))
        places = f.pointers("constants", "state", "work")
        rounding = self._predict(f, Real(f, "%ratio"), h)
        slowness, before = f.variable(f.constant(1.0)), f.variable(f.constant(0.0))
        rounds, last_ratio = f.variable(f.constant(0.0)), f.variable(f.constant(0.0))
        self.note(f, f.constant(0.0), THETA, "cache")
        with f.forever() as iterations:
            with f.when(~f.call(Bit, "stages", *places, h)):
                f.give(f.constant(UNSOUND))
            self._right_sides(f, h)
            self.push(f, STAGES)
            self.solve(f, "real", 1, 0)
            self.solve(f, "complex", 2, 1)
            size = f.function("sqrt", self._correct(f) * (1.0 / (STAGES * self.size)))
            with f.when(~(size < math.inf)):
                f.give(f.constant(UNSOUND))
            rounds.set(rounds.get() + 1.0)
            with f.when(size <= rounding):
                iterations.leave()
            with f.when(rounds.get() > 1.0):
                ratio = size / before.get()
                usual = f.select(rounds.get() > 2.0, last_ratio.get(), ratio)
                theta = f.function("sqrt", ratio * usual)
                last_ratio.set(ratio)
                self.note(f, theta, THETA, "cache")
                with f.when(theta >= 0.99):
                    f.give(f.constant(DIVERGED))
                slowness.set(theta / (f.constant(1.0) - theta))
                left = exp2_roughly(log2_roughly(theta) * (f.constant(float(ROUNDS)) - rounds.get()))
                with f.when(slowness.get() * size * left >= goal):
                    f.give(f.constant(DIVERGED))
            before.set(size)
            with f.when(slowness.get() * size <= goal):
                iterations.leave()
            with f.when(rounds.get() >= float(ROUNDS)):
                f.give(f.constant(DIVERGED))
        if self._count > layout.degrees:
            self._quadratures(f, places, h)
        f.give(rounds.get())
        return f

    def _predict(self, f: Function, ratio: Real, h: Real) -> Real:
        """Increments from the polynomials of the step before, and how they are measured; by what rounding
        errors of rates, as far as known, change them."""
        layout, lanes, degrees = self.state, self.lengths.lanes, self.state.degrees
        ratio = f.select(ratio < AHEAD, ratio, f.constant(0.0))
        zero, one = f.zero(lanes), f.splat(f.constant(1.0), lanes)
        wide, part = f.splat(h, lanes), 1.0 / self.given.tolerance
        scales = [f.splat(ratio * node, lanes) for node in NODES]
        squares = f.variable(zero)
        with f.loop(0, degrees, lanes, tested=False) as i:
            terms = [f.load_row("%state", i + place, lanes) for place in self.terms(layout)]
            z = []
            for scale in scales:
                total = f.fused(f.fused(terms[2], scale, terms[1]), scale, terms[0])
                z.append(total * scale)
            for k, value in enumerate(z):
                self.put_row(f, value, f"z{k}", i)
                self.put_row(f, weighed(f, z, PARTS[k]), f"w{k}", i)
            q, v = (f.magnitude(f.load_row("%state", i + shift, lanes)) for shift in (0, degrees))
            share = f.larger(one / (v + 1.0), wide / (q + 1.0)) * part
            share = f.select(self._among(f, i, degrees), share, zero)
            self.put_row(f, share, "shares", i)
            change = self.rounding.of(f, i) * wide * share
            squares.set(f.fused(change, change, squares.get()))
        return f.function("sqrt", f.reduce("fadd", squares.get(), f.constant(0.0)) * (1.0 / degrees))

    def _right_sides(self, f: Function, h: Real) -> None:
        """What Newton's equations are to give."""
        lanes, zero = self.lengths.lanes, f.zero(self.lengths.lanes)
        inverse = f.splat(f.constant(-1.0) / h, lanes)
        with f.loop(0, self.size, lanes, tested=False) as i:
            w, slopes = self.rows(f, "w", i), self.rows(f, "f", i)
            real, first, second = (weighed(f, slopes, PARTS[k]) for k in range(STAGES))
            a, b = COMPLEX.real, COMPLEX.imag
            values = (
                f.fused(w[0] * REAL, inverse, real),
                f.fused(f.fused(w[1], a, w[2] * -b), inverse, first),
                f.fused(f.fused(w[2], a, w[1] * b), inverse, second),
            )
            inside = self._among(f, i, self.size)
            for k, value in enumerate(values):
                self.put_row(f, f.select(inside, value, zero), f"rows{k}", i)
        with self.in_band(f) as (p, row):
            for k in range(STAGES):
                value = f.load("%work", row + self.areas[f"rows{k}"])
                f.store(value, "%work", p + (self.areas["x"] + k * self.band.length))

    def _correct(self, f: Function) -> Real:
        """Add the solutions, and the sum of their squares."""
        lanes = self.lengths.lanes
        with self.in_band(f) as (p, row):
            for k in range(STAGES):
                value = f.load("%work", p + (self.areas["x"] + k * self.band.length))
                f.store(value, "%work", row + self.areas[f"rows{k}"])
        total = f.variable(f.zero(lanes))
        with f.loop(0, self.size, lanes, tested=False) as i:
            changes, share = self.rows(f, "rows", i), self.row(f, "shares", i)
            w = [a + b for a, b in zip(self.rows(f, "w", i), changes)]
            for k, change in enumerate(changes):
                self.put_row(f, w[k], f"w{k}", i)
                self.put_row(f, weighed(f, w, VALUES[k]), f"z{k}", i)
                size = change * share
                total.set(f.fused(size, size, total.get()))
        return f.reduce("fadd", total.get(), f.constant(0.0))

    def _quadratures(self, f: Function, places: list[Pointer], h: Real) -> None:
        """The increments of integrals, from the integrands at the stages."""
        lanes, wide = self.lengths.lanes, f.splat(h, self.lengths.lanes)
        with f.when(~f.call(Bit, "stages", *places, h)):
            f.give(f.constant(UNSOUND))
        with f.loop(self.size, self._count, lanes, tested=False) as i:
            slopes = self.rows(f, "f", i)
            for k in range(STAGES):
                self.put_row(f, wide * weighed(f, slopes, WEIGHTS[k]), f"z{k}", i)

    def approached(self, f: Function, t: Real, h: Real) -> Real:
        """By what the step may be longer, by how near it brings the motion to where narrow forces act."""
        lanes, degrees, wide = self.lengths.lanes, self.state.degrees, f.splat(h, self.lengths.lanes)
        bounds, shifts = self._places.spare, self._places.spare + wide_of(self.state)
        for row, shares in ((0, LIFTED), (degrees, RAISED)):
            with f.loop(0, degrees, lanes, tested=False) as i:
                z = self.rows(f, "z", i)
                terms = [weighed(f, z, POLYNOMIAL[k]) for k in range(STAGES)]
                moved = f.zero(lanes) if row else f.load_row("%state", i + degrees, lanes)
                bound = f.zero(lanes)
                for k, (term, share) in enumerate(zip(terms, shares)):
                    moved = f.fused(term, 1.0 if row else 1.0 / (k + 2), moved)
                    bound = f.fused(f.magnitude(term), share, bound)
                for area, value in ((bounds, bound), (shifts, moved)):
                    f.store_row(value if row else value * wide, "%work", i + (area + row))
        at = f.place("%work", bounds, "double")
        part = f.call(Real, "approach", f.pointer("%constants"), t, f.pointer("%state"), at, h)
        return f.constant(NEARER) / f.larger(part, f.constant(SMALLEST))
