"""Elementary functions, ours and the C library's, compiled as functions of arrays."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence

import numpy as np

from lagrange_cli.native.compilation.llvm import compile_text
from lagrange_cli.native.compilation.machine import load
from lagrange_cli.native.functions.elementary import FUNCTIONS, definitions
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Real

Write = Callable[[Function, Sequence[Real]], Sequence[Real]]


def function(name: str, lanes: int) -> Callable[..., np.ndarray]:
    """Our function ``name`` of arrays of one length (a multiple of ``lanes``); a row for each result."""
    return compiled(text(name, lanes), FUNCTIONS[name].results)


def text(name: str, lanes: int) -> str:
    """A program that calls ``name``."""
    function = FUNCTIONS[name]

    def write(f: Function, values: Sequence[Real]) -> list[Real]:
        return f.parts([Real] * function.results, f"{name}.{lanes}", *values)

    made = over_columns(write, function.arguments, lanes)
    return made + definitions(made)


def compiled(text: str, results: int) -> Callable[..., np.ndarray]:
    """The function of arrays that the program of ``over_columns`` computes."""
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


def over_columns(write: Write, arguments: int, lanes: int) -> str:
    """``run(arguments, results, n)`` over matrices of n columns, where ``write`` writes one evaluation."""
    f = Function("define void @run(ptr %arguments, ptr %results, i64 %n) noinline #0", lanes)
    n = Integer(f, "%n", 1)
    with f.loop(0, n, lanes, tested=False) as i:
        values = [f.load_row("%arguments", n * row + i, lanes) for row in range(arguments)]
        for row, value in enumerate(write(f, values)):
            f.store_row(value, "%results", n * row + i)
    f.give()
    return f.text()
