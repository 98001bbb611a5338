"""``@follow``: eight motions at once, a lane for each; a lane whose motion has ended takes the next one.

Lanes take their steps together, each with its own length, by the rules for single motions (``step_size``,
``acceptance``). Those whose step is not accepted, and those near a singularity, are left to ``@advance``.

``%queue`` holds the number of the next member, that of the first one that may not begin yet, and whether to
stop (any thread may change them). Member n starts from row n of ``%states`` with row n of ``%parameters``.
Its result goes to row n of ``%results``: the state, then the time, and as integers the numbers of steps and
samples; then ``%ended[n]`` becomes 1 + the reason. Its samples go to part n modulo ``%slots`` of
``%samples``.

What lanes work on is unchanged between calls. ``@follow`` returns when it is told to stop, or when all its
lanes are empty and no member may begin.
"""

from __future__ import annotations

from lagrange_cli.native.ensembles.pack import Pack, each_lane, spread
from lagrange_cli.native.interface import Stop
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.members import BEYOND, HALT, LIMIT, NEXT
from lagrange_cli.native.numbers.error_free import two_sum
from lagrange_cli.native.state import LANES
from lagrange_cli.native.stepping.acceptance import DOUBLE, accepted, allowance
from lagrange_cli.native.stepping.advance import LAG, SMALLEST
from lagrange_cli.native.stepping.doubles import moved
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.noise import Noise
from lagrange_cli.native.stepping.polynomial import polynomial
from lagrange_cli.native.stepping.quadratures import Quadratures
from lagrange_cli.native.stepping.step_size import ENDLESS, StepSize, chosen_step
from lagrange_cli.native.stepping.sums import HighLow

ALL = 2**LANES - 1
ENOUGH, CRAWLING = 1 << 12, 2.0**-12
"""After so many steps, motions whose steps are this fraction of the usual length, and may become ever
shorter, are left to ``@advance``, too."""


