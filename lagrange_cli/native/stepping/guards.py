"""Guards in a step: which one's argument changes its sign first, and the change of its mode.

The arguments' quadratures are rows of the state, and their series known therefore. The parameters and the
modes are kept with the state, behind it: ``settings`` (see ``native.state``). The constants of the equations
are computed anew when a mode changes. An event's mode is the sign of its argument; what only has to be
recorded is copied behind ``%trial``, and ``%info`` counts the copies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import reduce
from operator import or_

from lagrange_cli.native.guards import BRIEF, LEFT, NOTES, NOWHERE, RECORDED, Role
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import table
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.state import Clock
from lagrange_cli.native.stepping.actions import NOTE
from lagrange_cli.native.stepping.at_once import LEAVES, UNCLEAR, hits
from lagrange_cli.native.stepping.guard_search import FROM_BOTH, GuardSearch
from lagrange_cli.native.stepping.near import NearPlaces
from lagrange_cli.native.stepping.passing import NEVER, kind_of, passing_tables
from lagrange_cli.native.stepping.steps import copy_function
from lagrange_cli.native.stepping.stopping import first_straight, stopping_tables
from lagrange_cli.records import dataclass

AWAY, CHANGED, NOTED = range(3)
"""The results of ``@flip``: the caller of ``@advance`` decides; other equations hold; the same ones do."""
JUMP = 2.0**-20
"""An argument on the wrong side that is this part of its change in a step has not been 0 just now."""
HARDLY = 2.0**-36, 2.0**-88
"""What moves by less than this part of the largest coordinate in a step may be moved by rounding errors."""
NEAR, MARGIN = 2.0**-60, 2.0**-40
"""Where numbers are more precise than doubles, in which roots are found, a step ends this part of it before
the root, and so do the next ones, until the root is so near."""
PART = 0.6
"""A companion divides steps to roots here: so it rounds the roots differently, even of the same
polynomials."""


@dataclass(frozen=True)
class GuardCode(GuardSearch):
    """Writes the functions that ``@advance`` calls for guards."""

    def functions(self) -> list[str]:
        """The functions."""
        roots = self.roots
        own = [self._first(), self._flip(), self._settled()]
        own += [first_straight(self.searched)] if self.stopping else []
        actions = self.actions.functions() if self.actions.any else []
        own += [roots.side()] if self.actions.any else []
        if self.rows.events:
            actions = [*actions, copy_function(self.layout, NOTE, self._unnoted)]
        guards = self.rows.guards
        tables = [
            table("guard_roles", [one.role for one in guards]),
            table("guard_rows", [one.row for one in guards]),
            table("guard_multipliers", [one.multiplier for one in guards]),
            *(
                [table("guard_limits", [one.limit for one in guards])]
                if any(one.limit for one in guards)
                else []
            ),
            table("guard_directions", [one.direction for one in guards]),
            *stopping_tables(self.rows),
            *(passing_tables(self.rows) if self.passing else []),
            *([table("guard_roots", self._roots)] if self._rooted else []),
            *([table("guard_jumps", [int(one.jumps) for one in guards])] if self._jumping else []),
            *(
                [table("guard_steep", [int(one.steep) for one in guards])]
                if self.interpolated and self.steep
                else []
            ),
        ]
        return [*tables, roots.text(), *actions, *(f.text() for f in own)]

    @property
    def _roots(self) -> list[int]:
        """Of each guard, on which side of 0 forces contain a root of its argument."""
        return [(FROM_BOTH + one.side) * one.rooted for one in self.rows.guards]

    @property
    def _jumping(self) -> bool:
        """Whether any event may be passed without being 0."""
        return any(one.jumps for one in self.rows.guards)

    def _flip(self) -> Function:
        """``@flip(state, constants, j, trial, info, work, sample)``: change the mode of a guard, or do what
        an event does, if that is simple: ``AWAY``, ``CHANGED`` or ``NOTED``."""
        given = "ptr %state, ptr %constants, i64 %j, ptr %trial, ptr %info, ptr %work, i64 %sample"
        f = Function(f"define internal i64 @flip({given}) #0")
        j, rows, layout, state = Integer(f, "%j"), self.rows, self.layout, f.pointer("%state")
        if rows.joined:
            first = self._first_of_all(f, j)
            with f.when(first.equals(LEAVES)):
                f.store(self.sides.mark(f), state, j + rows.fresh(layout))
                f.give(f.count(CHANGED))
            j = first
        role = f.load_integer("@guard_roles", j)
        mode, fresh = j + rows.mode(layout), j + rows.fresh(layout)
        before = f.load(state, mode)
        with f.when(role.equals(Role.SWITCH) & before.equals(0.0)):
            f.give(f.count(AWAY))
        with f.when(role.equals(Role.SWITCH) & self._has_jumped(f, j, before)):
            f.give(f.count(AWAY))
        with f.when(role.equals(Role.SWITCH)), f.when(self._hardly_moves(f, j)):
            f.give(f.count(AWAY))
        if self.passing:
            with f.when(role.equals(Role.HOLD)):
                with f.when(self._has_jumped(f, j, before)):
                    f.give(f.count(AWAY))
                places = f.pointer("%constants"), state, f.pointer("%work"), j
                with f.when(~f.call(Bit, "passes", *places)):
                    f.give(f.count(AWAY))
                f.store(self.sides.mark(f), state, fresh)
                f.give(f.count(CHANGED))
        result = f.variable(f.count(NOTED))
        if self.rows.events:
            self._note(f, role, j, before, result)
        else:
            result.set(f.count(CHANGED))
            with f.when(~(role.equals(Role.SWITCH) | role.equals(Role.CUT))):
                f.give(f.count(AWAY))
        f.store(-before, state, mode)
        f.store(self.sides.mark(f), state, fresh)
        with f.when(result.get().equals(CHANGED)):
            self.prepare(f, state)
        f.give(result.get())
        return f

    def _has_jumped(self, f: Function, j: Integer, mode: Real) -> Bit:
        """Whether the argument of a guard is on its other side, but has not been 0: it has jumped there, as
        over the cut of atan2."""
        row, term = self.lengths.place(f, f.load_integer("@guard_rows", j)), self.lengths.term
        u, rate = f.load(row, term), f.load(row, 2 * term)
        step = f.load(f.pointer("%state"), self.layout.at(Clock.STEP))
        return (u * mode < 0.0) & (f.magnitude(u) > f.magnitude(rate * step) * JUMP)

    def _hardly_moves(self, f: Function, j: Integer) -> Bit:
        """Whether coordinates hardly move at the rate with which the argument of a guard passes 0: then it
        may be nothing but rounding errors of forces that cancel, which the caller tells from a motion."""
        layout, state, lengths = self.layout, f.pointer("%state"), self.lengths
        row = lengths.place(f, f.load_integer("@guard_rows", j))
        rate, farthest = f.magnitude(f.load(row, 2 * lengths.term)), f.variable(f.constant(0.0))
        with f.loop(0, layout.degrees) as i:
            farthest.set(f.larger(farthest.get(), f.magnitude(f.load(state, i))))
        length = f.load(state, layout.at(Clock.LENGTH))
        return rate * length * length < farthest.get() * HARDLY[layout.parts - 1]

    def _first_of_all(self, f: Function, j: Integer) -> Integer:
        """The guard of the impact that comes first, if that of ``j`` is one of several now."""
        chosen, state = f.variable(j), f.pointer("%state")
        side = f.load(state, j + self.rows.mode(self.layout))
        event = side * f.load_integer("@guard_directions", j).to_real() <= 0.0
        with f.when(event & hits(f, j)):
            row = self.lengths.place(f, f.load_integer("@guard_rows", j))
            given = state, f.pointer("%constants"), j, f.pointer("%trial"), row
            first = f.call(Integer, "first_impact", *given)
            with f.when(first.equals(UNCLEAR)):
                f.give(f.count(AWAY))
            chosen.set(first)
        return chosen.get()

    def _note(self, f: Function, role: Integer, j: Integer, before: Real, result: Variable[Integer]) -> None:
        """Record an event, if it needs nothing else, and set the ``result`` of ``@flip``."""
        state, info, layout = f.pointer("%state"), f.pointer("%info"), self.layout
        with f.section() as changing:
            with f.when(role.equals(Role.SWITCH) | role.equals(Role.CUT)):
                result.set(f.count(CHANGED))
                changing.leave()
            leaving = (Role.HOLD, Role.REST, *self._breaks, *self._edges)
            with f.when(reduce(or_, [role.equals(one) for one in leaving])):
                f.give(f.count(AWAY))
            doubtful = role.equals(Role.RECORD)  # rounding leads there: the caller knows how large terms are
            if self._jumping:
                doubtful = doubtful | f.load_integer("@guard_jumps", j).equals(1)
            with f.when(doubtful & self._has_jumped(f, j, before)):
                f.give(f.count(AWAY))
            with f.when(before * f.load_integer("@guard_directions", j).to_real() > 0.0):
                changing.leave()
            count = f.load_integer(info, RECORDED)
            with f.when(role.equals(Role.ACTION) | ~(count < self.rows.records(layout))):
                f.give(f.count(AWAY))
            place = f.place("%trial", count * layout.memory + self.records)
            f.call(None, NOTE, state, place)
            term = self.lengths.term
            row = self.lengths.place(f, f.load_integer("@guard_rows", j))
            f.store(j.to_real(), place, layout.at(NOTES[0]))
            for m, note in enumerate(NOTES[1:], 2):
                rate = f.load(row, m * term) * float(m)
                if self.rows.joined:  # its time is that of others
                    again = (f.load(state, j + self.rows.fresh(layout)) > 0.0) & hits(f, j)
                    rate = f.select(again, f.constant(float(m == 2)), rate)
                f.store(rate, place, layout.at(note))
            if self.actions.any:
                with f.when(role.equals(Role.CHANGE)):
                    given = state, f.pointer("%constants"), j, f.pointer("%trial"), info
                    done = f.call(Integer, "change", *given, Integer(f, "%sample"), row)
                    with f.when(done.equals(LEFT)):
                        f.give(f.count(AWAY))
                    f.store(self.sides.mark(f), state, j + self.rows.fresh(layout))
                    f.give(f.count(CHANGED))
            f.store(count + 1, info, RECORDED)

    @property
    def _unnoted(self) -> Sequence[slice[int, int, None]]:
        """Places of the state that a record has not, where some are idle: besides these, modes and marks."""
        return (
            (*self.idle, slice(self.rows.mode(self.layout), self.layout.settings.stop)) if self.idle else ()
        )

    @property
    def passing(self) -> bool:
        """Whether compiled code finds out that the motion passes where it might be held. (Lists of guards
        would be lost with the series.)"""
        listed = self.near is not None and self.near.listed
        return not listed and any(kind_of(one) != NEVER for one in self.rows.guards)

    @property
    def holding(self) -> bool:
        """Whether a guard may hold the motion."""
        return any(one.role in (Role.HOLD, Role.REST) for one in self.rows.guards)

    def let_go(self, f: Function, state: Pointer, side: Real) -> None:
        """The equations in which nothing holds the motion of a state; arguments that it was held at have the
        sign ``side``."""
        with f.loop(0, self.rows.count, tested=False) as j:
            role, at = f.load_integer("@guard_roles", j), j + self.rows.mode(self.layout)
            mode = f.load(state, at)
            held = role.equals(Role.HOLD) & mode.equals(0.0)
            free = f.select(role.equals(Role.REST), f.constant(0.0), mode)
            f.store(f.select(held, side, free), state, at)
        self.prepare(f, state)

    @property
    def switches(self) -> bool:
        """Whether a guard is a switch that steps by series come to."""
        return not self.interpolated and self.any_switch

    @property
    def any_switch(self) -> bool:
        """Whether a guard is a switch."""
        return any(one.role is Role.SWITCH for one in self.rows.guards)

    def is_switch(self, f: Function, j: Integer) -> Bit:
        """Whether the guard ``j`` is a switch."""
        return f.load_integer("@guard_roles", j).equals(Role.SWITCH)

    def turn(self, f: Function, j: Integer) -> None:
        """The equations with the other mode of the guard ``j``."""
        state, mode = f.pointer("%state"), j + self.rows.mode(self.layout)
        f.store(-f.load(state, mode), state, mode)
        self.prepare(f, state)

    def modes(self, f: Function, state: Pointer) -> Pointer:
        """Where the modes of a state are."""
        return f.place(state, self.rows.mode(self.layout))

    def hold(self, f: Function, state: Pointer, modes: Pointer) -> None:
        """The equations of a state with these ``modes``."""
        with f.loop(0, self.rows.count, tested=False) as j:
            f.store(f.load(modes, j), self.modes(f, state), j)
        self.prepare(f, state)

    def prepare(self, f: Function, state: Pointer) -> None:
        """Compute the constants of the equations of a state."""
        f.call(None, "prepare", f.place(state, self.layout.settings.start), f.pointer("%constants"))

    def _settled(self) -> Function:
        """``@settled(state, h, work)``: after a step of ``h`` arguments that were 0 are so no more."""
        near = self.near if self.near and self.near.listed else None
        f = Function(
            f"define internal void @settled(ptr %state, double %h{', ptr %work' if near else ''}) #0"
        )
        h, place = Real(f, "%h"), self.layout.at(Clock.LENGTH)
        nowhere = f.magnitude(f.load("%state", self.layout.time)) * NOWHERE
        before = f.load("%state", place)
        f.store(f.select(h > f.larger(before * BRIEF, nowhere), h, before), "%state", place)
        with self._marked(f, near) as j:
            at = j + self.rows.fresh(self.layout)
            mark = f.load("%state", at)
            leads = (h > f.larger(mark * BRIEF, nowhere)) & (mark > 0.0)
            f.store(f.select(leads, f.constant(0.0), mark), "%state", at)
        f.give()
        return f

    @contextmanager
    def _marked(self, f: Function, near: NearPlaces | None) -> Iterator[Integer]:
        """All guards, or those that are near: others have no marks."""
        if near is None:
            with f.loop(0, self.rows.count, tested=False) as j:
                yield j
            return
        with near.eights(f, self.rows.count) as first, near.marked(f, first) as j:
            yield j
