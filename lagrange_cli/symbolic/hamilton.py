"""Hamilton's form: H(q, p, t) and the canonical equations (Goldstein, Classical Mechanics, eq. 8.18)."""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from lagrange_cli.errors import UsageError
from lagrange_cli.symbolic.equations import Equations
from lagrange_cli.symbolic.grouping import neat, tidy
from lagrange_cli.symbolic.linear import solve
from lagrange_cli.symbolic.order import Order, Role


@dataclass(frozen=True)
class Hamiltonian:
    """H and the canonical equations, in q, ``p`` and t; all of length n.

    dq_k/dt = dH/dp_k (``velocities``) and dp_k/dt = -dH/dq_k + Q_k (``rates``).
    """

    order: Order
    p: tuple[sympy.Expr, ...]
    H: sympy.Expr
    velocities: tuple[sympy.Expr, ...]
    rates: tuple[sympy.Expr, ...]


def hamilton_form(equations: Equations) -> Hamiltonian:
    """The Legendre transform of L.

    Raises ``UsageError`` where p = dL/dv is not linear in v, or its inverse is too long to print.
    """
    p = tuple(sympy.Symbol(f"p_{name}") for name in equations.coordinates)
    if taken := set(p) & set(equations.order.ranks):
        raise UsageError(f"{min(map(str, taken))} is the name of a momentum in --form hamilton: rename yours")
    ranks = {s: rank for s, rank in equations.order.ranks.items() if rank[0] < Role.VELOCITY}
    order = Order(ranks | {symbol: (Role.VELOCITY, index) for index, symbol in enumerate(p)})
    if any(not entry.free_symbols.isdisjoint(equations.v) for row in equations.mass_matrix for entry in row):
        raise UsageError("--form hamilton requires a Lagrangian that is quadratic in the velocities")

    at_rest = dict.fromkeys(equations.v, sympy.S.Zero)
    offsets = [momentum.xreplace(at_rest) for momentum in equations.momenta]
    excess = [own - offset for own, offset in zip(p, offsets, strict=True)]
    velocities = solve(equations.mass_matrix, excess, order)
    if velocities is None:
        raise UsageError(
            f"the Hamiltonian of {len(p)} coupled coordinates is too long to print: use --form matrix"
        )
    kinetic = sympy.Add(*(own * velocity for own, velocity in zip(excess, velocities, strict=True))) / 2
    energy = neat(kinetic - equations.L.xreplace(at_rest), order, Role.COORDINATE)
    known = dict(zip(equations.v, velocities, strict=True))
    rates = tuple(
        tidy(force.xreplace(known) - energy.diff(coordinate), order)
        for coordinate, force in zip(equations.q, equations.generalized_forces, strict=True)
    )
    return Hamiltonian(order, p, energy, velocities, rates)
