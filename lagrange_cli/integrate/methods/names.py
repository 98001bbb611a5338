"""The methods' names, where what they have in common is decided."""

TAYLOR = "taylor"
"""The project's own; all others are scipy's."""

IMPLICIT = frozenset({"Radau", "BDF", "LSODA"})
"""Those of scipy's methods that want the Jacobian."""

DOUBLE, DOUBLE_DOUBLE = "double", "double-double"
PRECISIONS = (DOUBLE, DOUBLE_DOUBLE)
"""What numbers are: one double, or the sum of two."""

DOUBLE_DOUBLE_COST = "20 to 50"
"""The time of a run in double-double, in times that in doubles: measured for the shipped systems of a few
coordinates (``benchmarks.doubledouble``)."""
