"""Functions F(q, t) that keep their values where a constraint on velocities holds, found by integration.

The form sum_k a_k dq_k + b dt of the constraint, divided by 1, by a coefficient or by two of them, is the
differential of F if F can be found by integrating its coefficients one after another.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy
from sympy.integrals.manualintegrate import manualintegrate

from lagrange_cli.errors import SpecError
from lagrange_cli.expression.symbolic import SympyAlgebra
from lagrange_cli.model.constraints import built_constraints
from lagrange_cli.model.scope import Scope
from lagrange_cli.spec.spec import Spec

MOST_PAIRS = 6
"""Products of two coefficients by which a form is divided."""
MOST_OPERATIONS = 60
"""The largest number of operations in a constraint whose integral is looked for."""


def integral_of(spec: Spec, name: str) -> str | None:
    """The function of a constraint that is integrable, in the language of system files; None where none is
    found."""
    try:
        scope: Scope[Any] = Scope(spec, SympyAlgebra())
        expression = next(one.expression for one in built_constraints(scope) if one.name == name)
    except (SpecError, ArithmeticError):
        return None
    if sympy.count_ops(expression) > MOST_OPERATIONS:
        return None
    rest = expression.subs(dict.fromkeys(scope.v, 0))
    form = [*(sympy.diff(expression, v) for v in scope.v), rest]
    variables = [*scope.q, scope.time]
    present = [(x, a) for x, a in zip(variables, form) if a != 0]
    factors = [a for _, a in present if a.free_symbols]
    pairs = [a * b for i, a in enumerate(factors) for b in factors[i:]]
    for divisor in (sympy.S.One, *factors, *pairs[:MOST_PAIRS]):
        found = potential([(x, sympy.simplify(a / divisor)) for x, a in zip(variables, form)])
        if found is not None:
            return str(found)
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
