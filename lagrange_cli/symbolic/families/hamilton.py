"""Hamilton's form of systems of families with a constant diagonal M, with indices: H = sum p^2/(2 m) + U, and
p - dL0/dq_dot instead of p where L has terms L0 that are linear in velocities."""

from __future__ import annotations

from collections.abc import Mapping

import sympy

from lagrange_cli.errors import UsageError
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.records import dataclass
from lagrange_cli.symbolic.families.equations import FamilyEquations
from lagrange_cli.symbolic.families.lines import Line, symbol_of
from lagrange_cli.symbolic.families.sums import gathered
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.indexed.members import KNOWN, Ranks, opened, renamed, summed_of
from lagrange_cli.symbolic.order import Order, Role


@dataclass(frozen=True)
class FamilyHamiltonian:
    """H and the canonical equations in q, p and t: dq/dt = dH/dp (``velocities``) and dp/dt = -dH/dq + Q
    (``rates``; with constraints, + A^T lambda), with a line for members that are alike."""

    order: Order
    H: sympy.Expr
    velocities: tuple[Line, ...]
    rates: tuple[Line, ...]


def momentum_name(coordinate: str) -> str:
    """``p_x`` for ``x``."""
    return f"p_{coordinate}"


def hamilton_form(equations: FamilyEquations) -> FamilyHamiltonian:
    """The Legendre transform of L. Raises ``UsageError`` where a name is taken, and ``Unsuited`` where
    velocities in forces cannot be replaced with indices."""
    if equations.masses is None:
        raise Unsuited
    ranks = equations.order.ranks
    assert isinstance(ranks, Ranks)
    bases = {name: role for name, role in ranks.bases.items() if role[0] < Role.VELOCITY}
    for rank, family in enumerate(equations.coordinates):
        name = momentum_name(family.name)
        if name in ranks.bases:
            raise UsageError(f"{name} is the name of a momentum in --form hamilton: rename yours")
        bases[name] = Role.VELOCITY, rank
    order = Order(Ranks(bases), equations.order.decimals)
    speeds = {velocity_name(family.name): family.name for family in equations.coordinates}
    kinetic, velocities = [], []
    for line, momentum in zip(equations.masses, equations.momenta, strict=True):
        p = symbol_of(line, momentum_name(line.family.name)) - at_rest(momentum.expression, equations.order)
        velocities.append(line.of(tidy(p / line.expression, order)))
        kinetic.append(summed_of(p**2 / (2 * line.expression), line.loops))

    def known(line: Line) -> Mapping[sympy.Symbol, sympy.Expr]:
        """The velocities in a force."""
        found = {}
        for symbol in line.expression.free_symbols:
            base, indices = KNOWN.get(symbol.name, (symbol.name, ()))
            if base in speeds:
                own = [one for one in velocities if one.family.name == speeds[base]]
                alike = [one for one in own if one.indices == indices]
                if not alike and len(own) > 1:
                    raise Unsuited
                one = (alike or own)[0]
                loops = {loop.index for loop in one.loops}
                names = {a.text: b for a, b in zip(one.indices, indices) if a.text in loops}
                found[symbol] = one.expression if alike else renamed(one.expression, names, {})
        return found

    rates = tuple(line.of(tidy(line.expression.xreplace(known(line)), order)) for line in equations.driving)
    potential = equations.U
    if potential is None:
        potential = -equations.L
    potential = at_rest(potential, equations.order)
    H = gathered(sympy.Add(*kinetic), order) + potential
    return FamilyHamiltonian(order, H, tuple(velocities), rates)


def at_rest(expression: sympy.Expr, order: Order) -> sympy.Expr:
    """An expression where all velocities are 0."""
    plain, sums = opened(expression)
    moving = [one for one in plain.free_symbols - sums.keys() if order.role(one) >= Role.VELOCITY]
    inside = {symbol: summed_of(at_rest(one.body, order), one.loops) for symbol, one in sums.items()}
    return plain.xreplace(dict.fromkeys(moving, sympy.S.Zero)).xreplace(inside)
