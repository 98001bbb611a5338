"""How equations of many unknowns with a symmetric matrix are factored, from the places of its entries."""

from __future__ import annotations

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.model.sparse import SparseElimination, eliminated

MOST, MOST_IN_TURN = 64, 48
"""Numbers of L for each unknown in L D L^T up to which it is sparse; and unknowns that are found together, if
some constraints follow from others in turn."""
DENSE = 2048
"""Unknowns up to which L D L^T may be dense: 32 MB, and 1.4e9 multiplications a step."""


def elimination_of(count: int, places: Places, waiting: int | None = None) -> SparseElimination | None:
    """How a matrix of ``count`` unknowns with entries at ``places`` (entries, 2), those on the diagonal and
    below, is factored; None where it is taken as dense. Raises ``Unsuited`` where L has too many numbers.
    Unknowns from number ``waiting`` on have none on the diagonal: they wait for all that they meet."""
    found, most = None, MOST * count
    if len(places) - count <= most:
        neighbours: list[set[int]] = [set() for _ in range(count)]
        for i, j in places.tolist():
            if i != j:
                neighbours[i].add(j)
                neighbours[j].add(i)
        found = eliminated(neighbours, most, waiting)
    if found is None and count > DENSE:
        raise Unsuited
    return found


def in_small_parts(count: int, pairs: Places) -> bool:
    """Whether the equations are several that do not meet each other, of few unknowns each."""
    return max(map(len, parts_of(count, pairs))) <= MOST_IN_TURN


def parts_of(count: int, pairs: Places) -> list[list[int]]:
    """The unknowns that meet each other, directly or not, from the places of a matrix's entries."""
    above = [*range(count)]

    def root(i: int) -> int:
        while above[i] != i:
            above[i] = above[above[i]]
            i = above[i]
        return i

    for i, j in pairs.tolist():
        a, b = root(i), root(j)
        above[max(a, b)] = min(a, b)
    found: dict[int, list[int]] = {}
    for i in range(count):
        found.setdefault(root(i), []).append(i)
    return [*found.values()]
