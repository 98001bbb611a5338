"""Functions F(q, t) that keep their values where a constraint on velocities holds, found by integration.

The form sum_k a_k dq_k + b dt of the constraint, divided by 1, by a coefficient or by two of them, is the
differential of F if F can be found by integrating its coefficients one after another.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import sympy
from sympy.integrals.manualintegrate import manualintegrate

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node, reachable
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.symbolic.from_graph import from_graph

MOST_PAIRS = 6
"""Products of two coefficients by which a form is divided."""
MOST_OPERATIONS = 120
"""The largest number of operations in a form whose integral is looked for."""


def integral_of(graph: Graph, form: Mapping[int, Node], variables: Sequence[Node]) -> str | None:
    """A function that an integrable form, with coefficients by the numbers of its ``variables``, keeps
    constant, in the language of system files; None where none is found."""
    if sum(map(operations, form.values())) > MOST_OPERATIONS:
        return None
    symbols = [sympy.Symbol(str(x.data)) for x in variables]
    factors = [a for a in form.values() if a.symbols]
    pairs = [a * b for i, a in enumerate(factors) for b in factors[i:]]
    for divisor in (graph.one, *factors, *pairs[:MOST_PAIRS]):
        divided = {k: a / divisor for k, a in form.items()}
        if not is_closed(graph, divided, variables):
            continue
        given = [from_graph(divided[k]) if k in form else sympy.S.Zero for k in range(len(variables))]
        integral = potential([(x, sympy.simplify(a)) for x, a in zip(symbols, given)])
        if integral is not None:
            return str(integral)
    return None


def is_closed(graph: Graph, form: Mapping[int, Node], variables: Sequence[Node]) -> bool:
    """Whether da_i/dx_j = da_j/dx_i for all coefficients, as that of a differential."""
    zero = graph.zero
    return all(
        is_zero(graph.diff(form.get(i, zero), x) - graph.diff(form.get(j, zero), y))
        for i, y in enumerate(variables)
        for j, x in enumerate(variables[:i])
        if i in form or j in form
    )


def operations(node: Node) -> int:
    """The number of operands in an expression, written out."""
    count: dict[Node, int] = {}
    for one in reachable([node]):
        count[one] = 1 + sum(count[argument] for argument in one.arguments)
    return count[node]


def potential(form: Sequence[tuple[Any, Any]]) -> Any:
    """F with dF = sum a dx; None where there is none, or it is not found."""
    found = sympy.S.Zero
    for x, a in form:
        missing = sympy.simplify(a - sympy.diff(found, x))
        if missing == 0:
            continue
        part = manualintegrate(missing, x)
        if part.has(sympy.Integral):
            return None
        found += part
    if all(sympy.simplify(sympy.diff(found, x) - a) == 0 for x, a in form):
        return sympy.simplify(found)
    return None
