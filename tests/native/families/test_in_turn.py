"""Elimination of blocks of known rank: what couples them, and multipliers of least norm. (Double-double ones
are those of motions, in ``families.test_linkages_in_turn``.)"""

from __future__ import annotations

import ctypes
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from lagrange_cli.families import elimination
from lagrange_cli.families.elimination import in_blocks
from lagrange_cli.integrate.arrays import aligned
from lagrange_cli.native.compilation.llvm import compile_text
from lagrange_cli.native.compilation.machine import FULL, load
from lagrange_cli.native.families.constraints.in_turn import DependentTables, InTurn
from lagrange_cli.native.families.tables import Tables
from lagrange_cli.native.families.vectors import DoubleVectors
from lagrange_cli.native.linear.dependent import called_in
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit
from tests.support.draws import examples


def solved(matrix, right, tied, surplus, first):
    """The solution by compiled code; None where a block has not its rank."""
    count = len(matrix)
    pairs = np.argwhere(np.tril(matrix != 0.0) | np.eye(count, dtype=bool))
    f = Function("define zeroext i1 @run(ptr noalias %entries, ptr noalias %right, ptr noalias %work) #0")
    tables = Tables(cast("Any", SimpleNamespace(slots=[])))
    blocks = in_blocks(count, pairs, tied, first)
    tabled = DependentTables(count, blocks, first, surplus, tables)
    solver, regular = InTurn(DoubleVectors(f), tabled, f.pointer("%work"), 0), f.variable(Bit(f, "true", 1))
    solver.factor(f.pointer("%entries"), tabled.placed(pairs), regular)
    for _ in range(2):  # a factorization serves all orders of a step
        solver.solve(f.pointer("%right"))
    f.give(regular.get())
    text = tables.text() + f.text()
    loaded, pointer = load(compile_text(text + called_in(text), FULL)), ctypes.c_void_p
    run = ctypes.CFUNCTYPE(ctypes.c_bool, pointer, pointer, pointer)(loaded.address("run"))
    entries, given, work = aligned(len(pairs)), aligned(count), aligned(tabled.size)
    entries[:], given[:] = matrix[tuple(pairs.T)], right
    work[:] = np.nan  # what is not written is not read
    found = run(*(one.ctypes.data for one in (entries, given, work)))
    return work[:count].copy() if found else None


def linkage(source, groups, single):
    """The slopes of so many groups of four constraints, one of which follows from the others of its group, on
    five coordinates each, and of ``single`` constraints that couple groups that are neighbours."""
    slopes = np.zeros((4 * groups + single, 5 * groups))
    for k in range(groups):
        own = source.integers(-3, 4, (3, 5)).astype(float)
        mixed = source.choice([-2, -1, 1, 2], 3) @ own  # a constraint without slopes is none
        slopes[4 * k : 4 * k + 4, 5 * k : 5 * k + 5] = source.permutation([*own, mixed])
    for row in slopes[4 * groups :]:
        begin = int(source.integers(0, 5 * groups - 7))
        row[begin : begin + 7] = source.integers(-3, 4, 7)
    return slopes


@pytest.mark.parametrize("form", ["positive", "with masses"])
@given(seed=st.integers(0, 2**32), groups=st.integers(2, 5), single=st.integers(0, 5))
@examples(6)
def test_the_solution_of_least_norm(form, seed, groups, single):
    """That of numpy's singular values, up to the condition, where blocks are coupled."""
    source = np.random.default_rng(seed)
    slopes = linkage(source, groups, single)
    count, coordinates = slopes.shape
    masses, first = np.diag(source.uniform(0.5, 2.0, coordinates)), 0
    matrix = slopes @ np.linalg.inv(masses) @ slopes.T
    if form == "with masses":
        masses += 0.2 * (np.eye(coordinates, k=1) + np.eye(coordinates, k=-1))
        matrix = np.block([[masses, -slopes.T], [-slopes, np.zeros((count, count))]])
        first = coordinates
    singular = np.linalg.svd(matrix, compute_uv=False)
    rank = len(matrix) - groups
    assume(singular[rank - 1] > 1e-5 * singular[0])
    right = matrix @ source.integers(-9, 9, len(matrix))
    tied = [range(first + 4 * k, first + 4 * k + 4) for k in range(groups)]
    surplus = {group[-1] for group in tied}
    expected = np.linalg.lstsq(matrix, right, rcond=1e-10)[0]
    room = 2.0**-44 * np.abs(expected).max() * singular[0] / singular[rank - 1]
    for together in (0, 48):  # in blocks of those that are tied, and as one block
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(elimination, "TOGETHER", together)
            found = solved(matrix, right, tied, surplus, first)
        assert found is not None
        assert found == pytest.approx(expected, abs=room)
        assert matrix @ found == pytest.approx(right, abs=room * singular[0] * 2.0**-8 + 2.0**-40)


def test_a_rank_that_is_lost_is_found():
    """One constraint more follows from the others: by itself, or by what couples it."""
    slopes = linkage(np.random.default_rng(1), 3, 2)
    tied, surplus = [range(4 * k, 4 * k + 4) for k in range(3)], {3, 7, 11}
    for lost in (slopes[12], slopes[0] + slopes[5]):
        slopes[13] = lost
        matrix = slopes @ slopes.T
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(elimination, "TOGETHER", 0)
            assert solved(matrix, matrix @ np.ones(14), tied, surplus, 0) is None
