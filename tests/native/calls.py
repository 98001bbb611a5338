"""Our elementary functions as functions of arrays: compiled, for any number of lanes."""

import ctypes
from collections.abc import Callable

import numpy as np

from lagrange_cli.native.arithmetic import kind
from lagrange_cli.native.compiler import compile_text
from lagrange_cli.native.elementary import ATTRIBUTES, FUNCTIONS, call, definitions
from lagrange_cli.native.emitter import Emitter
from lagrange_cli.native.machine import load


def function(name: str, lanes: int) -> Callable[..., np.ndarray]:
    """``name`` of arrays of one length (a multiple of ``lanes``), as an array with a row for each result."""
    code = load(compile_text(text(name, lanes), 1))
    address, pointer = code.address("run"), ctypes.c_void_p
    run = ctypes.CFUNCTYPE(None, pointer, pointer, ctypes.c_int64)(address)

    def evaluate(*arguments: np.ndarray) -> np.ndarray:
        assert code is not None  # it stays in memory as long as this function does
        given = np.array(np.broadcast_arrays(*arguments), dtype=float)
        results = np.empty((FUNCTIONS[name].results, given.shape[1]))
        run(given.ctypes.data, results.ctypes.data, given.shape[1])
        return results

    return evaluate


def text(name: str, lanes: int) -> str:
    """``run(arguments, results, n)``: each a matrix of n columns."""
    emitter, vector = Emitter(), kind("double", lanes)

    def place(array: str, row: int) -> str:
        offset = emitter.define(f"mul i64 %n, {row}")
        offset = emitter.define(f"add i64 {offset}, %i")
        return emitter.define(f"getelementptr double, ptr {array}, i64 {offset}")

    emitter.line("entry:\n  br label %loop\nloop:\n  %i = phi i64 [ 0, %entry ], [ %next, %loop ]")
    places = [place("%arguments", row) for row in range(FUNCTIONS[name].arguments)]
    values = [emitter.define(f"load {vector}, ptr {one}, align 8") for one in places]
    for row, value in enumerate(call(emitter, name, values, lanes)):
        emitter.line(f"  store {vector} {value}, ptr {place('%results', row)}, align 8")
    emitter.line(f"  %next = add i64 %i, {lanes}\n  %more = icmp ult i64 %next, %n")
    emitter.line("  br i1 %more, label %loop, label %done\ndone:\n  ret void")
    body = "\n".join(emitter.lines)
    made = f"define void @run(ptr %arguments, ptr %results, i64 %n) {ATTRIBUTES} {{\n{body}\n}}\n"
    return made + definitions(made)
