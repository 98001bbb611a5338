"""``Progress``: where ``@advance`` is, in the code that is written for it: the step before, which is to be
confirmed, the samples that are taken, and what leads out of it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from lagrange_cli.native.guards import DUE, RECORDED
from lagrange_cli.native.interface import Stop
from lagrange_cli.native.llvm.flow import Loop
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer, Real
from lagrange_cli.native.state import BEGINNING, Clock
from lagrange_cli.native.stepping.divided import DividedSteps
from lagrange_cli.native.stepping.guard_search import NO_GUARD
from lagrange_cli.native.stepping.guards import AWAY, NOTED
from lagrange_cli.native.stepping.steps import Now

NOTHING, BLIND, MOVED = -3, -2, -1
"""What a step's series must confirm about the step before: nothing; only that it passed a kink; everything
(and for the last step, what ``Stop`` says)."""

HEAD = (
    "define i64 @advance(ptr noalias %constants, ptr noalias %state, ptr noalias %work, ptr noalias %trial, "
    "double %stop, ptr noalias %times, i64 %count, ptr noalias %out, i64 %stride, i64 %last, i64 %pause, "
    "ptr noalias %info) #0"
)


class Progress:
    """The arguments of ``@advance``, and what changes from step to step.

    The step before has the ``length``, and began at the sample ``began``; ``pending`` is what is to be
    confirmed of it, within ``uneven``. The state where it began is in ``trial``.
    """

    def __init__(self, steps: DividedSteps) -> None:
        self.steps, self.f = steps, Function(HEAD)
        f = self.f
        self.state, self.trial, self.info = f.pointers("state", "trial", "info")
        self.stop, self.count, self.pause = Real(f, "%stop"), Integer(f, "%count"), Integer(f, "%pause")
        self.zero, self.one = f.constant(0.0), f.constant(1.0)
        yes, no = Bit(f, "true"), Bit(f, "false")
        self.yes, self.no = yes, no
        self.limited, self.limited_before, self.began = (f.variable(f.count(0)) for _ in range(3))
        self.length, self.uneven, self.usual_before = (f.variable(self.zero) for _ in range(3))
        self.index, self.taken = f.variable(f.count(0)), f.variable(f.count(0))
        self.pending, self.tries = f.variable(f.count(NOTHING)), f.variable(f.count(0))
        self.settled, self.unit_before = f.variable(yes), f.variable(self.one)
        """Whether the integrals of the step before are right already; the unit of time of its series."""
        self.due = f.variable(f.count(NO_GUARD)) if steps.guards else None
        self.listed = steps.given.near is not None and steps.given.near.listed
        """Whether guards that are near are listed (``NearPlaces``)."""
        self.stops = f.variable(no)
        """Whether the step before ends where a vector is 0 that friction acts along."""
        self.whole = f.variable(no)
        """Whether the next step to a root is not divided."""
        self._results = tuple(f.variable(f.count(0)) for _ in range(3))
        self._rounds: Loop | None = None

    # ------------------------------------------------------------------ the state

    def clock(self, number: Clock) -> Real:
        """What the state remembers."""
        return self.f.load(self.state, self.steps.state.at(number))

    def clock_before(self, number: Clock) -> Real:
        """What it remembered where the step before began."""
        return self.f.load(self.trial, self.steps.state.at(number))

    def remember(self, number: Clock, value: Real) -> None:
        """Set a number of the clock."""
        self.f.store(value, self.state, self.steps.state.at(number))

    def copy(self, origin: Pointer, to: Pointer) -> None:
        """Copy a whole state."""
        self.f.call(None, "copy", origin, to)

    def no_guard(self) -> None:
        """No guard is due."""
        if self.due is not None:
            self.due.set(self.f.count(NO_GUARD))

    # ------------------------------------------------------------------ the ways out

    def leave(self, code: Index, steps: Integer | None = None, samples: Integer | None = None) -> None:
        """Return ``code`` after so many ``steps`` and ``samples``, by default all that were taken."""
        assert self._rounds
        code = code if isinstance(code, Integer) else self.f.count(code)
        for one, value in zip(self._results, (samples or self.index.get(), steps or self.taken.get(), code)):
            one.set(value)
        self._rounds.leave()

    @contextmanager
    def rounds(self) -> Iterator[Loop]:
        """Round after round, until one of them leads out; then what is returned. Its code is written once."""
        f = self.f
        with f.forever() as self._rounds:
            yield self._rounds
        samples, steps, code = (one.get() for one in self._results)
        for i, value in enumerate((samples, steps, self.limited.get())):
            f.store(value, self.info, i)
        if self.due is not None:
            f.store(self.due.get(), self.info, DUE)
        f.give(code)

    def leave_divided(self, steps_before: Integer) -> None:
        """If a stop was requested while a step was divided, stop before this step, which will be repeated."""
        with self.f.when(self.steps.halted(self.f)):
            self.copy(self.trial, self.state)
            self.limited.set(self.limited_before.get())
            self.no_guard()
            self.leave(Stop.PAUSE, steps_before, self.began.get())

    def leaving_at_once(self) -> Bit:
        """Whether the step before is the last one of this call, if it is accepted."""
        last = self.pending.get().equals(Stop.END) | self.pending.get().equals(Stop.SAMPLES)
        return last | (self.taken.get() >= self.pause)

    def pauses(self) -> Bit:
        """Whether the caller is to have a look: after so many steps, or where no further action of an event
        can be recorded."""
        guards, paused = self.steps.guards, self.taken.get() >= self.pause
        if guards is None or not guards.actions.any:
            return paused
        most = guards.rows.records(guards.layout)
        return paused | (self.f.load_integer(self.info, RECORDED) + 1 >= most)

    def count_pass(self) -> Real:
        """Count that a guard has become 0; how often that was before while t hardly changed."""
        f = self.f
        passed, last = f.magnitude(self.clock(Clock.TIME)), self.clock(Clock.LAST_PASS)
        times = self.clock(Clock.PASSES)
        at_once = self.clock(Clock.TIME) - last <= passed * self.steps.bounds.no_time
        self.remember(Clock.PASSES, f.select(at_once, times + 1.0, self.zero))
        self.remember(Clock.LAST_PASS, self.clock(Clock.TIME))
        return times

    def change_mode(self, now: Now, since: Real) -> Bit:
        """Go on from here with the other mode of the guard that is due; whether the equations are the same.
        The caller decides what is not simple. The polynomials of steps began so long ``since``."""
        f, steps, due = self.f, self.steps, self.due
        assert due is not None
        assert steps.guards
        steps.arrive(f, now, since)
        times = self.count_pass()
        with f.when(times >= steps.guards.rows.changes):
            self.leave(Stop.GUARD)
        given = self.state, f.pointer("%constants"), due.get(), self.trial, self.info, f.pointer("%work")
        done = f.call(Integer, "flip", *given, self.index.get())
        with f.when(done.equals(AWAY)):
            self.leave(Stop.GUARD)
        with f.when(~done.equals(NOTED)):
            for number in BEGINNING:
                self.remember(number, self.zero)
        self.no_guard()
        self.pending.set(f.count(NOTHING))
        self.whole.set(self.no)
        return done.equals(NOTED)
