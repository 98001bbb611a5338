"""``@advance``: steps until the sample times are used up, the end is reached, or something stops it.

Every step must be accepted by the next one's series (``confirmation``); until then its samples may be
discarded. If it is not, a critical point lies within the step, such as a kink of the potential. This is
approached by halving the distance, and passed if the accelerations stay finite. The error is their change
times the resolution of time.

It is the same for all kinds of numbers. What differs are the ``Steps`` of a kind.
"""

from __future__ import annotations

from lagrange_cli.native.guards import COSTLY
from lagrange_cli.native.interface import Stop
from lagrange_cli.native.llvm.flow import Loop, Variable
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.state import Clock
from lagrange_cli.native.stepping.acceptance import Allowance, allowance
from lagrange_cli.native.stepping.at_once import hits
from lagrange_cli.native.stepping.confirmation import confirm
from lagrange_cli.native.stepping.divided import DividedSteps
from lagrange_cli.native.stepping.guard_search import NO_GUARD
from lagrange_cli.native.stepping.guards import MARGIN, NEAR, PART
from lagrange_cli.native.stepping.progress import BLIND, MOVED, NOTHING, Progress
from lagrange_cli.native.stepping.step_size import ENDLESS
from lagrange_cli.native.stepping.steps import Now, copy_function
from lagrange_cli.records import dataclass

LAG = 0.7
"""The factor by which the usual step may shrink per step, as steps do in front of a singularity."""
PASSES = 8.0
"""If so many kinks are passed while t hardly changes, the motion sticks at one."""
CHATTERS, LASTS = 4.0, 32.0
"""If switches have changed so many times while t hardly changes, it may be by rounding. That is over before
so many, or there are other reasons."""
TRIES = 1000
"""Lengths that are tried for a step, far more than halving takes to the resolution of time: there is none."""
SMALLEST = 2.0**-1022
UNRESOLVED = 2.0**-60
"""Steps on rates below this part of t do not resolve where a switch changes."""
REST = 2.0**-8
"""This part of a step is left to where a vector is 0 that friction acts along."""
BRANCH = 2.0**-20
"""A step that is so small a part of the one before it begins at a branch point of a force."""


def advance(steps: DividedSteps) -> str:
    """The text of ``@advance`` and all that it calls."""
    at = Progress(steps)
    f = at.f
    steps.forget(f)
    if at.listed and steps.given.near:
        steps.given.near.renew(f)
    with at.rounds() as rounds:
        t, low = at.clock(Clock.TIME), at.clock(Clock.TIME_LOW)
        now, regular = steps.expand(f, Now(t, low, at.clock(Clock.STEP), at.one), at.leaving_at_once)
        with f.when(~at.pending.get().equals(NOTHING)):
            confirm(at, now, regular, rounds)
        with f.when(at.pauses()):
            at.leave(Stop.PAUSE)
        with f.when(~regular):
            at.leave(Stop.SINGULAR)
        step = plan(at, now)
        approach(at, step)
        if at.due is not None:
            stop_at_guard(at, step, at.due, rounds)
        take(at, step)
    return "".join([*steps.functions(), copy_function(steps.state, idle=steps.given.idle), f.text()])


@dataclass(frozen=True)
class Planned:
    """A step that is planned from ``now``: as far as the series are good (``by_series``), and not known to be
    unsound; vetted, ``h``; with so much time ``left``. ``reach`` is what it could be, ``bound`` its length,
    and ``passed`` the size of t.

    A critical point within the distance ``gap`` is approached: ``goal`` is the distance that remains. A step
    just beyond one ``confirms`` nothing. The ``usual`` step is the basis of what is allowed; what the state
    remembers of the ``last`` point that was passed, how many ``times``, ``leaving`` one, and whether a
    difference is unexplained (``lax``), changes with the step.
    """

    now: Now
    by_series: Real
    sound: Bit
    left: Real
    h: Real
    reach: Real
    passed: Real
    gap: Real
    usual: Variable[Real]
    last: Variable[Real]
    times: Variable[Real]
    leaving: Variable[Real]
    lax: Variable[Real]
    confirms: Variable[Bit]
    goal: Variable[Real]
    bound: Variable[Real]


