"""The rounding error of cyclic momenta, which are constants of the motion, made visible to estimates.

They are rounded once and are then the same in every step. Two runs share this error, and their difference
does not show it. So a companion uses a value changed by one ulp.
"""

from __future__ import annotations

import numpy as np

from lagrange_cli.integrate.arrays import Array

SHORT = 2.0**27
"""Numbers whose last 27 bits are zero are taken to be exact, as sums and products of short numbers are."""


def perturb(momenta: Array, parameters: Array) -> None:
    """Change ``momenta`` by one ulp, by turns up and down, except those that are exact: short numbers, and
    parameters, their halves and doubles."""
    sizes = np.abs(parameters)
    exact = np.isin(np.abs(momenta), np.concatenate([sizes / 2, sizes, 2 * sizes]))
    with np.errstate(invalid="ignore"):  # what is not finite is left as it is
        exact |= (np.abs(np.frexp(momenta)[0]) * 2.0**53) % SHORT == 0
    rounded = np.flatnonzero(~exact & np.isfinite(momenta))
    ways = np.where(np.arange(len(rounded)) % 2, -1, 1)
    momenta[rounded] += ways * np.spacing(np.abs(momenta[rounded]))
