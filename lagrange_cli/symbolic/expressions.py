"""The equations of motion as sympy objects, for further calculations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import mpmath
import sympy

from lagrange_cli.symbolic.equations import Equations


def equalities(equations: Equations) -> dict[str, sympy.Eq]:
    """The Euler-Lagrange equation of each coordinate, by its name."""
    return {
        name: equality(one.left, one.right) for name, one in zip(equations.coordinates, equations.equations)
    }


def equality(left: sympy.Expr, right: sympy.Expr) -> sympy.Eq:
    """``left = right`` as it is written."""
    return sympy.Eq(left, right, evaluate=False)


def matrix(rows: Sequence[Sequence[sympy.Expr]]) -> sympy.ImmutableMatrix:
    """Rows as a matrix that cannot change."""
    return sympy.ImmutableMatrix(rows)


def value_of(expression: sympy.Expr, values: Mapping[sympy.Expr, Any]) -> Any:
    """An expression where its symbols have these values, with the digits that mpmath works with."""
    digits = mpmath.mp.dps
    known = {symbol: sympy.Float(x, digits) for symbol, x in values.items()}
    return mpmath.mpmathify(expression.xreplace(known).evalf(digits))
