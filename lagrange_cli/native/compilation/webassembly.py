"""A program as a WebAssembly module, for a page that computes.

LLVM writes object code for WebAssembly: a module whose memory and stack are given by whoever loads it, with
the names of its functions in a section for linkers (WebAssembly Core Specification, release 2.0, sec. 5.5;
Tool Conventions, "WebAssembly Object File Linking"). One object needs no linker: all addresses in it are
those of a module that begins at 0. Only the exports are
missing; they are made from the linkers' names.

The elementary functions come with the program, and so does ``fma``, which WebAssembly lacks. The page only
provides memory.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from lagrange_cli.native.compilation.stack import with_stack
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Real, kind
from lagrange_cli.records import dataclass

TRIPLE, FEATURES = "wasm32-unknown-unknown", "+simd128,+bulk-memory"
OPTIMIZE = 2
"""LLVM's level of code generation: the code is compiled once, and run where the reader is."""
COMPILER_STACK = 2**28
STACK, STACK_PER_BYTE = 2**18, 8
"""Bytes of stack: at least, and for a byte of code. A few bytes of code store a vector of 64."""

EXPORT, DATA = 7, 11
"""Sections. Those of number 0 are for tools."""
FUNCTION = 0
"""A kind of symbols and exports."""
SYMBOLS, OF_DATA, OF_SECTION = 8, 1, 3
"""The table of symbols among the parts of the section ``linking``, and two kinds of its rows."""
UNDEFINED, NAMED, LOCAL = 0x10, 0x40, 0x2
"""Flags of symbols."""
SPLITTER = 2.0**27 + 1
FUSED = re.compile(r"@llvm\.fma\.(?:v(\d+))?f64\(")


@dataclass(frozen=True)
class Module:
    """A module's ``code``; memory from ``heap`` on is free. Below it are the data and the stack, which begins
    at ``stack`` and grows downward."""

    code: bytes
    stack: int

    @property
    def heap(self) -> int:
        """The first byte that is free."""
        return self.stack


