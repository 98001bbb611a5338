"""SUNDIALS' CVODE, as scikit-sundae has it: backward differentiation formulas for stiff systems."""

from __future__ import annotations

import numba
import numpy as np
from sksundae.cvode import CVODE

from benchmarks.harness.turns import timed
from benchmarks.motions.stiff import Stiff
from benchmarks.peers import Array, Course, Engine

BANDED = 50
"""From so many coordinates on the matrices are banded ones."""


def stiff(motion: Stiff, *, tolerance: float) -> Engine:
    """The rates by hand, in numba."""
    rates, y = numba.njit(motion.rates), motion.pairs
    seconds, _ = timed(lambda: rates(0.0, y, np.empty_like(y)))
    band = {"linsolver": "band", "lband": motion.reach, "uband": motion.reach}

    def follow(initial: Array) -> Course:
        solver = CVODE(
            rates, method="BDF", rtol=tolerance, atol=tolerance, max_num_steps=10**7,
            **(band if motion.count >= BANDED else {}),
        )  # fmt: skip
        found = solver.solve(np.array([0.0, motion.stop]), initial)
        return Course(np.asarray(found.y[-1])[:, None], found.nfev)

    return Engine(seconds, follow)
