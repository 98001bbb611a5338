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
from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.constrained.potentials import closed_forms
from lagrange_cli.symbolic.from_graph import from_graph


def integral_of(graph: Graph, form: Mapping[int, Node], variables: Sequence[Node]) -> str | None:
    """A function that an integrable form, with coefficients by the numbers of its ``variables``, keeps
    constant, in the language of system files; None where none is found."""
    symbols = [sympy.Symbol(str(x.data)) for x in variables]
    for divided in closed_forms(graph, form, variables):
        given = [from_graph(divided[k]) if k in form else sympy.S.Zero for k in range(len(variables))]
        integral = potential([(x, sympy.simplify(a)) for x, a in zip(symbols, given)])
        if integral is not None:
            return str(integral)
    return None


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
