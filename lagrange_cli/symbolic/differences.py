"""Differences of parameters as the file writes them: R - a, where R is greater."""

from __future__ import annotations

import sympy

from lagrange_cli.expression.build import build
from lagrange_cli.expression.symbolic import SympyAlgebra
from lagrange_cli.expression.syntax import Binary, names, parts
from lagrange_cli.spec.spec import Spec


def written_differences(spec: Spec) -> frozenset[sympy.Expr]:
    """Those that no other way of writing them contradicts."""
    parameters = {one.name for one in spec.parameters}
    algebra = SympyAlgebra()
    found = set()
    for expression in spec.in_equations:
        for part in parts(expression.tree):
            if isinstance(part, Binary) and part.operator == "-":
                inside = [*names(part)]
                if inside and all(not one.indices and one.identifier in parameters for one in inside):
                    found.add(build(part, algebra.symbol, algebra))
    return frozenset(one for one in found if one.is_Add and -one not in found)
