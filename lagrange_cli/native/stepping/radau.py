"""Steps of order 15 by Gauss-Radau quadrature (``ias15``).

E. Everhart, in: Dynamics of Comets: Their Origin and Evolution, 1985; H. Rein and D. S. Spiegel, MNRAS 446,
2015. Rates within a step are a polynomial of degree 7, which passes through those at the step's beginning and
at seven nodes. It is found by iteration: from the polynomial follow the states at the nodes, from these the
rates, from these the polynomial. The polynomial of the step before is where it begins.

``advance`` is given the same as by other steps: the coefficients of polynomials in time, of degree 9 for q
and 8 for v and integrals. So a step can be sampled, ended anywhere, and left again. All that one step hands
over to the next is in the state's memory, behind all else (``StateLayout.carried``): the polynomials of the
rates, in units of the step, and the length that they ask for.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import comb

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.roughly import exp2_roughly, log2_roughly
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.numbers.error_free import operators_two_sum as two_sum
from lagrange_cli.native.state import CARRIED_COUNT, Clock, StateLayout
from lagrange_cli.native.stepping.acceptance import DOUBLE, Allowance, accepted
from lagrange_cli.native.stepping.advance import advance
from lagrange_cli.native.stepping.doubles import DoubleSteps
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.motion import Given, Steps
from lagrange_cli.native.stepping.radau_nodes import NODES, TERMS, inverse, products
from lagrange_cli.native.stepping.steps import Now, clear_function
from lagrange_cli.native.stepping.sums import DoubleSums
from lagrange_cli.records import dataclass, replace

ORDER = TERMS + 2
"""The degree of q's polynomials."""
LAST_TERM = 1e-9
"""What the last term of the rates may add to a velocity, relative to it, at full double precision: the error
at the end of a step is of twice the order (Rein and Spiegel, sec. 2.3)."""
CONVERGED = 1e-12
"""The iteration ends where it changes this term by so little: another one would change it by some hundredth
of that, and the state by less than its rounding. (Rates that are rounded change it by as much.)"""
ROUNDS, FEWEST = 12, 2
"""Iterations at most; and how many there are before it counts that they do not come closer any more."""
LEAST, MOST = 0.8, 2.0
"""A step is taken again that should have been shorter by this factor; and how much the next one is longer at
most."""
AHEAD = 8.0
"""A step that is longer than the one before by more than this factor begins without its polynomials."""
BEGINNING, TRIALS = 2.0**-10, 12
"""The first trial, as part of what velocities are over accelerations; and how often it may be made longer."""
LONGER, SHORTER, APART = 16.0, 0.0625, 0.125
"""By what factors, and by which one where rates are not finite."""
SMALLEST, LARGEST = 2.0**-1000, 2.0**1000
STRAIGHT = 3
NEXT, LENGTH, HEADER = 0, 1, LANES
EVALUATIONS = CARRIED_COUNT
"""What is carried: the length that is asked for, that of the last step, how often rates were computed at
nodes; then polynomials."""


