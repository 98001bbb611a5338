"""Steps in doubles (see ``advance``): rows of one motion side by side, and compensated summation."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from lagrange_cli.native.interface import Stop
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.numbers.error_free import two_sum
from lagrange_cli.native.state import LANES, Clock
from lagrange_cli.native.stepping.acceptance import DOUBLE, Allowance
from lagrange_cli.native.stepping.divided import DividedSteps
from lagrange_cli.native.stepping.given import Given
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.motion import AT_REST
from lagrange_cli.native.stepping.polynomial import careful_sum, polynomial, rate
from lagrange_cli.native.stepping.proof import proven
from lagrange_cli.native.stepping.step_size import ENDLESS, chosen_step
from lagrange_cli.native.stepping.steps import STRAIGHT, Now
from lagrange_cli.native.stepping.sums import CHAINS, RATE_CHAINS, DoubleSums, HighLow


def accelerate(lengths: Lengths, series: str = "jet") -> str:
    """``@accelerate``: rates of the velocities and integrals at one state, whose low parts are zeros,
    by a function that computes ``series``.

    It returns 0 where the mass matrix is singular.
    """
    given = "ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, ptr noalias %out"
    f = Function(f"define i64 @accelerate({given}) #0")
    constants, state, work = f.pointers("constants", "state", "work")
    regular = f.call(Bit, series, constants, Real(f, "%t"), state, work)
    single = lengths.one_by_one()
    with f.loop(lengths.degrees, lengths.rows, tested=False) as i:
        f.store(f.load(single.place(f, i), lengths.term), "%out", i - lengths.degrees)
    f.give(regular.to_integer())
    return f.text()


class DoubleSteps(DividedSteps):
    """The parts of steps in doubles."""

    refined, parts, small = False, 1, 2.0**-46

    def __init__(self, lengths: Lengths, given: Given) -> None:
        super().__init__(given, lengths, DOUBLE, DoubleSums(), AT_REST if given.proving[0] else 0.0)

    def own(self) -> list[Function]:
        return [self.sizes.shortened_step()]

    def compute(self, f: Function, time: HighLow, unit: Real, state: Pointer, series: Pointer) -> Bit:
        f.call(None, "clear", series, f.count(self.given.work))
        return f.call(Bit, "jet", f.pointer("%constants"), time[0] + time[1], state, series)

    def forget(self, f: Function) -> None:
        f.call(None, "clear", f.pointer("%work"), f.count(self.given.work))

    def straighten(self, f: Function) -> None:
        first = STRAIGHT * self.lengths.term
        f.call(None, "clear", f.place("%work", first), f.count(self.given.work - first))

    def expand(self, f: Function, now: Now, brief: Callable[[], Bit] | None = None) -> tuple[Now, Bit]:
        self.measure(f, now)
        return now, f.call(Bit, "jet", f.pointer("%constants"), now.t + now.low, *self.places(f))

    def choose(self, f: Function, now: Now, fail: Callable[[Stop], None]) -> tuple[Now, Real, Bit]:
        usual, met = chosen_step(f, now.previous, self.places(f))
        h, sound = f.variable(usual), met < ENDLESS
        with f.when(~sound):
            h.set(f.call(Real, "shortened_step", *self.places(f), usual))
            with f.when(~(h.get() > 0.0)):
                fail(Stop.NOT_FINITE)
        self._sound = sound
        return now, h.get(), sound

    def vet(self, f: Function, now: Now, h: Real, left: Real, free: Bit) -> Real:
        if not self.proofs:
            return h
        beyond = f.select(self._sound, f.count(self.lengths.order - 1), self._cut(f))
        return proven(f, self.proofs, now, h, left, free, self.places(f), beyond.to_real())

    def _cut(self, f: Function) -> Integer:
        """The order of the accelerations from which on there are none, where the series were cut."""
        m, lengths = f.variable(f.count(self.lengths.order)), self.lengths
        with f.when(~self._sound), f.section() as found, f.forever():
            total = f.variable(f.zero(lengths.lanes))
            with lengths.stored(f) as row:
                total.set(total.get() + f.magnitude(row.series()[m.get()]))
            with f.when((lengths.gather(f, "fadd", total.get()) > 0.0) | (m.get() < 3)):
                found.leave()
            m.set(m.get() - 1)
        return m.get() if lengths.followers else m.get() - 1

    def first_guard(self, f: Function, now: Now, h: Real) -> tuple[Real, Integer, Real]:
        assert self.guards
        return self.guards.first(f, h, now.unit)

    def sample(self, f: Function, now: Now, index: Integer, h: Real) -> Integer:
        at = f.variable(index)
        t, low, end = (f.splat(x, LANES) for x in (now.t, now.low, h))
        with f.forever() as rounds:
            dt = (f.load_row("%times", at.get(), LANES) - t) - low
            hits = (dt <= end).count()
            with f.when(hits.equals(0)):
                rounds.leave()

            def take(i: Integer, series: Iterable[Real]) -> None:
                c = [f.splat(one, LANES) for one in series]
                rest = f.splat(f.load("%state", i + self.state.part(1).start), LANES)
                value = f.splat(f.load("%state", i), LANES) + (polynomial(f, c, dt) * dt + rest)
                f.store_row(value, "%out", i * Integer(f, "%stride") + at.get())

            self.take_series(f, take)
            at.set(at.get() + hits)
            rounds.repeat(hits.equals(LANES))
        return at.get()

    def take_series(self, f: Function, take: Callable[[Integer, Iterable[Real]], None]) -> None:
        """``take`` the coefficients of each row, from the first on."""
        lengths = self.lengths.one_by_one()
        with f.loop(0, lengths.rows, tested=False) as i:
            row = lengths.place(f, i)
            take(i, (f.load(row, m * lengths.term) for m in range(1, lengths.order + 1)))

    def pass_time(self, f: Function, now: Now, h: Real) -> None:
        """The time at the end of the step."""
        t, low = two_sum(now.t, now.low + h)
        f.store(t, "%state", self.state.at(Clock.TIME))
        f.store(low, "%state", self.state.at(Clock.TIME_LOW))

    def move(self, f: Function, now: Now, h: Real, final: Bit, allowed: Allowance) -> Real:
        self.pass_time(f, now, h)
        if self.noise:
            self.noise.count(f)
        nothing = self.bounds.nothing(f, h) if self.proof else None
        return moved(
            f, self.lengths, h, allowed, self.expected(f)[:2], self.state.width, nothing, noise=self.noise_at
        )


def moved(
    f: Function,
    lengths: Lengths,
    h: Real,
    allowed: Allowance,
    expected: tuple[Pointer, Pointer],
    low: int,
    nothing: Real | None = None,
    moving: Bit | None = None,
    noise: int = 0,
) -> Real:
    """Take the state to the end of the step, and write down what is expected there; the place farthest from
    0.

    Low parts are ``low`` rows behind. Errors of the accelerations up to ``nothing`` are allowed whatever
    moves, and what is ``noise`` rows behind velocities. Only motions that are ``moving`` change.
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
            most = allowed.of(f, lengths, f.magnitude(speed) + f.magnitude(c[0]), row.floored(lesser))
            if noise:
                most = most + row.at("%state", noise)
            row.put(speed, rates)
            row.put(most if nothing is None else most + lengths.wide(f, nothing), allowances)
    return lengths.gather(f, "fmax", farthest.get())
