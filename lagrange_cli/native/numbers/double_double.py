"""Double-double numbers in LLVM IR: the unevaluated sum of two doubles, some 106 bits.

Sums and products by transformations without rounding (Dekker, Numer. Math. 18, 1971; Knuth, TAOCP 2, sec.
4.2.2), put together as by Joldes, Muller and Popescu (ACM TOMS 44, 2017), who bound their errors by a
few units of 2^-106. Each operation is a function of its own, called where it is needed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.numbers.double import Emitter, Operand, literal, operand
from lagrange_cli.records import dataclass

VECTOR = f"<{LANES} x double>"
TYPE = "%pair"


@dataclass(frozen=True)
class Pair:
    """A number: ``high`` is the double nearest to it, ``low`` what is left."""

    body: DoubleDoubleBody
    high: Operand
    low: Operand

    def __add__(self, other: Pair) -> Pair:
        return self.body.function("add", self, other)

    def __sub__(self, other: Pair) -> Pair:
        return self + -other

    def __neg__(self) -> Pair:
        return Pair(self.body, *(operand(self.body.neg(x)) for x in (self.high, self.low)))

    def __mul__(self, other: Pair) -> Pair:
        return self.body.function("mul", self, other)

    def __truediv__(self, other: Pair) -> Pair:
        return self.body.function("div", self, other)

    def scaled(self, factor: Operand) -> Pair:
        """Its product with a double."""
        return self.body.function("scale", self, factor)

    def divided(self, by: Operand) -> Pair:
        """Its quotient by a double."""
        return self.body.function("divide", self, by)


class DoubleDoubleBody(Emitter):
    """The body of one function over such numbers, with loops over indices."""

    COST = 4

    def __init__(self) -> None:
        super().__init__()
        self.label = "entry"
        self.line("entry:")

    def number(self, value: Fraction | float | int) -> Pair:
        """A constant, rounded to a double-double."""
        high, low = split(Fraction(value)) if value == value else (float(value), 0.0)
        return Pair(self, operand(literal(high)), operand(literal(low)))

    def function(self, name: str, *arguments: Pair | Operand) -> Pair:
        """``@pair_name`` of numbers and doubles."""
        flat = [x for one in arguments for x in ((one.high, one.low) if isinstance(one, Pair) else (one,))]
        self.operations += 1
        listed = ", ".join(f"double {x}" for x in flat)
        return self.unpacked(self.define(f"call {TYPE} @pair_{name}({listed})"))

    def unpacked(self, made: Operand) -> Pair:
        """The number that a function has returned."""
        return Pair(self, *(self.define(f"extractvalue {TYPE} {made}, {i}") for i in (0, 1)))

    def get(self, pointer: str, index: int | str, beyond: int) -> Pair:
        """The number at ``pointer[index]``, whose low part is ``beyond`` doubles behind."""
        place = self.place(pointer, index)
        return Pair(self, self.load(place, 0), self.load(place, beyond))

    def put(self, value: Pair | None, pointer: str, index: int | str, beyond: int) -> None:
        """Store a number there; None is 0."""
        place = self.place(pointer, index)
        self.store(None if value is None else value.high, place, 0)
        self.store(None if value is None else value.low, place, beyond)

    def place(self, pointer: str, index: int | str) -> str:
        """The address of the double ``pointer[index]``."""
        return self.define(f"getelementptr inbounds double, ptr {pointer}, i64 {index}")

    def integer(self, operation: str, a: int | str, b: int | str) -> str:
        """An operation on two integers."""
        return self.define(f"{operation} i64 {a}, {b}")

    def choose(self, condition: str, yes: Pair, no: Pair) -> Pair:
        """One of two numbers."""
        ways = ((yes.high, no.high), (yes.low, no.low))
        return Pair(self, *(self.define(f"select i1 {condition}, double {a}, double {b}") for a, b in ways))

    def compare(self, relation: str, a: Operand, b: float | Operand) -> str:
        """A relation between two doubles."""
        other = b if isinstance(b, str) else operand(literal(b))
        return self.define(f"fcmp {relation} double {a}, {other}")

    def loop(self, first: int | str, last: int | str, step: Callable[[str], None], by: int = 1) -> None:
        """``step(i)`` for i = first .. last - 1; what goes from one round to the next lies in memory."""
        before, tag = self.label, self.fresh().removeprefix("%")
        self.line(f"  br label %{tag}\n{tag}:")
        place = len(self.lines)
        self.line(f"  %{tag}.more = icmp slt i64 %{tag}.i, {last}")
        self.line(f"  br i1 %{tag}.more, label %{tag}.in, label %{tag}.out\n{tag}.in:")
        self.label = f"{tag}.in"
        step(f"%{tag}.i")
        self.line(f"  %{tag}.next = add nsw i64 %{tag}.i, {by}\n  br label %{tag}\n{tag}.out:")
        self.lines.insert(
            place, f"  %{tag}.i = phi i64 [ {first}, %{before} ], [ %{tag}.next, %{self.label} ]"
        )
        self.label = f"{tag}.out"

    def returned(self, value: Pair) -> None:
        """Return a number."""
        half = self.define(f"insertvalue {TYPE} poison, double {value.high}, 0")
        self.line(f"  ret {TYPE} {self.define(f'insertvalue {TYPE} {half}, double {value.low}, 1')}")


def split(value: Fraction) -> tuple[float, float]:
    """The nearest double, and the one nearest to what is left."""
    try:
        high = float(value)
    except OverflowError:
        return (float("inf") if value > 0 else float("-inf")), 0.0
    return high, float(value - Fraction(high))


def two_sum(e: Emitter, a: Operand, b: Operand) -> tuple[Operand, Operand]:
    """a + b and its rounding error."""
    total = operand(e.add(a, b))
    back = e.sub(total, a)
    return total, operand(e.add(e.sub(a, e.sub(total, back)), e.sub(b, back)))


def fast_sum(e: Emitter, a: Operand, b: Operand) -> tuple[Operand, Operand]:
    """a + b and its rounding error, where |a| >= |b|."""
    total = operand(e.add(a, b))
    return total, operand(e.sub(b, e.sub(total, a)))


def fused(e: Emitter, a: Operand, b: Operand, c: Operand) -> Operand:
    """a * b + c with one rounding."""
    return e.call("llvm.fma.f64", a, b, c)


def two_product(e: Emitter, a: Operand, b: Operand) -> tuple[Operand, Operand]:
    """a * b and its rounding error."""
    product = operand(e.mul(a, b))
    return product, fused(e, a, b, operand(e.neg(product)))


def function(head: str, body: DoubleDoubleBody) -> str:
    """A function's text."""
    lines = "\n".join(body.lines)
    return f"define internal {head} #0 {{\n{lines}\n}}\n"


