"""Blocks of equations in machine code, for tests of their elimination."""

import ctypes
from fractions import Fraction

import numpy as np

from lagrange_cli.integrate.arrays import aligned
from lagrange_cli.native.compilation.llvm import compile_text
from lagrange_cli.native.compilation.machine import load
from lagrange_cli.native.linear.blocks import Factorization
from lagrange_cli.native.linear.dependent import called_in
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.double_double import DoubleDouble, operations

KINDS = {"doubles": Emitter, "double-double": DoubleDouble}


def solver(make, size, level, unrolled=0, form="general", **constraints):
    """A compiled function of (matrix, right-hand side): the solution, or None where the matrix is singular.

    Numbers are rows of their parts.
    """
    f = Function("define zeroext i1 @run(ptr noalias %matrix, ptr noalias %right, ptr noalias %work) #0")
    kind = make(f)
    parts = kind.parts

    def number(pointer, index):
        return kind.load(pointer, parts * index, 1)

    matrix = [[number("%matrix", size * j + k) for k in range(size)] for j in range(size)]
    blocks = Factorization(kind, 0, {form: unrolled})
    block, regular = blocks.factor(matrix, form == "definite", **constraints)
    for _ in range(2):  # a factorization serves all orders of a step
        solution = block.solve([number("%right", j) for j in range(size)], kind.one)
    for j, value in enumerate(solution):
        kind.store(value, "%right", parts * j, 1)
    f.give(Bit(f, regular))
    text = [*(operations() if parts == 2 else ()), *blocks.functions]
    text = "\n".join([*text, f.text()])
    loaded, pointer = load(compile_text(text + called_in(text), level)), ctypes.c_void_p
    function = ctypes.CFUNCTYPE(ctypes.c_bool, pointer, pointer, pointer)(loaded.address("run"))
    work = aligned(max(1, blocks.place))

    def solve(matrix, right):
        given, result = np.ascontiguousarray(matrix), right.copy()
        done = loaded and function(given.ctypes.data, result.ctypes.data, work.ctypes.data)
        return result if done else None

    return solve


def exact(numbers):
    """Rows of parts as fractions."""
    return [sum(map(Fraction, row)) for row in numbers]