def plan(at: Progress, now: Now) -> Planned:
    """The step that the series allow. Where time does not resolve it, and what rests begins to move, the step
    is as short as time resolves."""
    f, steps, t = at.f, at.steps, now.t
    gap = at.clock(Clock.GAP)
    now, by_series, sound = steps.choose(f, now, at.leave)
    if steps.guards and steps.guards.switches and steps.state.rows >= COSTLY:
        leave_at_root(at, now, by_series)
    left = (at.stop - t) - now.low
    h, passed = steps.vet(f, now, by_series, left, gap.equals(0.0)), f.magnitude(t)
    if creeping(at):
        length = f.variable(h)
        with f.when(h < resolved(at, passed)), f.when(creeps(at, now, passed)):
            length.set(resolved(at, passed))
        h = length.get()
    reach = f.smaller(h, left)
    with f.when(too_short(at, h, passed, left) | (at.tries.get() >= TRIES)):
        at.leave(Stop.UNDERFLOW)
    remembered = Clock.USUAL_STEP, Clock.LAST_PASS, Clock.PASSES, Clock.LEAVING, Clock.UNEXPLAINED
    usual, last, times, leaving, lax = (f.variable(at.clock(one)) for one in remembered)
    kept = usual, last, times, leaving, lax
    at.stops.set(at.no)
    aims = f.variable(at.yes), f.variable(gap), f.variable(h)
    return Planned(now, by_series, sound, left, h, reach, passed, gap, *kept, *aims)


def too_short(at: Progress, h: Real, passed: Real, left: Real) -> Bit:
    """Whether a step is so short that the motion ends before, or is taken further in another way."""
    shortest = UNRESOLVED if switched(at) else at.steps.bounds.shortest
    return (h <= passed * shortest + SMALLEST) & (h < left)


def switched(at: Progress) -> bool:
    """Whether steps on rates come to switches: forces, as powers of depths, may be no numbers beyond."""
    guards = at.steps.guards
    return guards is not None and guards.interpolated and guards.any_switch


def creeping(at: Progress) -> bool:
    """Whether steps may be shorter than time resolves although hardly anything moves: where forces begin that
    are rounding errors at first."""
    return bool(at.steps.given.static) and not at.steps.constrained


def resolved(at: Progress, passed: Real) -> Real:
    """The shortest step that moves the time then."""
    return passed * (2.0 * at.steps.bounds.ulp)


def creeps(at: Progress, now: Now, passed: Real) -> Bit:
    """Whether hardly anything moves in it."""
    f = at.f
    return f.call(Bit, "creeps", f.pointer("%work"), *at.steps.scaled(f, now.unit, resolved(at, passed)))


def leave_at_root(at: Progress, now: Now, by_series: Real) -> None:
    """Where a mode has just changed, and steps become very short, a force has no series: the caller looks for
    a way across."""
    here = now.previous.equals(0.0) & at.clock(Clock.LAST_PASS).equals(now.t)
    with at.f.when(here & (by_series < at.clock(Clock.LENGTH) * BRANCH)):
        at.leave(Stop.ROOT)