def define(name: str, kinds: str, formula: Callable[..., Pair | tuple[Operand, Operand]]) -> str:
    """The text of ``@pair_name``; ``kinds``: p for an argument that is a number, d for one double."""
    body = DoubleDoubleBody()
    given: list[Pair | Operand] = [
        f"%a{i}" if kind == "d" else Pair(body, f"%a{i}", f"%b{i}") for i, kind in enumerate(kinds)
    ]
    made = formula(body, *given)
    body.returned(made if isinstance(made, Pair) else Pair(body, *made))
    heads = ", ".join(f"double %a{i}" + (f", double %b{i}" if k == "p" else "") for i, k in enumerate(kinds))
    lines = "\n".join(body.lines)
    return f"define internal {TYPE} @pair_{name}({heads}) #0 {{\n{lines}\n}}\n"


def _add(e: DoubleDoubleBody, a: Pair, b: Pair) -> tuple[Operand, Operand]:
    high, error = two_sum(e, a.high, b.high)
    low, rest = two_sum(e, a.low, b.low)
    high, error = fast_sum(e, high, operand(e.add(error, low)))
    return fast_sum(e, high, operand(e.add(error, rest)))


def _mul(e: DoubleDoubleBody, a: Pair, b: Pair) -> tuple[Operand, Operand]:
    product, error = two_product(e, a.high, b.high)
    cross = fused(e, a.low, b.high, fused(e, a.high, b.low, operand(e.mul(a.low, b.low))))
    return fast_sum(e, product, operand(e.add(error, cross)))


def _scale(e: DoubleDoubleBody, a: Pair, b: Operand) -> tuple[Operand, Operand]:
    product, error = two_product(e, a.high, b)
    return fast_sum(e, product, fused(e, a.low, b, error))


def _div(e: DoubleDoubleBody, a: Pair, b: Pair) -> Pair:
    first = operand(e.div(a.high, b.high))
    rest = a - b.scaled(first)
    second = operand(e.div(rest.high, b.high))
    rest = rest - b.scaled(second)
    third = operand(e.div(rest.high, b.high))
    return Pair(e, *fast_sum(e, first, second)) + Pair(e, third, operand(None))


