"""``Function``: a function of machine code, written as in a program.

f = Function("define internal double @sum(ptr %a, i64 %n) #0")
total = f.variable(f.constant(0.0))
with f.loop(0, Integer(f, "%n")) as i:
    total.set(total.get() + f.load("%a", i))
f.give(total.get())
text = f.text()
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar, overload

from lagrange_cli.native.llvm.flow import Flow
from lagrange_cli.native.llvm.text import kind, literal, operand
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer, Real, Value, cast

V = TypeVar("V", bound=Value)


class Function(Flow):
    """The text of one function: what it calls, loads, stores and gives, in the blocks of ``Flow``."""

    _rooms = 0

    def give(self, *values: Value) -> None:
        """Return nothing, a value, or several together."""
        if not values:
            self.line("  ret void")
        elif len(values) == 1:
            self.line(f"  ret {values[0].kind} {values[0].name}")
        else:
            together, made = f"{{ {', '.join(one.kind for one in values)} }}", "poison"
            for k, one in enumerate(values):
                made = self.define(f"insertvalue {together} {made}, {one.kind} {one.name}, {k}")
            self.line(f"  ret {together} {made}")
        self.here.ended = True

    # calls and memory

    @overload
    def call(self, result: type[V], name: str, *arguments: Value, lanes: int = ...) -> V: ...
    @overload
    def call(self, result: None, name: str, *arguments: Value, lanes: int = ...) -> None: ...
    def call(self, result: type[V] | None, name: str, *arguments: Value, lanes: int = 0) -> V | None:
        """A call of ``@name``; of as many ``lanes`` as the body, if not said."""
        listed = ", ".join(f"{one.kind} {one.name}" for one in arguments)
        if result is None:
            self.line(f"  call void @{name}({listed})")
            return None
        type = kind(result.type, lanes or self.lanes)
        return result(self, self.define(f"call {type} @{name}({listed})"), lanes or self.lanes)

    def parts(self, results: Sequence[type[Any]], name: str, *arguments: Value, lanes: int = 0) -> list[Any]:
        """A call of ``@name``, which gives several values together, or one."""
        if len(results) == 1:
            return [self.call(results[0], name, *arguments, lanes=lanes)]
        listed, lanes = ", ".join(f"{one.kind} {one.name}" for one in arguments), lanes or self.lanes
        together = f"{{ {', '.join(kind(one.type, lanes) for one in results)} }}"
        made = self.define(f"call {together} @{name}({listed})")
        parts = (self.define(f"extractvalue {together} {made}, {k}") for k in range(len(results)))
        return [one(self, part, lanes) for one, part in zip(results, parts)]

    def lane_by_lane(
        self, given: Sequence[Real], count: int, single: Callable[[Sequence[Real]], Sequence[Real]]
    ) -> list[Real]:
        """So many vectors of what ``single`` makes of each lane of the given ones."""
        lanes = given[0].lanes
        results = [self.variable(Real(self, "poison", lanes)) for _ in range(count)]
        with self.loop(0, lanes, tested=False) as i:
            made = single([self.lane(one, i) for one in given])
            for result, one in zip(results, made):
                result.set(self.inserted(result.get(), one, i))
        return [result.get() for result in results]

    def pointer(self, name: str) -> Pointer:
        """An argument that is a place in memory."""
        return Pointer(self, name, 1)

    def pointers(self, *names: str) -> list[Pointer]:
        """Several of them, whose names are given without %."""
        return [Pointer(self, f"%{name}", 1) for name in names]

    def reals(self, *names: str) -> list[Real]:
        """Likewise arguments that are numbers."""
        return [Real(self, f"%{name}") for name in names]

    def place(self, base: Pointer | str, index: Index | str, type: str = "") -> Pointer:
        """The address of ``base[index]``: of doubles of the body's lanes, or of ``type``."""
        name, at = (one.name if isinstance(one, Value) else one for one in (base, index))
        text = f"getelementptr inbounds {type or self.real}, ptr {name}, i64 {at}"
        return Pointer(self, self.define(text), 1)

    def load(self, base: Pointer | str, index: Index = 0) -> Real:
        """``base[index]``, of the body's lanes."""
        place = self.place(base, index)
        return Real(self, self.define(f"load {self.real}, ptr {place.name}, align {8 * self.lanes}"))

    def store(self, value: Value, base: Pointer | str, index: Index = 0) -> None:
        """``base[index] = value``, of the body's lanes."""
        place = self.place(base, index, value.kind)
        self.line(f"  store {value.kind} {value.name}, ptr {place.name}, align {8 * value.lanes}")

    def load_row(self, base: Pointer | str, index: Index | str, lanes: int, *, aligned: bool = False) -> Real:
        """``lanes`` doubles side by side from ``base[index]`` on, where ``base`` counts single ones."""
        place = self.place(base, index, "double")
        text = f"load {kind('double', lanes)}, ptr {place.name}, align {8 * lanes if aligned else 8}"
        return Real(self, self.define(text), lanes)

    def prefetch(self, base: Pointer | str, index: Index) -> None:
        """Have the line of the double ``base[index]`` brought near, if it is memory."""
        place = self.place(base, index, "double")
        self.line(f"  call void @llvm.prefetch.p0(ptr {place.name}, i32 0, i32 3, i32 1)")

    def copy_rows(
        self, source: tuple[Pointer | str, int], target: tuple[Pointer | str, int], count: int, lanes: int
    ) -> None:
        """Copy so many doubles, ``lanes`` together, from ``base[index]`` on to another place."""
        (origin, first), (to, place) = source, target
        with self.loop(0, count, lanes, tested=False) as i:
            value = self.load_row(origin, i + first if first else i, lanes)
            self.store_row(value, to, i + place if place else i)

    def store_row(
        self,
        value: Real,
        base: Pointer | str,
        index: Index | str,
        *,
        aligned: bool = False,
        volatile: bool = False,
    ) -> None:
        """The same, stored."""
        place, word = self.place(base, index, "double"), "store volatile" if volatile else "store"
        align = 8 * value.lanes if aligned else 8
        self.line(f"  {word} {value.kind} {value.name}, ptr {place.name}, align {align}")

    def load_integer(self, base: Pointer | str, index: Index = 0) -> Integer:
        """One integer."""
        place = self.place(base, index, "i64")
        return Integer(self, self.define(f"load i64, ptr {place.name}, align 8"), 1)

    def load_pointer(self, base: Pointer | str, index: Index = 0) -> Pointer:
        """A place in memory that is written there, where ``base`` counts doubles."""
        place = self.place(base, index, "double")
        return Pointer(self, self.define(f"load ptr, ptr {place.name}, align 8"), 1)

    def room(self, doubles: int) -> Pointer:
        """Memory for so many doubles while the function runs."""
        name = f"%room{self._rooms}"
        self._rooms += 1
        self._entry.lines.insert(0, f"  {name} = alloca double, i64 {doubles}, align 8")
        return Pointer(self, name, 1)

    # what threads share

    def observe(self, base: Pointer | str, index: Index = 0, ordering: str = "acquire") -> Integer:
        """An integer that another thread may change: one that it may ``publish``, and with it all that it has
        written before; or that alone (``monotonic``)."""
        place = self.place(base, index, "i64")
        return Integer(self, self.define(f"load atomic i64, ptr {place.name} {ordering}, align 8"), 1)

    def publish(self, value: Integer, base: Pointer | str, index: Index = 0) -> None:
        """Store an integer behind all that has been written before."""
        place = self.place(base, index, "i64")
        self.line(f"  store atomic i64 {value.name}, ptr {place.name} release, align 8")

    def replace(self, old: Integer, new: Integer, base: Pointer | str, index: Index = 0) -> Bit:
        """Store ``new`` where ``old`` still is; whether it was."""
        place, values = self.place(base, index, "i64"), f"i64 {old.name}, i64 {new.name}"
        both = self.define(f"cmpxchg ptr {place.name}, {values} acq_rel acquire, align 8")
        return Bit(self, self.define(f"extractvalue {{ i64, i1 }} {both}, 1"), 1)


def upper_half(x: Real) -> Real:
    """The upper half of its bits as a number: for x > 0, 2^20 (1023 + log2 x) to 0.09 * 2^20."""
    body, short = x.body, kind("i32", x.lanes)
    upper = x.bits().operation("lshr", 32)
    halved = body.define(f"trunc {upper.kind} {upper.name} to {short}")
    return Real(body, body.define(f"sitofp {short} {halved} to {x.kind}"), x.lanes)


def log2_roughly(x: Real) -> Real:
    """log2 of a positive number to 0.09; for 0 some -1023."""
    return x.body.fma(upper_half(x), 2.0**-20, -1023.0)


def exp2_roughly(x: Real) -> Real:
    """2^x to 0.3 percent, for |x| <= 1000; beyond, as at the limit."""
    body = x.body
    low, high = (body.splat(Real(body, operand(literal(bound)), 1), x.lanes) for bound in (-1000.0, 1000.0))
    bounded = body.smaller(body.larger(x, low), high)
    floor = body.function("floor", bounded)
    f = bounded - floor
    p = body.fma(f, body.fma(f, 0.3301, 0.6645), 1.0)
    return p * ((cast(floor, "fptosi", Integer) + 1023) << 52).number()
