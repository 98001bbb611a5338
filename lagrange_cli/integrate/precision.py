"""The numbers in which a motion is computed, and their precision."""

from __future__ import annotations

import sys

DOUBLE, DOUBLE_DOUBLE = "double", "double-double"
PRECISIONS = (DOUBLE, DOUBLE_DOUBLE)
"""The kinds of numbers: one double, or the sum of two."""

FULL_PRECISION = sys.float_info.epsilon
"""The relative error per step at which a double is used in full."""
FULL_DOUBLE_DOUBLE = 2.0**-104
"""About the same for a double-double."""

DOUBLE_DOUBLE_COST = "20 to 50"
"""The time of a run in double-double, in times that in doubles: measured for the shipped systems of a few
coordinates (``benchmarks.doubledouble``)."""
