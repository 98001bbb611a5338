"""Formulas and loops over vectors, a lane for each of eight motions."""

from __future__ import annotations

from collections.abc import Callable

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.numbers.vector import Body, Real


class Lanes(Body):
    """The body of one function of eight lanes, with memory and loops; an index counts vectors."""

    def __init__(self) -> None:
        super().__init__(LANES)
        self.label = "entry"
        self.line("entry:")

    def line(self, text: str) -> None:
        """One line as it is."""
        self.lines.append(text)

    def place(self, pointer: str, index: int | str) -> str:
        """The address of ``pointer[index]``."""
        return self.define(f"getelementptr inbounds {self.real}, ptr {pointer}, i64 {index}")

    def load(self, pointer: str, index: int | str) -> Real:
        """``pointer[index]``."""
        return Real(self, self.define(f"load {self.real}, ptr {self.place(pointer, index)}, align 64"))

    def store(self, value: Real, pointer: str, index: int | str) -> None:
        """``pointer[index] = value``."""
        self.line(f"  store {self.real} {value.name}, ptr {self.place(pointer, index)}, align 64")

    def row(self, index: str, span: int) -> str:
        """The row of coefficients of row ``index`` of the state."""
        return self.place("%work", self.define(f"mul i64 {index}, {span}"))

    def above(self, a: Real, b: Real) -> str:
        """Whether a > b."""
        return self.define(f"fcmp ogt {self.real} {a.name}, {b.name}")

    def larger(self, a: Real, b: Real) -> Real:
        """The larger one; b where either is not a number."""
        return self.select(self.above(a, b), a, b)

    def smaller(self, a: Real, b: Real) -> Real:
        """The smaller one; b where either is not a number."""
        return self.select(self.above(b, a), a, b)

    def magnitude(self, a: Real) -> Real:
        """|a|."""
        return self.function("fabs", a)

    def loop(
        self, first: int, last: int, carried: list[Real], step: Callable[[str, list[Real]], list[Real]]
    ) -> list[Real]:
        """``carried`` after ``step(i, carried)`` for i = first .. last - 1, at least once."""
        before, tag = self.label, f"L{len(self.lines)}"
        self.label = tag
        self.line(f"  br label %{tag}\n{tag}:")
        place = len(self.lines)
        inside = [Real(self, f"%{tag}.{j}") for j in range(len(carried))]
        after = step(f"%{tag}.i", inside)
        self.line(f"  %{tag}.next = add nuw nsw i64 %{tag}.i, 1")
        self.line(f"  %{tag}.more = icmp ult i64 %{tag}.next, {last}")
        self.line(f"  br i1 %{tag}.more, label %{tag}, label %{tag}.done\n{tag}.done:")
        latch, self.label = self.label, f"{tag}.done"
        phis = [f"  %{tag}.i = phi i64 [ {first}, %{before} ], [ %{tag}.next, %{latch} ]"]
        for old, one, new in zip(carried, inside, after):
            phis.append(f"  {one.name} = phi {self.real} [ {old.name}, %{before} ], [ {new.name}, %{latch} ]")
        self.lines[place:place] = phis
        return after


def two_sum(body: Lanes, a: Real, b: Real) -> tuple[Real, Real]:
    """a + b and its rounding error."""
    total = a + b
    back = total - a
    return total, (a - (total - back)) + (b - back)


def upper_half(body: Lanes, x: Real) -> Real:
    """The upper half of its bits as a number: for x > 0, 2^20 (1023 + log2 x) to 0.09 * 2^20."""
    upper = body.integers("lshr", body.bits(x), 32)
    short = body.define(f"trunc {body.integer} {upper} to <{LANES} x i32>")
    return Real(body, body.define(f"sitofp <{LANES} x i32> {short} to {body.real}"))


def log2_roughly(body: Lanes, x: Real) -> Real:
    """log2 of a positive number to 0.09, as in ``stepper.ll``; for 0 some -1023."""
    return body.fma(upper_half(body, x), 2.0**-20, -1023.0)


def exp2_roughly(body: Lanes, x: Real) -> Real:
    """2^x to 0.3 percent, as in ``stepper.ll``."""
    bounded = body.smaller(body.larger(x, body.constant(-1000.0)), body.constant(1000.0))
    floor = body.function("floor", bounded)
    f = bounded - floor
    p = body.fma(f, body.fma(f, 0.3301, 0.6645), 1.0)
    whole = body.define(f"fptosi {body.real} {floor.name} to {body.integer}")
    scale = body.number(body.integers("shl", body.integers("add", whole, 1023), 52))
    return p * scale


def define(head: str, body: Lanes, *results: Real) -> str:
    """A function's text, with the return of ``results`` if there are any, and what it declares."""
    if len(results) == 1:
        body.line(f"  ret {body.real} {results[0].name}")
    elif results:
        kind, made = f"{{ {', '.join([body.real] * len(results))} }}", "poison"
        for k, one in enumerate(results):
            made = body.define(f"insertvalue {kind} {made}, {body.real} {one.name}, {k}")
        body.line(f"  ret {kind} {made}")
    lines = "\n".join(body.lines)
    return f"define internal {head} #1 {{\n{lines}\n}}\n"
