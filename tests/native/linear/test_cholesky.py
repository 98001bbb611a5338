"""Large definite blocks of the mass matrix: factored and solved in machine code, against numpy."""

import ctypes
from functools import partial

import numpy as np
import pytest

from lagrange_cli.integrate.arrays import aligned
from lagrange_cli.native.compilation.llvm import compile_text
from lagrange_cli.native.compilation.machine import FULL, QUICK, load
from lagrange_cli.native.linear.blocks import UNROLLED, Factorization
from lagrange_cli.native.linear.cholesky import LargeDefinite
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import literal
from lagrange_cli.native.llvm.vector import Bit
from lagrange_cli.native.numbers.double import Emitter

SCALE = -0.5


def solver(size, level):
    """A compiled function of (matrix, right-hand side, work): solves in place, says whether it could.

    The solution is of ``SCALE`` times the right-hand side.
    """
    f = Function("define zeroext i1 @solve(ptr noalias %matrix, ptr noalias %right, ptr noalias %work) #0")
    emitter = Emitter(f)
    matrix = [[emitter.load("%matrix", size * j + k) for k in range(size)] for j in range(size)]
    blocks = Factorization(emitter, 0, {"definite": partial(LargeDefinite, emitter)}, UNROLLED)
    block, regular = blocks.factor(matrix, True)
    for _ in range(2):  # twice: a factorization serves all orders of a step
        solution = block.solve([emitter.load("%right", j) for j in range(size)], literal(SCALE))
    for j, value in enumerate(solution):
        emitter.store(value, "%right", j)
    f.give(Bit(f, regular))
    # the second solution is of the first one's right-hand side, as it is only overwritten at the end
    loaded = load(compile_text("\n".join([*blocks.functions, f.text()]), level))
    pointer = ctypes.c_void_p
    function = ctypes.CFUNCTYPE(ctypes.c_bool, pointer, pointer, pointer)(loaded.address("solve"))
    return block, function, aligned(max(1, blocks.place)), loaded


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("level", [QUICK, FULL])
@pytest.mark.parametrize("size", [2, UNROLLED["definite"], 13, 16, 17, 24, 31, 50])
def test_large_definite_blocks_are_solved(size, level):
    block, function, work, loaded = solver(size, level)
    assert isinstance(block, LargeDefinite) == (size > UNROLLED["definite"])
    source = np.random.default_rng(size)
    for _ in range(3):  # again and again in the same memory, as in step after step
        half = source.normal(size=(size, size))
        matrix = half @ half.T + np.diag(source.uniform(0.5, 2.0, size))
        known = source.normal(size=size)
        right = matrix @ known
        assert function(np.ascontiguousarray(matrix).ctypes.data, right.ctypes.data, work.ctypes.data)
        error = np.linalg.norm(matrix @ right / SCALE - matrix @ known)
        assert error <= 1e-14 * size * np.linalg.norm(matrix, 2) * np.linalg.norm(known)
    assert loaded


@pytest.mark.parametrize("size", [2, 13, 24])
def test_singular_blocks_are_found(size):
    _, function, work, loaded = solver(size, FULL)
    half = np.random.default_rng(1).normal(size=(size, size - 1))
    matrix, right = half @ half.T, np.ones(size)
    assert not function(np.ascontiguousarray(matrix).ctypes.data, right.ctypes.data, work.ctypes.data)
    assert loaded
