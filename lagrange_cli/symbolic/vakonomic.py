"""Hamilton's principle applied to L + sum_j mu_j g_j, with constraints g_j = 0 on
velocities.

These are not the equations of motion. They contain mu_j (d/dt dg_j/dq_dot_k - dg_j/dq_k), and d'Alembert's
principle has no such forces. Only if the constraints can be integrated is the motion the same
(M. R. Flannery, Am. J. Phys. 73, 265, 2005).
"""

from __future__ import annotations

import sympy

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.records import dataclass
from lagrange_cli.symbolic.constraints import forces_of, multiplier_symbols
from lagrange_cli.symbolic.equations import Equation, Equations
from lagrange_cli.symbolic.grouping import neat
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.slopes import along_motion, slope
from lagrange_cli.symbolic.textbook import textbook_form

REMARK = (
    "unless the constraints on velocities are integrable, these are not the equations of motion, which "
    "'solve' integrates"
)


@dataclass(frozen=True)
class Vakonomic:
    """``lagrangian`` L + sum_j mu_j g_j and its Euler-Lagrange ``equations``, one for each coordinate, in q,
    q_dot, q_ddot, t, ``multipliers`` mu_j and their ``rates``, symbols both."""

    order: Order
    multipliers: tuple[sympy.Symbol, ...]
    rates: tuple[sympy.Symbol, ...]
    lagrangian: sympy.Expr
    equations: tuple[Equation, ...]


def vakonomic_form(equations: Equations) -> Vakonomic:
    """The vakonomic equations, which do not describe the motion. Raises ``UsageError`` where no constraint is
    nonholonomic."""
    given = [each for each in equations.constraints if not each.holonomic]
    if not given:
        reason = "it applies Hamilton's principle to nonholonomic constraints, and this system has none"
        raise UsageError(f"no --form vakonomic: {reason}")
    if any(each.pushes or not each.linear for each in equations.constraints):
        reason = "forces contain multipliers, and these differ between d'Alembert's and Hamilton's principle"
        raise UsageError(f"no --form vakonomic: {reason}")
    q, v, a = equations.q, equations.v, equations.a
    multipliers = multiplier_symbols([each.name for each in given], "mu", equations.order.ranks)
    rates = tuple(sympy.Symbol(velocity_name(str(symbol))) for symbol in multipliers)
    first = len(equations.constraints)
    ranks = {symbol: (Role.MULTIPLIER, first + k) for k, symbol in enumerate((*multipliers, *rates))}
    order = Order(equations.order.ranks | ranks, equations.order.decimals)
    terms = [symbol * each.expression for symbol, each in zip(multipliers, given, strict=True)]
    lagrangian = sympy.Add(neat(equations.L, order, Role.VELOCITY), *terms)
    bound = forces_of([each for each in equations.constraints if each.holonomic], len(q))
    lefts = []
    for k, (row, force, own) in enumerate(zip(equations.mass_matrix, equations.force, bound, strict=True)):
        left = sympy.Add(*(entry * one for entry, one in zip(row, a, strict=True))) - force - own
        for each, mu, rate in zip(given, multipliers, rates, strict=True):
            own_slope = each.slopes[k]
            bent = along_motion(own_slope, q, v, equations.time) - slope(each.expression, q[k])
            left += rate * own_slope + mu * bent
        lefts.append(left)
    return Vakonomic(
        order, multipliers, rates, lagrangian, tuple(textbook_form(left, order) for left in lefts)
    )