class Follower:
    """Writes ``@follow`` and what it calls. Equations that depend on t are ``timed``."""

    def __init__(
        self, pack: Pack, order: int, tolerance: float, parameters: int, *, timed: bool = False
    ) -> None:
        self.pack, self.places, self.parameters = pack, pack.places, parameters
        self.lengths = Lengths(
            pack.degrees, pack.rows, pack.width, order, LANES, 1, row=LANES * pack.span, term=LANES
        )
        self.bounds, self.noise = DOUBLE.coarser(tolerance).timed(timed), None
        if pack.degrees > 1:
            size = 0.5 * self.bounds.rounding
            self.noise = Noise(self.lengths, pack.width, 2 * pack.width, 0, size, 0, self.expand)
        uncertain = (self.noise.place, 1.0) if self.noise else None
        self.sizes = StepSize(self.lengths, tolerance, uncertain=uncertain)
        first = 2 * pack.degrees
        given = first, pack.quadratures, tolerance, self.bounds
        self.quadratures = Quadratures(self.lengths, *given) if pack.quadratures else None

    def text(self) -> str:
        """All of them."""
        own = self.admit(), self.retire(), *self.sampling(), self.record(), self.follow()
        rough = [self.quadratures.rough()] if self.quadratures else []
        noise = [self.noise.function()] if self.noise else []
        made = *self.sizes.functions(), accepted(self.lengths), *noise, *rough, *own
        return "".join(f.text() for f in made)

    def sampling(self) -> list[Function]:
        """The functions that find out when samples are due."""
        return [self.ahead()]

    def column(self, f: Function, lane: Integer) -> Pointer:
        """The first double of a lane, from which others are ``LANES`` doubles apart."""
        return f.place("%state", lane, "double")

    def number(self, f: Function, name: str, lane: Integer) -> Pointer:
        """The place of one of a lane's numbers."""
        return f.place(self.column(f, lane), LANES * self.places[name], "double")

    def part(self, f: Function, name: str, shift: int = 0) -> Pointer:
        """The place of a part of the pack."""
        return f.place("%state", LANES * (self.places[name] - shift), "double")

    def admit(self) -> Function:
        """``@admit``: load the next member into a lane; false if there is none."""
        heads = "ptr %state, i64 %lane, ptr %parameters, ptr %states, ptr %queue, double %start"
        f = Function(f"define internal i1 @admit({heads}) #0")
        lane, rows = Integer(f, "%lane"), self.pack.rows
        with f.forever() as rounds:
            n = f.observe("%queue", NEXT)
            with f.when(~(n < f.observe("%queue", LIMIT))):
                f.give(Bit(f, "false"))
            rounds.repeat(~f.replace(n, n + 1, "%queue", NEXT))
        scratch = self.part(f, "scratch")
        f.call(None, "prepare_lane", f.place("%parameters", n * self.parameters), scratch)
        spread(f, scratch, self.number(f, "constants", lane), self.pack.constants)
        spread(f, f.place("%states", n * rows), self.number(f, "state", lane), rows)
        with f.loop(self.places["low"], self.places["member"], tested=False) as i:
            f.store(f.constant(0.0), self.column(f, lane), i * LANES)
        self.begin(f, n, lane)
        f.store(Real(f, "%start"), self.number(f, "time", lane))
        f.store(n, self.number(f, "member", lane))
        f.give(Bit(f, "true"))
        return f

    def expand(self, f: Function, time: HighLow, unit: Real) -> None:
        """Compute the series of the lanes' states."""
        t, low = time
        f.call(Bit, "paired_jet", f.pointer("%constants"), t + low, f.pointer("%state"), f.pointer("%work"))

    def begin(self, f: Function, n: Integer, lane: Integer) -> None:
        """Load what else a member begins with."""

    def retire(self) -> Function:
        """``@retire``: store the result of a lane's member."""
        heads = "ptr %state, i64 %lane, i64 %code, ptr %results, ptr %ended"
        f = Function(f"define internal void @retire({heads}) #0")
        lane, rows = Integer(f, "%lane"), self.pack.rows
        n = f.load_integer(self.number(f, "member", lane))
        result, column = f.place("%results", n * (rows + BEYOND)), self.column(f, lane)
        with f.loop(0, rows, tested=False) as i:
            f.store(f.load(column, i * LANES), result, i)
        for place, name in enumerate(("time", "steps", "reached"), rows):
            f.store(f.load(self.number(f, name, lane)), result, place)
        mark = f.define(f"trunc i64 {(Integer(f, '%code') + 1).name} to i8")
        f.line(f"  store atomic i8 {mark}, ptr {f.place('%ended', n, 'i8').name} release, align 1")
        f.give()
        return f

    def ahead(self) -> Function:
        """``@ahead``: the time of each lane's next sample within the step; nan if there is none."""
        f = Function("define internal REAL @ahead(ptr %state, ptr %times, i64 %count) #0", LANES)
        times, none = f.variable(f.zero(LANES)), Real(f, "0x7FF8000000000000", 1)
        with f.loop(0, LANES, tested=False) as lane:
            reached = f.load_integer(self.number(f, "reached", lane))
            one = f.variable(none)
            with f.when(reached < Integer(f, "%count", 1)):
                one.set(f.load_row("%times", reached, 1))
            times.set(f.inserted(times.get(), one.get(), lane))
        f.give((times.get() - self.get(f, "time")) - self.get(f, "time_low"))
        return f

    def record(self) -> Function:
        """``@record``: sample the lanes in %mask at the time %dt of the step."""
        heads = "ptr %state, ptr %work, REAL %dt, i64 %mask, i64 %count, i64 %slots, ptr %samples"
        f = Function(f"define internal void @record({heads}) #0", LANES)
        dt, trial = Real(f, "%dt"), self.part(f, "trial")
        rows = self.pack.rows + self.pack.sampled
        with self.lengths.each(f) as row:
            change = polynomial(f, row.series().terms(1, self.lengths.order), dt) * dt
            row.put(row.at("%state") + (change + row.at("%state", self.pack.width)), trial)
        self.complete(f, dt, trial)
        count = Integer(f, "%count", 1)
        with each_lane(f, Integer(f, "%mask", 1)) as lane:
            slot = f.load_integer(self.number(f, "member", lane)).operation("urem", Integer(f, "%slots", 1))
            place = self.number(f, "reached", lane)
            reached = f.load_integer(place)
            f.store(reached + 1, place)
            column = f.place(trial, lane, "double")
            with f.loop(0, rows, tested=False) as i:
                x = f.load_row(column, i * LANES, 1)
                f.store_row(x, "%samples", (slot * rows + i) * count + reached)
        f.give()
        return f

    def complete(self, f: Function, dt: Real, trial: Pointer) -> None:
        """Write what else belongs to a sample at the time ``dt`` of the step."""

    def get(self, f: Function, name: str) -> Real:
        """A number of each lane."""
        return f.load("%state", self.places[name])

    def put(self, f: Function, name: str, value: Real) -> None:
        """The same, stored."""
        f.store(value, "%state", self.places[name])

    def bounded(self, f: Function, h: Real, left: Real, live: Bit) -> Real:
        """The step of the lanes that are ``live``, which may be shorter than ``h``; so much time is
        ``left``."""
        return h

    def sample(self, f: Function, step: Real, moving: Bit, count: Integer) -> Integer | None:
        """Take the samples of lanes that are ``moving``; those that need no others, if there are such."""
        with f.when(~count.equals(0)), f.forever() as sampling:
            dt = f.call(Real, "ahead", f.pointer("%state"), f.pointer("%times"), count)
            due = ((dt <= step) & moving).mask()
            with f.when(due.equals(0)):
                sampling.leave()
            self.take(f, dt, due, count)
        return None

    def take(self, f: Function, dt: Real, due: Integer, count: Integer) -> None:
        """Sample the lanes that are ``due``."""
        places = f.pointer("%state"), f.pointer("%work")
        f.call(None, "record", *places, dt, due, count, Integer(f, "%slots", 1), f.pointer("%samples"))

    def halt(self, f: Function) -> None:
        """Hand over the results so far of members that are not followed to their ends."""

    def follow(self) -> Function:
        """``@follow``."""
        heads = (
            "ptr noalias %state, ptr noalias %parameters, ptr noalias %states, ptr %queue, double %start, "
            "double %stop, ptr noalias %times, i64 %count, ptr noalias %results, ptr noalias %ended, "
            "ptr noalias %samples, i64 %slots"
        )
        f = Function(f"define void @follow({heads}) #0", LANES)
        bounds, zero = self.bounds, f.constant(0.0)
        f.line(f"  %work = getelementptr inbounds {f.real}, ptr %state, i64 {self.places['work']}")
        state, work = f.pointer("%state"), f.pointer("%work")
        expected = self.part(f, "rates", self.pack.degrees), self.part(f, "allowed", self.pack.degrees)
        stop, count = f.splat(Real(f, "%stop", 1), LANES), Integer(f, "%count", 1)
        with f.forever() as rounds:
            with f.when(~f.observe("%queue", HALT).equals(0)):
                self.halt(f)
                f.give()
            active = f.variable(f.load_integer(self.part(f, "active")))
            empty = active.get().operation("xor", ALL)
            with f.when(~empty.equals(0)):
                with f.section() as filled, each_lane(f, empty) as lane:
                    places = f.pointers("parameters", "states", "queue")
                    got = f.call(Bit, "admit", state, lane, *places, Real(f, "%start", 1), lanes=1)
                    with f.when(~got):
                        filled.leave()
                    active.set(active.get() | (f.count(1) << lane))
                f.store(active.get(), self.part(f, "active"))
                with f.when(active.get().equals(0)):
                    f.give()
            live = active.get().flags(LANES)
            t, low, previous = (self.get(f, name) for name in ("time", "time_low", "previous"))
            if self.noise:
                due = self.noise.due(f) & live
                with f.when(f.any(due)):
                    at = self.part(f, "constants"), state, work, self.part(f, "arrays")
                    self.noise.call(f, at, (t, low, f.constant(1.0)), due)
            regular = f.call(Bit, "paired_jet", self.part(f, "constants"), t + low, state, work)
            uneven = self.get(f, "uneven")
            one, never = f.constant(1.0), Bit(f, "zeroinitializer")
            agree = f.call(Bit, "accepted", work, *expected, uneven, one, never, zero)
            begun = ~self.get(f, "steps").bits().equals(0)
            refused = ~(agree & regular) & begun & live
            finishing = f.load_integer(self.part(f, "finishing")).flags(LANES)
            h, met = chosen_step(f, previous, (state, work), live)
            left, passed = (stop - t) - low, f.magnitude(t)
            h = self.bounded(f, h, left, live)
            stuck = (h <= passed * bounds.shortest + SMALLEST) & (h < left)
            taken = self.get(f, "steps").bits()
            way = f.magnitude((t - f.splat(Real(f, "%start", 1), LANES)) + low) * CRAWLING
            stuck = stuck | ((taken > ENOUGH) & (h * taken.to_real() < way) & (h < left))
            moving = live & regular & (met < ENDLESS) & ~(stuck | finishing | refused)
            if self.quadratures:  # steps are divided by single motions only
                moving = moving & ~f.call(Bit, "rough", state, work, f.smaller(h, left))
            final = (left <= h) & moving
            step = f.select(moving, f.smaller(h, left), zero)
            full = self.sample(f, step, moving, count)
            usual = f.larger(step, self.get(f, "usual") * LAG)
            allowed = allowance(f, bounds, passed, usual, step)
            if self.noise:
                self.noise.count(f, f.select(moving, 1.0, zero))
            width = self.pack.width
            noise = self.noise.place if self.noise else 0
            farthest = moved(f, self.lengths, step, allowed, expected, width, moving=moving, noise=noise)
            later, rest = two_sum(t, low + step)
            for name, value in (
                ("time", f.select(moving, later, t)),
                ("time_low", f.select(moving, rest, low)),
            ):
                self.put(f, name, value)
            if self.pack.constrained:
                f.call(None, "project_lanes", self.part(f, "constants"), state, moving)
            self.put(f, "usual", usual)
            self.put(f, "uneven", farthest * allowed.place)
            self.put(f, "previous", f.select(moving, step, previous))
            self.put(f, "steps", (self.get(f, "steps").bits() + moving.to_integer()).number())
            f.store(final.mask() if full is None else final.mask() | full, self.part(f, "finishing"))
            done = (live & ~moving).mask()
            with f.when(~done.equals(0)):
                ended = (finishing & ~refused).mask()
                with each_lane(f, done) as lane:
                    is_end = ~(ended & (f.count(1) << lane)).equals(0)
                    code = f.select(is_end, f.count(Stop.END), f.count(Stop.PAUSE))
                    f.call(None, "retire", state, lane, code, f.pointer("%results"), f.pointer("%ended"))
                f.store(active.get().operation("xor", done), self.part(f, "active"))
            rounds.go_on()
        return f
