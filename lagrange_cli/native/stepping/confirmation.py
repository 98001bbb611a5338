"""The step before is confirmed by the series at its end (``acceptance``), or taken back."""

from __future__ import annotations

from lagrange_cli.native.interface import Stop
from lagrange_cli.native.llvm.flow import Loop
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.state import Clock
from lagrange_cli.native.stepping.guard_search import NO_GUARD
from lagrange_cli.native.stepping.progress import BLIND, NOTHING, Progress
from lagrange_cli.native.stepping.steps import Now
from lagrange_cli.records import dataclass

EVIDENCE, NOISY = 2.0, 2.0**16
"""After this many steps whose prediction failed narrowly, rounding is the cause: the bound is raised by this
factor."""
HUGE = 1.7976931348623157e308


@dataclass(frozen=True)
class Refused:
    """A step that is not confirmed by the series ``now`` at its end, where the equations are ``regular``, or
    not. It should only pass a kink if it is ``blind``; ``less`` steps were taken before it. Of differences,
    ``floor`` is nothing; there were so many narrow ``failures``, and an ``unexplained`` one."""

    now: Now
    regular: Bit
    blind: Bit
    less: Integer
    floor: Real
    failures: Real
    unexplained: Real


def confirm(at: Progress, now: Now, regular: Bit, rounds: Loop) -> None:
    """Confirm the step before, or take it back; leave if it was the last one; change the mode that is due.

    The series ``now`` are those at its end, where the equations are ``regular``, or not.
    """
    f, steps = at.f, at.steps
    floor = steps.bounds.nothing_much / (at.length.get() * at.length.get())
    failures, unexplained = at.clock(Clock.NARROW_FAILURES), at.clock(Clock.UNEXPLAINED)
    lenient = failures >= EVIDENCE
    if steps.constrained:  # what the state was moved by near a singular configuration counts there
        before = at.clock_before(Clock.PROJECTIONS)
        lenient = lenient | (at.clock(Clock.PROJECTIONS) > before)
    slack = f.select(lenient, NOISY, at.one)
    good = steps.agree(f, now, at.uneven.get(), slack, unexplained > 0.0, floor) & regular
    if at.due is not None and steps.guards and steps.guards.switches:
        good = good_beyond(at, now, good, (slack, unexplained > 0.0, floor))
    if steps.guards and steps.guards.stopping:
        good = good | at.stops.get()
    if steps.remeasures:
        good = good_but_for_rounding(at, now, good, (slack, unexplained > 0.0, floor))
    blind, less = at.pending.get().equals(BLIND), at.taken.get() - 1
    with f.when(~good):
        take_back(at, Refused(now, regular, blind, less, floor, failures, unexplained))
        rounds.go_on()
    if steps.quadratures:
        with f.when(~at.settled.get()), f.when(steps.surprising(f, now, at.length.get())):
            start = at.clock_before(Clock.TIME), at.clock_before(Clock.TIME_LOW)
            before_it = Now(*start, at.zero, at.unit_before.get())
            steps.resume(f, before_it)
            steps.part(f, before_it, at.length.get(), (at.began.get(), at.index.get()))
            at.leave_divided(less)
            steps.forget(f)
            steps.expand(f, Now(now.t, now.low, at.clock(Clock.STEP), at.one))
    for number in (Clock.REFUSED, Clock.REFUSED_BEYOND, Clock.UNEXPLAINED):
        at.remember(number, at.zero)
    at.tries.set(f.count(0))
    with f.when(at.pending.get().equals(Stop.END)):
        at.leave(Stop.END)
    # The step contains more samples than there is room for. It is completed after they are written, from the
    # unchanged state.
    with f.when(at.pending.get().equals(Stop.SAMPLES)):
        at.copy(at.trial, at.state)
        at.limited.set(at.limited_before.get())
        at.leave(Stop.SAMPLES, less)
    if at.due is not None:
        with f.when(~at.due.get().equals(NO_GUARD)), f.when(~at.change_mode(now, at.length.get())):
            steps.forget(f)
            rounds.go_on()


