"""Quadratures in double-double (see ``quadratures``): the series of a part have their own unit of time."""

from __future__ import annotations

from collections.abc import Callable

from lagrange_cli.native.llvm.function import Function, Variable
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.numbers.double_double import TYPE
from lagrange_cli.native.stepping.acceptance import Bounds, allowance
from lagrange_cli.native.stepping.lengths import Lengths, Row
from lagrange_cli.native.stepping.quadratures import NAN, Part, Places, Quadratures, Time
from lagrange_cli.native.stepping.step_size import ENDLESS

WIDE = 2.0**12
"""If a part is so many times longer than the unit of its series, coefficients were lost and are computed
again."""
NARROWER, NARROWEST = 2.0**-32, 2.0**-300
"""The factor for the unit if coefficients overflow, and its lower limit."""
EXPONENT = 0x7FF0000000000000


def apply(f: Function, name: str, *arguments: Real) -> tuple[Real, Real]:
    """A sum or product of numbers (see ``numbers.double_double``)."""
    listed = ", ".join(f"double {one.name}" for one in arguments)
    made = f.define(f"call {TYPE} @{TYPE[1:]}_{name}({listed})")
    high, low = (Real(f, f.define(f"extractvalue {TYPE} {made}, {i}")) for i in (0, 1))
    return high, low


class PairQuadratures(Quadratures):
    """The same for numbers of two parts. ``expand`` computes the series of parts in ``unit``; those of the
    step have the unit ``whole``."""

    unit: Variable[Real]
    whole: Real
    again: Callable[[], None]

    def __init__(
        self, lengths: Lengths, first: int, count: int, low: int, tolerance: float, bounds: Bounds,
        beyond: int, third: int, rest: float,
    ) -> None:  # fmt: skip
        super().__init__(lengths, first, count, low, tolerance, bounds, fades=False, rest=rest)
        self._beyond, self._third = beyond, third

    @property
    def alone(self) -> bool:
        return False

    def sum(self, f: Function, name: str, row: Row, work: Pointer, h: Time, unit: Real) -> Time:
        """A series of ``work`` summed at ``h``."""
        inverse, zero = f.constant(1.0) / unit, f.constant(0.0)
        place = row.series(work).place
        high, low = f.parts(name, [zero, zero], place, h[0] * inverse, h[1] * inverse)
        return (high * inverse, low * inverse) if name == "slope" else (high, low)

    def go(self, f: Function, at: Places, place: Time) -> None:
        with self.lengths.each(f) as row, f.when(~row.among(*self.own.leading)):
            old = row.at(at.begin), row.at(at.begin, self.low)
            new = apply(f, "add", *old, *self.sum(f, "polynomial", row, at.work, place, self.whole))
            for shift, value in zip((0, self.low), new):
                row.put(value, at.parts, shift)

    def asked(self, f: Function, at: Places, left: Real) -> Real:
        length, fresh = f.variable(left), f.variable(Bit(f, "true"))
        with f.forever() as rounds:
            unit = self.unit.get()
            scaled = f.call(Real, "integral_length", at.parts, at.there, left * (f.constant(1.0) / unit))
            with f.when(~(scaled > 0.0) & (unit > NARROWEST)):
                self.unit.set(unit * NARROWER)
                self.again()
                fresh.set(Bit(f, "false"))
                rounds.go_on()
            length.set(f.smaller(scaled * unit, left))
            with f.when((scaled > WIDE) & (length.get() < ENDLESS) & fresh.get()):
                self.unit.set((length.get().bits() & EXPONENT).number())
                self.again()
                fresh.set(Bit(f, "false"))
                rounds.go_on()
            rounds.leave()
        return length.get()

    def first(self, f: Function, row: Row, work: Pointer) -> Time:
        """What an integrand is."""
        inverse, series = f.constant(1.0) / self.unit.get(), row.series(work)
        return series[1] * inverse, series[1 + self._beyond] * inverse

    def change(self, f: Function, row: Row, at: Places, part: Part, h: Time) -> Time:
        """What is added to an integral within ``h`` of the beginning of a part."""
        rate, low = (self.known(f, one) for one in self.first(f, row, at.there))
        linear = apply(f, "mul", rate, low, *h)
        summed = self.sum(f, "polynomial", row, at.there, h, self.unit.get())
        return self.choice(f, part.short, linear, summed)

    def add(self, f: Function, at: Places, part: Part, usual: Real, t: Real) -> None:
        allowed = allowance(f, self.bounds, t, usual, part.h[0])
        with self.own.velocities(f) as row:
            old = row.at(at.parts), row.at(at.parts, self.low)
            new = apply(f, "add", *old, *self.change(f, row, at, part, part.h))
            speed = self.sum(f, "slope", row, at.there, part.h, self.unit.get())
            rate = f.magnitude(self.known(f, self.rate(f, row, at)))
            lesser = f.smaller(f.magnitude(new[0]), f.magnitude(old[0]))
            most = allowed.of(f, self.own, f.magnitude(speed[0]) + rate, lesser)
            most = most + self.nothing(f, part.h[0])
            most = f.select(part.short, rate, most)
            arrays = (self.array(f, at, number) for number in (4, 5, 6))
            for array, value in zip(arrays, (speed[0], most, speed[1])):
                row.put(value, array)
            for shift, value in zip((0, self.low), new):
                row.put(value, self.array(f, at, 2), shift)

    def confirmed(self) -> Function:
        given = ", ".join(f"ptr %{name}" for name in ("work", "rates", "allowed", "low", "integrals"))
        f = Function(f"define internal i1 @integrals_confirmed({given}, double %inverse, double %nothing) #0")
        bad, inverse = f.variable(Bit(f, "false")), Real(f, "%inverse")
        with self.own.velocities(f) as row:
            rate, low = (row.series()[1 + shift] * inverse for shift in (0, self._beyond))
            apart = f.magnitude((row.at("%rates") - rate) + (row.at("%low") - low))
            new = row.at("%integrals")
            bad.set(
                bad.get()
                | (apart.compared("ugt", row.at("%allowed") + Real(f, "%nothing")) & new.equals(new))
            )
        f.give(~bad.get())
        return f

    def confirm(self, f: Function, at: Places) -> Bit:
        arrays = (self.array(f, at, number) for number in (4, 5, 6, 2))
        inverse = f.constant(1.0) / self.unit.get()
        return f.call(Bit, "integrals_confirmed", at.there, *arrays, inverse, f.constant(0.0))

    def rate(self, f: Function, row: Row, at: Places) -> Real:
        return self.first(f, row, at.there)[0]

    def give(self, f: Function, at: Places, state: Pointer, live: Bit, whole: Bit) -> None:
        none, zero = Real(f, NAN, 1), f.constant(0.0)
        with self.own.velocities(f) as row:
            for shift in (0, self.low):
                row.put(f.select(whole, row.at(at.parts, shift), none), state, shift)
            row.put(zero, state, self._third)

    def sample_at(self, f: Function, at: Places, part: Part, dt: Time, index: Integer) -> None:
        """One sample: rows of ``%out`` are ``%stride`` apart, low parts ``%beyond`` behind."""
        h = apply(f, "add", *dt, -part.start[0], -part.start[1])
        with self.own.velocities(f) as row:
            old = row.at(at.parts), row.at(at.parts, self.low)
            value = apply(f, "add", *old, *self.change(f, row, at, part, h))
            place = row.i * Integer(f, "%stride") + index
            f.store(value[0], "%out", place)
            f.store(value[1], "%out", place + Integer(f, "%beyond"))