def compile_webassembly(text: str) -> Module:
    """The module of a program's ``text``; it exports every function that is not internal."""
    code: bytes = with_stack(object_code, COMPILER_STACK)(with_fma(text))
    sections = [*sections_of(code)]
    functions = exported(sections)
    data = max((end for number, content in sections if number == DATA for end in ends_of(content)), default=0)
    stack = data + max(STACK, STACK_PER_BYTE * len(code))
    return Module(linked(code, sections, functions), -(-stack // 64) * 64)


def object_code(text: str) -> bytes:
    """LLVM's object code for WebAssembly."""
    import llvmlite.binding as llvm

    from lagrange_cli.native.llvm.declarations import complete

    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    target = llvm.Target.from_triple(TRIPLE)
    machine = target.create_target_machine(cpu="generic", features=FEATURES, opt=OPTIMIZE)
    code: bytes = machine.emit_object(llvm.parse_assembly(complete(text)))
    return code


# fma


def with_fma(text: str) -> str:
    """``text`` with its own functions in place of the C library's and of those that LLVM calls.

    ``fmuladd`` stays what it is: where there is no such instruction, a product and a sum.
    """
    from lagrange_cli.native.functions.portable import self_contained

    text = self_contained(text)
    lanes = sorted({int(found or 1) for found in FUSED.findall(text)})
    text = FUSED.sub(lambda found: f"@fma.{found[1] or 1}(", text)
    wide = [WIDE_PRODUCT] if "mul i128" in text else []
    return "\n".join([text, *map(fma, lanes), chosen("fmin", "olt"), chosen("fmax", "ogt"), *wide])


def fma(lanes: int) -> str:
    """``@fma.N(a, b, c)``: a * b + c from operations that are rounded one by one (T. J. Dekker, Numerische
    Mathematik 18, 1971: the product without loss, then the sum).

    The sum of the three parts is rounded twice. If c is about -a * b, as where the error of a product is
    asked for, the result is exact. What is too large for that is computed as it is without ``fma``.
    """
    real = kind("double", lanes)
    f = Function(f"define internal {real} @fma.{lanes}({real} %a, {real} %b, {real} %c) #0", lanes)
    a, b, c = (Real(f, name, lanes) for name in ("%a", "%b", "%c"))
    product = a * b
    (a_high, a_low), (b_high, b_low) = halves(a), halves(b)
    error = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)
    total = product + c
    back = total - product
    rest = (product - (total - back)) + (c - back)
    value = total + (rest + error)
    sure = Bit(f, f.define(f"fcmp ord {real} {value.name}, {value.name}"), lanes)
    f.give(f.select(sure, value, total))
    return f.text()


def halves(x: Real) -> tuple[Real, Real]:
    """The upper and the lower 26 digits of x (G. W. Veltkamp)."""
    scaled = x * SPLITTER
    high = scaled - (scaled - x)
    return high, x - high


def chosen(name: str, comparison: str) -> str:
    """C's ``fmin`` or ``fmax``, which LLVM calls: the other number, where one is none."""
    f = Function(f"define hidden double @{name}(double %a, double %b) #0")
    a, b = Real(f, "%a"), Real(f, "%b")
    first = Bit(f, f.define(f"fcmp {comparison} double %a, %b"), 1)
    nothing = Bit(f, f.define("fcmp uno double %b, %b"), 1)
    f.give(f.select(first | nothing, a, b))
    return f.text()


WIDE_PRODUCT = """
define hidden void @__multi3(ptr %product, i64 %a, i64 %a.high, i64 %b, i64 %b.high) #0 {
  %a0 = and i64 %a, 4294967295
  %a1 = lshr i64 %a, 32
  %b0 = and i64 %b, 4294967295
  %b1 = lshr i64 %b, 32
  %p00 = mul i64 %a0, %b0
  %p01 = mul i64 %a0, %b1
  %p10 = mul i64 %a1, %b0
  %p11 = mul i64 %a1, %b1
  %m0 = lshr i64 %p00, 32
  %m1 = and i64 %p01, 4294967295
  %m2 = and i64 %p10, 4294967295
  %m3 = add i64 %m0, %m1
  %middle = add i64 %m3, %m2
  %l0 = and i64 %p00, 4294967295
  %l1 = shl i64 %middle, 32
  %low = or i64 %l0, %l1
  %h0 = lshr i64 %p01, 32
  %h1 = lshr i64 %p10, 32
  %h2 = lshr i64 %middle, 32
  %h3 = mul i64 %a, %b.high
  %h4 = mul i64 %a.high, %b
  %s0 = add i64 %p11, %h0
  %s1 = add i64 %s0, %h1
  %s2 = add i64 %s1, %h2
  %s3 = add i64 %s2, %h3
  %high = add i64 %s3, %h4
  store i64 %low, ptr %product, align 8
  %above = getelementptr i8, ptr %product, i64 8
  store i64 %high, ptr %above, align 8
  ret void
}
"""
"""LLVM's function for products of 128 bits, with which angles beyond 2^20 are reduced."""


# The format


def number(value: int) -> bytes:
    """An unsigned integer (LEB128)."""
    made = bytearray()
    while value > 127:
        made.append(value & 127 | 128)
        value >>= 7
    return bytes([*made, value])


class Reader:
    """Bytes from a place on."""

    def __init__(self, content: bytes, place: int = 0) -> None:
        self.content, self.place = content, place

    def byte(self) -> int:
        """One byte."""
        self.place += 1
        return self.content[self.place - 1]

    def number(self) -> int:
        """An integer (LEB128), its sign aside."""
        value = shift = 0
        while True:
            one = self.byte()
            value |= (one & 127) << shift
            shift += 7
            if one < 128:
                return value

    def text(self) -> str:
        """A name."""
        return self.bytes().decode()

    def bytes(self) -> bytes:
        """Bytes behind their number."""
        size = self.number()
        self.place += size
        return self.content[self.place - size : self.place]


def sections_of(code: bytes) -> Iterator[tuple[int, bytes]]:
    """The number and the content of each section."""
    reader = Reader(code, 8)
    while reader.place < len(code):
        yield reader.byte(), reader.bytes()


def exported(sections: Sequence[tuple[int, bytes]]) -> dict[str, int]:
    """The functions that others may call, by name."""
    found: dict[str, int] = {}
    for section, content in sections:
        reader = Reader(content)
        if section != 0 or reader.text() != "linking":
            continue
        reader.number()  # the version
        while reader.place < len(content):
            part, inner = reader.byte(), Reader(reader.bytes())
            for _ in range(inner.number() if part == SYMBOLS else 0):
                symbol, flags = inner.byte(), inner.number()
                if symbol == OF_SECTION:
                    inner.number()
                    continue
                index = inner.number() if symbol != OF_DATA else -1
                own = not flags & UNDEFINED
                name = inner.text() if own or flags & NAMED or symbol == OF_DATA else ""
                if symbol == OF_DATA and own:
                    _ = inner.number(), inner.number(), inner.number()  # segment, offset, size
                if symbol == FUNCTION and own and not flags & LOCAL:
                    found[name] = index
    return found


def ends_of(content: bytes) -> Iterator[int]:
    """Where the segments of a section of data end in memory."""
    reader = Reader(content)
    for _ in range(reader.number()):
        reader.number()  # it is copied to memory 0
        reader.byte()  # i32.const
        start = reader.number()
        reader.byte()  # end
        yield start + len(reader.bytes())


def linked(code: bytes, sections: Sequence[tuple[int, bytes]], functions: dict[str, int]) -> bytes:
    """The module: its sections but those for tools, with the section of exports at its place."""
    rows = (section_bytes(name.encode()) + bytes([FUNCTION]) + number(i) for name, i in functions.items())
    exports = EXPORT, number(len(functions)) + b"".join(rows)
    kept = [one for one in sections if one[0] not in (0, EXPORT)]
    before = [one for one in kept if one[0] < EXPORT]
    behind = [one for one in kept if one[0] > EXPORT]
    listed = [*before, exports, *behind]
    return code[:8] + b"".join(bytes([section]) + section_bytes(content) for section, content in listed)


def section_bytes(content: bytes) -> bytes:
    """Bytes behind their number."""
    return number(len(content)) + content
