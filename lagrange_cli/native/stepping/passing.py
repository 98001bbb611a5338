"""Whether a motion clearly passes u = 0, where a force that jumps there may hold it.

It does if neither of two forces stops it: that which would hold it exceeds its bound, or it has a velocity
across u = 0; and that of the other side leads on. Whatever is not far above rounding is left to the caller
(``integrate.guards.settling``), as are several arguments that are 0 at one time.
"""

from __future__ import annotations

from collections.abc import Callable

from lagrange_cli.native.guards import GuardRow, GuardRows, Role
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import table
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.state import Clock, StateLayout
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.records import dataclass

CLEAR = 2.0**-40
"""A rate that is more than this part of all accelerations is no rounding error."""
EXCEEDS = 1.0 + 2.0**-30
"""A multiplier beyond this is more than the force that jumps can be."""
NEVER, TRIED, PLACED = range(3)
"""Compiled code does not look at a guard; it finds out what would hold the motion; or need not, as the
argument is a place."""


def kind_of(guard: GuardRow) -> int:
    """Which of these it is. Friction along vectors, or on members alone, holds the motion whenever it can."""
    if guard.role is not Role.HOLD or guard.pivots or guard.explicit:
        return NEVER
    return PLACED if guard.placed else TRIED


def passing_tables(rows: GuardRows) -> list[str]:
    """The kinds of all guards, and the events that may have no side."""
    kinds = table("passing", [kind_of(one) for one in rows.guards])
    return [kinds, table("standing", rows.standing)] if rows.standing else [kinds]


@dataclass(frozen=True)
class Passing:
    """Writes ``@passes``. ``compute`` puts the series of the state where they belong, in the unit of time;
    ``prepare`` the constants of the equations."""

    rows: GuardRows
    layout: StateLayout
    lengths: Lengths
    compute: Callable[[Function], Bit]
    prepare: Callable[[Function, Pointer], None]

    def function(self) -> Function:
        """``@passes(constants, state, work, j)``: whether the motion passes u = 0 at guard ``j``. Then its
        mode and the constants are those of the other side, else they are as before. The series are lost."""
        f = Function("define internal i1 @passes(ptr %constants, ptr %state, ptr %work, i64 %j) #0")
        rows, j, state = self.rows, Integer(f, "%j"), f.pointer("%state")
        place, kind = j + rows.mode(self.layout), f.load_integer("@passing", j)
        before = f.load(state, place)
        with f.when(kind.equals(NEVER) | before.equals(0.0) | self._others(f, j)):
            f.give(f.never(1))

        def tried(mode: Real) -> tuple[Real, Real]:
            """With this mode, the rate of the argument, and what is rounding beside accelerations."""
            f.store(mode, state, place)
            self.prepare(f, state)
            self.compute(f)
            total = f.variable(f.constant(0.0))
            with f.loop(self.layout.degrees, 2 * self.layout.degrees, tested=False) as i:
                total.set(total.get() + f.magnitude(self._coefficient(f, i, 1)))
            return self._coefficient(f, f.load_integer("@guard_rows", j), 2), total.get() * CLEAR

        free = f.variable(kind.equals(PLACED))
        with f.when(~free.get()):
            rate, least = tried(f.constant(0.0))
            force, most = self._force(f, j)
            free.set((f.magnitude(rate) > least) | (f.magnitude(force) > most * EXCEEDS))
        beyond, least = tried(-before)
        with f.when(free.get() & (-(before * beyond) > least)):
            f.give(~f.never(1))
        f.store(before, state, place)
        self.prepare(f, state)
        f.give(f.never(1))
        return f

    def _coefficient(self, f: Function, row: Integer, m: int) -> Real:
        """The derivative of the integral in a row, divided by (m - 1)!."""
        return f.load(self.lengths.place(f, row), m * self.lengths.term) * float(m)

    def _force(self, f: Function, j: Integer) -> tuple[Real, Real]:
        """What holds the motion, and how much of it there may be."""
        force, most = self._coefficient(f, f.load_integer("@guard_multipliers", j), 1), f.constant(1.0)
        if any(one.limit for one in self.rows.guards):
            limit = f.load_integer("@guard_limits", j)
            limited = ~limit.equals(0)
            first = f.select(limited, limit, f.count(self.layout.degrees))
            above, below = (self._coefficient(f, first + k, 1) for k in range(2))
            force = f.select(limited, above - below, force)
            most = f.select(limited, f.magnitude(above + below), most)
        return force, most

    def _others(self, f: Function, j: Integer) -> Bit:
        """Whether something else has a say: other arguments that are 0 now, events that have no side while
        the motion stands still, or so many changes that the motion may be held by them."""
        rows, layout, state = self.rows, self.layout, f.pointer("%state")
        found = f.variable(f.load(state, layout.at(Clock.PASSES)) >= rows.changes)
        with f.loop(0, rows.switches, tested=False) as k:
            fresh = f.load(state, k + rows.fresh(layout)) > 0.0
            found.set(found.get() | (fresh & ~k.equals(j)))
        if rows.standing:
            with f.loop(0, len(rows.standing), tested=False) as n:
                side = f.load(state, f.load_integer("@standing", n) + rows.mode(layout))
                found.set(found.get() | side.equals(0.0))
        return found.get()
