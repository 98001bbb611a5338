"""``@advance``: steps until the sample times are used up, the end is reached, or something stops it.

Every step must be accepted by the next one's series (``acceptance``); until then its samples may be
discarded. If it is not, a critical point lies within the step, such as a kink of the potential. This is
approached by halving the distance, and passed if the accelerations stay finite. The error is their change
times the resolution of time.

It is the same for all kinds of numbers. What differs are the ``Steps`` of a kind.
"""

from __future__ import annotations

from lagrange_cli.native.guards import DUE
from lagrange_cli.native.interface import Stop
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer, Real
from lagrange_cli.native.state import BEGINNING, Clock
from lagrange_cli.native.stepping.acceptance import Allowance, allowance
from lagrange_cli.native.stepping.guard_search import NO_GUARD
from lagrange_cli.native.stepping.guards import AWAY, MARGIN, NEAR, NOTED, PART
from lagrange_cli.native.stepping.motion import Steps
from lagrange_cli.native.stepping.steps import Now, copy_function

EVIDENCE, NOISY = 2.0, 2.0**16
"""After this many steps whose prediction failed narrowly, rounding is the cause: the bound is raised by this
factor."""
NOTHING, BLIND, MOVED = -3, -2, -1
"""What a step's series must confirm about the step before: nothing; only that it passed a kink; everything
(and for the last step, what ``Stop`` says)."""
LAG = 0.7
"""The factor by which the usual step may shrink per step, as steps do in front of a singularity."""
PASSES = 8.0
"""If so many kinks are passed while t hardly changes, the motion sticks at one."""
TRIES = 1000
"""Lengths that are tried for a step, far more than halving takes to the resolution of time: there is none."""
SMALLEST, HUGE = 2.0**-1022, 1.7976931348623157e308

HEAD = (
    "define i64 @advance(ptr noalias %constants, ptr noalias %state, ptr noalias %work, ptr noalias %trial, "
    "double %stop, ptr noalias %times, i64 %count, ptr noalias %out, i64 %stride, i64 %last, i64 %pause, "
    "ptr noalias %info) #0"
)