def good_beyond(at: Progress, now: Now, good: Bit, allowed: tuple[Real, Bit, Real]) -> Bit:
    """The same, if a step to where a switch changes is not ``good``: whether the accelerations beyond it are
    those expected. A force such as u^1.5 has no series where u is 0, and no value where rounding has let u be
    below."""
    f, steps, due = at.f, at.steps, at.due
    assert due is not None
    assert steps.guards
    found, uneven = f.variable(good), at.uneven.get()
    with f.when(~good & ~due.get().equals(NO_GUARD)), f.when(steps.guards.is_switch(f, due.get())):
        again = Now(now.t, now.low, at.clock(Clock.STEP), at.one)
        steps.guards.turn(f, due.get())
        steps.forget(f)
        beyond, regular = steps.expand(f, again)
        found.set(steps.agree(f, beyond, uneven, *allowed) & regular)
        steps.guards.turn(f, due.get())
        with f.when(~found.get()):
            steps.forget(f)
            steps.expand(f, again)
    return found.get()


def good_but_for_rounding(at: Progress, now: Now, good: Bit, allowed: tuple[Real, Bit, Real]) -> Bit:
    """The same once it is known how much of the accelerations is rounding, if a step is not ``good`` that
    approached no critical point: halving the distance to what is none takes as many steps as to a kink."""
    f, steps = at.f, at.steps
    found = f.variable(good)
    with f.when(~good & at.clock_before(Clock.GAP).equals(0.0)):
        regular = steps.remeasure(f, Now(now.t, now.low, at.clock(Clock.STEP), at.one))
        found.set(steps.agree(f, now, at.uneven.get(), *allowed) & regular)
    return found.get()


def take_back(at: Progress, step: Refused) -> None:
    """There is a critical point within the step that the series does not show: go back and take at most half
    the step; or, if the equations were singular just beyond the point, go twice as far beyond it. If small
    differences recur, they are due to rounding, and the allowance is raised."""
    f, steps = at.f, at.steps
    less, regular, before = step.less, step.regular, at.usual_before.get()
    with f.when((at.length.get() > before * steps.bounds.widest) & step.blind):
        # The critical point cannot be passed. The run ends at the last state where the equations hold, or at
        # the first one where they are not finite.
        finite = steps.agree(f, step.now, at.uneven.get(), at.one, at.yes, f.constant(HUGE))
        with f.when(regular & ~finite):
            at.leave(Stop.NOT_FINITE, less, at.began.get())
        at.copy(at.trial, at.state)
        code = f.select(regular, f.count(Stop.UNDERFLOW), f.count(Stop.SINGULAR))
        at.leave(code, less, at.began.get())
    narrow = steps.agree(f, step.now, at.uneven.get(), f.constant(NOISY), at.no, step.floor) & regular
    at.copy(at.trial, at.state)
    if at.due is not None:  # a step that is stopped by a guard comes no nearer
        stopped = ~at.due.get().equals(NO_GUARD) & ~step.blind & (at.clock(Clock.GAP) > 0.0)
        with f.when(stopped & ~(at.length.get() < at.clock(Clock.GAP))):
            at.no_guard()
            at.leave(Stop.UNDERFLOW, less, at.began.get())
    steps.forget(f)
    begins, apart = at.clock(Clock.GAP).equals(0.0), at.clock(Clock.LEAVING).equals(0.0)
    counts = narrow & begins & (at.length.get() > before * 0.25) & apart
    at.remember(Clock.NARROW_FAILURES, step.failures + counts.to_real())
    at.remember(Clock.GAP, f.select(step.blind, at.length.get() * 2.0, at.length.get()))
    at.remember(Clock.REFUSED, f.select(begins, at.one, at.clock(Clock.REFUSED)))
    at.remember(Clock.REFUSED_BEYOND, step.blind.to_real())
    at.remember(Clock.UNEXPLAINED, step.unexplained)
    at.remember(Clock.USUAL_STEP, f.select(begins, before, at.clock(Clock.USUAL_STEP)))
    at.index.set(at.began.get())
    at.taken.set(less)
    at.tries.set(at.tries.get() + 1)
    at.pending.set(f.count(NOTHING))
    at.no_guard()
