"""Terms of the integrals of separable systems.

Where the Hamilton-Jacobi equation separates, each coordinate k has an equation p_k^2 = sum_j c_j f_j(q_k),
with constants c_j: h, momenta of cyclic coordinates, and others. So there are integrals that are sums of
p_k p_l f, h g and u, with functions f, g, u of one coordinate (P. Staeckel, C. R. Acad. Sci. 116, 485, 1893),
such as those of Liouville, and Carter's constant (Phys. Rev. 174, 1559, 1968). The functions are those that L
is made of, and their reciprocals.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.mechanics.conserved.ansatz import Term, Variables, powers
from lagrange_cli.mechanics.conserved.noether import Noether
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model


def functions_of(model: Model[Node], matrix: Sequence[Sequence[Node]]) -> list[Node]:
    """Functions of one coordinate in L, and their reciprocals; ``matrix`` is the mass matrix."""
    graph = graph_of(model)
    lagrangian = -model.potential if model.lagrangian is None else model.lagrangian
    (still,) = substituted(graph, [lagrangian], dict.fromkeys(model.v, graph.zero))
    pieces = [one for node in (*chain.from_iterable(matrix), still) for one in pieces_of(node, model)]
    return [*dict.fromkeys(one for piece in pieces for one in (piece, graph.one / piece))]


def separable(
    model: Model[Node], noether: Noether, functions: Sequence[Node]
) -> tuple[Variables, list[Term]]:
    """The momenta, and the terms of such sums."""
    h, n = noether.energy, len(model.q)
    none = (0,) * n
    found = [Term(none, (), (one,)) for one in functions]
    found += [Term(none, (), (h, one)) for one in functions]
    for speeds in powers(n, 2):
        found += [Term(speeds, ()), *(Term(speeds, (), (one,)) for one in functions)]
    names = [f"p_{name}" for name in model.coordinates]
    return Variables((), noether.energetics.momenta, (), names, words={h: "h"}), found


def pieces_of(node: Node, model: Model[Node]) -> Iterator[Node]:
    """The largest parts of an expression that depend on one coordinate, without constant factors; of sums,
    their terms before them."""
    graph, moving = node.graph, variables(model)
    count = sum(bool(node.symbols & q.symbols) for q in model.q)
    if node.kind is Kind.SUM or (count > 1 and node.kind is Kind.PRODUCT):
        for one in node.arguments:
            yield from pieces_of(one, model)
    if count == 1:
        factors = [*zip(node.arguments, node.data)] if node.kind is Kind.PRODUCT else [(node, 1)]
        yield graph.product((a, e) for a, e in factors if a.symbols & moving)
    elif count > 1 and node.kind is Kind.PRODUCT:
        for q in model.q:
            alone = [(a, e) for a, e in zip(node.arguments, node.data) if not a.symbols & moving & ~q.symbols]
            yield from pieces_of(graph.product(alone), model)