def advance(steps: Steps) -> str:
    """The text of ``@advance`` and all that it calls."""
    f, layout, bounds = Function(HEAD), steps.state, steps.bounds
    state, trial, info = f.pointers("state", "trial", "info")
    stop, count, pause = Real(f, "%stop"), Integer(f, "%count"), Integer(f, "%pause")
    zero, one, yes, no = f.constant(0.0), f.constant(1.0), Bit(f, "true"), Bit(f, "false")

    def clock(number: Clock) -> Real:
        return f.load(state, layout.at(number))

    def remember(number: Clock, value: Real) -> None:
        f.store(value, state, layout.at(number))

    def copy(origin: Pointer, to: Pointer) -> None:
        f.call(None, "copy", origin, to)

    limited, limited_before, began = (f.variable(f.count(0)) for _ in range(3))
    length, uneven, usual_before = (f.variable(zero) for _ in range(3))
    index, taken, pending = f.variable(f.count(0)), f.variable(f.count(0)), f.variable(f.count(NOTHING))
    tries = f.variable(f.count(0))
    settled, unit_before = f.variable(yes), f.variable(one)
    """Whether the integrals of the step before are right already; the unit of time of its series."""

    due = f.variable(f.count(NO_GUARD)) if steps.guards else None
    whole = f.variable(no)
    """Whether the next step to a root is not divided."""

    def leave(code: Index, steps: Integer, samples: Integer | None = None) -> None:
        for i, value in enumerate((samples or index.get(), steps, limited.get())):
            f.store(value, info, i)
        if due is not None:
            f.store(due.get(), info, DUE)
        f.give(code if isinstance(code, Integer) else f.count(code))

    def leave_divided(steps_before: Integer) -> None:
        """If a stop was requested while a step was divided, stop before this step, which will be repeated."""
        with f.when(steps.halted(f)):
            copy(trial, state)
            limited.set(limited_before.get())
            if due is not None:
                due.set(f.count(NO_GUARD))
            leave(Stop.PAUSE, steps_before, began.get())

    def change_mode(now: Now) -> Bit:
        """Go on from here with the other mode of the guard that is due; whether the equations are the same.
        The caller decides what is not simple."""
        assert due is not None
        steps.watch(f, now, zero)
        passed, last, times = f.magnitude(clock(Clock.TIME)), clock(Clock.LAST_PASS), clock(Clock.PASSES)
        at_once = clock(Clock.TIME) - last <= passed * bounds.no_time
        remember(Clock.PASSES, f.select(at_once, times + 1.0, zero))
        remember(Clock.LAST_PASS, clock(Clock.TIME))
        assert steps.guards
        with f.when(times >= steps.guards.rows.changes):
            leave(Stop.GUARD, taken.get())
        given = state, f.pointer("%constants"), due.get(), trial, info, f.pointer("%work"), index.get()
        done = f.call(Integer, "flip", *given)
        with f.when(done.equals(AWAY)):
            leave(Stop.GUARD, taken.get())
        with f.when(~done.equals(NOTED)):
            for number in BEGINNING:
                remember(number, zero)
        due.set(f.count(NO_GUARD))
        pending.set(f.count(NOTHING))
        whole.set(no)
        return done.equals(NOTED)

    def leaving_at_once() -> Bit:
        """Whether the step before is the last one of this call, if it is accepted."""
        last = pending.get().equals(Stop.END) | pending.get().equals(Stop.SAMPLES)
        return last | (taken.get() >= pause)

    steps.forget(f)
    with f.forever() as rounds:
        t, low = clock(Clock.TIME), clock(Clock.TIME_LOW)
        now, regular = steps.expand(f, Now(t, low, clock(Clock.STEP), one), leaving_at_once)
        with f.when(~pending.get().equals(NOTHING)):
            floor = bounds.nothing_much / (length.get() * length.get())
            failures, unexplained = clock(Clock.NARROW_FAILURES), clock(Clock.UNEXPLAINED)
            lenient = failures >= EVIDENCE
            if steps.constrained:  # what the state was moved by near a singular configuration counts there
                before = f.load(trial, layout.at(Clock.PROJECTIONS))
                lenient = lenient | (clock(Clock.PROJECTIONS) > before)
            slack = f.select(lenient, NOISY, one)
            good = steps.agree(f, now, uneven.get(), slack, unexplained > 0.0, floor) & regular
            blind, less = pending.get().equals(BLIND), taken.get() - 1
            # There is a critical point within the step that the series does not show. Go back and take at
            # most half the step; or, if the equations were singular just beyond the point, go twice as far
            # beyond it. (If small differences recur, they are due to rounding, and the allowance is raised.)
            with f.when(~good):
                before = usual_before.get()
                with f.when((length.get() > before * bounds.widest) & blind):
                    # The critical point cannot be passed. The run ends at the last state where the equations
                    # hold, or at the first one where they are not finite.
                    finite = steps.agree(f, now, uneven.get(), one, yes, f.constant(HUGE))
                    with f.when(regular & ~finite):
                        leave(Stop.NOT_FINITE, less, began.get())
                    copy(trial, state)
                    code = f.select(regular, f.count(Stop.UNDERFLOW), f.count(Stop.SINGULAR))
                    leave(code, less, began.get())
                narrow = steps.agree(f, now, uneven.get(), f.constant(NOISY), no, floor) & regular
                copy(trial, state)
                steps.forget(f)
                begins, apart = clock(Clock.GAP).equals(0.0), clock(Clock.LEAVING).equals(0.0)
                counts = narrow & begins & (length.get() > before * 0.25) & apart
                remember(Clock.NARROW_FAILURES, failures + counts.to_real())
                remember(Clock.GAP, f.select(blind, length.get() * 2.0, length.get()))
                remember(Clock.REFUSED, f.select(begins, one, clock(Clock.REFUSED)))
                remember(Clock.REFUSED_BEYOND, blind.to_real())
                remember(Clock.UNEXPLAINED, unexplained)
                remember(Clock.USUAL_STEP, f.select(begins, before, clock(Clock.USUAL_STEP)))
                index.set(began.get())
                taken.set(less)
                tries.set(tries.get() + 1)
                pending.set(f.count(NOTHING))
                if due is not None:
                    due.set(f.count(NO_GUARD))
                rounds.go_on()
            if steps.quadratures:
                with f.when(~settled.get()), f.when(steps.surprising(f, now, length.get())):
                    start = f.load(trial, layout.at(Clock.TIME)), f.load(trial, layout.at(Clock.TIME_LOW))
                    before_it = Now(*start, zero, unit_before.get())
                    steps.resume(f, before_it)
                    steps.part(f, before_it, length.get(), (began.get(), index.get()))
                    leave_divided(less)
                    steps.forget(f)
                    steps.expand(f, Now(t, low, clock(Clock.STEP), one))
            for number in (Clock.REFUSED, Clock.REFUSED_BEYOND, Clock.UNEXPLAINED):
                remember(number, zero)
            tries.set(f.count(0))
            with f.when(pending.get().equals(Stop.END)):
                leave(Stop.END, taken.get())
            # The step contains more samples than there is room for. It is completed after they are written,
            # from the unchanged state.
            with f.when(pending.get().equals(Stop.SAMPLES)):
                copy(trial, state)
                limited.set(limited_before.get())
                leave(Stop.SAMPLES, less)
            if due is not None:
                with f.when(~due.get().equals(NO_GUARD)), f.when(~change_mode(now)):
                    steps.forget(f)
                    rounds.go_on()
        with f.when(taken.get() >= pause):
            leave(Stop.PAUSE, taken.get())
        with f.when(~regular):
            leave(Stop.SINGULAR, taken.get())

        gap = clock(Clock.GAP)
        now, by_series, sound = steps.choose(f, now, lambda why: leave(why, taken.get()))
        left = (stop - t) - low
        h = steps.vet(f, now, by_series, left, gap.equals(0.0))
        reach, passed = f.smaller(h, left), f.magnitude(t)
        too_short = (h <= passed * bounds.shortest + SMALLEST) & (h < left)
        with f.when(too_short | (tries.get() >= TRIES)):
            leave(Stop.UNDERFLOW, taken.get())

        usual, last, times = (
            f.variable(clock(one)) for one in (Clock.USUAL_STEP, Clock.LAST_PASS, Clock.PASSES)
        )
        leaving, lax = (f.variable(clock(one)) for one in (Clock.LEAVING, Clock.UNEXPLAINED))
        confirms, goal, bound = f.variable(yes), f.variable(gap), f.variable(h)
        # Before a critical point: halve the distance until it is at the resolution of the numbers, then step
        # to just beyond the point. If steps as short as that are not accepted either, the differences are
        # due to rounding.
        with f.section() as bounded:
            with f.when(~gap.equals(0.0)):
                half, beyond = gap * 0.5, clock(Clock.REFUSED_BEYOND) > 0.0
                refused = clock(Clock.REFUSED) > 0.0
                grain = f.select(refused, f.constant(bounds.doubt), f.constant(bounds.grain))
                measure = f.select(refused, f.smaller(h, usual.get()), usual.get())
                resolved = passed * bounds.ulp + measure * grain
                with f.when((half > resolved) & (h > resolved) & ~beyond):
                    bound.set(f.smaller(h, half))
                    bounded.leave()
                with f.when(~(refused & ~beyond)):
                    # Passed many times while t hardly changes: the motion sticks at this point.
                    at_once = t - last.get() <= passed * bounds.no_time
                    times.set(f.select(at_once, times.get() + 1.0, zero))
                    last.set(t)
                    with f.when(times.get() >= PASSES):
                        leave(Stop.UNDERFLOW, taken.get())
                    bound.set(f.select(beyond, gap, f.smaller(gap, resolved * 2.0)))
                    steps.straighten(f)
                    confirms.set(no)
                    bounded.leave()
                with f.when(lax.get() > 0.0):
                    leave(Stop.UNDERFLOW, taken.get())
                lax.set(one)
                goal.set(zero)
            # The allowance is based on the usual step. It shrinks no faster than the steps do in front of a
            # singularity, and short steps just after a critical point do not reduce it.
            near, grows = leaving.get(), h > now.previous * 1.25
            still = (grows | (near >= 2.0)) & (near > 0.0)
            lagging = f.larger(reach, usual.get() * LAG)
            usual.set(f.select(still, usual.get(), lagging))
            leaving.set(still.to_real())
        if due is not None:  # the step ends where a mode changes
            ahead = f.smaller(bound.get(), left)
            root, which, known = steps.first_guard(f, now, ahead)
            bound.set(f.select(known < ahead, known, bound.get()))
            with f.when(root <= ahead):
                due.set(which)
                with f.when(root < 0.0):
                    leave(Stop.GUARD, taken.get())
                with f.when(root.equals(0.0)):
                    change_mode(now)
                    steps.forget(f)
                    rounds.go_on()
                bound.set(root)
                confirms.set(yes)
                if steps.in_two:
                    due.set(f.select(whole.get(), which, f.count(NO_GUARD)))
                    bound.set(f.select(whole.get(), root, root * PART))
                    whole.set(yes)
                if steps.refined:
                    close = root <= f.smaller(h, left) * NEAR
                    due.set(f.select(close, which, f.count(NO_GUARD)))
                    bound.set(f.select(close, root, root * (1.0 - MARGIN)))
                assert steps.guards
                bound.set(steps.guards.beyond(f, bound.get(), which, ahead))
        # Whether the stop time may have influenced this step. As long as it has not, a run to a later time
        # takes the same steps.
        limited_before.set(limited.get())
        influenced = (by_series >= left) | (bound.get() >= left)
        limited.set(limited.get() | influenced.to_integer())
        sampled = steps.sample(f, now, index.get(), bound.get())
        final, used_up, is_last = left <= bound.get(), sampled >= count, ~Integer(f, "%last").equals(0)
        ending, leaves, seen = used_up & is_last & final, used_up & ~is_last, confirms.get()
        with f.when(leaves & ~seen):
            leave(Stop.SAMPLES, taken.get(), sampled)
        copy(state, trial)
        began.set(index.get())
        step = f.select(final, left, bound.get())
        if due is not None:
            f.call(None, "settled", state, step)
        length.set(step)
        usual_before.set(usual.get())
        remember(Clock.USUAL_STEP, usual.get())
        remember(Clock.LAST_PASS, last.get())
        remember(Clock.PASSES, times.get())
        remember(Clock.LEAVING, f.select(seen, leaving.get(), 2.0))
        remember(Clock.UNEXPLAINED, lax.get())
        remember(Clock.STEP, reach)
        rest = f.select(goal.get().equals(0.0), zero, goal.get() - step)
        remember(Clock.GAP, f.select(seen, rest, zero))
        usually = allowance(f, bounds, passed, usual.get(), step)
        passing = bounds.almost / step
        allowed = Allowance(
            f.select(seen, usually.change, zero), f.select(seen, usually.speed, passing), usually.place
        )
        farthest = steps.move(f, now, step, final, allowed)
        steps.project(f, due)
        uneven.set(f.select(seen, f.fused(farthest, usually.place, f.constant(SMALLEST)), zero))
        if steps.quadratures:
            rough = steps.rough(f, now, step, sound) & seen
            settled.set(rough | ~seen | ~sound)
            unit_before.set(now.unit)
            with f.when(rough):
                steps.part(f, now, step, (began.get(), sampled))
                leave_divided(taken.get())
                steps.forget(f)
        taken.set(taken.get() + 1)
        with f.when(ending & ~seen):
            leave(Stop.END, taken.get(), sampled)
        moved = f.select(seen, f.count(MOVED), f.count(BLIND))
        full = f.select(leaves, f.count(Stop.SAMPLES), moved)
        pending.set(f.select(ending, f.count(Stop.END), full))
        index.set(sampled)
        with f.when(~sound):
            steps.forget(f)
    return "".join([*steps.functions(), copy_function(layout), f.text()])
