"""Machine code from the text of a program, through LLVM."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import llvmlite.binding as llvm

from lagrange_cli.native.program import STEPPING, Program


@dataclass(frozen=True)
class Machine:
    """A compiled program: its functions as callables over addresses; ``engine`` keeps the code alive."""

    program: Program
    engine: Any
    prepare: Callable[..., None]
    observe: Callable[..., None]
    linearize: Callable[..., None] | None
    advance: Callable[..., int] | None
    accelerate: Callable[..., int]


def compile_program(program: Program, optimize: int = 1) -> Machine:
    """Compile ``program`` for this processor; ``optimize`` is LLVM's code generation level, 0 to 3."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_triple(llvm.get_process_triple())
    machine = target.create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=llvm.get_host_cpu_features().flatten(), opt=optimize, jit=True
    )
    module = llvm.parse_assembly(program.text)
    engine = llvm.create_mcjit_compiler(module, machine)
    engine.finalize_object()
    pointer, integer, real = ctypes.c_void_p, ctypes.c_int64, ctypes.c_double

    def function(name: str, result: Any, *arguments: Any) -> Any:
        address = engine.get_function_address(name)
        return ctypes.CFUNCTYPE(result, *arguments)(address) if address else None

    stepping = program.order >= STEPPING
    return Machine(
        program=program,
        engine=engine,
        prepare=function("prepare", None, pointer, pointer),
        observe=function("observe", None, pointer, pointer, pointer, pointer, integer, integer),
        linearize=function("linearize", None, pointer, pointer, pointer, pointer, integer, integer),
        advance=function(
            "advance", integer, pointer, pointer, pointer, pointer, real, pointer, integer, pointer,
            integer, integer, integer, pointer,
        ) if stepping else None,
        accelerate=function("accelerate", integer, pointer, real, pointer, pointer, pointer),
    )  # fmt: skip
