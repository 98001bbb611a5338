"""Impulses of many constraints, from the matrix of the equations, most entries of which are 0."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.arrays import largest_of
from lagrange_cli.integrate.impacts.refinement import chosen, refined

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.native.interface import Interface

ENOUGH = 1e-6
"""Constraints are satisfied by a step that leaves this part of what they were off by."""
REFINED = 3
"""Steps of refinement of a solution."""
SHIFT = 2.0**-30
"""Part of the largest product a^2/m that is put on the diagonal: dependent constraints do no harm then."""


def sparse_step(
    program: Interface, entries: Array, off: Array, choices: Sequence[Sequence[int]]
) -> Array | None:
    """The change of coordinates or velocities after which constraints that are ``off`` by these values are
    satisfied: of the first of the ``choices`` of those that may change with which that is possible, or of the
    last one (parts, n); None where the equations are singular. The ``entries`` (parts, k) are at the places
    of the program's pattern."""
    from scipy.sparse import csr_array, diags_array
    from scipy.sparse.linalg import splu

    n, count, parts = program.degrees, program.constraints, len(entries)
    whole = csr_array((entries[0], tuple(program.places)), shape=(n + count, n + count))
    most, moved = float(np.abs(whole[n:]).max()), np.zeros((parts, n))
    for free in choices:
        own, kept = len(free), np.array([*free, *range(n, n + count)], dtype=np.int64)
        matrix = whole[kept][:, kept]
        mass = largest_of(matrix.diagonal()[:own])
        shift = SHIFT * most**2 / (mass or 1.0) or 1.0
        right, solution = np.concatenate([np.zeros(own), off]), np.zeros((1, own + count))
        try:
            factors = splu((matrix - diags_array(np.repeat([0.0, shift], [own, count]))).tocsc())
        except RuntimeError:
            return None
        if parts == 1:
            for _ in range(REFINED):
                solution[0] += factors.solve(right - matrix @ solution[0])
        else:
            there, places = chosen(kept, program.places, n + count)
            solution = refined(factors.solve, entries[:, there], places, right, parts * REFINED)
        moved[:] = 0.0
        moved[:, kept[:own]] = solution[:, :own]
        left = off - whole[n:, :n] @ moved[0]
        if not largest_of(left) > ENOUGH * largest_of(off):
            break
    return moved if np.all(np.isfinite(moved)) else None