def approach(at: Progress, step: Planned) -> None:
    """Before a critical point: halve the distance until it is at the resolution of the numbers, then step to
    just beyond the point. If steps as short as that are not accepted either, the differences are due to
    rounding."""
    f, bounds, h, t, passed = at.f, at.steps.bounds, step.h, step.now.t, step.passed
    with f.section() as bounded:
        with f.when(~step.gap.equals(0.0)):
            half, beyond = step.gap * 0.5, at.clock(Clock.REFUSED_BEYOND) > 0.0
            refused = at.clock(Clock.REFUSED) > 0.0
            grain = f.select(refused, f.constant(bounds.doubt), f.constant(bounds.grain))
            measure = f.select(refused, f.smaller(h, step.usual.get()), step.usual.get())
            resolved = passed * bounds.ulp + measure * grain
            with f.when((half > resolved) & (h > resolved) & ~beyond):
                step.bound.set(f.smaller(h, half))
                bounded.leave()
            with f.when(~(refused & ~beyond)):
                # Passed many times while t hardly changes: the motion sticks at this point.
                at_once = t - step.last.get() <= passed * bounds.no_time
                step.times.set(f.select(at_once, step.times.get() + 1.0, at.zero))
                step.last.set(t)
                with f.when(step.times.get() >= PASSES):
                    at.leave(Stop.UNDERFLOW)
                step.bound.set(f.select(beyond, step.gap, f.smaller(step.gap, resolved * 2.0)))
                at.steps.straighten(f)
                step.confirms.set(at.no)
                bounded.leave()
            with f.when(step.lax.get() > 0.0):
                at.leave(Stop.UNDERFLOW)
            step.lax.set(at.one)
            step.goal.set(at.zero)
        # The allowance is based on the usual step. It shrinks no faster than the steps do in front of a
        # singularity, and short steps just after a critical point, or just before a jump, do not reduce it.
        near, grows = step.leaving.get(), h > step.now.previous * 1.25
        still = (grows | (near >= 2.0)) & (near > 0.0)
        sudden = at.steps.sudden(f, step.by_series)
        lag = LAG if sudden is None else f.select(sudden, at.one, f.constant(LAG))
        lagging = f.larger(step.reach, step.usual.get() * lag)
        step.usual.set(f.select(still, step.usual.get(), lagging))
        step.leaving.set(still.to_real())


def stop_at_guard(at: Progress, step: Planned, due: Variable[Integer], rounds: Loop) -> None:
    """The step ends where a mode changes."""
    f, steps = at.f, at.steps
    aim = aim_at_stop(at, step) if steps.guards and steps.guards.stopping else None
    ahead = f.smaller(step.bound.get(), step.left)
    root, which, known = steps.first_guard(f, step.now, ahead)
    if creeping(at) and steps.guards and steps.guards.switches:
        root, known = without_chatter(at, step, root, which, known)
    step.bound.set(f.select(known < ahead, known, step.bound.get()))
    if switched(at):
        with f.when(~(root <= ahead) & too_short(at, step.bound.get(), step.passed, step.left)):
            at.leave(Stop.UNDERFLOW)
    if steps.guards and steps.guards.rows.joined:  # what is driven back is hit now
        root = f.select((root < 0.0) & hits(f, which), at.zero, root)
    if aim:
        zero, vector, stops = aim
        first = (root > ahead) & (known >= ahead)
        stops = stops & (first | (which.equals(vector) & (root > 0.0) & (root <= ahead)))
        root, which = f.select(stops, zero, root), f.select(stops, vector, which)
        at.stops.set(stops)
    with f.when(root <= ahead):
        due.set(which)
        with f.when(root < 0.0):
            if creeping(at):
                at.count_pass()
            at.leave(Stop.GUARD)
        with f.when(root.equals(0.0)):
            at.change_mode(step.now, at.zero)
            steps.forget(f)
            if at.listed and steps.given.near and steps.guards and steps.guards.rows.affected:
                steps.given.near.renew(f)
            rounds.go_on()
        step.bound.set(root)
        step.confirms.set(at.yes)
        if steps.in_two:
            due.set(f.select(at.whole.get(), which, f.count(NO_GUARD)))
            step.bound.set(f.select(at.whole.get(), root, root * PART))
            at.whole.set(at.yes)
        if steps.refined:
            close = root <= f.smaller(step.h, step.left) * NEAR
            due.set(f.select(close, which, f.count(NO_GUARD)))
            step.bound.set(f.select(close, root, root * (1.0 - MARGIN)))
        assert steps.guards
        step.bound.set(steps.guards.beyond(f, step.bound.get(), which, ahead))


def aim_at_stop(at: Progress, step: Planned) -> tuple[Real, Integer, Bit]:
    """Let the step end where a vector goes straight to 0 that friction acts along, if that is near: when, its
    guard, and whether it ends there. There friction has no direction, so that no series can confirm it. So
    the step ends before, unless it is short: then it needs no confirmation."""
    f, guards = at.f, at.steps.guards
    assert guards
    times = step.bound.get(), at.clock(Clock.LENGTH), step.usual.get()
    zero, which, short = guards.straight(f, *times)
    free = step.gap.equals(0.0) | (zero <= step.bound.get())
    near = (zero <= step.left) & free
    before = f.select(short, zero, zero * (1.0 - REST))
    step.bound.set(f.select(near, before, step.bound.get()))
    return zero, which, near & short