def span_of(layout: StateLayout) -> int:
    """Doubles of a number for each rate, in whole vectors that may begin at any of them."""
    return LANES * (-(-(layout.rows - layout.degrees) // LANES) + 1)


def carried(layout: StateLayout) -> int:
    """Doubles that steps hand over."""
    return HEADER + TERMS * span_of(layout)


@dataclass(frozen=True)
class Places:
    """Where things are in ``%work``: the series that ``advance`` reads first; the jet's last."""

    layout: StateLayout

    @property
    def span(self) -> int:
        return span_of(self.layout)

    @property
    def terms(self) -> int:
        """b[0], b[1], .."""
        return LANES * (-(-self.layout.width * (ORDER + 1) // LANES) + 1)  # rows are written in whole vectors

    @property
    def differences(self) -> int:
        """g[0], g[1], .."""
        return self.terms + TERMS * self.span

    @property
    def begin(self) -> int:
        """The rates where the step begins."""
        return self.differences + TERMS * self.span

    @property
    def rates(self) -> int:
        """The rates at a node, if they have to be copied."""
        return self.begin + self.span

    @property
    def scale(self) -> int:
        """The step over the size of each velocity."""
        return self.rates + self.span

    @property
    def state(self) -> int:
        """The state at a node, and its low parts."""
        return self.scale + self.span

    @property
    def low(self) -> int:
        """Its low parts, until it is complete."""
        return self.state + LANES * (-(-2 * self.layout.width // LANES) + 1)

    @property
    def chosen(self) -> int:
        """The length of the step that the polynomials are made for, and the next one."""
        return self.low + LANES * (-(-self.layout.width // LANES) + 1)

    @property
    def floor(self) -> int:
        """The least that velocities are measured by, at their rows."""
        return self.chosen + LANES

    @property
    def jet(self) -> int:
        """What ``@jet`` works on."""
        return self.floor + LANES * (-(-self.layout.width // LANES) + 1)


class RadauSteps(DoubleSteps):
    """The parts of these steps. The rates are those of ``@jet``, whose series have the places ``rates``
    in its own part of ``%work``."""

    def __init__(self, rates: Lengths, given: Given) -> None:
        layout = given.state
        lanes = min(layout.width, LANES)
        floor = Places(layout).floor if given.floors else 0
        lengths = Lengths(
            layout.degrees, layout.rows, layout.width, ORDER, lanes, lanes, 1, 1, layout.width, floor=floor
        )
        Steps.__init__(self, given, lengths, DOUBLE, DoubleSums(), 0.0)
        self.quadratures = None  # integrals are followed as velocities are
        self.lengths = lengths
        self._work, self._rates, self._places = given.work, rates, Places(layout)
        self._count = layout.rows - layout.degrees

    def functions(self) -> list[str]:
        made = [accepted(self.lengths), self._radau(), self._carry()]
        return [clear_function(), self.given.floors, *(f.text() for f in made)]

    # what ``advance`` asks for

    def expand(self, f: Function, now: Now) -> tuple[Now, Bit]:
        """The rates; the polynomials follow with the length of the step."""
        state, work, at = f.pointer("%state"), f.pointer("%work"), self._places
        self.measure(f)
        regular = self._evaluate(f, now.t + now.low, state, work)
        rates = self._rates_at(f, work)
        with self._each(f, self._count) as i:
            value = f.load_row(rates, i, self.lengths.lanes)
            f.store_row(value, work, i + at.begin)
        with self._each(f, self._count) as i:  # what is behind the last one is overwritten below
            f.store_row(
                f.load_row(work, i + at.begin, self.lengths.lanes),
                work,
                i + (self.lengths.width + self.lengths.degrees),
            )
        return now, regular

    def choose(self, f: Function, now: Now, fail: Callable[[], None]) -> tuple[Now, Real, Bit]:
        h = f.call(Real, "radau", f.pointer("%constants"), f.pointer("%state"), f.pointer("%work"))
        with f.when(~(h > 0.0)):
            fail()
        return now, h, Bit(f, "true")

    def straighten(self, f: Function) -> None:
        first, last = STRAIGHT * self.lengths.term, self._places.terms
        with f.loop(first, last, self.lengths.lanes, tested=False) as i:
            f.store_row(f.zero(self.lengths.lanes), "%work", i)

    def move(self, f: Function, now: Now, h: Real, final: Bit, allowed: Allowance) -> Real:
        farthest = super().move(f, now, h, final, allowed)
        f.call(None, "carry", f.pointer("%state"), f.pointer("%work"), h)
        return farthest

    # rates

    def _evaluate(self, f: Function, t: Real, state: Pointer, work: Pointer) -> Bit:
        jet = f.place(work, self._places.jet, "double")
        return f.call(Bit, "jet", f.pointer("%constants"), t, state, jet)

    def _rates_at(self, f: Function, work: Pointer) -> Pointer:
        """Where they are side by side, after ``_evaluate``."""
        lengths, at = self._rates, self._places
        degrees = self.lengths.degrees
        if lengths.row == 1:
            return f.place(work, at.jet + lengths.term + degrees, "double")
        with f.loop(0, self._count, tested=False) as i:
            row = i + degrees
            lane = row & (lengths.lanes - 1)
            place = (row - lane) * lengths.row + lane + (lengths.first + lengths.term + at.jet)
            f.store(f.load(work, place), work, i + at.rates)
        return f.place(work, at.rates, "double")

    @contextmanager
    def _each(self, f: Function, count: int) -> Iterator[Integer]:
        """Vectors of so many rows."""
        with f.loop(0, count, self.lengths.lanes, tested=False) as i:
            yield i

    # a step

    def _radau(self) -> Function:
        """``@radau(constants, state, work)``: the length of the step, with its polynomials in ``%work``; 0
        where there is none so short that its rates are finite."""
        f = Function(
            "define internal double @radau(ptr noalias %constants, ptr noalias %state, ptr noalias %work) #0"
        )
        layout, at, state = self.state, self._places, f.pointer("%state")
        t, low = (f.load(state, layout.at(one)) for one in (Clock.TIME, Clock.TIME_LOW))
        first = f.load(state, layout.at(Clock.STEP)).equals(0.0)
        gap = f.load(state, layout.at(Clock.GAP))
        asked, last = (f.load(state, layout.carried_at + one) for one in (NEXT, LENGTH))
        h = f.variable(f.select(first, self._first_length(f), asked))
        with f.when(~gap.equals(0.0)):  # what is beyond a critical point must not count
            h.set(f.smaller(h.get(), gap * 0.5))
        trials, one = f.variable(f.count(0)), f.constant(1.0)
        f.store(f.constant(0.0), "%work", at.chosen + EVALUATIONS)
        with f.forever() as attempts:
            self._predict(f, h.get(), f.select(first, f.constant(0.0), h.get() / f.select(first, one, last)))
            regular = self._iterate(f, t, low, h.get())
            factor, finite = self._factor(f)
            good = regular & finite
            with f.when(~good):
                h.set(h.get() * APART)
                with f.when(h.get() < SMALLEST):
                    f.give(f.constant(0.0))
                attempts.go_on()
            with f.when(factor < LEAST):
                h.set(h.get() * f.larger(factor, f.constant(SHORTER)))
                attempts.go_on()
            early = first & (factor > MOST) & (trials.get() < TRIALS) & gap.equals(0.0)
            with f.when(~early):
                f.store(h.get(), "%work", at.chosen + LENGTH)
                longer = h.get() * f.smaller(factor, f.constant(MOST))
                f.store(longer, "%work", at.chosen + NEXT)
                attempts.leave()
            h.set(h.get() * f.smaller(factor, f.constant(LONGER)))
            trials.set(trials.get() + 1)
        self._finish(f, h.get())
        f.give(h.get())
        return f

    def _first_length(self, f: Function) -> Real:
        speed, rate = f.variable(f.zero(self.lengths.lanes)), f.variable(f.zero(self.lengths.lanes))
        degrees, lanes = self.lengths.degrees, self.lengths.lanes
        with self._each(f, degrees) as i:
            among = self._among(f, i, degrees)
            v = f.magnitude(f.load_row("%state", i + degrees, lanes))
            a = f.magnitude(f.load_row("%work", i + self._places.begin, lanes))
            for one, value in ((speed, v), (rate, a)):
                one.set(f.larger(f.select(among, value, f.zero(lanes)), one.get()))
        v, a = (f.reduce("fmax", one.get()) for one in (speed, rate))
        usual = (v > 0.0) & (a > 0.0)
        return f.select(usual, v / f.select(usual, a, f.constant(1.0)), f.constant(1.0)) * BEGINNING

    def _among(self, f: Function, i: Integer, count: int) -> Bit:
        lanes = self.lengths.lanes
        if lanes == 1:
            return i < count
        listed = ", ".join(f"i64 {lane}" for lane in range(lanes))
        return f.splat(i, lanes) + Integer(f, f"<{listed}>", lanes) < count

    def _term(self, f: Function, first: int, k: int, i: Integer) -> Real:
        return f.load_row("%work", i + (first + k * self._places.span), self.lengths.lanes)

    def _put(self, f: Function, value: Real, first: int, k: int, i: Integer) -> None:
        f.store_row(value, "%work", i + (first + k * self._places.span))

    def _predict(self, f: Function, h: Real, ratio: Real) -> None:
        """b from the step before, g from b, and the scales."""
        layout, at, lanes = self.state, self._places, self.lengths.lanes
        ratio = f.select(ratio < AHEAD, ratio, f.constant(0.0))
        powers = [ratio]
        for _ in range(1, TERMS):
            powers.append(powers[-1] * ratio)
        wide, rows = [f.splat(one, lanes) for one in powers], inverse(products())
        length, zero = f.splat(h, lanes), f.zero(lanes)
        with self._each(f, self._count) as i:
            before = layout.carried_at + HEADER
            b = [f.load_row("%state", i + (before + k * at.span), lanes) * wide[k] for k in range(TERMS)]
            for k, one in enumerate(b):
                self._put(f, one, at.terms, k, i)
            for n in range(TERMS):
                total = b[n]
                for k in range(n + 1, TERMS):
                    total = f.fused(b[k], float(rows[n][k]), total)
                self._put(f, total, at.differences, n, i)
            v = f.magnitude(f.load_row("%state", i + layout.degrees, lanes))
            a = f.larger(f.magnitude(self._term(f, at.begin, 0, i)), f.magnitude(b[0]))
            if self.lengths.floor:
                v = f.larger(v, f.load_row("%work", i + (self.lengths.floor + layout.degrees), lanes))
            size = f.larger(v, a * length)
            there = self._among(f, i, self._count) & (size > SMALLEST)
            one = length / f.select(there, size, f.splat(f.constant(1.0), lanes))
            f.store_row(f.select(there, one, zero), "%work", i + at.scale)

    def _iterate(self, f: Function, t: Real, low: Real, h: Real) -> Bit:
        """Compute rates at the nodes until they do not change any more; whether all of them were regular."""
        before, rounds = f.variable(f.constant(math.inf)), f.variable(f.count(0))
        regular = f.variable(Bit(f, "true"))
        with f.forever() as iterations:
            for n in range(TERMS):
                error, good = self._node(f, n, t, low, h)
                regular.set(regular.get() & good)
            rounds.set(rounds.get() + 1)
            stalls = (rounds.get() > FEWEST) & (error >= before.get())
            near = error <= max(CONVERGED, 0.001 * self.given.tolerance)
            done = near | stalls | (rounds.get() >= ROUNDS) | ~regular.get()
            with f.when(done):
                iterations.leave()
            before.set(error)
        place = self._places.chosen + EVALUATIONS
        spent = f.load("%work", place) + rounds.get().to_real() * float(TERMS)
        f.store(spent, "%work", place)
        return regular.get()

    def _node(self, f: Function, n: int, t: Real, low: Real, h: Real) -> tuple[Real, Bit]:
        """The state at a node, its rates, and the polynomial through them; by how much its last term has
        changed, and whether the rates are regular."""
        layout, at, lanes = self.state, self._places, self.lengths.lanes
        degrees, width, s = layout.degrees, layout.width, NODES[n]
        hs = h * s
        wide = f.splat(hs, lanes)

        def total(i: Integer, divisors: list[int]) -> Real:
            """a(0) and b, each times a power of s, over a divisor."""
            begin = self._term(f, at.begin, 0, i)
            sums = [begin * (1.0 / divisors[0]), None]
            for k in range(TERMS):
                factor = s ** (k + 1) / divisors[k + 1]
                b = self._term(f, at.terms, k, i)
                other = sums[(k + 1) % 2]
                sums[(k + 1) % 2] = b * factor if other is None else f.fused(b, factor, other)
            assert sums[0] is not None and sums[1] is not None
            return sums[0] + sums[1]

        def put(i: Integer, row: Integer, change: Real, rest: Real) -> None:
            high, error = two_sum(f.load_row("%state", row, lanes), change + rest)
            f.store_row(high, "%work", row + at.state)
            f.store_row(error, "%work", row + at.low)

        with self._each(f, degrees) as i:
            twice = total(i, [(k + 1) * (k + 2) for k in range(TERMS + 1)])
            v, v_low = (f.load_row("%state", i + (degrees + part * width), lanes) for part in (0, 1))
            change = f.fused(wide, f.fused(wide, twice, v_low), wide * v)
            put(i, i, change, f.load_row("%state", i + width, lanes))
        with self._each(f, self._count) as i:
            change = wide * total(i, [k + 1 for k in range(TERMS + 1)])
            put(i, i + degrees, change, f.load_row("%state", i + (degrees + width), lanes))
        with f.loop(0, width, lanes, tested=False) as i:
            f.store_row(f.load_row("%work", i + at.low, lanes), "%work", i + (at.state + width))
        work = f.pointer("%work")
        good = self._evaluate(f, t + (low + hs), f.place(work, at.state, "double"), work)
        rates = self._rates_at(f, work)
        parts, largest = products()[n], f.variable(f.zero(lanes))
        with self._each(f, self._count) as i:
            x = (f.load_row(rates, i, lanes) - self._term(f, at.begin, 0, i)) * (1.0 / s)
            for j in range(n):
                x = (x - self._term(f, at.differences, j, i)) * (1.0 / (s - NODES[j]))
            change = x - self._term(f, at.differences, n, i)
            self._put(f, x, at.differences, n, i)
            for k in range(n + 1):
                b = self._term(f, at.terms, k, i)
                self._put(f, f.fused(change, float(parts[k]), b), at.terms, k, i)
            if n == TERMS - 1:
                error = f.magnitude(change) * f.load_row("%work", i + at.scale, lanes)
                largest.set(f.larger(error, largest.get()))
        return f.reduce("fmax", largest.get()), good

    def _factor(self, f: Function) -> tuple[Real, Bit]:
        """By what the step should be longer, by its last two terms, and whether all rates are finite."""
        at, lanes = self._places, self.lengths.lanes
        most = [f.variable(f.zero(lanes)) for _ in range(2)]
        total = f.variable(f.zero(lanes))
        with self._each(f, self._count) as i:
            scale = f.load_row("%work", i + at.scale, lanes)
            for one, k in zip(most, (TERMS - 2, TERMS - 1)):
                b = f.magnitude(self._term(f, at.terms, k, i))
                one.set(f.larger(b * scale, one.get()))
            moving = self._among(f, i, self.lengths.degrees)
            total.set(total.get() + f.select(moving, b, f.zero(lanes)))
        goal = math.log2(self._last_term)
        exponents = []
        for one, order in zip(most, (TERMS - 1, TERMS)):
            largest = f.smaller(f.reduce("fmax", one.get()), f.constant(LARGEST))
            exponents.append((log2_roughly(largest) * -1.0) * (1.0 / order) + goal / TERMS)
        factor = exp2_roughly(f.smaller(*exponents))
        return factor, f.reduce("fadd", total.get(), f.constant(0.0)) < math.inf

    @property
    def _last_term(self) -> float:
        looser: float = max(1.0, self.given.tolerance * 2.0**52) ** (TERMS / (2 * TERMS + 1))
        return LAST_TERM * looser

    def _finish(self, f: Function, h: Real) -> None:
        """The coefficients of the polynomials, in time, where ``advance`` reads them."""
        at, lanes, width = self._places, self.lengths.lanes, self.lengths.width
        degrees = self.lengths.degrees
        powers = [h]
        for _ in range(1, TERMS):
            powers.append(powers[-1] * h)

        def put(value: Real, m: int, i: Integer) -> None:
            f.store_row(value, "%work", i + m * width)

        def coefficient(k: int, i: Integer, divisor: int) -> Real:
            return self._term(f, at.terms, k, i) / f.splat(powers[k] * float(divisor), lanes)

        # what is written behind the last coordinate is overwritten by the velocities, and behind the last
        # row by the next coefficient
        for m in range(1, ORDER + 1):
            with self._each(f, degrees) as i:
                if m == 1:
                    put(f.load_row("%state", i + degrees, lanes), m, i)
                elif m == 2:
                    put(self._term(f, at.begin, 0, i) * 0.5, m, i)
                else:
                    put(coefficient(m - 3, i, m * (m - 1)), m, i)
            with self._each(f, self._count) as i:
                if m == 1:
                    put(self._term(f, at.begin, 0, i), m, i + degrees)
                elif m == ORDER:
                    put(f.zero(lanes), m, i + degrees)
                else:
                    put(coefficient(m - 2, i, m), m, i + degrees)

    def _carry(self) -> Function:
        """``@carry(state, work, length)``: what the next step is given, after so long a step."""
        f = Function("define internal void @carry(ptr noalias %state, ptr noalias %work, double %length) #0")
        layout, at, lanes = self.state, self._places, self.lengths.lanes
        length = Real(f, "%length")
        h, following = (f.load("%work", at.chosen + one) for one in (LENGTH, NEXT))
        f.store(following, "%state", layout.carried_at + NEXT)
        f.store(length, "%state", layout.carried_at + LENGTH)
        counted = layout.carried_at + EVALUATIONS
        f.store(f.load("%state", counted) + f.load("%work", at.chosen + EVALUATIONS), "%state", counted)
        ratio = length / h
        powers = [f.splat(f.constant(1.0), lanes), f.splat(ratio, lanes)]
        for _ in range(1, TERMS):
            powers.append(powers[-1] * powers[1])
        with self._each(f, self._count) as i:
            b = [self._term(f, at.terms, k, i) * powers[k + 1] for k in range(TERMS)]
            for k in range(TERMS):
                total = b[k]
                for j in range(k + 1, TERMS):
                    total = f.fused(b[j], float(comb(j + 1, k + 1)), total)
                place = i + (layout.carried_at + HEADER + k * at.span)
                f.store_row(total, "%state", place)
        f.give()
        return f


def on_rates(rates: Lengths, given: Given) -> tuple[int, str]:
    """The doubles of ``%work``, and IR of ``@advance`` and its helpers, on a ``@jet`` that has ``given.work``
    for itself and leaves the rates at the places of ``rates``."""
    work = Places(given.state).jet + given.work
    return work, advance(RadauSteps(rates, replace(given, work=work)))
