"""Simple actions of events, done where a step has ended: new values of the state and of parameters.

An action is simple if no switch and no contact has to be chosen after it, and its own event's argument does
not change by it. Before and after it the state is recorded (``guards``)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from itertools import accumulate
from typing import TYPE_CHECKING

from lagrange_cli.native.guards import AFTER, DONE, LEFT, NOTES, RECORDED, SAMPLE, SMALL, GuardRows, Role
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import table
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.state import Clock, StateLayout
from lagrange_cli.native.stepping.at_once import NOTHING, AtOnce, hits, without_auxiliary, write_speeds
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.native.stepping.bounces import Bounces
    from lagrange_cli.native.stepping.coming_to_rest import ComingToRest

HUGE = 1.7976931348623157e308
ALONE = "act_alone"
"""The function that gives what one event's action sets, if there is one."""
PUSH = "push"
"""The function that sets what an event's action sets, and lets constraints act that have impulses then."""
NOTE = "note"
"""The function that copies a state into a record."""
SAME = 2.0**-46
"""Zeros within this part of the time, or of a step, are at the same time (``integrate.impacts.sides``)."""


@dataclass(frozen=True)
class ActionCode:
    """Writes ``@change``."""

    rows: GuardRows
    layout: StateLayout
    records: int
    term: int
    """Doubles from a coefficient of an argument to the next one."""
    alone: bool = False
    """Whether ``@act_alone`` gives what one event's action sets. Then what events do is looked up, too."""
    row: int = 1
    """The same from an argument to the next one."""
    interpolated: bool = False
    """Whether series are polynomials through values. Then the caller decides on flights that these may not
    show."""

    @property
    def any(self) -> bool:
        """Whether there are simple actions."""
        return any(one.role is Role.CHANGE for one in self.rows.guards)

    def functions(self) -> list[str]:
        """Its IR."""
        moving, settings = self.layout.motion.stop, self.layout.settings.start
        places = [place if place < moving else settings + place - moving for _, place in self.rows.changed]
        changed, affected = ([guard for guard, _ in one] for one in (self.rows.changed, self.rows.affected))
        tables = [
            table("changed_by", changed),
            table("changed_places", places),
            table("affected_by", affected or [-1]),
            table("affected", [guard for _, guard in self.rows.affected] or [0]),
        ]
        if self.alone:
            for name, guards in (("changed", changed), ("affected", affected)):
                order = sorted(range(len(guards)), key=guards.__getitem__)
                each = Counter(guards)
                starts = accumulate((each[j] for j in range(self.rows.count)), initial=0)
                tables += [table(f"{name}_first", [*starts]), table(f"{name}_order", order or [0])]
        if self.rows.bounces:
            numbers = {guard: k for k, (guard, _) in enumerate(self.rows.bounces)}
            rests = dict(self.rows.bounces)
            every = range(self.rows.count)
            tables.append(table("bounces", [numbers.get(j, NOTHING) for j in every]))
            tables.append(table("rests_at", [rests.get(j, NOTHING) for j in every]))
        if self.rows.reached:
            listed = sorted(self.rows.reached)
            each = Counter(guard for guard, _ in listed)
            starts = accumulate(each.values(), initial=0)
            tables.append(table("touching", [*each]))
            tables.append(table("reached_first", [*starts]))
            tables.append(table("reached", [self.layout.degrees + place for _, place in listed]))
            if self.rows.joined:
                tables.append(table("moved", [self._moved(place) for _, place in self.rows.changed]))
        own = [self.at_once.first(self._acted).text()] if self.rows.joined else []
        return [*tables, *own, self._change().text()]

    @property
    def at_once(self) -> AtOnce:
        """The code for impacts at one time."""
        own = partial(self._own, name="changed", count=len(self.rows.changed))
        return AtOnce(
            self.rows, self.layout, self.term, self.row, lambda f, j: own(f, j=j), self._behind_actions
        )

    @property
    def rest(self) -> ComingToRest:
        """The code for impacts after which the motion rests."""
        from lagrange_cli.native.stepping.coming_to_rest import ComingToRest

        own = partial(self._own, name="changed", count=len(self.rows.changed))
        return ComingToRest(self.rows, self.layout, self.interpolated, lambda f, j: own(f, j=j), self._acted)

    @property
    def bounces(self) -> Bounces:
        """The code for what impacts leave."""
        from lagrange_cli.native.stepping.bounces import Bounces

        given = self.rows, self.layout, self.term, self.interpolated
        return Bounces(*given, self.at_once, rests=self.rest.possible)

    def _change(self) -> Function:
        """``@change(state, constants, j, trial, info, sample, row)``: do what event ``j`` does, after so many
        samples. The series of its argument is at ``row``."""
        given = "ptr %state, ptr %constants, i64 %j, ptr %trial, ptr %info, i64 %sample, ptr %row"
        f = Function(f"define internal i64 @change({given}) #0")
        rows, layout, j = self.rows, self.layout, Integer(f, "%j")
        state, info, left = f.pointer("%state"), f.pointer("%info"), f.count(LEFT)
        count = f.load_integer(info, RECORDED)
        with f.when(~(count + 1 < rows.records(layout))):
            f.give(left)
        if rows.switches:
            with f.when(self._switching(f, j)):
                f.give(left)
        if rows.events > 1 and not self.alone:
            with f.when(self._others(f, j)):
                f.give(left)
        results = self._acted(f, j)
        changed = "changed", len(rows.changed), j
        with self._own(f, *changed) as i, f.when(~(f.magnitude(f.load(results, i)) <= HUGE)):
            f.give(left)
        known = None
        if rows.bounces:
            if rows.joined:
                known = self.at_once.speeds(f, j, results)
            if rows.reached:
                apart = Bit(f, "true") if known is None else ~hits(f, j)
                with f.when(apart), self.at_once.touching(f, j, results):
                    f.give(left)
            bounce = self.bounces.of(f, j, results, known)
        before, after = (f.place("%trial", (count + k) * layout.memory + self.records) for k in range(2))
        f.store(Integer(f, "%sample").to_real(), before, layout.at(SAMPLE))
        if known is not None:
            speeds = f.place(results, self._behind_actions, "double")
            arrays = f.pointer("%constants"), state, results, speeds
            with f.when(f.call(Integer, PUSH, *arrays, j - rows.first_event).equals(LEFT)):
                f.give(left)
            settles = f.variable(f.never(1))
            if self.rest.possible:
                # other forces may act where it ends other contacts: they do not lead back as those before it
                freed = bounce.last & self.at_once.frees(f, j, speeds, results, known)
                with f.when((bounce.still | (bounce.last & ~freed)) & hits(f, j)):
                    drags = self.rest.stop(f, j, before, bounce, known)
                    write_speeds(f, rows, layout, results, speeds)
                    settles.set(bounce.still | ~drags)
            resting = bounce.rests, settles.get()
            clear, holds = self.at_once.release(f, j, speeds, results, known, *resting)
            with f.when(~clear):
                for first in (0, layout.width):
                    f.copy_rows((before, first), (state, first), 2 * layout.degrees, 1)
                f.give(left)
        else:
            with self._own(f, *changed) as i:
                place = f.load_integer("@changed_places", i)
                f.store(f.load(results, i), state, place)
                with f.when(place < 2 * layout.degrees):
                    f.store(f.constant(0.0), state, place + layout.width)
        if rows.bounces:
            self.bounces.note_time(f, j)
        for k in range(layout.cyclic_momenta.start, layout.cyclic_momenta.stop):
            for part in (0, layout.width):  # they follow from the new velocities
                f.store(f.constant(0.0), state, k + part)
        with self._own(f, "affected", max(1, len(rows.affected)), j) as i:
            other = f.load_integer("@affected", i)
            f.store(f.constant(0.0), state, other + rows.mode(layout))
            f.store(f.constant(0.0), state, other + rows.fresh(layout))
        own = j + rows.mode(layout)
        side = f.constant(0.0)
        if self.interpolated and rows.bounces:  # its speed tells, which long polynomials show less precisely
            impact = ~f.load_integer("@bounces", j).equals(NOTHING)
            side = f.select(impact, f.load(state, own), side)
        if rows.joined:  # where it has no speed, rounding would tell
            side = f.select(hits(f, j), f.load(state, own), side)
        f.store(side, state, own)
        if self.rest.possible:
            with f.when(holds):
                self.rest.hold(f, j, side)
        f.call(None, "prepare", f.place(state, layout.settings.start), f.pointer("%constants"))
        f.call(None, NOTE, state, after)
        f.store(f.constant(AFTER), after, layout.at(NOTES[0]))
        if rows.joined:
            self.rest.note(f, after, bounce, holds)
        f.store(count + 2, info, RECORDED)
        f.give(f.count(DONE))
        return f

    def _switching(self, f: Function, j: Integer) -> Bit:
        """Whether modes of switches may have to be chosen after an action: where an argument is 0 up to
        rounding, or the motion is held there."""
        rows, layout, state = self.rows, self.layout, f.pointer("%state")
        largest, found = f.variable(f.constant(0.0)), f.variable(f.never(1))
        with f.loop(0, layout.degrees, tested=False) as i:
            largest.set(f.larger(f.magnitude(f.load(state, i)), largest.get()))

        def value(k: Integer) -> Real:
            return self.at_once.coefficient(f, f.pointer("%row"), j, k, 1)

        with f.loop(0, rows.switches, tested=False) as k:
            largest.set(f.larger(f.magnitude(value(k)), largest.get()))
        with f.loop(0, rows.switches, tested=False) as k:
            mode, mark = (f.load(state, k + place(layout)) for place in (rows.mode, rows.fresh))
            at_zero = (mark > 0.0) | ~(value(k) * mode > largest.get() * SMALL)
            found.set(found.get() | at_zero)
        return found.get()

    def _others(self, f: Function, j: Integer) -> Bit:
        """Whether other arguments than those of impacts are 0 at the same time: the action may change their
        way."""
        rows, layout, state = self.rows, self.layout, f.pointer("%state")
        long = f.larger(f.magnitude(f.load(state, layout.time)), f.load(state, layout.at(Clock.STEP)))
        time, found = long * SAME, f.variable(f.never(1))
        first = rows.first_event
        with f.loop(first, first + rows.events, tested=False) as k:
            mode, mark = (f.load(state, k + place(layout)) for place in (rows.mode, rows.fresh))
            u, rate = (self.at_once.coefficient(f, f.pointer("%row"), j, k, m) for m in (1, 2))
            now, ahead, fresh = f.magnitude(u) <= f.magnitude(rate) * time, rate * mode, mark > 0.0
            due = now & (((ahead < 0.0) & ~fresh) | ((ahead > 0.0) & fresh)) & ~k.equals(j)
            if rows.bounces:
                due = due & f.load_integer("@bounces", k).equals(NOTHING)
            found.set(found.get() | due)
        return found.get()

    def _moved(self, place: int) -> int:
        """What moves with a velocity that is set, where constraints couple it with others."""
        rows, n = self.rows, self.layout.degrees
        return n + rows.joined[place - n] if n <= place < 2 * n else place

    @contextmanager
    def _own(self, f: Function, name: str, count: int, j: Integer) -> Iterator[Integer]:
        """A loop over those of ``count`` entries of a table that are by guard ``j``."""
        if not self.alone:
            with f.loop(0, count, tested=False) as i, f.when(f.load_integer(f"@{name}_by", i).equals(j)):
                yield i
            return
        first, last = (f.load_integer(f"@{name}_first", one) for one in (j, j + 1))
        with f.loop(first, last) as k:
            yield f.load_integer(f"@{name}_order", k)

    @property
    def _behind_actions(self) -> int:
        """How many numbers ``@act`` gives: rates of contacts' arguments follow, and the length of a step."""
        return len(self.rows.changed) + 2 * self.rows.events + len(self.rows.bounces)

    def _acted(self, f: Function, j: Integer | None = None) -> Pointer:
        """Compute what the actions of all events set, or that of one if it can be done alone."""
        rows, layout, state = self.rows, self.layout, f.pointer("%state")
        results = f.place("%trial", self.records + rows.records(layout) * layout.memory)
        time, one = f.place(state, layout.time), f.count(1)
        if rows.degrees < layout.degrees:
            state = without_auxiliary(f, rows, layout, results)
            results = f.place(results, 2 * rows.degrees, "double")
        if self.alone and not rows.reached and j is not None:
            f.call(None, ALONE, f.pointer("%constants"), time, state, results, j - rows.first_event)
        else:
            f.call(None, "act", f.pointer("%constants"), time, state, results, one, one)
        return results
