"""The stepping loop in double-double (see ``stepper``): lengths are doubles, time and state are not.

The state keeps a third part of every number behind the clock, so that adding up steps loses nothing. As
there, every step is confirmed by the series that begins at its end (``acceptance_double_double``).
"""

from __future__ import annotations

from lagrange_cli.native.functions.correctly_rounded import power
from lagrange_cli.native.interface import Stop
from lagrange_cli.native.llvm.template import fill_in
from lagrange_cli.native.numbers.double import Operand, literal, operand
from lagrange_cli.native.numbers.double_double import (
    TYPE,
    DoubleDoubleBody,
    Pair,
    function,
)
from lagrange_cli.native.numbers.error_free import fast_sum, two_sum
from lagrange_cli.native.recurrences.layout_rows import Rows, velocities
from lagrange_cli.native.state import CLOCK
from lagrange_cli.native.stepping.acceptance_double_double import confirmation, numbers
from lagrange_cli.native.stepping.step_size import LAST_TERM, LOWEST_TERM, SLACK
from lagrange_cli.records import dataclass

LONGEST = 1e30
"""The longest step: what a motion without forces gets."""


@dataclass(frozen=True)
class DoubleDoubleStepper:
    """Writes ``@advance`` and what it calls."""

    rows: Rows
    tolerance: float

    def functions(self) -> list[str]:
        """Their text."""
        values: dict[str, object] = {
            "time": 2 * self.rows.width,
            "rows": len(self.rows.state),
            "memory": 3 * self.rows.width + CLOCK,
            "longest": operand(literal(LONGEST)),
            **numbers(self.tolerance),
            **{stop.name.lower(): int(stop) for stop in Stop},
        }
        made = [self.polynomial(), self.slope(), self.since(), self.sample(), self.update(), self.length()]
        return [*made, self.rates(), *confirmation(self.rows), fill_in("advance_double_double", values)]

    def size(self, body: DoubleDoubleBody, velocity: int, row: str, h: Operand) -> Operand:
        """The largest of the velocity and the next three terms of its series over a step."""
        size: Operand = operand(None)
        for value in [body.load(row, m) for m in (3, 2, 1)] + [body.load("%state", velocity)]:
            scaled = operand(body.mul(size, h))
            size = body.call("llvm.maxnum.f64", body.call("llvm.fabs.f64", value), scaled)
        return size

    def length(self) -> str:
        """``@length(state, work, h)``: the step, sizes measured over ``h``; nan where coefficients are."""
        body, one = DoubleDoubleBody(), operand(literal(1.0))
        safety = power(LAST_TERM * self.tolerance, 1.0 / self.rows.top)
        worst, total = body.define("alloca double"), body.define("alloca double")
        body.store(operand(literal(-1e300)), worst, 0)
        body.store(None, total, 0)
        inverses = []
        for velocity, row in velocities(self.rows, body):
            size = self.size(body, velocity, row, "%h")
            moving = body.compare("ogt", size, 0.0)
            inverse = body.define(f"fdiv double {one}, {size}")
            inverse = body.define(f"select i1 {moving}, double {inverse}, double {operand(None)}")
            inverses.append((row, inverse))

        def term(m: str) -> None:
            most, all_of_them = operand(None), body.load(total, 0)
            for row, inverse in inverses:
                size = body.call("llvm.fabs.f64", body.load(row, m))
                all_of_them = operand(body.add(all_of_them, size))
                most = body.call("llvm.maxnum.f64", most, body.mul(size, inverse))
            body.store(all_of_them, total, 0)
            high = body.define(f"icmp sge i64 {m}, {(self.rows.top + 1) // 2}")
            slack = body.define(f"select i1 {high}, double {operand(None)}, double {operand(literal(SLACK))}")
            number = body.define(f"sitofp i64 {m} to double")
            exponent = body.div(body.sub(body.call("llvm.log2.f64", most), slack), number)
            body.store(body.call("llvm.maxnum.f64", exponent, body.load(worst, 0)), worst, 0)

        body.loop(LOWEST_TERM, self.rows.top + 1, term)
        step = body.mul(body.call("llvm.exp2.f64", body.neg(body.load(worst, 0))), literal(safety))
        step = body.call("llvm.minnum.f64", step, literal(LONGEST))
        finite = body.compare("olt", body.load(total, 0), float("inf"))
        nan = operand(literal(float("nan")))
        body.line(f"  ret double {body.define(f'select i1 {finite}, double {step}, double {nan}')}")
        return function("double @length(ptr %state, ptr %work, double %h)", body)

    def polynomial(self) -> str:
        """``@polynomial(row, h)``: sum_{m=1}^{order} row[m] h^m; of the upper half a double is enough."""
        body, half = DoubleDoubleBody(), self.rows.order // 2 + 4
        total = body.define("alloca [2 x double]")
        h = Pair(body, "%h", "%hl")
        upper: Operand = body.load("%row", self.rows.order)
        for m in range(self.rows.order - 1, half, -1):
            upper = operand(body.fma(upper, "%h", body.load("%row", m)))
        body.put(Pair(body, upper, operand(None)), total, 0, 1)

        def term(i: str) -> None:
            m = body.integer("sub", half, i)
            more = body.get(total, 0, 1) * h + body.get("%row", m, self.rows.beyond)
            body.put(more, total, 0, 1)

        body.loop(0, half, term)
        body.returned(body.get(total, 0, 1) * h)
        return function(f"{TYPE} @polynomial(ptr %row, double %h, double %hl)", body)

    def slope(self) -> str:
        """``@slope(row, h)``: sum_{m=1}^{top} m row[m] h^(m-1); of the upper half a double is enough."""
        body, half = DoubleDoubleBody(), max(1, self.rows.order // 2 - 4)
        total = body.define("alloca [2 x double]")
        h = Pair(body, "%h", "%hl")
        upper: Operand = operand(None)
        for m in range(self.rows.top, half, -1):
            share = operand(body.mul(body.load("%row", m), literal(float(m))))
            upper = operand(body.fma(upper, "%h", share))
        body.put(Pair(body, upper, operand(None)), total, 0, 1)

        def term(i: str) -> None:
            m = body.integer("sub", half, i)
            number = body.define(f"sitofp i64 {m} to double")
            more = body.get(total, 0, 1) * h + body.get("%row", m, self.rows.beyond).scaled(number)
            body.put(more, total, 0, 1)

        body.loop(0, half, term)
        body.returned(body.get(total, 0, 1))
        return function(f"{TYPE} @slope(ptr %row, double %h, double %hl)", body)

    def since(self) -> str:
        """``@since(s, t, tl)``: the time from t to s."""
        body = DoubleDoubleBody()
        high, low = two_sum(body, "%s", operand(body.neg("%t")))
        body.returned(Pair(body, *fast_sum(body, high, operand(body.sub(low, "%tl")))))
        return function(f"{TYPE} @since(double %s, double %t, double %tl)", body)

    def change(self, body: DoubleDoubleBody, index: int) -> Pair:
        """What a series adds over (%h, %hl)."""
        row = body.place("%work", self.rows.row(index))
        made = body.define(f"call {TYPE} @polynomial(ptr {row}, double %h, double %hl)")
        return body.unpacked(made)

    def sample(self) -> str:
        """``@sample``: the state at (%h, %hl), rows ``stride`` apart, low parts ``beyond`` behind."""
        body = DoubleDoubleBody()
        for row, index in enumerate(self.rows.state):
            value = body.get("%state", row, self.rows.width) + self.change(body, index)
            place = body.place("%out", body.integer("mul", "%stride", row))
            body.store(value.high, place, 0)
            body.store(value.low, place, "%beyond")
        body.line("  ret void")
        heads = "ptr %state, ptr %work, double %h, double %hl, ptr %out, i64 %stride, i64 %beyond"
        return function(f"void @sample({heads})", body)

    def update(self) -> str:
        """``@update``: the state at the end of the step (%h, %hl), in three parts."""
        body, third = DoubleDoubleBody(), 2 * self.rows.width + CLOCK
        for row, index in enumerate(self.rows.state):
            old, change = body.get("%state", row, self.rows.width), self.change(body, index)
            high, error = two_sum(body, old.high, change.high)
            low, rest = two_sum(body, old.low, change.low)
            low, more = two_sum(body, error, low)
            rest = operand(body.add(body.add(rest, more), body.load("%state", third + row)))
            low, rest = two_sum(body, low, rest)
            high, low = fast_sum(body, high, low)
            low, rest = two_sum(body, low, rest)
            body.put(Pair(body, high, low), "%state", row, self.rows.width)
            body.store(rest, "%state", third + row)
        body.line("  ret void")
        return function("void @update(ptr %state, ptr %work, double %h, double %hl)", body)

    def rates(self) -> str:
        """``@rates(work, rates)``: the accelerations, as doubles, of series of scale 1."""
        body = DoubleDoubleBody()
        for i, (_, row) in enumerate(velocities(self.rows, body)):
            body.store(body.load(row, 1), "%rates", i)
        body.line("  ret void")
        return function("void @rates(ptr %work, ptr %rates)", body)
