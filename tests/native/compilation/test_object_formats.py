"""Object code for other platforms, as far as it can be judged without them: it needs what is there."""

from __future__ import annotations

import struct

import llvmlite.binding as llvm
import pytest

from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.program import write_run
from lagrange_cli.native.llvm.declarations import complete
from lagrange_cli.native.llvm.text import fused
from tests.support.motion import DEFAULT, FULL, residual_of

EVERY_FUNCTION = """
parameters: {k: 0.5}
coordinates: {x: {initial: 0.25}, y: {initial: 0.25}}
lagrangian: >-
  x_dot**2/2 + y_dot**2/2 - tan(x) - asin(x)*acos(k*y) - atan(y) - sinh(x)*cosh(y) - tanh(x) - atan2(x, 1 + y)
  - exp(sin(x)) - log(2 + cos(y)) - sqrt(1 + x**2) - (2 + x)**k
"""
LIBRARY = {
    "acos", "asin", "atan", "atan2", "cos", "cosh", "exp", "floor", "fma", "log", "memcpy", "memset", "pow",
    "sin", "sinh", "tan", "tanh",
}  # fmt: skip
"""What every platform's C library has."""
STACK, FLOATS = "__chkstk", "_fltused"
"""What Windows has for functions with large frames, and what it marks code with that has floating point."""
UNWINDING = {".pdata", ".xdata"}
"""Tables for exceptions, which LLVM's loader on Windows cannot place; the code has no exceptions."""


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize(
    ("triple", "cpu"),
    [
        ("x86_64-pc-windows-msvc", "x86-64"),
        ("x86_64-pc-windows-msvc", "haswell"),
        ("x86_64-apple-darwin", "haswell"),
        ("arm64-apple-darwin", "apple-m1"),
    ],
)
@pytest.mark.parametrize("system", ["driven_damped_pendulum", EVERY_FUNCTION], ids=["pendulum", "functions"])
def test_the_code_needs_nothing_that_the_platform_lacks(triple, cpu, system):
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple(triple).create_target_machine(cpu=cpu, opt=1, jit=True)
    run = {"method": "taylor", "tolerance": FULL, "outputs": frozenset(DEFAULT)}
    for ensemble in (False, True):
        program, _ = write_run(residual_of(system), Compilation(**run, ensemble=ensemble))
        text = fused(program.text) if cpu != "x86-64" else program.text
        module = llvm.parse_assembly(complete(text))
        module.triple = triple
        code = machine.emit_object(module)
        if "windows" in triple:
            sections, needed = in_coff(code)
            assert needed <= LIBRARY | {STACK, FLOATS}
        else:
            sections, needed = in_mach_o(code)
            assert needed <= {f"_{name}" for name in LIBRARY}
        assert needed and not sections & UNWINDING


def text(raw: bytes) -> str:
    return raw.partition(b"\0")[0].decode("ascii")


def in_coff(code: bytes) -> tuple[set[str], set[str]]:
    """Sections and symbols that are defined elsewhere (Microsoft, PE Format, sec. 4 and 5.4)."""
    _, count, _, table, symbols, optional, _ = struct.unpack_from("<HHIIIHH", code)
    sections = {text(code[20 + optional + 40 * i :][:8]) for i in range(count)}
    names, place, end = set(), table, table + 18 * symbols
    while place < end:
        raw, _, section, _, _, auxiliary = struct.unpack_from("<8sIhHBB", code, place)
        zeros, offset = struct.unpack("<II", raw)
        if section == 0:
            names.add(text(code[end + offset :][:99]) if zeros == 0 else text(raw))
        place += 18 * (1 + auxiliary)
    return sections, names


def in_mach_o(code: bytes) -> tuple[set[str], set[str]]:
    """The same of Apple's format (mach-o/loader.h and nlist.h)."""
    (commands,) = struct.unpack_from("<I", code, 16)
    sections, names, place = set(), set(), 32
    for _ in range(commands):
        command, size = struct.unpack_from("<II", code, place)
        if command == 0x19:  # LC_SEGMENT_64
            (count,) = struct.unpack_from("<I", code, place + 64)
            sections |= {text(code[place + 72 + 80 * i :][:16]) for i in range(count)}
        elif command == 0x2:  # LC_SYMTAB
            table, count, strings, _ = struct.unpack_from("<IIII", code, place + 8)
            for offset, kind, *_ in struct.iter_unpack("<IBBHQ", code[table : table + 16 * count]):
                if kind & 0x0F == 1:  # N_UNDF and external
                    names.add(text(code[strings + offset :][:99]))
        place += size
    return sections, names
