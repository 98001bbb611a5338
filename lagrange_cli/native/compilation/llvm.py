"""From the text of a program to object code, and from object code to memory, by LLVM."""

from __future__ import annotations

from typing import Any

import llvmlite.binding as llvm

from lagrange_cli.native.llvm.declarations import complete
from lagrange_cli.native.llvm.text import fused
from lagrange_cli.portions import portion
from lagrange_cli.records import dataclass

EMISSION = 4.5, 8.0
"""How many times longer than reading its text LLVM takes to make code of it, at levels 0 and 1: the time left
is shown by this. At level 0 it was 4.3 to 4.5 of programs of 1 to 40 MB, at level 1 it is 7 to 10."""


@dataclass(frozen=True)
class Engine:
    """Object code in memory where LLVM has put it; ``engine`` keeps it there. ``instructions`` are all bytes,
    as nothing tells what are tables."""

    engine: Any
    instructions: int

    def address(self, function: str) -> int:
        """Where a function is, 0 if there is none of that name."""
        address: int = self.engine.get_function_address(function)
        return address


def compile_text(text: str, optimize: int, loops: bool = False) -> bytes:
    """The object code of LLVM IR for this processor; ``optimize`` is the code generation level, 0 to 3, and
    ``loops`` says whether its time is that of loops over members of families."""
    llvm.set_option("", reduction(loops))
    machine = target_machine(optimize)
    whole = complete(suited(text))
    with portion(1.0 + EMISSION[min(optimize, 1)]) as work:
        module = llvm.parse_assembly(whole)
        work.reach(1.0)
        code: bytes = machine.emit_object(module)
    return code


def reduction(loops: bool) -> str:
    """LLVM's option whether to reduce the addresses in loops to fewer ones. In ``loops`` over members that
    took a third of its time, and the code was hardly faster."""
    return f"-disable-lsr={'true' if loops else 'false'}"


def suited(text: str) -> str:
    """``text`` with ``fmuladd`` made ``fma`` where the processor can: so all levels give the same bits."""
    machine = llvm.get_process_triple().partition("-")[0]
    return fused(text) if "+fma," in features() or machine in ("aarch64", "arm64") else text


def load_with_llvm(code: bytes) -> Engine:
    """Object code of ``compile_text`` in memory, whatever the platform."""
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), target_machine(0))
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return Engine(engine, len(code))


def target_machine(optimize: int) -> Any:
    """LLVM's code generator for this processor."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_triple(llvm.get_process_triple())
    return target.create_target_machine(cpu=processor_name(), features=features(), opt=optimize, jit=True)


def processor_name() -> str:
    """LLVM's name for this processor."""
    name: str = llvm.get_host_cpu_name()
    return name


def features() -> str:
    """The features of this processor, in LLVM's notation."""
    listed: str = llvm.get_host_cpu_features().flatten()
    return listed
