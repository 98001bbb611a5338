"""What guards look at in steps on rates: polynomials through its values at points of the step.

Where one of them has a root, the step is taken again, so that it ends there, and then again until the root
does not move any more. So the time of an event is as precise as the ends of steps are, which polynomials
within steps are not.
"""

from __future__ import annotations

from fractions import Fraction
from math import comb

from lagrange_cli.native.guards import BRIEF, NOTES, NOWHERE, GuardRows
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import literal, operand, table
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.rates.nodes import RatesAtNodes
from lagrange_cli.native.rates.places import HEAD, RISES, WITHIN, Places
from lagrange_cli.native.rates.reversals import Reversals, parts_of
from lagrange_cli.native.stepping.polynomial import polynomial, weighed
from lagrange_cli.native.stepping.roots import NONE, points_of
from lagrange_cli.native.stepping.stopping import sliding
from lagrange_cli.native.stepping.sums import CHAINS

CLOSE, NEAR, TIMES = 2.0**-51, 2.0**-20, 12
"""The step ends at a root if this moves by no more than this part, or if it is near and moves no less than
before; and how often it is taken again at most."""
FARTHER, AHEAD, LOST = 1.25, 16.0, 3
"""The root may be so much beyond the end of the step. If it is not, it is looked for so much farther, or half
way to the end of the whole step (geometric mean), so often."""
NEARER, DOUBTS = 0.0625, 8
"""Where an argument begins at 0 and seems to lead back, the step is taken again, so much shorter, so often;
likewise where only a part of it is examined. Polynomials of long steps have errors in which what hardly moves
is lost. Only then does the first value behind 0 tell where it leads: an argument may go back, and be on its
side again there."""
NOTED = len(NOTES)
"""The highest coefficient of an argument that is noted where an event happens."""
NOW = 2.0**-60
"""The root is where the step begins if it is nearer than this part of t."""


def watched_rows(guards: GuardRows) -> tuple[int, ...]:
    """The rows of the state whose rates guards look at: arguments, multipliers, and parts of vectors."""
    rows = {*range(guards.first, guards.first + guards.arguments)}
    for one in guards.guards:
        rows |= {one.row} | ({one.multiplier} if one.multiplier else set())
    for j in sliding(guards):
        rows |= {*parts_of(guards.guards[j])}
    return tuple(sorted(rows))


def terms_of(points: list[float]) -> list[list[float]]:
    """Row m - 1: the weights of the values at all points but 0, less the one there, in coefficient m."""
    given = [Fraction(one) for one in points[1:]]
    rows = [[Fraction(0)] * len(given) for _ in given]
    for n, own in enumerate(given):
        product, scale = [Fraction(0), Fraction(1)], own
        for other in given:
            if other is not own:
                shifted = [Fraction(0), *product]
                product = [a - other * b for a, b in zip(shifted, [*product, Fraction(0)])]
                scale *= own - other
        for m, one in enumerate(product[1:]):
            rows[m][n] = one / scale
    return [[float(one) for one in row] for row in rows]


