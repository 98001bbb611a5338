"""The rounding of constants that are computed from parameters, made visible.

A system's frequency sqrt(k/m) is rounded once and is then the same in every step. Two runs share this error,
and their difference does not show it. So a companion uses a value changed by one ulp.
"""

from __future__ import annotations

import numpy as np

from lagrange_cli.integrate.arrays import Array

SHORT = 2.0**27
"""Constants whose last 27 bits are zero are taken to be exact, as sums and products of short numbers are."""


def perturb(constants: Array, parameters: Array, number: int) -> None:
    """Change ``constants`` by one ulp, by turns ``number`` of them up and down, except those that are exact:
    short numbers, and parameters, their halves and doubles."""
    sizes = np.abs(parameters)
    exact = np.isin(np.abs(constants), np.concatenate([sizes / 2, sizes, 2 * sizes]))
    with np.errstate(invalid="ignore"):  # what is not finite is left as it is
        exact |= (np.abs(np.frexp(constants)[0]) * 2.0**53) % SHORT == 0
    rounded = np.flatnonzero(~exact & np.isfinite(constants))
    ways = np.where(np.arange(len(rounded)) // number % 2, 1, -1)
    constants[rounded] += ways * np.spacing(np.abs(constants[rounded]))
