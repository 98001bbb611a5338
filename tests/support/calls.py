"""Elementary functions, ours and the C library's, compiled as functions of arrays."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence

import numpy as np

from lagrange_cli.native.compilation.llvm import compile_text
from lagrange_cli.native.compilation.machine import load
from lagrange_cli.native.functions.elementary import ATTRIBUTES, FUNCTIONS, call, definitions
from lagrange_cli.native.llvm.text import Operand
from lagrange_cli.native.llvm.vector import kind
from lagrange_cli.native.numbers.double import Emitter

Write = Callable[[Emitter, Sequence[Operand]], Sequence[Operand]]


def function(name: str, lanes: int) -> Callable[..., np.ndarray]:
    """Our function ``name`` of arrays of one length (a multiple of ``lanes``); a row for each result."""
    return compiled(text(name, lanes), FUNCTIONS[name].results)


def text(name: str, lanes: int) -> str:
    """A program that calls ``name``."""
    made = looped(
        lambda emitter, values: call(emitter, name, values, lanes), FUNCTIONS[name].arguments, lanes
    )
    return made + definitions(made)


def compiled(text: str, results: int) -> Callable[..., np.ndarray]:
    """The function of arrays that the program of ``looped`` computes."""
    return loaded(compile_text(text, 1), results)


def loaded(program: bytes, results: int) -> Callable[..., np.ndarray]:
    """The same of its object code."""
    code = load(program)
    address, pointer = code.address("run"), ctypes.c_void_p
    run = ctypes.CFUNCTYPE(None, pointer, pointer, ctypes.c_int64)(address)

    def evaluate(*arguments: np.ndarray) -> np.ndarray:
        assert code is not None  # it stays in memory as long as this function does
        given = np.array(np.broadcast_arrays(*arguments), dtype=float)
        made = np.empty((results, given.shape[1]))
        run(given.ctypes.data, made.ctypes.data, given.shape[1])
        return made

    return evaluate


def looped(write: Write, arguments: int, lanes: int) -> str:
    """``run(arguments, results, n)`` over matrices of n columns, where ``write`` writes one evaluation."""
    emitter, vector = Emitter(), kind("double", lanes)

    def place(array: str, row: int) -> str:
        offset = emitter.define(f"mul i64 %n, {row}")
        offset = emitter.define(f"add i64 {offset}, %i")
        return emitter.define(f"getelementptr double, ptr {array}, i64 {offset}")

    emitter.line("entry:\n  br label %loop\nloop:\n  %i = phi i64 [ 0, %entry ], [ %next, %loop ]")
    places = [place("%arguments", row) for row in range(arguments)]
    values = [emitter.define(f"load {vector}, ptr {one}, align 8") for one in places]
    for row, value in enumerate(write(emitter, values)):
        emitter.line(f"  store {vector} {value}, ptr {place('%results', row)}, align 8")
    emitter.line(f"  %next = add i64 %i, {lanes}\n  %more = icmp ult i64 %next, %n")
    emitter.line("  br i1 %more, label %loop, label %done\ndone:\n  ret void")
    body = "\n".join(emitter.lines)
    return f"define void @run(ptr %arguments, ptr %results, i64 %n) {ATTRIBUTES} {{\n{body}\n}}\n"
