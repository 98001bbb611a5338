"""Simple actions of events, done where a step has ended: new values of the state and of parameters.

An action is simple if no switch and no contact has to be chosen after it, and its own event's argument does
not change by it. Before and after it the state is recorded (``guards``)."""

from __future__ import annotations

from lagrange_cli.native.guards import AFTER, NOTES, RECORDED, RECORDS, SAMPLE, GuardRows, Role
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import table
from lagrange_cli.native.llvm.vector import Integer
from lagrange_cli.native.state import StateLayout
from lagrange_cli.records import dataclass

HUGE = 1.7976931348623157e308
DONE, LEFT = 1, 0
"""The results of ``@change``: it is done, or left to the caller of ``@advance``."""


@dataclass(frozen=True)
class ActionCode:
    """Writes ``@change``."""

    rows: GuardRows
    layout: StateLayout
    records: int

    @property
    def any(self) -> bool:
        """Whether there are simple actions."""
        return any(one.role is Role.CHANGE for one in self.rows.guards)

    def functions(self) -> list[str]:
        """Its IR."""
        moving, settings = self.layout.motion.stop, self.layout.settings.start
        places = [place if place < moving else settings + place - moving for _, place in self.rows.changed]
        tables = [
            table("changed_by", [guard for guard, _ in self.rows.changed]),
            table("changed_places", places),
            table("affected_by", [guard for guard, _ in self.rows.affected] or [-1]),
            table("affected", [guard for _, guard in self.rows.affected] or [0]),
        ]
        return [*tables, self._change().text()]

    def _change(self) -> Function:
        """``@change(state, constants, j, trial, info, sample)``: do what event ``j`` does, after so many
        samples."""
        given = "ptr %state, ptr %constants, i64 %j, ptr %trial, ptr %info, i64 %sample"
        f = Function(f"define internal i64 @change({given}) #0")
        rows, layout, j = self.rows, self.layout, Integer(f, "%j")
        state, info, left = f.pointer("%state"), f.pointer("%info"), f.count(LEFT)
        results = f.place("%trial", self.records + RECORDS * layout.memory)
        count, one = f.load_integer(info, RECORDED), f.count(1)
        with f.when(~(count + 1 < RECORDS)):
            f.give(left)
        time = f.place(state, layout.time)
        f.call(None, "act", f.pointer("%constants"), time, state, results, one, one)
        with f.loop(0, len(rows.changed), tested=False) as i:
            infinite = ~(f.magnitude(f.load(results, i)) <= HUGE)
            with f.when(f.load_integer("@changed_by", i).equals(j) & infinite):
                f.give(left)
        before, after = (f.place("%trial", (count + k) * layout.memory + self.records) for k in range(2))
        f.store(Integer(f, "%sample").to_real(), before, layout.at(SAMPLE))
        with f.loop(0, len(rows.changed), tested=False) as i:
            place = f.load_integer("@changed_places", i)
            with f.when(f.load_integer("@changed_by", i).equals(j)):
                f.store(f.load(results, i), state, place)
                with f.when(place < 2 * layout.degrees):
                    f.store(f.constant(0.0), state, place + layout.width)
        for k in range(layout.cyclic_momenta.start, layout.cyclic_momenta.stop):
            for part in (0, layout.width):  # they follow from the new velocities
                f.store(f.constant(0.0), state, k + part)
        f.call(None, "prepare", f.place(state, layout.settings.start), f.pointer("%constants"))
        with f.loop(0, max(1, len(rows.affected)), tested=False) as i:
            other = f.load_integer("@affected", i)
            with f.when(f.load_integer("@affected_by", i).equals(j)):
                f.store(f.constant(0.0), state, other + rows.mode(layout))
                f.store(f.constant(0.0), state, other + rows.fresh(layout))
        f.store(f.constant(0.0), state, j + rows.mode(layout))
        f.call(None, "copy", state, after)
        f.store(f.constant(AFTER), after, layout.at(NOTES[0]))
        f.store(count + 2, info, RECORDED)
        f.give(f.count(DONE))
        return f
