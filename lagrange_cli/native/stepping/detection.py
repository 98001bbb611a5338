"""Detection of functions that hide a narrow force (see ``mechanics.hidden_forces``).

Their arguments are followed, since these have convergent series. Where an argument changes much within a
step, the accelerations are computed at the places where such a function shows most: where its argument
crosses 0, is greatest, or nearest to 0. If they differ from those that the step's series predicts there, the
step goes at most half of the way."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from lagrange_cli.native.functions.correctly_rounded import exponential
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import literal, operand
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.stepping.search import crossing, greatest
from lagrange_cli.records import dataclass

CLOSE = 3.0
"""An argument may change by this much: no such function then grows by more than e^6."""
TAIL, BASE_TAIL = 0.1, 1e-9
"""The largest sum of the last two terms of an argument's series; for a base, relative to its size."""
PARTS = 16
"""Places of the step at which the argument is computed at first."""
HALVINGS = 50
"""How often a distance is halved, to the resolution of doubles."""
SHARP, ARGUMENT_SHARP = 2.0**-40, 2.0**6
"""Where a base is so small a part of what its series adds up, or such a part of what an argument's adds up
exceeds the other, their values are computed in place: the series has cancelled."""
TRIES = 1100
"""Any number halved this many times is 0."""
SEEN = 2.0**-40
"""The error with which an acceleration must be predicted, relative to its size, to its change and to what
would change the velocity in a step."""


class StepFunction(Function):
    """A function that is given a step, ``step``, and more: its series at ``%work``, and memory for another
    state and its series at ``%trial``."""

    def __init__(self, result: str, name: str, more: str) -> None:
        given = "ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work, ptr noalias %trial"
        super().__init__(f"define internal {result} @{name}({given}, {more}) #0")
        places = [self.pointer(f"%{name}") for name in ("constants", "state", "work", "trial")]
        self.t = Real(self, "%t")
        self.step = places[0], self.t, *places[1:]


