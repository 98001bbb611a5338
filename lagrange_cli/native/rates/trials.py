"""Trials of steps on rates: how long a step is that a method accepts.

The first step of a motion may be tried several times, each time longer. A step is tried again where its
method says so, and a much shorter one where rates are not finite.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Real
from lagrange_cli.native.rates.nodes import RatesAtNodes
from lagrange_cli.native.rates.noise import RateNoise
from lagrange_cli.native.rates.places import EVALUATIONS, HEAD, LENGTH, NEXT, TRIED
from lagrange_cli.native.rates.stalling import Stalling
from lagrange_cli.native.rates.watching import Watching
from lagrange_cli.native.state import Clock
from lagrange_cli.records import dataclass

BEGINNING, TRIALS = 2.0**-10, 12
"""The first trial, as part of what velocities are over accelerations; and how often it may be made longer."""
FIRST = 2.0**100
"""The longest first trial, in 2^-10: where forces are hardly more than 0, its square would be infinite."""
LONGER, APART = 16.0, 0.125
"""By what factor at most, and by which one where rates are not finite."""
SMALLEST, LARGEST = 2.0**-1000, 2.0**1000


@dataclass(frozen=True)
class Trial:
    """What became of a step: by what ``factor`` it should be longer, whether it must be taken ``again`` with
    that length, and whether all rates were ``sound``: regular and finite."""

    factor: Real
    again: Bit
    sound: Bit


class Trials(RatesAtNodes):
    """Steps of a length that is found by trials."""

    patience = 0
    """How often a step is taken again before rounding errors of rates are measured."""
    most: float
    """How much the next one is longer at most."""
    shorter: float
    """And one that is taken again, shorter."""
    rounding: RateNoise
    stalling: Stalling
    watching: Watching | None

    def begin(self, f: Function, first: Bit, h: Real) -> Real:
        """Prepare for the trials of a step, perhaps the ``first`` one of a motion. The length to begin with,
        where it would be ``h``."""
        return h

    @abstractmethod
    def finish(self, f: Function, h: Real) -> None:
        """Write the coefficients of the polynomials, in time, where ``advance`` reads them."""

    @abstractmethod
    def attempt(self, f: Function, t: Real, low: Real, h: Real, ratio: Real, doubtful: Bit) -> Trial:
        """Try a step of ``h``, ``ratio`` times as long as the one before (0 at first). If ``doubtful``, it is
        not to be shorter because of rounding."""

    def judged(
        self, f: Function, doubtful: Bit, factor: Callable[[], tuple[Real, Bit, Bit]]
    ) -> tuple[Real, Bit]:
        """The ``factor`` by which a step should be longer, and whether its rates are finite. If rounding may
        have made it small, and it is ``doubtful``, what rounding explains is measured first."""
        kept, finite = f.variable(f.constant(0.0)), f.variable(Bit(f, "true"))
        with f.forever() as judging:
            found, sound, rounded = factor()
            kept.set(found)
            finite.set(sound)
            with f.when(~(rounded & sound & doubtful) | self.rounding.known(f)):
                judging.leave()
            self.rounding.measure(f)
        return kept.get(), finite.get()

    def further(self, f: Function) -> Callable[[Real], Bit] | None:
        """What computes the other rates that polynomials need, of a step of some length, and tells whether
        they are finite."""
        return None

    def _tried(self) -> Function:
        """``@tried(constants, state, work, exact)``: the length of the step, with its polynomials in
        ``%work``; 0 where there is none so short that its rates are finite, -1 where the motion is stuck.
        If ``exact`` is not 0, the step has been tried before, and is taken again with this length."""
        f = Function(f"define internal double @tried{HEAD}, double %exact) #0")
        exact = Real(f, "%exact")
        given = exact > 0.0
        layout, at, state = self.state, self._places, f.pointer("%state")
        t, low = (f.load(state, layout.at(one)) for one in (Clock.TIME, Clock.TIME_LOW))
        first = f.load(state, layout.at(Clock.STEP)).equals(0.0)
        gap = f.load(state, layout.at(Clock.GAP))
        asked, last = (f.load(state, layout.carried_at + one) for one in (NEXT, LENGTH))
        h = f.variable(f.select(first, self._first_length(f), asked))
        with f.when(~gap.equals(0.0)):  # what is beyond a critical point must not count
            h.set(f.smaller(h.get(), gap * 0.5))
        trials, refused, one = f.variable(f.count(0)), f.variable(f.count(0)), f.constant(1.0)
        h.set(f.select(given, exact, h.get()))
        with f.when(~given):
            with f.when(self.stalling.stuck(f)):
                f.give(f.constant(-1.0))
            f.store(f.constant(0.0), "%work", at.chosen + EVALUATIONS)
            self.rounding.forget(f)
            h.set(self.begin(f, first, h.get()))
        further = self.further(f)
        with f.forever() as attempts:
            ratio = f.select(first, f.constant(0.0), h.get() / f.select(first, one, last))
            if self.given.static or self.given.cancelling:
                f.store(h.get(), "%work", at.chosen + TRIED)
            trial = self.attempt(f, t, low, h.get(), ratio, refused.get() >= self.patience)
            factor = trial.factor
            with f.when(given):
                f.store(h.get(), "%work", at.chosen + LENGTH)
                with f.when(~(trial.sound if further is None else trial.sound & further(h.get()))):
                    f.give(f.constant(0.0))
                attempts.leave()
            with f.when(~trial.sound):
                h.set(h.get() * APART)
                with f.when(h.get() < SMALLEST):
                    f.give(f.constant(0.0))
                attempts.go_on()
            with f.when(trial.again):
                refused.set(refused.get() + 1)
                h.set(h.get() * f.larger(factor, f.constant(self.shorter)))
                attempts.go_on()
            early = first & (factor > self.most) & (trials.get() < TRIALS) & gap.equals(0.0)
            with f.when(~early):
                if further is not None:
                    with f.when(~further(h.get())):
                        h.set(h.get() * APART)
                        attempts.go_on()
                f.store(h.get(), "%work", at.chosen + LENGTH)
                longer = h.get() * f.smaller(factor, f.constant(self.most))
                f.store(longer, "%work", at.chosen + NEXT)
                attempts.leave()
            h.set(h.get() * f.smaller(factor, f.constant(LONGER)))
            trials.set(trials.get() + 1)
        self.finish(f, h.get())
        if self.watching:
            self.watching.watch(f, h.get())
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
        usual_length = f.smaller(v / f.select(usual, a, f.constant(1.0)), f.constant(FIRST))
        return f.select(usual, usual_length, f.constant(1.0)) * BEGINNING
