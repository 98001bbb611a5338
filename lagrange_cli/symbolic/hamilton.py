"""Hamilton's form: H(q, p, t) and the canonical equations (Goldstein, Classical Mechanics, eq. 8.18); and the
vakonomic equations."""

from __future__ import annotations

import sympy

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.records import dataclass
from lagrange_cli.symbolic.constraints import forces_of, multiplier_symbols
from lagrange_cli.symbolic.equations import Equation, Equations
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.linear import Singular, solve
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.slopes import along_motion, gradient, slope
from lagrange_cli.symbolic.textbook import neat, textbook_form


@dataclass(frozen=True)
class Hamiltonian:
    """H and the canonical equations, in q, ``p`` and t; all of length n, except the ``constraints``.

    dq_k/dt = dH/dp_k (``velocities``) and dp_k/dt = -dH/dq_k + Q_k (``rates``), where Q_k has the forces of
    constraint, too. Where it is not ``solved``, velocities are too long to print, or p_k = dL/dv_k is not
    linear in them: they are symbols, which this determines, H is the energy function and
    dp_k/dt = dL/dq_k + Q_k, the same as functions of them.
    """

    order: Order
    p: tuple[sympy.Expr, ...]
    H: sympy.Expr
    velocities: tuple[sympy.Expr, ...]
    rates: tuple[sympy.Expr, ...]
    constraints: tuple[sympy.Expr, ...]
    solved: bool = True


def no_hamiltonian() -> UsageError:
    """The error of a mass matrix that is singular."""
    reason = "the mass matrix is singular, so that momenta do not determine the velocities"
    return UsageError(f"there is no Hamiltonian: {reason}")


def hamilton_form(equations: Equations) -> Hamiltonian:
    """The Legendre transform of L. Raises ``UsageError`` where p = dL/dv does not determine v."""
    p = tuple(sympy.Symbol(f"p_{name}") for name in equations.coordinates)
    if taken := set(p) & set(equations.order.ranks):
        raise UsageError(f"{min(map(str, taken))} is the name of a momentum in --form hamilton: rename yours")
    ranks = {s: rank for s, rank in equations.order.ranks.items() if rank[0] < Role.VELOCITY}
    ranks |= {symbol: (Role.VELOCITY, index) for index, symbol in enumerate(p)}
    order = Order(ranks, equations.order.decimals)
    if not linear_in_velocities(equations):
        return in_steps(equations, p)

    at_rest = dict.fromkeys(equations.v, sympy.S.Zero)
    offsets = [momentum.xreplace(at_rest) for momentum in equations.momenta]
    excess = [own - offset for own, offset in zip(p, offsets, strict=True)]
    try:
        velocities = solve(equations.mass_matrix, excess.__getitem__, order)
    except Singular as error:
        raise no_hamiltonian() from error
    if velocities is None:
        return in_steps(equations, p)
    kinetic = sympy.Add(*(own * velocity for own, velocity in zip(excess, velocities, strict=True))) / 2
    energy = neat(kinetic - equations.L.xreplace(at_rest), order, Role.COORDINATE)
    known = dict(zip(equations.v, velocities, strict=True))
    bound = forces_of(equations.constraints, len(p))
    slopes = gradient(energy, equations.q)
    rates = tuple(
        tidy((force + own).xreplace(known) - slope, order)
        for slope, force, own in zip(slopes, equations.generalized_forces, bound, strict=True)
    )
    constraints = tuple(
        each.expression if each.holonomic else tidy(each.expression.xreplace(known), order)
        for each in equations.constraints
    )
    return Hamiltonian(order, p, energy, velocities, rates, constraints)


def linear_in_velocities(equations: Equations) -> bool:
    """Whether p = dL/dv is linear in v: unlike that of a relativistic particle."""
    return all(entry.free_symbols.isdisjoint(equations.v) for row in equations.mass_matrix for entry in row)


def in_steps(equations: Equations, p: tuple[sympy.Expr, ...]) -> Hamiltonian:
    """The canonical equations with velocities that momenta determine: -dH/dq at fixed p is dL/dq at fixed
    v."""
    known, count = equations.order, len(p)
    ranks = {own: (Role.VELOCITY, count + k) for k, own in enumerate(p)}
    order = Order({**known.ranks, **ranks}, known.decimals)
    bound = forces_of(equations.constraints, count)
    slopes = gradient(equations.L, equations.q)
    rates = tuple(
        tidy(slope + force + own, known)
        for slope, force, own in zip(slopes, equations.generalized_forces, bound, strict=True)
    )
    constraints = tuple(each.expression for each in equations.constraints)
    return Hamiltonian(order, p, equations.h, equations.v, rates, constraints, solved=False)


REMARK = (
    "unless the constraints on velocities are integrable, these are not the equations of motion, which "
    "'solve' integrates"
)


@dataclass(frozen=True)
class Vakonomic:
    """``lagrangian`` L + sum_j mu_j g_j and its Euler-Lagrange ``equations``, one for each coordinate, in q,
    q_dot, q_ddot, t, ``multipliers`` mu_j and their ``rates``, symbols both.

    These are not the equations of motion: they are Hamilton's principle applied to L + sum_j mu_j g_j, with
    constraints g_j = 0 on velocities. They contain mu_j (d/dt dg_j/dq_dot_k - dg_j/dq_k), and d'Alembert's
    principle has no such forces. Only if the constraints can be integrated is the motion the same
    (M. R. Flannery, Am. J. Phys. 73, 265, 2005).
    """

    order: Order
    multipliers: tuple[sympy.Symbol, ...]
    rates: tuple[sympy.Symbol, ...]
    lagrangian: sympy.Expr
    equations: tuple[Equation, ...]


def vakonomic_form(equations: Equations) -> Vakonomic:
    """The vakonomic equations, which do not describe the motion. Raises ``UsageError`` where no constraint is
    nonholonomic."""
    given = [each for each in equations.constraints if not each.holonomic and each.acts]
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
