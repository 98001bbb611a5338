"""Integrals of many equal particles on a line that act on each other in pairs, of every degree.

Let I_k be the sum of all products of k velocities of different particles, with -V_ij/m in place of any of the
products v_i v_j of a pair. For the Toda lattice these are the coefficients of the characteristic polynomial
of Flaschka's matrix (M. Henon, Phys. Rev. B 9, 1921, 1974), for the particles of Calogero and Sutherland
those of Moser's (K. Sawada and T. Kotera, J. Phys. Soc. Japan 39, 1614, 1975). For other potentials they are
not constant: like all candidates they have to be proven.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node, terms_of
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model

FEWEST = 5
"""The least number of particles: of fewer, all polynomials are tried."""

Pairs = Mapping[tuple[int, int], Node]


def pairs_of(model: Model[Node], matrix: Sequence[Sequence[Node]]) -> Pairs | None:
    """V_ij/m by pairs; None for another system."""
    graph, count = graph_of(model), len(model.q)
    if model.lagrangian is not None or model.constraints or not count >= FEWEST:
        return None
    mass = matrix[0][0]
    if any(
        one is not (mass if i == j else graph.zero)
        for i, row in enumerate(matrix)
        for j, one in enumerate(row)
    ):
        return None
    found: dict[tuple[int, int], list[tuple[Node, float]]] = {}
    others = [model.time, *model.v]
    for term, factor in terms_of(model.potential):
        inside = [k for k, q in enumerate(model.q) if term.symbols & q.symbols]
        if any(term.symbols & one.symbols for one in others) or len(inside) not in (0, 2):
            return None
        if inside:
            found.setdefault((inside[0], inside[1]), []).append((term, factor))
    return {pair: graph.sum(terms) / mass for pair, terms in found.items()}


def sums_of_pairs(model: Model[Node], matrix: Sequence[Sequence[Node]]) -> Iterator[tuple[int, Node]]:
    """k and I_k, from k = 3 on."""
    pairs = pairs_of(model, matrix)
    if pairs is None:
        return
    graph = graph_of(model)
    sums = _sums(graph, model.v, pairs, 0, frozenset(), {})
    yield from ((degree, sums[degree]) for degree in range(3, len(model.q) + 1))


def _sums(
    graph: Graph,
    v: Sequence[Node],
    pairs: Pairs,
    first: int,
    gone: frozenset[int],
    known: dict[object, list[Node]],
) -> list[Node]:
    """The sums of all degrees of the particles from the ``first`` on that are not ``gone`` in pairs."""
    if first == len(v):
        return [graph.one]
    if first in gone:
        return _sums(graph, v, pairs, first + 1, gone - {first}, known)
    if (first, gone) not in known:
        rest = _sums(graph, v, pairs, first + 1, gone, known)
        terms: list[list[tuple[Node, float]]] = [[] for _ in range(len(v) + 1)]
        for degree, node in enumerate(rest):
            terms[degree].append((node, 1.0))
            terms[degree + 1].append((v[first] * node, 1.0))
        for (i, j), potential in pairs.items():
            if i == first and j not in gone:
                for degree, node in enumerate(_sums(graph, v, pairs, first + 1, gone | {j}, known)):
                    terms[degree + 2].append((potential * node, -1.0))
        made = [graph.sum(some) for some in terms if some]
        known[first, gone] = made
    return known[first, gone]
