"""Guards in a step: which one's argument changes its sign first, and the change of its mode.

The arguments' quadratures are rows of the state, and their series known therefore. The parameters and the
modes are kept with the state, behind it: ``settings`` (see ``native.state``). The constants of the equations
are computed anew when a mode changes."""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.state import GuardRows, StateLayout
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.native.stepping.roots import NONE, Roots
from lagrange_cli.records import dataclass

NEAR, MARGIN = 2.0**-60, 2.0**-40
"""Where numbers are more precise than doubles, in which roots are found, a step ends this part of it before
the root, and so do the next ones, until the root is so near."""


@dataclass(frozen=True)
class GuardCode:
    """Writes what ``@advance`` calls for guards."""

    rows: GuardRows
    layout: StateLayout
    lengths: Lengths

    def functions(self) -> list[str]:
        """The functions."""
        roots = Roots(self.lengths.order, self.lengths.term)
        own = self._first(), self._flip(), self._settled()
        table = _table("guard_multipliers", self.rows.multipliers)
        return [table, roots.text(), *(f.text() for f in own)]

    def first(self, f: Function, h: Real, unit: Real) -> tuple[Real, Integer, Real]:
        """What ``@first_guard`` gives for a step of ``h``, in the ``unit`` of time of the series."""
        together = "{ double, i64, double }"
        listed = f"ptr %state, ptr %work, double {h.name}, double {unit.name}, ptr %trial"
        made = f.define(f"call {together} @first_guard({listed})")
        root, known = (Real(f, f.define(f"extractvalue {together} {made}, {i}")) for i in (0, 2))
        return root, Integer(f, f.define(f"extractvalue {together} {made}, 1"), 1), known

    def largest(self, f: Function) -> Real:
        """The sum of the last coefficients of all arguments: not finite where one of these is not."""
        total = f.variable(f.constant(0.0))
        with f.loop(0, self.rows.count, tested=False) as j:
            row = self._series(f, j + self.rows.first)
            for m in (self.lengths.order - 2, self.lengths.order - 1):
                total.set(total.get() + f.magnitude(f.load(row, m * self.lengths.term)))
        return total.get()

    def _series(self, f: Function, row: Integer | int) -> Pointer:
        """Where the series of a row is."""
        lengths = self.lengths
        at = row * lengths.row
        return f.place("%work", at + lengths.first if lengths.first else at, "double")

    def _first(self) -> Function:
        """``@first_guard(state, work, h, unit, scratch)``: when one is due in a step of ``h``, its
        number, and how much of the step is known."""
        given = "ptr %state, ptr %work, double %h, double %unit, ptr %scratch"
        f = Function(f"define internal {{ double, i64, double }} @first_guard({given}) #0")
        rows, layout = self.rows, self.layout
        earliest, which = f.variable(f.constant(NONE)), f.variable(f.count(0))
        reach = f.variable(Real(f, "%h"))

        def look(row: Pointer, start: Real, side: Real, fresh: Bit, j: Integer) -> None:
            reach.set(f.call(Real, "known", row, reach.get()))
            given = row, reach.get(), start, side, fresh, f.pointer("%scratch")
            found = f.call(Real, "first_root", *given)
            with f.when(found < earliest.get()):
                earliest.set(found)
                which.set(j)
                reach.set(f.larger(f.constant(0.0), f.smaller(found, reach.get())))

        with f.loop(0, rows.count, tested=False) as j:
            mode = f.load("%state", j + rows.mode(layout))
            fresh = f.load("%state", j + rows.fresh(layout)) > 0.0
            with f.when(mode.equals(0.0)):
                multiplier = f.load_integer("@guard_multipliers", j)
                for side in (-1.0, 1.0):
                    look(self._series(f, multiplier), Real(f, "%unit"), f.constant(side), Bit(f, "false"), j)
            with f.otherwise():
                look(self._series(f, j + rows.first), f.constant(0.0), mode, fresh, j)
        f.give(earliest.get(), which.get(), reach.get())
        return f

    def _flip(self) -> Function:
        """``@flip(state, constants, j)``: change the mode of a simple guard; whether it is one."""
        f = Function("define internal i1 @flip(ptr %state, ptr %constants, i64 %j) #0")
        j, rows, layout = Integer(f, "%j"), self.rows, self.layout
        with f.when(~f.load_integer("@guard_multipliers", j).equals(0)):
            f.give(Bit(f, "false"))
        f.store(-f.load("%state", j + rows.mode(layout)), "%state", j + rows.mode(layout))
        f.store(f.constant(1.0), "%state", j + rows.fresh(layout))
        f.call(None, "prepare", f.place("%state", layout.settings.start), f.pointer("%constants"))
        f.give(Bit(f, "true"))
        return f

    def _settled(self) -> Function:
        """``@settled(state)``: no argument is 0 any more."""
        f = Function("define internal void @settled(ptr %state) #0")
        with f.loop(0, self.rows.count, tested=False) as j:
            f.store(f.constant(0.0), "%state", j + self.rows.fresh(self.layout))
        f.give()
        return f


def _table(name: str, row: Sequence[int]) -> str:
    return f"@{name} = private constant [{len(row)} x i64] [{', '.join(f'i64 {x}' for x in row)}]\n"