@dataclass(frozen=True)
class Detection:
    """``@detected(step, h)``: ``h``, or at most half the distance to a force that the series does not
    contain.

    Series have coefficients up to ``order``, ``width`` doubles apart, and ``rows`` rows: q and v of so many
    ``degrees``, the quadratures of what is followed, with such ``powers`` (see ``mechanics.hidden_forces``),
    and others. Those of another state are at ``%trial[series]``, ``work`` doubles long. An error of the
    accelerations that moves a coordinate by less than ``least`` in a step is not seen.
    """

    order: int
    width: int
    rows: int
    degrees: int
    powers: tuple[float, ...]
    series: int
    work: int
    least: float

    @property
    def first(self) -> int:
        """The row of the first quadrature."""
        return 2 * self.degrees

    def text(self) -> str:
        """Its IR, if there is anything to follow."""
        if not self.powers:
            return ""
        growths = [exponential(2 * CLOSE / abs(power)) if power else 0.0 for power in self.powers]
        parts = [_table("hidden_powers", self.powers), _table("hidden_growths", growths)]
        parts += (self._followed(name) for name in ("argument", "slope"))
        return "".join([*parts, self._expand_at(), self._unseen(), self._hidden(), self._detected()])

    def descend(
        self,
        f: Function,
        row: Pointer | str,
        highest: int,
        lowest: int,
        add: Callable[[Real, Real, Integer], Real],
    ) -> Real:
        """The sum that ``add(sum, c[m], m)`` makes for m = highest .. lowest of the series at ``row``."""
        m, total = f.variable(f.count(highest)), f.variable(f.constant(0.0))
        with f.forever() as rounds:
            total.set(add(total.get(), f.load(row, m.get() * self.width), m.get()))
            m.set(m.get() - 1)
            rounds.repeat(m.get() >= lowest)
        return total.get()

    def _followed(self, name: str) -> str:
        """The argument u, or its slope, at ``x`` in the step: of its quadrature, c[m] = u[m - 1] / m."""
        f, lowest = Function(f"define internal double @{name}(ptr noalias %row, double %x) #0"), 1
        if name == "slope":
            lowest = 2

        def add(total: Real, c: Real, m: Integer) -> Real:
            u = c * m.to_real()
            return f.fused(total, Real(f, "%x"), u if lowest == 1 else u * (m - 1).to_real())

        f.give(self.descend(f, "%row", self.order - 1, lowest, add))
        return f.text()

    def _expand_at(self) -> str:
        """The series at the state that the step's series gives at ``x``; whether the mass matrix is regular
        there."""
        f = StepFunction("i1", "expand_at", "double %x")
        x, trial, there = Real(f, "%x"), f.pointer("%trial"), f.place("%trial", self.series)
        f.call(None, "clear", trial, f.count(2 * self.width))
        f.call(None, "clear", there, f.count(self.work))
        with f.loop(0, self.rows, tested=False) as i:
            row = f.place("%work", i)
            moved = self.descend(f, row, self.order, 1, lambda total, c, _: (total + c) * x)
            f.store(f.load("%state", i) + moved, trial, i)
        f.give(f.call(Bit, "jet", f.step[0], f.t + x, trial, there))
        return f.text()

    def rate(self, f: Function, row: Integer) -> Real:
        """The rate of a row as it was computed in place."""
        return f.load("%trial", row + (self.series + self.width))

    def _unseen(self) -> str:
        """Whether the rates of velocities and quadratures at ``x`` in a step of ``h`` differ from those that
        its series predicts. (nan differs, too.)"""
        f = StepFunction("i1", "unseen", "double %x, double %h")
        x, h, followed = Real(f, "%x"), Real(f, "%h"), len(self.powers)
        with f.when(~f.call(Bit, "expand_at", *f.step, x)):
            f.give(Bit(f, "true"))
        inverse = f.constant(SEEN) / h
        nothing = f.constant(self.least) / (h * f.function("maxnum", h, 1.0))
        with f.loop(self.degrees, self.rows - followed, tested=False) as i:
            j = f.select(i < self.first, i, i + followed)
            row = f.place("%work", j)
            rate = self.descend(
                f, row, self.order - 1, 1, lambda total, c, m: f.fused(total, x, c * m.to_real())
            )
            change = f.magnitude(rate) + f.magnitude(f.load(row, self.width))
            allowed = f.fused(f.magnitude(f.load("%state", j)), inverse, change * SEEN) + nothing
            with f.when(~(f.magnitude(self.rate(f, j) - rate) <= allowed)):
                f.give(Bit(f, "true"))
        f.give(Bit(f, "false"))
        return f.text()

    def _hidden(self) -> str:
        """The place in a step of ``h`` at which row ``which`` reveals a force that the series does not
        contain, or 0."""
        f = StepFunction("double", "hidden", "i64 %which, double %h")
        which, h, nowhere = Integer(f, "%which"), Real(f, "%h"), f.constant(0.0)
        row = Followed(self, f, which, h)
        signed, growth = (f.load(f"@hidden_{name}", which - self.first) for name in ("powers", "growths"))
        power = f.magnitude(signed)
        is_base = power > 0.0

        start = row.value(nowhere)
        near, far = f.magnitude(start), row.change(self.order - 1)
        unit = f.select(is_base, near, f.constant(1.0))
        with f.when(~(f.select(is_base, far * power, far) > unit * CLOSE)):
            f.give(nowhere)
        # its own series must have converged
        reached = near + far
        tail = f.select(is_base, reached * BASE_TAIL, f.constant(TAIL))
        with f.when(~(far - row.change(self.order - 3) <= tail)):
            f.give(h)

        before, most, least, largest = (f.variable(x) for x in (start, start, near, near))
        at_most, at_least, at_cross = (f.variable(f.count(0)) for _ in range(3))
        with f.loop(1, PARTS + 1, tested=False) as k:
            u = row.value(row.part * k.to_real())
            size = f.magnitude(u)
            more, less = u > most.get(), size < least.get()
            crosses = (before.get() < 0.0).compared("ne", u < 0.0) & at_cross.get().equals(0)
            before.set(u)
            most.set(f.select(more, u, most.get()))
            at_most.set(f.select(more, k, at_most.get()))
            least.set(f.select(less, size, least.get()))
            at_least.set(f.select(less, k, at_least.get()))
            largest.set(f.function("maxnum", largest.get(), size))
            at_cross.set(f.select(crosses, k, at_cross.get()))
        with f.when(largest.get() < least.get() * growth):
            f.give(nowhere)

        def look(x: Real) -> None:
            value = f.magnitude(row.value(x))
            with f.when(row.unseen_about(x, f.select(is_base, value / power, f.constant(1.0)))):
                f.give(x)

        any_cross, nearest = at_cross.get() > 0, row.extremum(at_least.get())
        rounded = reached * SHARP
        cancels = any_cross | (f.magnitude(row.value(nearest)) < rounded)
        with f.when(f.select(is_base, (signed < 0.0) & cancels, rounded > ARGUMENT_SHARP)):
            found = row.unseen_in_place(lambda u: -f.magnitude(u))
            with f.when((found > 0.0) | is_base):
                f.give(found)
            f.give(row.unseen_in_place(lambda u: u))
        with f.when(any_cross):
            look(row.crossing(at_cross.get()))
        highest = row.extremum(at_most.get())
        with f.when(highest > 0.0):
            look(highest)
        with f.when(at_least.get().compared("ne", at_most.get()) & ~any_cross & (nearest > 0.0)):
            look(nearest)
        f.give(nowhere)
        return f.text()

    def _detected(self) -> str:
        f = StepFunction("double", "detected", "double %h")
        length = f.variable(Real(f, "%h"))
        with f.loop(0, TRIES, tested=False), f.section() as shorter:
            with f.loop(self.first, self.first + len(self.powers), tested=False) as which:
                place = f.call(Real, "hidden", *f.step, which, length.get())
                with f.when(~place.equals(0.0)):
                    length.set(place * 0.5)
                    shorter.leave()
            f.give(length.get())
        f.give(length.get())
        return f.text()


