"""Hamilton's form: H(q, p, t) and the canonical equations (Goldstein, Classical Mechanics, eq. 8.18)."""

from __future__ import annotations

import sympy

from lagrange_cli.errors import UsageError
from lagrange_cli.records import dataclass
from lagrange_cli.symbolic.constraints import forces_of
from lagrange_cli.symbolic.equations import Equations
from lagrange_cli.symbolic.grouping import neat, tidy
from lagrange_cli.symbolic.linear import Singular, solve
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.slopes import gradient


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
        velocities = solve(equations.mass_matrix, excess, order)
    except Singular as error:
        reason = "the mass matrix is singular, so that momenta do not determine the velocities"
        raise UsageError(f"there is no Hamiltonian: {reason}") from error
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
