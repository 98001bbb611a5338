"""Which constraints are solved for coordinates beforehand: those that make a step take less work.

The work is counted, never measured: so every machine decides alike. A step computes so many ``ORDERS``. An
order takes the convolutions, the solution of the linear system, and a product for each term of a coordinate
that follows from others, and of its velocity. The factorization is shared by all orders of a step.
"""

from __future__ import annotations

from collections.abc import Callable

from lagrange_cli.mechanics.elimination.reduction import Elimination, eliminated
from lagrange_cli.mechanics.formulations import if_affordable
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.variables import numbered
from lagrange_cli.native.linear.symmetric import elimination
from lagrange_cli.series.program import SeriesProgram

ORDERS = 20
TERMS = 5
"""Products that a convolution counts for: it has up to ``ORDERS``, eight of which are made at once."""
SHORT = 2
"""Coordinates in a constraint that leaves as many entries 0 as there were."""


def reduced(residual: Residual) -> Elimination | None:
    """The equations without the coordinates that constraints give: all that are linear, or the short ones;
    None where neither saves work."""
    if not residual.multipliers:
        return None
    series = residual.series()
    best, least = None, work(residual, series)

    def attempt(most: int) -> Callable[[], Elimination | None]:
        return lambda: eliminated(residual, most)

    for most in dict.fromkeys((len(residual.model.q), SHORT)):
        found = if_affordable(residual.graph, attempt(most))
        if found is not None:
            needed = work(found.after, found.after.series())
            if needed < least:
                best, least = found, needed
            if found.longest <= SHORT:
                break
    return best


def work(residual: Residual, series: SeriesProgram) -> float:
    """Products for each order of a step."""
    coordinates = len(residual.model.q)
    total = float(TERMS * series.convolutions)
    for block in residual.blocks:
        places = {j: place for place, j in enumerate(block)}
        bound = sum(j >= coordinates for j in block)
        neighbours = [{places[k] for k in residual.entries[j]} - {places[j]} for j in block]
        if not (residual.definite and bound):
            neighbours = [{*range(len(block))} - {place} for place in range(len(block))]
        below = [len(after) for after in elimination(neighbours, len(block) - bound).values()]
        # L and its transpose, or L and U; and the diagonal
        total += (
            sum(2 * count + 1 for count in below) + sum(count * (count + 3) / 2 for count in below) / ORDERS
        )
    symbols = numbered((*residual.model.q, *residual.model.v))
    for one in residual.dependent:
        for node in (one.place, one.speed):
            total += 0 if node is None else len(residual.graph.gradient(node, symbols))
    return total
