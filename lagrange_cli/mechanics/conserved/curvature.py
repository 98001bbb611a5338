"""The curvature of the metric that the mass matrix M is, at random places modulo a prime.

With the symbols of Christoffel of the first kind, C_p,bc = (M_pb,c + M_pc,b - M_bc,p)/2, it is

    R_abcd = (M_ad,bc + M_bc,ad - M_ac,bd - M_bd,ac)/2 + C_ad M^-1 C_bc - C_ac M^-1 C_bd

(L. D. Landau and E. M. Lifshitz, The Classical Theory of Fields, eq. 92.1). Where it is not 0, there are no
coordinates in which T = m v^2/2. Where it is not K (M_ac M_bd - M_ad M_bc) with one K everywhere, a free
motion has fewer than n (n + 1)/2 symmetries (L. P. Eisenhart, Riemannian Geometry, 1926, section 71). What is
not 0 modulo a prime is not 0, so that nothing is missed.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from itertools import combinations, islice, product

from lagrange_cli.expression.modular import solved
from lagrange_cli.expression.node import Kind, reachable, union
from lagrange_cli.expression.residues import SMALL
from lagrange_cli.mechanics.conserved.residue_states import States
from lagrange_cli.mechanics.variables import variables


def may_be_flat(states: States) -> bool:
    """Whether it is not shown that the space of a system without constraints is curved."""
    return not any(curvature for curvature, _ in curvatures(states, 1))


def may_be_uniform(states: States) -> bool:
    """Whether it is not shown that its curvature is not the same in all places and directions."""
    every = [*curvatures(states, 2)]
    bent, area = next((one for one in every if one[1]), (0, 1))
    return all((r * area - bent * a) % SMALL == 0 for r, a in every)


def curvatures(states: States, count: int) -> Iterator[tuple[int, int]]:
    """4 R_abcd and 4 (M_ac M_bd - M_ad M_bc) for all planes ab and cd, at so many places with the same
    parameters. None where M depends on more than the coordinates, has no values, or no inverse."""
    graph, model, n = states.graph, states.model, len(states.model.q)
    moving, pairs = variables(model), [*product(range(n), repeat=2)]
    metric = {(i, j): states.noether.matrix[i][j] for i, j in pairs}
    if union(metric.values()) & moving & ~union(model.q):
        return
    slopes = {(*pair, k): graph.diff(m, q) for pair, m in metric.items() for k, q in enumerate(model.q)}
    bends = {(*some, k): graph.diff(s, q) for some, s in slopes.items() for k, q in enumerate(model.q)}
    nodes = dict.fromkeys((*metric.values(), *slopes.values(), *bends.values()))
    source, symbols = random.Random(n), (one for one in reachable(nodes) if one.kind is Kind.SYMBOL)
    parameters = {str(one.data): source.randrange(1, SMALL) for one in symbols if not one.symbols & moving}
    for state in islice(states.random(SMALL, nodes, parameters, accelerated=False), count):
        g, dg, ddg = (
            {key: state.values[one] for key, one in some.items()} for some in (metric, slopes, bends)
        )
        matrix = [[g[i, j] for j in range(n)] for i in range(n)]
        first = {(b, c): [dg[p, b, c] + dg[p, c, b] - dg[b, c, p] for p in range(n)] for b, c in pairs}
        raised = {pair: solved(matrix, one, SMALL) for pair, one in first.items()}
        if None in raised.values():
            return
        for (a, b), (c, d) in product(combinations(range(n), 2), repeat=2):
            bent = 2 * (ddg[a, d, b, c] + ddg[b, c, a, d] - ddg[a, c, b, d] - ddg[b, d, a, c])
            bent += dot(first[a, d], raised[b, c]) - dot(first[a, c], raised[b, d])
            yield bent % SMALL, 4 * (g[a, c] * g[b, d] - g[a, d] * g[b, c]) % SMALL


def dot(one: Sequence[int], other: Sequence[int] | None) -> int:
    """The sum of products of their components."""
    return sum(a * b for a, b in zip(one, other or ()))
