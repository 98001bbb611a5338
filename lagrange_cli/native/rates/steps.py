"""Steps that are taken on rates at several states, instead of series at one: what their methods share.

A method proposes polynomials for a step of some length, and says by what factor the length should have been
another one. ``advance`` is given the same as by other steps: coefficients of polynomials in time. So a step
can be sampled, ended anywhere, and left again. All that one step hands over to the next is in the state's
memory, behind all else (``StateLayout.carried``).
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from functools import partial

from lagrange_cli.native.interface import Stop
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Real
from lagrange_cli.native.rates.noise import RateNoise
from lagrange_cli.native.rates.places import EVALUATIONS, HEADER, LENGTH, LONGEST, NEXT, RISES, TRIED, Places
from lagrange_cli.native.rates.stalling import Stalling
from lagrange_cli.native.rates.trials import Trials
from lagrange_cli.native.rates.watching import Watching, watched_rows
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.acceptance import Allowance
from lagrange_cli.native.stepping.given import Given
from lagrange_cli.native.stepping.lengths import side_by_side
from lagrange_cli.native.stepping.steps import Now, clear_function
from lagrange_cli.records import replace

STRAIGHT = 3
SUDDEN = 0.5
"""A step that is shorter than the one asked for by more than this factor does not lead to a singularity, in
front of which steps become shorter little by little, but to where a force jumps."""


class RateSteps(Trials):
    """What these steps are made of."""

    implicit = False
    """Whether it needs ``Given.coupling``."""
    approaches = False
    """Whether it takes short steps near poles (``Given.approach``)."""
    beside = False
    """Whether velocities are measured beside the largest one (``Lengths.floor``)."""
    compares = False
    """Whether rates at the end of a step are compared with those that its polynomials have there."""

    def __init__(self, given: Given) -> None:
        layout, order, places = given.state, self.order, self.places_of(given)
        lengths = side_by_side(layout.degrees, layout.rows, order, places.floor)
        if not (given.floors or (self.beside and layout.degrees > 1)):
            lengths = replace(lengths, floor=0)
        super().__init__(given, lengths, places)
        self.noise = None
        at = places.begin, places.spare, places.modes, places.state, places.chosen + TRIED
        self.rounding = RateNoise(self, *at)
        self.stalling = Stalling(layout.carried_at, given.tolerance)
        self.watching = None
        if self.guards:
            assert given.guards
            longest = layout.carried_at + LONGEST
            kept = replace(self.guards, longest=longest, rises=places.chosen + RISES)
            self.guards = replace(kept, interpolated=True, tolerance=given.tolerance)
            self.watching = Watching(self, places, watched_rows(given.guards), order - 2)

    def functions(self) -> list[str]:
        made = [*self.acceptance(), *self.helpers(), *self.rounding.functions(), self._tried(), self._carry()]
        texts = [clear_function(), *self.given.texts]
        if self.guards and self.watching:
            texts += self.guards.functions()
            texts += self.watching.tables()
            made += self.watching.functions()
            made += self.passing()
        return [*texts, *(f.text() for f in made)]

    @classmethod
    def places_of(cls, given: Given) -> Places:
        """Where things are in ``%work``, with what guards take."""
        count = len(watched_rows(given.guards)) if given.guards else 0
        return replace(cls.room(given), watched=count * (cls.order - 1))

    # what a method says

    @staticmethod
    @abstractmethod
    def room(given: Given) -> Places:
        """Where things are in ``%work``."""

    @staticmethod
    def carried(layout: StateLayout) -> int:
        """Doubles that a step hands over to the next."""
        return HEADER

    def helpers(self) -> list[Function]:
        """Functions of its own."""
        return []

    def write_terms(
        self, f: Function, place: Callable[[int, Integer], Real], rate: Callable[[int, Integer], Real]
    ) -> None:
        """Write them: from the second one on those of coordinates, ``place(m, i)``, and those of velocities
        and integrals, ``rate(m, i)``."""
        self.write_velocities(f)
        for m in range(1, self.order + 1):
            if m > 1:
                self.write_term(f, m, 0, partial(place, m))
            self.write_term(f, m, self.lengths.degrees, partial(rate, m))

    def write_velocities(self, f: Function) -> None:
        """The first coefficients of coordinates."""
        degrees, lanes = self.lengths.degrees, self.lengths.lanes
        self.write_term(f, 1, 0, lambda i: f.load_row("%state", i + degrees, lanes))

    def write_term(self, f: Function, m: Index, first: int, value: Callable[[Integer], Real]) -> None:
        """Write the ``m``-th coefficients of coordinates (``first`` is 0), or of velocities and integrals: in
        this order, as those of coordinates are written beyond the last one, too, and those of velocities
        where the next coefficients of coordinates begin."""
        with self._each(f, self._count if first else self.lengths.degrees) as i:
            f.store_row(value(i), "%work", i + first + m * self.lengths.width)

    def hand_over(self, f: Function, h: Real, length: Real) -> None:
        """Leave for the next step what it needs, after ``length`` of a step of ``h``."""

    # what ``advance`` asks for

    def expand(self, f: Function, now: Now, brief: Callable[[], Bit] | None = None) -> tuple[Now, Bit]:
        """The rates; the polynomials follow with the length of the step."""
        state, work, at = f.pointer("%state"), f.pointer("%work"), self._places
        self.floors(f)
        rates, regular = self._evaluate(f, now.t + now.low, state, work)
        f.copy_rows((rates, 0), (work, at.begin), self._count, self.lengths.lanes)
        first = self.lengths.width + self.lengths.degrees  # what is behind the last one is overwritten below
        f.copy_rows((work, at.begin), (work, first), self._count, self.lengths.lanes)
        return now, regular

    def choose(self, f: Function, now: Now, fail: Callable[[Stop], None]) -> tuple[Now, Real, Bit]:
        if self.guards and self.guards.steep:
            with f.when(self.guards.at_root(f)):
                fail(Stop.ROOT)
        h = self.retried(f, f.constant(0.0))
        with f.when(h < 0.0):
            fail(Stop.STUCK)
        with f.when(~(h > 0.0)):
            fail(Stop.NOT_FINITE)
        return now, h, Bit(f, "true")

    def vet(self, f: Function, now: Now, h: Real, left: Real, free: Bit) -> Real:
        """Where there are guards, the last step is taken again with its own length. Ends of steps are more
        precise than what is within: where forces cancel, what happens there is told by its last digits."""
        if not self.watching:
            return super().vet(f, now, h, left, free)
        length = f.variable(h)
        with f.when(h > left), f.when(self.retried(f, left) > 0.0):
            length.set(left)
        return length.get()

    def sudden(self, f: Function, h: Real) -> Bit | None:
        if not self.compares:
            return None
        return h < f.load("%state", self.state.carried_at + NEXT) * SUDDEN

    def first_guard(self, f: Function, now: Now, h: Real) -> tuple[Real, Integer, Real]:
        assert self.watching
        return self.watching.first(f, h)

    def agree(self, f: Function, now: Now, uneven: Real, slack: Real, unexplained: Bit, floor: Real) -> Bit:
        """Whether the rates at the end of a step are those expected, or if its error has been estimated in
        units of what is allowed, whether they are finite."""
        if self.compares:
            return super().agree(f, now, uneven, slack, unexplained, floor)
        total = f.variable(f.zero(self.lengths.lanes))
        with self._each(f, self._count) as i:
            rate = f.magnitude(f.load_row("%work", i + self._places.begin, self.lengths.lanes))
            inside = self._among(f, i, self._count)
            total.set(total.get() + f.select(inside, rate, f.zero(self.lengths.lanes)))
        return f.reduce("fadd", total.get(), f.constant(0.0)) < math.inf

    @property
    def remeasures(self) -> bool:
        return self.compares

    def remeasure(self, f: Function, now: Now) -> Bit:
        self.rounding.measure(f)
        allowed = self.expected(f)[1]
        with self.lengths.velocities(f) as row:
            row.put(row.at(allowed) + row.at("%state", self.rounding.place), allowed)
        return Bit(f, "true")

    def straighten(self, f: Function) -> None:
        first, last = STRAIGHT * self.lengths.term, self._places.own
        with f.loop(first, last, self.lengths.lanes, tested=False) as i:
            f.store_row(f.zero(self.lengths.lanes), "%work", i)

    def move(self, f: Function, now: Now, h: Real, final: Bit, allowed: Allowance) -> Real:
        farthest = super().move(f, now, h, final, allowed)
        f.call(None, "carry", f.pointer("%state"), f.pointer("%work"), h)
        return farthest

    @property
    def noise_at(self) -> int:
        return self.rounding.place

    def arrive(self, f: Function, now: Now, since: Real) -> None:
        if self.watching:
            self.watching.shift(f, since)

    def _carry(self) -> Function:
        """``@carry(state, work, length)``: what the next step is given, after so long a step."""
        f = Function("define internal void @carry(ptr noalias %state, ptr noalias %work, double %length) #0")
        layout, at = self.state, self._places
        length = Real(f, "%length")
        h, following = (f.load("%work", at.chosen + one) for one in (LENGTH, NEXT))
        f.store(following, "%state", layout.carried_at + NEXT)
        f.store(length, "%state", layout.carried_at + LENGTH)
        counted = layout.carried_at + EVALUATIONS
        f.store(f.load("%state", counted) + f.load("%work", at.chosen + EVALUATIONS), "%state", counted)
        self.stalling.count(f, length, self._fastest(f) * length)
        self.hand_over(f, h, length)
        f.give()
        return f
