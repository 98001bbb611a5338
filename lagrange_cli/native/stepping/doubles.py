"""Steps in doubles (see ``advance``): rows of one motion side by side, and compensated summation."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from lagrange_cli.native.interface import records_at
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.numbers.error_free import operators_two_sum as two_sum
from lagrange_cli.native.recurrences.layout import Layout
from lagrange_cli.native.state import LANES, Clock, GuardRows, StateLayout
from lagrange_cli.native.stepping.acceptance import DOUBLE, Allowance, accepted
from lagrange_cli.native.stepping.advance import STRAIGHT, Now, Steps, advance, clear_function
from lagrange_cli.native.stepping.guards import GuardCode
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.polynomial import careful_sum, polynomial, rate
from lagrange_cli.native.stepping.proof import Proof, Proving, proven
from lagrange_cli.native.stepping.quadratures import Part, Places, Quadratures, Time, followed, sampling
from lagrange_cli.native.stepping.step_size import ENDLESS, StepSize, chosen_step
from lagrange_cli.records import replace

AT_REST = 2.0**-900
"""Where steps are proven, velocities below this do not limit them."""
CHAINS, RATE_CHAINS = 4, 2
"""Partial sums of a polynomial that are added in parallel."""


SMALL = 2.0**-46
"""A defect up to this part of what moves is not told from rounding (see ``Proof``)."""


def stepper(
    layout: Layout,
    state: StateLayout,
    work: int,
    tolerance: float,
    proving: tuple[Proving | None, Proving | None] = (None, None),
    guards: GuardRows | None = None,
) -> str:
    """IR of ``@advance`` and its helpers for ``work`` doubles of ``%work``."""
    return advance(DoubleSteps(layout, state, work, tolerance, proving, guards))


class DoubleSteps(Steps):
    """What steps in doubles are made of."""

    refined = False

    def __init__(
        self,
        layout: Layout,
        state: StateLayout,
        work: int,
        tolerance: float,
        proving: tuple[Proving | None, Proving | None],
        guards: GuardRows | None,
    ) -> None:
        self.state, degrees = state, state.degrees
        self.bounds = DOUBLE.coarser(tolerance)
        width, lanes = layout.width, min(layout.width, LANES)
        self.lengths = Lengths(degrees, len(layout.state), width, layout.order, lanes, lanes, 1, 1, width)
        first, count = followed(state, guards)
        self.quadratures = None
        if count:
            self.lengths = replace(self.lengths, apart=True)
            rest = AT_REST if proving[1] else 0.0
            self.quadratures = Quadratures(
                self.lengths, first, count, width, tolerance, self.bounds, rest=rest
            )
        self.sizes = StepSize(self.lengths, tolerance, AT_REST if proving[0] else 0.0)
        self.guards = GuardCode(guards, state, self.lengths, records_at(state, work, 1)) if guards else None
        self._work = work
        self._proof: Proof | None = None
        self._integrands: Proof | None = None
        self._series = self.state.memory + width + LANES
        small = SMALL * max(1.0, tolerance / self.bounds.precision)
        proof = partial(Proof, lengths=self.lengths, low=width, nothing=self.bounds.nothing_much, small=small)
        if proving[0]:
            self._proof = proof(*proving[0])
        if proving[1]:
            self._integrands = proof(*proving[1], integrals=(first, count))

    def functions(self) -> list[str]:
        """See ``Steps``."""
        lengths = self.lengths
        made = [*self.sizes.functions(), self.sizes.shortened_step(), accepted(lengths)]
        made += [self._proof.function()] if self._proof else []
        made += [self._integrands.function()] if self._integrands else []
        if self.quadratures:
            made += [*self.quadratures.functions(), self.divide()]
        guards = self.guards.functions() if self.guards else []
        return [clear_function(), *guards, *(f.text() for f in made)]

    def places(self, f: Function) -> tuple[Pointer, Pointer]:
        """The state, and the series."""
        return f.pointer("%state"), f.pointer("%work")

    def forget(self, f: Function) -> None:
        f.call(None, "clear", f.pointer("%work"), f.count(self._work))

    def straighten(self, f: Function) -> None:
        first = STRAIGHT * self.lengths.term
        f.call(None, "clear", f.place("%work", first), f.count(self._work - first))

    def expand(self, f: Function, now: Now) -> tuple[Now, Bit]:
        return now, f.call(Bit, "jet", f.pointer("%constants"), now.t + now.low, *self.places(f))

    def choose(self, f: Function, now: Now, fail: Callable[[], None]) -> tuple[Now, Real, Bit]:
        usual, met = chosen_step(f, now.previous, self.places(f))
        h, sound = f.variable(usual), met < ENDLESS
        with f.when(~sound):
            h.set(f.call(Real, "shortened_step", *self.places(f), usual))
            with f.when(~(h.get() > 0.0)):
                fail()
        self._sound = sound
        return now, h.get(), sound

    def vet(self, f: Function, now: Now, h: Real, left: Real, free: Bit) -> Real:
        if self._proof is None:
            return h
        beyond = f.select(self._sound, f.count(self.lengths.order - 1), self._cut(f))
        return proven(f, now, h, left, free, self.places(f), beyond.to_real())

    def _cut(self, f: Function) -> Integer:
        """The order of the accelerations from which on there are none, where the series were cut."""
        m, lengths = f.variable(f.count(self.lengths.order)), self.lengths
        with f.when(~self._sound), f.section() as found, f.forever():
            total = f.variable(f.zero(lengths.lanes))
            with lengths.each(f) as row:
                total.set(total.get() + f.magnitude(row.series()[m.get()]))
            with f.when((lengths.gather(f, "fadd", total.get()) > 0.0) | (m.get() < 3)):
                found.leave()
            m.set(m.get() - 1)
        return m.get() - 1

    def first_guard(self, f: Function, now: Now, h: Real) -> tuple[Real, Integer, Real]:
        assert self.guards
        return self.guards.first(f, h, now.unit)

    def sample(self, f: Function, now: Now, index: Integer, h: Real) -> Integer:
        at, lengths = f.variable(index), self.lengths
        t, low, end = (f.splat(x, LANES) for x in (now.t, now.low, h))
        with f.forever() as rounds:
            dt = (f.load_row("%times", at.get(), LANES) - t) - low
            hits = (dt <= end).count()
            with f.when(hits.equals(0)):
                rounds.leave()
            with f.loop(0, lengths.rows, tested=False) as i:
                row = f.place("%work", i)
                c = [f.splat(f.load(row, m * lengths.term), LANES) for m in range(1, lengths.order + 1)]
                rest = f.splat(f.load("%state", i + self.state.part(1).start), LANES)
                value = f.splat(f.load("%state", i), LANES) + (polynomial(f, c, dt) * dt + rest)
                f.store_row(value, "%out", i * Integer(f, "%stride") + at.get())
            at.set(at.get() + hits)
            rounds.repeat(hits.equals(LANES))
        return at.get()

    def move(self, f: Function, now: Now, h: Real, final: Bit, allowed: Allowance) -> Real:
        t, low = two_sum(now.t, now.low + h)
        f.store(t, "%state", self.state.at(Clock.TIME))
        f.store(low, "%state", self.state.at(Clock.TIME_LOW))
        nothing = None
        if self._proof:
            nothing = f.constant(self.bounds.nothing_much) / (h * f.larger(h, f.constant(1.0)))
        return moved(f, self.lengths, h, allowed, self.expected(f), self.state.width, nothing)

    def expected(self, f: Function) -> tuple[Pointer, Pointer]:
        """Where the accelerations are that are expected, and how far off they may be."""
        first = self.state.memory
        return f.place("%trial", first), f.place("%trial", first + self.state.width)

    def agree(self, f: Function, now: Now, uneven: Real, slack: Real, unexplained: Bit, room: Real) -> Bit:
        given = self.places(f)[1], *self.expected(f), uneven, slack, unexplained, room
        return f.call(Bit, "accepted", *given)

    def rough(self, f: Function, now: Now, h: Real) -> Bit:
        given = f.pointer("%trial"), f.pointer("%work"), h
        rough = f.call(Bit, "rough", *given)
        if self._integrands is None:
            return rough
        return rough | ~self.has_proven(f, now.t + now.low, *given)

    def has_proven(self, f: Function, t: Real, state: Pointer, work: Pointer, h: Real) -> Bit:
        """Whether the integrands have nothing to hide within ``h``."""
        given = f.pointer("%constants"), t, state, work, h, f.constant(1.0)
        return f.call(Bit, "integrands_proven", *given, f.constant(float(self.lengths.order - 1)))

    def surprising(self, f: Function, now: Now, h: Real) -> Bit:
        assert self.quadratures
        given = f.pointer("%work"), *self.expected(f), f.pointer("%state"), self.quadratures.nothing(f, h)
        return ~f.call(Bit, "integrals_confirmed", *given)

    def resume(self, f: Function, before: Now) -> None:
        self.forget(f)
        given = f.pointer("%trial"), f.pointer("%work")
        f.call(Bit, "jet", f.pointer("%constants"), before.t + before.low, *given)

    def part(self, f: Function, before: Now, h: Real, samples: tuple[Integer, Integer]) -> None:
        places = (f.pointer(f"%{name}") for name in ("constants", "trial", "work", "state", "times", "out"))
        f.call(None, "divide", *places, before.t, before.low, h, *samples, Integer(f, "%stride"))

    def divide(self) -> Function:
        """``@divide``: the integrals of a step of ``h`` from ``%trial`` on, with the series in ``%work``, by
        parts; also those of the samples from ``first`` to before ``last``."""
        heads = ", ".join(f"ptr %{name}" for name in ("constants", "trial", "work", "state", "times", "out"))
        more = "double %t, double %low, double %h, i64 %first, i64 %last, i64 %stride"
        f = Function(f"define internal void @divide({heads}, {more}) #0")
        assert self.quadratures
        made, t, low = self.quadratures, Real(f, "%t"), Real(f, "%low")
        trial, h, end = f.pointer("%trial"), Real(f, "%h"), Integer(f, "%last")
        series, arrays = (f.place(trial, one) for one in (self._series, self._series + self._work))
        at, yes = Places(trial, f.pointer("%work"), arrays, series), Bit(f, "true")
        index = f.variable(Integer(f, "%first"))

        def expand(place: Time) -> None:
            f.call(None, "clear", series, f.count(self._work))
            f.call(Bit, "jet", f.pointer("%constants"), (t + low) + place[0], arrays, series)

        def write(part: Part, dt: Real, reached: Integer) -> None:
            made.sample(f, at, part, dt, reached)

        def since(instant: Real) -> Real:
            return (instant - t) - low

        sample = sampling(f, index, end, since, lambda dt, part: dt <= part.end[0], write)

        def prove(place: Time, length: Real) -> Bit:
            return self.has_proven(f, (t + low) + place[0], arrays, series, length)

        step, proof = (h, f.constant(0.0)), prove if self._integrands else None
        whole = made.divide(f, at, t, step, yes, expand, sample, proof)
        made.give(f, at, f.pointer("%state"), yes, whole)
        f.give()
        return f


def moved(
    f: Function,
    lengths: Lengths,
    h: Real,
    allowed: Allowance,
    expected: tuple[Pointer, Pointer],
    low: int,
    nothing: Real | None = None,
    moving: Bit | None = None,
) -> Real:
    """Take the state to the end of the step, and write down what is expected there; the place farthest from
    0.

    Low parts are ``low`` rows behind. Errors of the accelerations up to ``nothing`` are allowed whatever
    moves. Only motions that are ``moving`` change.
    """
    degrees, (rates, allowances) = lengths.degrees, expected
    h = lengths.wide(f, h)
    farthest = f.variable(f.zero(lengths.lanes))
    with lengths.each(f) as row:
        c, is_place = row.series().terms(1, lengths.order), row.among(0, degrees)
        change, rest = careful_sum(f, c, h, CHAINS if lengths.together > 1 else 1)
        old, lost = row.at("%state"), row.at("%state", low)
        # the low part of a velocity moves its coordinate
        extra = row.only(is_place, row.at("%state", low + degrees) * h)
        new, error = two_sum(old, change + ((lost + extra) + rest))
        row.put(new if moving is None else f.select(moving, new, old), "%state")
        row.put(error if moving is None else f.select(moving, error, lost), "%state", low)
        lesser = f.smaller(f.magnitude(new), f.magnitude(old))
        farthest.set(f.larger(farthest.get(), row.only(is_place, lesser)))
        with row.if_velocities():
            if lengths.together == 1:  # read again: there are too many of them to be kept
                c = row.series().terms(1, lengths.order)
            speed = rate(f, c[:-1], h, RATE_CHAINS if lengths.together > 1 else 1)
            most = allowed.of(f, lengths, f.magnitude(speed) + f.magnitude(c[0]), lesser)
            row.put(speed, rates)
            row.put(most if nothing is None else most + lengths.wide(f, nothing), allowances)
    return lengths.gather(f, "fmax", farthest.get())
