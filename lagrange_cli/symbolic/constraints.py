"""The constraints in textbook form, and what they contribute to the equations of motion.

A constraint f(q, t) = 0 or g(q, q_dot, t) = 0 says of the velocities that sum_k a_k q_dot_k + b = 0, with
a_k = df/dq_k and b = df/dt, or a_k = dg/dq_dot_k and b the rest of g. Its generalized forces are lambda a_k
(Goldstein, Poole and Safko, Classical Mechanics, 3rd ed., section 2.4).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import sympy

from lagrange_cli.errors import NotLinear
from lagrange_cli.expression.vocabulary import dotted
from lagrange_cli.model.model import Constraint as Given
from lagrange_cli.model.model import Model
from lagrange_cli.records import replace
from lagrange_cli.symbolic.equations import Constraint
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.linear import Singular, solve
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.slopes import along_motion, gradient, slope
from lagrange_cli.symbolic.textbook import neat
from lagrange_cli.symbolic.work import COUNTER, later

LARGEST_BLOCK = 8
"""The largest number of coupled accelerations and multipliers for which an explicit solution is tried."""
LONGEST = 250
"""Terms and factors of the longest such solution that is printed."""
PATIENCE = 3_000_000
"""Steps of work after which the search for a solution ends."""

TOO_LONG = "too long to print"
DEPENDENT = "the equations do not determine the multipliers: the constraints depend on one another"
SINGULAR = "the mass matrix is singular"
BENT = "the forces are not linear in the multipliers"
"""Why there are no explicit accelerations."""

Row = Sequence[sympy.Expr]


def multiplier_symbols(
    names: Iterable[str], letter: str, known: Iterable[sympy.Expr]
) -> tuple[sympy.Symbol, ...]:
    """``lambda_rod``, or another letter, for each constraint; with underscores behind it where that is
    ``known`` already as the name of something else, or would be read as a time derivative."""
    taken = {str(symbol) for symbol in known}
    found = []
    for name in names:
        base, bracket, index = f"{letter}_{name.replace('.', '_')}".partition("[")
        while base + bracket + index in taken or dotted(base)[1]:
            base += "_"
        taken.add(base + bracket + index)
        found.append(sympy.Symbol(base + bracket + index))
    return tuple(found)


def with_equations(
    model: Model[sympy.Expr], lefts: Mapping[str, sympy.Expr], order: Order
) -> Model[sympy.Expr]:
    """The model in which the constraints of coordinates without mass are the left sides of their equations of
    motion, by name: exactly, as all numbers are here. Those of coordinates that others replace stay."""
    constraints = tuple(
        replace(one, expression=tidy(lefts[one.of], order)) if one.of in lefts else one
        for one in model.constraints
    )
    return replace(model, constraints=constraints)


def without_idle_multipliers(
    constraints: Iterable[Constraint], model: Model[sympy.Expr]
) -> tuple[Constraint, ...]:
    """The constraints of a model, with 0 for the multipliers of those that are equations of motion."""
    pairs = zip(constraints, model.constraints, strict=True)
    return tuple(replace(each, multiplier=sympy.S.Zero) if one.of else each for each, one in pairs)


def shown_constraints(
    model: Model[sympy.Expr], symbols: Sequence[sympy.Symbol], order: Order
) -> tuple[Constraint, ...]:
    """The constraints with their ``symbols``. Raises ``NotLinear``."""
    return tuple(
        shown(model, one, symbol, order) for one, symbol in zip(model.constraints, symbols, strict=True)
    )


def shown(
    model: Model[sympy.Expr], one: Given[sympy.Expr], multiplier: sympy.Symbol, order: Order
) -> Constraint:
    """One constraint."""
    q, v, time = model.q, model.v, model.time
    expression = neat(one.expression, order, Role.VELOCITY)
    if one.holonomic:
        slopes = tuple(tidy(one, order) for one in gradient(expression, q))
        drift = tidy(slope(expression, time), order)
        pairs = zip(slopes, v, strict=True)
        speed = sympy.Add(*(one * own for one, own in pairs if one != 0), drift)
    else:
        at_rest = dict.fromkeys(v, sympy.S.Zero)
        slopes = tuple(tidy(one, order) for one in gradient(expression, v))
        if any(tidy(bent, order) != 0 for one in slopes for bent in gradient(one, v)):
            raise NotLinear(one.name)
        slopes = tuple(one.xreplace(at_rest) for one in slopes)
        drift = tidy(expression.xreplace(at_rest), order)
        speed = expression
    rate = later(lambda: tidy(-along_motion(speed, q, v, time), order))
    return Constraint(one.name, expression, one.holonomic, multiplier, slopes, drift, rate)


def with_symbols(model: Model[sympy.Expr], symbols: Sequence[sympy.Symbol]) -> Model[sympy.Expr]:
    """The model with these symbols of multipliers in place of its own."""
    new = {one.multiplier: symbol for one, symbol in zip(model.constraints, symbols, strict=True)}
    particles = [replace(one, force=tuple(x.xreplace(new) for x in one.force)) for one in model.particles]
    events = [
        replace(
            one,
            argument=one.argument.xreplace(new),
            changes={name: value.xreplace(new) for name, value in one.changes.items()},
        )
        for one in model.events
    ]
    return replace(
        model,
        particles=tuple(particles),
        generalized_forces=tuple(force.xreplace(new) for force in model.generalized_forces),
        dissipation=model.dissipation.xreplace(new),
        events=tuple(events),
    )


def with_pushes(constraints: tuple[Constraint, ...], forces: Row, order: Order) -> tuple[Constraint, ...]:
    """The constraints with what the generalized ``forces`` have in front of their multipliers, as far as
    these are linear in all of them."""
    symbols = [each.multiplier for each in constraints]
    if all(force.free_symbols.isdisjoint(symbols) for force in forces):
        return constraints
    columns = zip(*(gradient(force, symbols) for force in forces), strict=True)
    pushes = [tuple(tidy(one, order) for one in column) for column in columns]
    linear = all(push.free_symbols.isdisjoint(symbols) for row in pushes for push in row)
    return tuple(
        replace(each, pushes=row) if linear else replace(each, linear=False)
        for each, row in zip(constraints, pushes, strict=True)
    )


def forces_of(constraints: Sequence[Constraint], count: int) -> tuple[sympy.Expr, ...]:
    """sum_i lambda_i a_ik, for each of ``count`` coordinates."""
    return tuple(
        sympy.Add(*(each.multiplier * each.slopes[k] for each in constraints if each.slopes[k] != 0))
        for k in range(count)
    )


def bordered(matrix: Sequence[Row], constraints: Sequence[Constraint]) -> tuple[Row, ...]:
    """[[M, -A^T - B], [-A, 0]], the matrix of accelerations and multipliers, from M; B are the pushes."""
    upper = [(*row, *(-each.column(k) for each in constraints)) for k, row in enumerate(matrix)]
    zeros = [sympy.S.Zero] * len(constraints)
    return (*upper, *((*(-slope for slope in each.slopes), *zeros) for each in constraints))


def explicit(
    matrix: Sequence[Row], force: Row, constraints: Sequence[Constraint], order: Order
) -> tuple[tuple[sympy.Expr, ...] | None, str]:
    """The accelerations and then the multipliers as functions of q, q_dot and t; or None, and why."""
    if not all(each.linear for each in constraints):
        return None, BENT
    try:
        if not constraints:
            found = solve(matrix, force.__getitem__, order)
            return found, "" if found else TOO_LONG
        whole, n = bordered(matrix, constraints), len(force)

        def right(i: int) -> sympy.Expr:
            return force[i] if i < n else -constraints[i - n].rate

        found = attempt(lambda: solve(whole, right, order, LARGEST_BLOCK, LONGEST))
        return found, "" if found else TOO_LONG
    except Singular:
        return None, DEPENDENT if constraints else SINGULAR


def attempt(function: Callable[[], tuple[sympy.Expr, ...] | None]) -> tuple[sympy.Expr, ...] | None:
    """The result of ``function``, or None where it takes too much work."""
    return function() if COUNTER.work is None else COUNTER.work.attempt(PATIENCE, function)