def without_chatter(
    at: Progress, step: Planned, root: Real, which: Integer, known: Real
) -> tuple[Real, Real]:
    """The root of a guard, and how far others are known to have none. Where a switch has changed again and
    again while hardly anything moves, its argument is a rounding error: the next change is looked for once
    time has moved, and has no root until then."""
    f, guards = at.f, at.steps.guards
    assert guards
    found, until, least = f.variable(root), f.variable(known), resolved(at, step.passed)
    times = step.times.get()
    soon = (root < least) & ~root.equals(0.0) & (times >= CHATTERS) & (times < LASTS)
    with f.when(soon & guards.is_switch(f, which)), f.when(creeps(at, step.now, step.passed)):
        step.times.set(times + 1.0)
        f.store(at.zero, at.state, which + guards.rows.fresh(at.steps.state))
        found.set(f.constant(ENDLESS))
        until.set(least)
    return found.get(), until.get()


def take(at: Progress, planned: Planned) -> None:
    """Take the step, and the samples within it; remember what the next one must confirm of it."""
    f, steps, now, zero = at.f, at.steps, planned.now, at.zero
    left, bound, usual = planned.left, planned.bound, planned.usual
    # Whether the stop time may have influenced this step. As long as it has not, a run to a later time takes
    # the same steps.
    at.limited_before.set(at.limited.get())
    influenced = (planned.by_series >= left) | (bound.get() >= left)
    at.limited.set(at.limited.get() | influenced.to_integer())
    sampled = steps.sample(f, now, at.index.get(), bound.get())
    final, used_up, is_last = left <= bound.get(), sampled >= at.count, ~Integer(f, "%last").equals(0)
    ending, leaves, seen = used_up & is_last & final, used_up & ~is_last, planned.confirms.get()
    with f.when(leaves & ~seen):
        at.leave(Stop.SAMPLES, samples=sampled)
    at.copy(at.state, at.trial)
    at.began.set(at.index.get())
    step = f.select(final, left, bound.get())
    if at.due is not None:
        work = [f.pointer("%work")] * at.listed
        f.call(None, "settled", at.state, step, *work)
    at.length.set(step)
    at.usual_before.set(usual.get())
    at.remember(Clock.USUAL_STEP, usual.get())
    at.remember(Clock.LAST_PASS, planned.last.get())
    at.remember(Clock.PASSES, planned.times.get())
    at.remember(Clock.LEAVING, f.select(seen, planned.leaving.get(), 2.0))
    at.remember(Clock.UNEXPLAINED, planned.lax.get())
    at.remember(Clock.STEP, planned.reach)
    goal = planned.goal.get()
    rest = f.select(goal.equals(0.0), zero, goal - step)
    at.remember(Clock.GAP, f.select(seen, rest, zero))
    usually = allowance(f, steps.bounds, planned.passed, usual.get(), step)
    passing = steps.bounds.almost / step
    allowed = Allowance(
        f.select(seen, usually.change, zero), f.select(seen, usually.speed, passing), usually.place
    )
    farthest = steps.move(f, now, step, final, allowed)
    steps.project(f, at.due)
    at.uneven.set(f.select(seen, f.fused(farthest, usually.place, f.constant(SMALLEST)), zero))
    if steps.quadratures:
        # the series at the end have no integrands there, and those of the step are good
        stops = at.stops.get() & planned.sound
        rough = steps.rough(f, now, step, planned.sound) & seen & ~stops
        at.settled.set(rough | ~seen | ~planned.sound | stops)
        at.unit_before.set(now.unit)
        with f.when(rough):
            steps.part(f, now, step, (at.began.get(), sampled))
            at.leave_divided(at.taken.get())
            steps.forget(f)
    at.taken.set(at.taken.get() + 1)
    with f.when(ending & ~seen):
        at.leave(Stop.END, samples=sampled)
    moved = f.select(seen, f.count(MOVED), f.count(BLIND))
    full = f.select(leaves, f.count(Stop.SAMPLES), moved)
    at.pending.set(f.select(ending, f.count(Stop.END), full))
    at.index.set(sampled)
    with f.when(~planned.sound):
        steps.forget(f)