def _divide(e: DoubleDoubleBody, a: Pair, b: Operand) -> tuple[Operand, Operand]:
    first = operand(e.div(a.high, b))
    product, error = two_product(e, first, b)
    rest = e.add(e.sub(e.sub(a.high, product), error), a.low)
    return fast_sum(e, first, operand(e.div(rest, b)))


def _sqrt(e: DoubleDoubleBody, a: Pair) -> Pair:
    first = e.call("llvm.sqrt.f64", a.high)
    square, error = two_product(e, first, first)
    rest = e.add(e.sub(e.sub(a.high, square), error), a.low)
    root = Pair(e, *fast_sum(e, first, operand(e.div(rest, e.add(first, first)))))
    return e.choose(e.compare("oeq", a.high, 0.0), e.number(0), root)


def convolve(beyond: int) -> str:
    """``@convolve(a, b, n)``: sum_{m=0}^{n} a[m] b[n-m].

    ``a`` and ``b`` are the addresses of coefficients 0; low parts are ``beyond`` doubles behind, and
    there are zeros before coefficients 0. A lane has the sum of every eighth term, and apart from it all that
    was rounded off.
    """
    e = DoubleDoubleBody()
    sums = [e.define(f"alloca {VECTOR}, align 64") for _ in range(2)]
    for one in sums:
        e.line(f"  store {VECTOR} zeroinitializer, ptr {one}, align 64")

    def load(pointer: str, align: int) -> str:
        return e.define(f"load {VECTOR}, ptr {pointer}, align {align}")

    def op(name: str, a: str, b: str) -> str:
        return e.define(f"{name} {VECTOR} {a}, {b}")

    def fma(a: str, b: str, c: str) -> str:
        tag = f"llvm.fma.v{LANES}f64"
        return e.define(f"call {VECTOR} @{tag}({VECTOR} {a}, {VECTOR} {b}, {VECTOR} {c})")

    def term(m: str) -> None:
        first = e.place("%a", m)
        last = e.place("%b", e.integer("sub", e.integer("sub", "%n", m), LANES - 1))
        ah, al = load(first, 64), load(e.place(first, beyond), 64)
        order = ", ".join(f"i32 {LANES - 1 - lane}" for lane in range(LANES))
        bh, bl = (
            e.define(f"shufflevector {VECTOR} {x}, {VECTOR} poison, <{LANES} x i32> <{order}>")
            for x in (load(last, 8), load(e.place(last, beyond), 8))
        )
        product = op("fmul", ah, bh)
        error = fma(ah, bh, e.define(f"fneg {VECTOR} {product}"))
        error = fma(al, bh, fma(ah, bl, error))
        old, rest = (load(one, 64) for one in sums)
        total = op("fadd", old, product)
        back = op("fsub", total, old)
        lost = op("fadd", op("fsub", old, op("fsub", total, back)), op("fsub", product, back))
        rest = op("fadd", rest, op("fadd", lost, error))
        for value, one in ((total, sums[0]), (rest, sums[1])):
            e.line(f"  store {VECTOR} {value}, ptr {one}, align 64")

    e.loop(0, e.integer("add", "%n", 1), term, by=LANES)
    lanes = [
        [e.define(f"extractelement {VECTOR} {x}, i64 {i}") for i in range(LANES)]
        for x in (load(one, 64) for one in sums)
    ]
    totals = list(zip(*lanes))
    while len(totals) > 1:
        pairs = []
        for (a, low_a), (b, low_b) in zip(totals[::2], totals[1::2]):
            total, error = two_sum(e, a, b)
            pairs.append((total, operand(e.add(error, e.add(low_a, low_b)))))
        totals = pairs
    e.returned(Pair(e, *fast_sum(e, *totals[0])))
    lines = "\n".join(e.lines)
    return f"define internal {TYPE} @convolve(ptr %a, ptr %b, i64 %n) #0 {{\n{lines}\n}}\n"


def operations() -> Sequence[str]:
    """The type, and the functions that ``Pair`` calls."""
    return (
        f"{TYPE} = type {{ double, double }}\n",
        define("add", "pp", _add),
        define("mul", "pp", _mul),
        define("scale", "pd", _scale),
        define("div", "pp", _div),
        define("divide", "pd", _divide),
        define("sqrt", "p", _sqrt),
    )
