"""Sides of events after actions, where arguments have not come through 0."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from lagrange_cli.native.guards import SMALLEST, GuardRows, Role
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Real
from lagrange_cli.native.state import Clock, StateLayout
from lagrange_cli.native.stepping.at_once import NOTHING
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class EventSides:
    """Writes the code for them, in a step of ``%h`` of a state."""

    rows: GuardRows
    layout: StateLayout
    lengths: Lengths

    def decide(self, f: Function, j: Integer) -> None:
        """Set the mode of an event that has none since an action has been done."""
        rows, layout, state = self.rows, self.layout, f.pointer("%state")
        mode, mark = j + rows.mode(layout), j + rows.fresh(layout)
        undecided = f.load(state, mode).equals(0.0)
        if rows.bounces:  # contacts have no other mode, and events at which members rest
            rests = f.load_integer("@rests_at", j)
            held = f.load(state, f.select(rests.equals(NOTHING), j, rests) + rows.mode(layout))
            rest = f.load_integer("@guard_roles", j).equals(Role.REST)
            undecided = undecided & held.equals(0.0) & ~rest
        if rows.switches:
            undecided = undecided & ~(j < rows.switches)
        with f.when(undecided), self._if_nothing_holds(f):
            row = self.lengths.place(f, f.load_integer("@guard_rows", j))
            fresh = f.load(state, mark) > 0.0
            scratch = f.pointer("%scratch")
            _, size = f.parts((Real, Real), "known", row, Real(f, "%h"), scratch)
            side = f.call(Real, "side_of", scratch, size, fresh)
            f.store(side, state, mode)
            with f.when(f.load(row, self.lengths.term).equals(0.0)):
                f.store(self.mark(f), state, mark)

    @contextmanager
    def _if_nothing_holds(self, f: Function) -> Iterator[None]:
        """What is done if no switch holds the motion: where one does, events may have no side."""
        held, modes = f.variable(f.never(1)), self.rows.mode(self.layout)
        if not self.rows.switches:
            yield
            return
        with f.loop(0, self.rows.switches, tested=False) as k:
            held.set(held.get() | f.load("%state", k + modes).equals(0.0))
        with f.when(~held.get()):
            yield

    def mark(self, f: Function) -> Real:
        """The mark of an argument that is 0 now."""
        return f.larger(f.load("%state", self.layout.at(Clock.LENGTH)), f.constant(SMALLEST))