class Watching:
    """Writes the functions that look for roots of polynomials of a ``degree``, with what is ``at`` its places
    in ``%work``."""

    def __init__(self, steps: RatesAtNodes, at: Places, rows: tuple[int, ...], degree: int) -> None:
        self.steps, self.begin, self.values = steps, at.begin, at.values
        self.within, self.rises = at.chosen + WITHIN, at.chosen + RISES
        self.rows, self.degree = rows, degree
        self.points = points_of(degree)
        assert steps.guards
        self.reversals = Reversals(steps.guards.rows, steps.state, at.values, rows, self.points)

    def tables(self) -> list[str]:
        """The rows, and the points."""
        listed = ", ".join(f"double {operand(literal(x))}" for x in self.points)
        points = f"@points = private constant [{len(self.points)} x double] [{listed}]\n"
        return [table("watched", self.rows), points, *self.reversals.tables()]

    def functions(self) -> list[Function]:
        """The functions."""
        return [*self.reversals.functions(), self._watch(), self._located()]

    def watch(self, f: Function, h: Real) -> None:
        """A call of ``@watch``."""
        f.call(None, "watch", *f.pointers("constants", "state", "work"), h)

    def shift(self, f: Function, since: Real) -> None:
        """The first coefficients about the end of a step that began so long ``since``, but for the values,
        which are known there."""
        width, last = self.steps.state.width, self.degree + 1
        with f.loop(0, len(self.rows), tested=False) as j:
            row = f.load_integer("@watched", j)
            terms = {m: f.load("%work", row + m * width) for m in range(2, last + 1)}
            for m in range(2, min(last, NOTED) + 1):
                weights = [comb(k - 1, m - 1) * k / m for k in range(m, last + 1)]
                shifted = [terms[k] * weight for k, weight in zip(range(m, last + 1), weights)]
                f.store(polynomial(f, shifted, since), "%work", row + m * width)

    def first(self, f: Function, h: Real) -> tuple[Real, Integer, Real]:
        """A call of ``@located``."""
        places = f.pointers("constants", "state", "work", "trial")
        root, which, known = f.parts((Real, Integer, Real), "located", *places, h)
        return root, which, known

    def _watch(self) -> Function:
        """``@watch(constants, state, work, h)``: polynomials of the rows, in place of the integrals of what
        the method has for them."""
        f = Function(f"define internal void @watch{HEAD}, double %h) #0")
        steps, count, lanes = self.steps, len(self.rows), self.steps.lengths.lanes
        width, degrees = steps.state.width, steps.state.degrees
        h, now = Real(f, "%h"), steps.now(f)
        with f.loop(0, count, tested=False) as j:
            row = f.load_integer("@watched", j)
            f.store(f.load("%work", row + (self.begin - degrees)), "%work", j + self.values)
        with f.loop(1, self.degree + 1, tested=False) as n:
            time = h * f.load("@points", n)
            wide = f.splat(time, lanes)
            with f.loop(0, width, lanes, tested=False) as i:
                terms = [f.load_row("%work", i + m * width, lanes) for m in range(1, steps.order + 1)]
                change = polynomial(f, terms, wide, CHAINS) * wide
                steps.put_state(f, i, change, f.load_row("%state", i + width, lanes))
            rates, _ = steps.node(f, now + time)
            with f.loop(0, count, tested=False) as j:
                row = f.load_integer("@watched", j)
                f.store(f.load(rates, row - degrees), "%work", n * count + j + self.values)
        steps.spend(f, f.constant(float(self.degree)))
        f.store(self.reversals.call(f, h), "%work", self.within)
        inverse = f.constant(1.0) / h
        with f.loop(0, count, tested=False) as j:
            values = [f.load("%work", j + (self.values + n * count)) for n in range(self.degree + 1)]
            first, rest = values[0], values[-1] - values[0]
            changes = [one - first for one in values[1:]]
            terms, power = [], inverse
            for weights in terms_of(self.points):
                total = weighed(f, changes, weights)
                terms.append(total)
                rest = rest - total
            terms[0] = terms[0] + rest  # so that it has the value at the end, which was rounded otherwise
            row = f.load_integer("@watched", j)
            f.store(first, "%work", row + width)
            for m, term in enumerate(terms, 2):
                f.store(term * power * (1.0 / m), "%work", row + m * width)
                power = power * inverse
        f.give()
        return f

    def _located(self) -> Function:
        """``@located(constants, state, work, trial, h)``: what ``@first_guard`` gives for a step of ``h``,
        where the step has been taken again so that it ends at the root."""
        f = Function(
            f"define internal {{ double, i64, double }} @located{HEAD}, ptr noalias %trial, double %h) #0"
        )
        steps, guards = self.steps, self.steps.guards
        assert guards
        unit, none, length = f.constant(1.0), f.constant(NONE), f.variable(Real(f, "%h"))
        f.store(f.constant(0.0), "%work", self.rises)
        with f.section() as sure, f.loop(0, DOUBTS, tested=False):
            root, which, known = guards.first(f, length.get(), unit)
            within = f.load("%work", self.within)
            with f.when((root >= 0.0) & ((root < none) | (known >= length.get())) & (within >= length.get())):
                sure.leave()
            shorter = f.select(root < 0.0, length.get() * NEARER, known)
            with f.when((root < 0.0) & (shorter <= self._brief(f, which))):
                sure.leave()
            length.set(f.select(within < length.get(), within, shorter))
            with f.when(~(steps.retried(f, length.get()) > 0.0)):
                f.give(none, which, length.get())
        h = length.get()
        root, which, known = guards.first(f, h, unit)
        places = f.variable(root), f.variable(which), f.variable(known)
        with f.when(root < 0.0):
            f.store(unit, "%work", self.rises)
            root, which, known = guards.first(f, h, unit)
            places[0].set(root)
            places[1].set(which)
            places[2].set(known)
        root, which, known = places[0].get(), places[1].get(), places[2].get()
        now = root <= f.magnitude(steps.now(f)) * NOW
        with f.when(now | ~(root <= known)):
            f.give(f.select(now & (root > 0.0), f.constant(0.0), root), which, known)
        end, guard, apart = f.variable(root), f.variable(which), f.variable(h)
        lost, free = f.variable(f.count(0)), f.variable(f.constant(0.0))
        with f.section() as found, f.loop(0, TIMES, tested=False) as i:
            x = end.get()
            with f.when(~(steps.retried(f, x) > 0.0)):
                f.give(none, which, x)  # @advance goes back from where rates are not finite
            root, which, known = guards.first(f, f.smaller(h, x * FARTHER), unit)
            with f.when((root > 0.0) & (root <= known)):
                guard.set(which)
                distance = f.magnitude(root - x)
                with f.when((distance <= x * CLOSE) | (distance <= x * NEAR) & (distance >= apart.get())):
                    found.leave()
                apart.set(distance)
                end.set(root)
            with f.otherwise():
                lost.set(lost.get() + 1)
                free.set(f.select((root >= 0.0) & (known >= x), x, free.get()))
                with f.when((x >= h) | (lost.get() >= LOST) | i.equals(TIMES - 1)):
                    steps.retried(f, h)
                    root, which, known = guards.first(f, h, unit)
                    root = f.select(self._crosses(f, which, h), root, none)
                    with f.when((root >= none) & (known < free.get())):  # up to a root that is rounding
                        f.give(none, which, steps.retried(f, free.get()))
                    f.give(root, which, known)
                end.set(f.smaller(f.larger(x * AHEAD, f.function("sqrt", x * h)), h))
        f.give(end.get(), guard.get(), h)
        return f

    def _brief(self, f: Function, which: Integer) -> Real:
        """How long a step is, at most, after which the argument of a guard that was 0 still is: with such
        steps alone the motion would not come away from there."""
        guards = self.steps.guards
        assert guards
        mark = f.load("%state", which + guards.rows.fresh(guards.layout))
        return f.larger(mark * BRIEF, f.magnitude(self.steps.now(f)) * NOWHERE)

    def _crosses(self, f: Function, which: Integer, h: Real) -> Bit:
        """Whether the argument of a guard is on the other side where the step of ``h`` ends. Otherwise a root
        that shorter steps do not have is rounding."""
        guards = self.steps.guards
        assert guards
        row, term = guards.lengths.place(f, f.load_integer("@guard_rows", which)), guards.lengths.term
        value = f.constant(0.0)
        for m in reversed(range(1, self.degree + 2)):
            value = f.fused(value, h, f.load(row, m * term) * float(m))
        return value * f.load("%state", which + guards.rows.mode(guards.layout)) < 0.0
