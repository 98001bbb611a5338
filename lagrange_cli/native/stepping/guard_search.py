"""Guards in a step: which one's argument changes its sign first (see ``guards``)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from lagrange_cli.native.guards import AT_REST, HELD, SMALLEST, GuardRows, Role
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.state import LANES, StateLayout
from lagrange_cli.native.stepping.actions import ActionCode
from lagrange_cli.native.stepping.event_sides import EventSides
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.near import NearPlaces
from lagrange_cli.native.stepping.roots import NONE, Roots
from lagrange_cli.native.stepping.stopping import Searched, first_reached, first_stopped, sliding
from lagrange_cli.records import dataclass

NO_GUARD = -1
BEYOND = 2.0**-44
"""The part of a step by which it goes beyond the cut of a function: whether it is there, rounding must not
decide."""
RADIUS = 0.5
"""Away from the zero of a root, which has a series no farther than to there, a step is this part of the way
back, at most: beyond it the series diverges, however weak the force is."""
FROM_BOTH = 2
"""A root on both sides of 0; 1 more, or less, where it is on one side only."""
WIDER = 2.0**16
"""After a zero, a step is longer than the one before by no more than this factor."""
MANY = 32
"""From so many guards on a vector of them is looked at together."""
STOPPED = 2.0**-50, 2.0**-102
"""A vector is 0 but for rounding up to this part of the velocities that it is made of."""
CLEARLY = 1.0 + 2.0**-44
"""What exceeds the sum of all other terms by this factor is not 0, whatever is rounded."""


@dataclass(frozen=True)
class GuardSearch:
    """Writes the function that looks for the first guard in a step."""

    rows: GuardRows
    layout: StateLayout
    lengths: Lengths
    records: int
    """Where records are, behind ``%trial``."""
    interpolated: bool = False
    """Whether arguments are polynomials through values of theirs, instead of series."""
    tolerance: float = 0.0
    """That of steps on rates."""
    longest: int = 0
    """Where in the state the longest one so far is."""
    rises: int = 0
    """Where ``%work`` tells whether polynomials rise that seem to do so farther on."""
    near: NearPlaces | None = None
    """Where ``%work`` tells which guards that are side by side have series in this step, if others have none
    (``native.families.nearness``)."""
    alone: bool = False
    """Whether actions of events are computed one by one (``ActionCode.alone``)."""
    idle: Sequence[slice[int, int, None]] = ()
    """Places of the state that steps never change."""

    @property
    def roots(self) -> Roots:
        """The code for roots of arguments."""
        return Roots(self.lengths.order, self.lengths.term, self.interpolated)

    @property
    def sides(self) -> EventSides:
        """The code for sides of events."""
        return EventSides(self.rows, self.layout, self.lengths)

    @property
    def actions(self) -> ActionCode:
        """The code for simple actions."""
        lengths = self.lengths
        given = self.rows, self.layout, self.records, lengths.term, self.alone, lengths.row
        return ActionCode(*given, self.interpolated)

    @property
    def _rooted(self) -> bool:
        """Whether forces contain roots of guards' arguments, whose series do not converge beyond 0."""
        return not self.interpolated and self.rooted

    @property
    def rooted(self) -> bool:
        """Whether forces contain roots of guards' arguments."""
        return any(one.rooted for one in self.rows.guards)

    @property
    def steep(self) -> bool:
        """Whether these are infinitely steep where an argument is 0."""
        return any(one.steep for one in self.rows.guards)

    def at_root(self, f: Function) -> Bit:
        """Whether the motion is where such an argument is 0, and no way across has been tried."""
        found = f.variable(f.never(1))
        with f.loop(0, self.rows.count, tested=False) as j:
            mark, mode = (f.load("%state", j + one(self.layout)) for one in (self.rows.fresh, self.rows.mode))
            fresh = (mark >= SMALLEST) & ~mode.equals(0.0)
            found.set(found.get() | (fresh & f.load_integer("@guard_steep", j).equals(1)))
        return found.get()

    @property
    def _resting(self) -> bool:
        """Whether the motion may rest in contact. That ends where friction that holds it is at its limit."""
        return any(one.role is Role.REST for one in self.rows.guards)

    @property
    def _breaks(self) -> tuple[Role, ...]:
        """The role of breaks, if there are any."""
        return (Role.BREAK,) * any(one.role is Role.BREAK for one in self.rows.guards)

    @property
    def _edges(self) -> tuple[Role, ...]:
        """The role of edges, if there are any."""
        return (Role.EDGE,) * any(one.role is Role.EDGE for one in self.rows.guards)

    def before_break(self, f: Function, which: Integer) -> Bit | None:
        """Whether a step ends where something may jump by the guard ``which``, or ``NO_GUARD``; None if no
        guard is of that kind."""
        if not self._breaks:
            return None
        some = ~which.equals(NO_GUARD)
        return f.load_integer("@guard_roles", f.select(some, which, f.count(0))).equals(Role.BREAK) & some

    def first(self, f: Function, h: Real, unit: Real) -> tuple[Real, Integer, Real]:
        """What ``@first_guard`` gives for a step of ``h``, in the ``unit`` of time of the series."""
        state, work, trial = f.pointers("state", "work", "trial")
        root, which, known = f.parts((Real, Integer, Real), "first_guard", state, work, h, unit, trial)
        return root, which, known

    def beyond(self, f: Function, root: Real, which: Integer, ahead: Real) -> Real:
        """Where a step of at most ``ahead`` ends that comes to the ``root`` of a guard."""
        if not any(one.role is Role.CUT for one in self.rows.guards):
            return root
        cut = f.load_integer("@guard_roles", which).equals(Role.CUT)
        return f.select(cut, f.smaller(ahead, root + ahead * BEYOND), root)

    @property
    def searched(self) -> Searched:
        """What vectors that stop are found by."""
        return Searched(self.rows, self.lengths, self.layout, STOPPED[self.layout.parts - 1])

    @property
    def stopping(self) -> bool:
        """Whether there are vectors that steps by series lead to 0."""
        return not self.interpolated and self.layout.parts == 1 and bool(sliding(self.rows))

    def straight(self, f: Function, *times: Real) -> tuple[Real, Integer, Bit]:
        """What ``first_straight`` finds."""
        places = f.pointers("state", "work")
        zero, which, short = f.parts((Real, Integer, Bit), "first_straight", *places, *times)
        return zero, which, short

    def largest(self, f: Function) -> Real:
        """The sum of the last coefficients of all arguments: not finite where one of these is not."""
        total = f.variable(f.constant(0.0))
        with f.loop(0, self.rows.arguments, tested=False) as j:
            row = self.lengths.place(f, j + self.rows.first)
            for m in (self.lengths.order - 2, self.lengths.order - 1):
                total.set(total.get() + f.magnitude(f.load(row, m * self.lengths.term)))
        return total.get()

    def _first(self) -> Function:
        """``@first_guard(state, work, h, unit, scratch)``: when one is due in a step of ``h``, its
        number, and how much of the step is known."""
        given = "ptr %state, ptr %work, double %h, double %unit, ptr %scratch"
        f = Function(f"define internal {{ double, i64, double }} @first_guard({given}) #0")
        rows, layout = self.rows, self.layout
        earliest, which = f.variable(f.constant(NONE)), f.variable(f.count(0))
        reach = f.variable(Real(f, "%h"))

        def look(row: Pointer, start: Real, side: Real, fresh: Bit, j: Integer) -> None:
            scratch = f.pointer("%scratch")
            length, size = f.parts((Real, Real), "known", row, reach.get(), scratch)
            reach.set(length)
            u = f.load(row, self.lengths.term)
            clear = start + u * side + f.magnitude(u) > size * CLEARLY
            with f.when(fresh | ~clear):
                rises = f.load("%work", self.rises) > 0.0 if self.interpolated else Bit(f, "false")
                found = f.call(Real, "first_root", scratch, reach.get(), start, side, fresh, rises)
                with f.when(found < earliest.get()):
                    earliest.set(found)
                    which.set(j)
                    reach.set(f.larger(f.constant(0.0), f.smaller(found, reach.get())))

        with self._suspects(f, reach) as j:
            if self.actions.any:
                self.sides.decide(f, j)
            mark = f.load("%state", j + rows.fresh(layout))
            fresh = mark > 0.0
            with f.when(mark > SMALLEST):  # what counts as rounding depends on how far one looks
                reach.set(f.smaller(reach.get(), mark * WIDER / Real(f, "%unit")))
            mode = f.load("%state", j + rows.mode(layout))
            with f.when(~mode.equals(0.0) & self._has_roots(f, j)):
                row = f.load_integer("@guard_rows", j)
                look(self.lengths.place(f, row), f.constant(0.0), mode, fresh, j)
                if self._rooted:
                    u, rate = (f.load(self.lengths.place(f, row), m * self.lengths.term) for m in (1, 2))
                    leaving = (u * mode > 0.0) & (rate * mode > 0.0)
                    roots = f.load_integer("@guard_roots", j)
                    free = (roots.equals(FROM_BOTH + 1) & (mode < 0.0)) | (
                        roots.equals(FROM_BOTH - 1) & (mode > 0.0)
                    )
                    with f.when(leaving & ~roots.equals(0) & ~free):
                        reach.set(f.smaller(reach.get(), u / (rate + rate) * RADIUS))
            with f.when(mode.equals(0.0) & f.load_integer("@guard_roles", j).equals(Role.HOLD)):
                self._look_at_multiplier(f, j, look)
            with f.when(mode.equals(0.0) & f.load_integer("@guard_roles", j).equals(Role.SWITCH)):
                row, rest = f.load_integer("@guard_rows", j), f.larger(f.constant(AT_REST), -mark)
                for side in (-1.0, 1.0):
                    look(self.lengths.place(f, row), rest, f.constant(side), Bit(f, "false"), j)
        if self.interpolated:
            first_reached(self.searched, f, self.tolerance, self.longest, earliest, which)
        else:
            first_stopped(self.searched, f, earliest, which)
        # a later guard's argument may be known for less of the step than to an earlier one's root
        within = earliest.get() <= reach.get()
        f.give(f.select(within, earliest.get(), f.constant(NONE)), which.get(), reach.get())
        return f

    def _has_roots(self, f: Function, j: Integer) -> Bit:
        """Whether a guard's argument is looked at for roots: the lengths of vectors that friction acts along
        are no polynomials where these turn round, unless they are known by series."""
        if not (self.interpolated and sliding(self.rows)):
            return Bit(f, "true")
        return f.load_integer("@guard_vectors", j).equals(0)

    @contextmanager
    def _suspects(self, f: Function, reach: Variable[Real]) -> Iterator[Integer]:
        """Guards one by one; where there are many, without those of which nothing is due, vector by vector,
        in the part of the step that is left to ``reach``."""
        count, whole = self.rows.count, self.rows.side_by_side
        if whole < MANY or self.lengths.row != 1:
            with f.loop(0, count, tested=False) as j:
                yield j
            return
        if self.near is not None and self.near.listed:
            near = self.near
            with (
                near.eights(f, count) as first,
                f.when(self._any(f, first, reach)),
                near.marked(f, first) as j,
            ):
                yield j
            return
        with f.loop(0, count, LANES, tested=False) as first:
            suspect = f.variable(Bit(f, "true"))
            with f.when(first < whole):
                if self.near is None:
                    suspect.set(f.any(self._suspect(f, first, reach.get())))
                else:
                    suspect.set(f.any(f.load_row("%work", first + self.near.marks, LANES) > 0.0))
                    with f.when(suspect.get()):
                        suspect.set(f.any(self._suspect(f, first, reach.get())))
            end = first + LANES
            last = f.select(end > count, f.count(count), end)
            with f.when(suspect.get()), f.loop(first, last, tested=False) as j:
                if self.near is None:
                    yield j
                else:
                    with f.when((f.load("%work", j + self.near.marks) > 0.0) | (j >= whole)):
                        yield j

    def _any(self, f: Function, first: Integer, reach: Variable[Real]) -> Bit:
        """Whether any guard of a vector has to be looked at; those of one that is not whole have."""
        suspect = f.variable(Bit(f, "true"))
        with f.when(first < self.rows.side_by_side):
            suspect.set(f.any(self._suspect(f, first, reach.get())))
        return suspect.get()

    def _suspect(self, f: Function, first: Integer, reach: Real) -> Bit:
        """Which guards of a vector have to be looked at: whose arguments are near 0, or not known, in a step
        of ``reach``."""
        layout, term = self.layout, self.lengths.term
        row = self.lengths.place(f, first + self.rows.guards[0].row)
        mode = f.load_row("%state", first + self.rows.mode(layout), LANES)
        mark = f.load_row("%state", first + self.rows.fresh(layout), LANES)
        apart = self.roots.apart(f, row, reach, mode) & (mark <= 0.0) & (f.magnitude(mode) > 0.0)
        if self._rooted:
            u, rate = (f.load_row(row, m * term, LANES) * mode for m in (1, 2))
            apart = apart & ((rate <= 0.0) | (u / (rate + rate) * RADIUS >= f.splat(reach, LANES)))
        return ~apart

    def _look_at_multiplier(
        self, f: Function, j: Integer, look: Callable[[Pointer, Real, Real, Bit, Integer], None]
    ) -> None:
        """The time at which the force that holds the motion reaches its limit."""
        seen = Bit(f, "false")

        def against_one() -> None:
            row = self.lengths.place(f, f.load_integer("@guard_multipliers", j))
            bound = Real(f, "%unit")
            if self._resting:
                most = bound * (HELD - 1.0)
                at_limit = f.magnitude(f.magnitude(f.load(row, self.lengths.term)) - bound) <= most
                bound = f.select(at_limit, bound + most, bound)
            for side in (-1.0, 1.0):
                look(row, bound, f.constant(side), seen, j)

        if not any(one.limit for one in self.rows.guards):
            against_one()
            return
        limit = f.load_integer("@guard_limits", j)
        with f.when(limit.equals(0)):
            against_one()
        with f.otherwise():
            above, below = self.lengths.place(f, limit), self.lengths.place(f, limit + 1)
            both = f.load(above, self.lengths.term) + f.load(below, self.lengths.term)
            side = f.select(both < 0.0, f.constant(-1.0), f.constant(1.0))
            for row in (above, below):
                look(row, self._allowance(f, j, row, both), side, seen, j)

    def _allowance(self, f: Function, j: Integer, row: Pointer, both: Real) -> Real:
        """By how much a force, or the square of one, may exceed its limit, twice which is ``both``: if they
        are equal at the beginning, rounding does not decide."""
        nothing = f.constant(0.0)
        anywhere = self.rows.bound or self._resting
        if not (sliding(self.rows) or anywhere):
            return nothing
        most = f.magnitude(both) * (HELD - 1.0)
        at_limit = f.magnitude(f.load(row, self.lengths.term)) <= most
        if not anywhere:
            at_limit = at_limit & ~f.load_integer("@guard_vectors", j).equals(0)
        return f.select(at_limit, most, nothing)
