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
from lagrange_cli.native.llvm.vector import Integer, Real
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
SPLITTER, HALF = 2.0**27 + 1, 2**32 - 1
FUSED = re.compile(r"@llvm\.fma\.(?:v(\d+))?f64\(")


@dataclass(frozen=True)
class Module:
    """A module's ``code``; memory from ``heap`` on is free. Below it are the data and the stack, which begins
    there and grows downward."""

    code: bytes
    heap: int


def compile_webassembly(text: str, loops: bool = False) -> Module:
    """The module of a program's ``text``; it exports every function that is not internal. ``loops``: see
    ``compile_text``."""
    code: bytes = with_stack(object_code, COMPILER_STACK)(with_fma(text), loops)
    sections = [*sections_of(code)]
    functions = exported(sections)
    data = max((end for number, content in sections if number == DATA for end in ends_of(content)), default=0)
    stack = data + max(STACK, STACK_PER_BYTE * len(code))
    return Module(linked(code, sections, functions), -(-stack // 64) * 64)


def object_code(text: str, loops: bool) -> bytes:
    """LLVM's object code for WebAssembly."""
    import llvmlite.binding as llvm

    from lagrange_cli.native.compilation.llvm import reduction
    from lagrange_cli.native.llvm.declarations import complete

    llvm.set_option("", reduction(loops))
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
    wide = [wide_product()] if "mul i128" in text else []
    return "\n".join([text, *map(fma, lanes), chosen("fmin", "olt"), chosen("fmax", "ogt"), *wide])


def fma(lanes: int) -> str:
    """``@fma.N(a, b, c)``: a * b + c from operations that are rounded one by one (T. J. Dekker, Numerische
    Mathematik 18, 1971: the product without loss, then the sum).

    The sum of the three parts is rounded twice. If c is about -a * b, as where the error of a product is
    asked for, the result is exact. What is too large for that is computed as it is without ``fma``.
    """
    f = Function(f"define internal REAL @fma.{lanes}(REAL %a, REAL %b, REAL %c) #0", lanes)
    a, b, c = f.reals("a", "b", "c")
    product = a * b
    (a_high, a_low), (b_high, b_low) = halves(a), halves(b)
    error = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)
    total = product + c
    back = total - product
    rest = (product - (total - back)) + (c - back)
    value = total + (rest + error)
    f.give(f.select(value.compared("ord", value), value, total))
    return f.text()


def halves(x: Real) -> tuple[Real, Real]:
    """The upper and the lower 26 digits of x (G. W. Veltkamp)."""
    scaled = x * SPLITTER
    high = scaled - (scaled - x)
    return high, x - high


def chosen(name: str, comparison: str) -> str:
    """C's ``fmin`` or ``fmax``, which LLVM calls: the other number, where one is none."""
    f = Function(f"define hidden double @{name}(double %a, double %b) #0")
    a, b = f.reals("a", "b")
    f.give(f.select(a.compared(comparison, b) | b.compared("uno", b), a, b))
    return f.text()


def wide_product() -> str:
    """LLVM's function for products of 128 bits, with which angles beyond 2^20 are reduced."""
    f = Function("define hidden void @__multi3(ptr %product, i64 %a, i64 %a.high, i64 %b, i64 %b.high) #0")
    a, a_high, b, b_high = (Integer(f, f"%{name}") for name in ("a", "a.high", "b", "b.high"))
    (a0, a1), (b0, b1) = ([x & HALF, x.operation("lshr", 32)] for x in (a, b))
    least, one, other, most = a0 * b0, a0 * b1, a1 * b0, a1 * b1
    middle = least.operation("lshr", 32) + (one & HALF) + (other & HALF)
    for part in (one, other, middle):
        most = most + part.operation("lshr", 32)
    f.store((least & HALF) | (middle << 32), "%product")
    f.store(most + a * b_high + a_high * b, "%product", 1)
    f.give()
    return f.text()


# The format


def number(value: int) -> bytes:
    """An unsigned integer (LEB128)."""
    made = bytearray()
    while value > 127:
        made.append(value & 127 | 128)
        value >>= 7
    return bytes([*made, value])


class ByteReader:
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
    reader = ByteReader(code, 8)
    while reader.place < len(code):
        yield reader.byte(), reader.bytes()


def exported(sections: Sequence[tuple[int, bytes]]) -> dict[str, int]:
    """The functions that others may call, by name."""
    found: dict[str, int] = {}
    for section, content in sections:
        reader = ByteReader(content)
        if section != 0 or reader.text() != "linking":
            continue
        reader.number()  # the version
        while reader.place < len(content):
            part, inner = reader.byte(), ByteReader(reader.bytes())
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
    reader = ByteReader(content)
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