class Followed:
    """What is followed in row ``which``, in a step of ``h``, while the search for a place is written.

    The step has ``PARTS`` parts; their ends are places 0 to ``PARTS``."""

    def __init__(self, detection: Detection, f: StepFunction, which: Integer, h: Real) -> None:
        self._detection, self._f, self._which, self._h = detection, f, which, h
        self._row = f.place("%work", which)
        self.part = h * (1.0 / PARTS)

    def value(self, x: Real) -> Real:
        """The argument at ``x``, by its series."""
        return self._f.call(Real, "argument", self._row, x)

    def change(self, highest: int) -> Real:
        """A bound of its change within the step, from the terms up to ``highest``."""
        f, h = self._f, self._h
        return self._detection.descend(
            f, self._row, highest, 2, lambda total, c, m: (total + f.magnitude(c) * m.to_real()) * h
        )

    def crossing(self, k: Integer) -> Real:
        """Its zero before place ``k``."""
        start = self.part * (k - 1).to_real()
        return crossing(self._f, lambda x: self.value(x) < 0.0, start, self.part)

    def extremum(self, k: Integer) -> Real:
        """The place of an extremum around place ``k``, or that place if there is none."""
        f, (start, end) = self._f, self._around(k)

        def falls(x: Real) -> Bit:
            return f.call(Real, "slope", self._row, x) < 0.0

        found = f.variable(self.part * k.to_real())
        with f.when(falls(start).compared("ne", falls(end))):
            found.set(crossing(f, falls, start, end - start))
        return found.get()

    def unseen_about(self, x: Real, enough: Real) -> Bit:
        """Whether the series is wrong at ``x``, or where the argument differs by ``enough``, so that the
        function is about 3 times smaller or larger: at its maximum a force may be 0."""
        f, here = self._f, self.value(x)
        back = f.variable(x)
        with f.section() as search, f.loop(0, HALVINGS, tested=False):
            back.set(back.get() * 0.5)
            with f.when(~(f.magnitude(self.value(x - back.get()) - here) > enough)):
                search.leave()
        found = f.variable(self._unseen(x - back.get()))
        with f.when(~found.get()):
            found.set(self._unseen(x))
        return found.get()

    def unseen_in_place(self, shown: Callable[[Real], Real]) -> Real:
        """Where the function shows most, by the argument as it is computed in place: a place before which the
        series is wrong, or 0."""
        f, detection = self._f, self._detection

        def value(x: Real) -> Real:
            f.call(Bit, "expand_at", *f.step, x)
            return shown(detection.rate(f, self._which))

        best, at = f.variable(f.constant(float("-inf"))), f.variable(f.count(0))
        with f.loop(0, PARTS + 1, tested=False) as k:
            found = value(self.part * k.to_real())
            more = found > best.get()
            best.set(f.select(more, found, best.get()))
            at.set(f.select(more, k, at.get()))
        start, end = self._around(at.get())
        there = greatest(f, value, start, end - start)
        back, result = f.variable(there), f.variable(f.constant(0.0))
        with f.section() as search, f.loop(0, HALVINGS + 1, tested=False):
            back.set(back.get() * 0.5)
            with f.when(self._unseen(there - back.get())):
                result.set(there)
                search.leave()
        return result.get()

    def _unseen(self, x: Real) -> Bit:
        return self._f.call(Bit, "unseen", *self._f.step, x, self._h)

    def _around(self, k: Integer) -> tuple[Real, Real]:
        """The ends of what is within a part of place ``k``."""
        f, x = self._f, self.part * k.to_real()
        return f.function("maxnum", x - self.part, 0.0), f.function("minnum", x + self.part, self._h)


def _table(name: str, row: Sequence[float]) -> str:
    listed = ", ".join(f"double {operand(literal(x))}" for x in row)
    return f"@{name} = private constant [{len(row)} x double] [{listed}]\n"
