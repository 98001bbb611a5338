"""From a model to its equations of motion, by Euler-Lagrange applied to L in sympy.

Goldstein, Poole and Safko, Classical Mechanics (3rd ed.), eqs. 1.53, 1.70, 2.44, 2.53. Coordinates,
velocities and accelerations are symbols throughout; d/dt is the chain rule,
sum_k v_k d/dq_k + a_k d/dv_k + d/dt.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import sympy

from lagrange_cli.errors import SingularCoordinate
from lagrange_cli.expression.vocabulary import acceleration_name
from lagrange_cli.model.model import Event as Occurrence
from lagrange_cli.model.model import Model
from lagrange_cli.symbolic.conservation import balance
from lagrange_cli.symbolic.constraints import (
    explicit,
    forces_of,
    multiplier_symbols,
    shown_constraints,
    with_equations,
    with_pushes,
    with_symbols,
    without_idle_multipliers,
)
from lagrange_cli.symbolic.equations import Equations, Event
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.slopes import along_motion, gradient
from lagrange_cli.symbolic.textbook import neat, textbook_form
from lagrange_cli.symbolic.work import check_size

DIFFERENCE = re.compile(r"\(\s*\w+\s*-\s*\w+\s*\)")
"""What a difference of two parameters looks like."""


def derive_equations(model: Model[sympy.Expr], noted: dict[str, sympy.Expr] | None = None) -> Equations:
    """The equations of motion of a model, its momenta, energy function and conservation laws.

    Energies and momenta are ``noted`` by name as they are found: these remain where the equations are too
    long.
    """
    noted = {} if noted is None else noted
    q, v = model.q, model.v
    a = tuple(model.algebra.symbol(acceleration_name(name)) for name in model.coordinates)
    others = [*model.parameters.values(), model.time, *q, *v, *a]
    multipliers = multiplier_symbols([each.name for each in model.constraints], "lambda", others)
    order = textbook_order(model, a, multipliers)
    model = with_symbols(model, multipliers)

    kinetic = potential = None
    if model.lagrangian is None:
        kinetic = noted["T"] = tidy(kinetic_energy(model), order)
        potential = noted["U"] = neat(model.potential, order, Role.COORDINATE)
        lagrangian = neat(kinetic - potential, order, Role.COORDINATE)
    else:
        lagrangian = neat(model.lagrangian, order, Role.VELOCITY)
    noted["L"] = lagrangian

    # the rate of a momentum is the longest expression of all: what is too long shows soon
    pairs = []
    for name, one in zip(model.coordinates, gradient(lagrangian, v), strict=True):
        momentum = noted[f"p_{name}"] = tidy(one, order)
        pairs.append(with_rate(momentum, model))
    momenta, rates = (tuple(listed) for listed in zip(*pairs, strict=True))
    slopes = tuple(tidy(one, order) for one in gradient(lagrangian, q))
    forces = tuple(tidy(force, order) for force in generalized_forces(model))
    mass_matrix = symmetric_matrix(momenta, v, order)
    own_equations = (rate - slope - force for rate, slope, force in zip(rates, slopes, forces, strict=True))
    model = with_equations(model, dict(zip(model.coordinates, own_equations, strict=True)), order)
    constraints = with_pushes(shown_constraints(model, multipliers, order), forces, order)
    constraints = without_idle_multipliers(constraints, model)
    bound = forces_of(constraints, len(q))
    idle = [
        name
        for k, (name, row) in enumerate(zip(model.coordinates, mass_matrix, strict=True))
        if all(entry == 0 for entry in (*row, *(each.slopes[k] for each in constraints)))
    ]
    if idle:
        raise SingularCoordinate(idle)
    left_sides = tuple(
        sympy.Add(*(entry * own for entry, own in zip(row, a, strict=True))) + rate - slope - force - own
        for rate, row, slope, force, own in zip(rates, mass_matrix, slopes, forces, bound, strict=True)
    )
    at_rest = dict.fromkeys((*a, *(each.multiplier for each in constraints if each.linear)), sympy.S.Zero)
    force = tuple(
        tidy(-(left.xreplace(at_rest) + own.xreplace(at_rest)), order)
        for left, own in zip(left_sides, bound, strict=True)
    )
    solution, unsolved = explicit(mass_matrix, force, constraints, order)
    accelerations = None if solution is None else solution[: len(q)]
    transform = sympy.Add(*(p * own for p, own in zip(momenta, v, strict=True))) - lagrangian
    h = neat(transform, order, Role.COORDINATE)
    conserved, changing = balance(
        model,
        order,
        (kinetic, potential, lagrangian, h),
        (momenta, slopes, forces),
        accelerations,
        constraints,
    )
    return Equations(
        name=model.name,
        coordinates=model.coordinates,
        parameters=model.parameters,
        order=order,
        time=model.time,
        q=q,
        v=v,
        a=a,
        T=kinetic,
        U=potential,
        L=lagrangian,
        momenta=momenta,
        generalized_forces=forces,
        equations=tuple(textbook_form(left, order) for left in left_sides),
        mass_matrix=mass_matrix,
        force=force,
        accelerations=accelerations,
        h=h,
        conserved=conserved,
        changing=changing,
        events=tuple(shown_event(event, order) for event in model.events),
        constraints=constraints,
        multipliers=None if solution is None else solution[len(q) :],
        unsolved=unsolved,
        degrees_of_freedom=len(q) - len(constraints),
        first_order=sum(bool(one.of) and not one.holonomic for one in model.constraints),
        redundant={one.name: neat(one.expression, order, Role.COORDINATE) for one in model.redundant},
        replaced={name: neat(one, order, Role.COORDINATE) for name, one in model.replaced.items()},
    )


def with_rate(momentum: sympy.Expr, model: Model[sympy.Expr]) -> tuple[sympy.Expr, sympy.Expr]:
    """A momentum, and its rate of change without accelerations."""
    return momentum, check_size(along_motion(momentum, model.q, model.v, model.time))


def shown_event(event: Occurrence[sympy.Expr], order: Order) -> Event:
    """An event with its expressions in textbook form."""
    changes = {name: neat(value, order, Role.VELOCITY) for name, value in event.changes.items()}
    return Event(
        event.name, neat(event.argument, order, Role.VELOCITY), event.direction, event.stops, changes
    )


def textbook_order(
    model: Model[sympy.Expr], a: Sequence[sympy.Expr], multipliers: Sequence[sympy.Expr]
) -> Order:
    """Roles and ranks of the model's symbols: parameters in the file's order, coordinates in that of q."""
    roles = (
        (Role.PARAMETER, model.parameters.values()),
        (Role.MULTIPLIER, multipliers),
        (Role.TIME, (model.time,)),
        (Role.COORDINATE, model.q),
        (Role.VELOCITY, model.v),
        (Role.ACCELERATION, a),
    )
    ranks = {symbol: (role, rank) for role, symbols in roles for rank, symbol in enumerate(symbols)}
    if model.spec is None or not DIFFERENCE.search(model.spec.text):
        return Order(ranks, model.spec is None or model.spec.decimals)
    from lagrange_cli.symbolic.differences import written_differences  # few files have them

    return Order(ranks, model.spec.decimals, written_differences(model.spec))


def kinetic_energy(model: Model[sympy.Expr]) -> sympy.Expr:
    """T = sum m v^2/2 over the particles."""
    return sympy.Add(
        *(particle.mass * component**2 / 2 for particle in model.particles for component in particle.velocity)
    )


def generalized_forces(model: Model[sympy.Expr]) -> list[sympy.Expr]:
    """Q_k = (given) + sum_i F_i . dr_i/dq_k - dD/dv_k, with Rayleigh's function D."""
    dissipation = gradient(model.dissipation, model.v)
    totals = [given - own for given, own in zip(model.generalized_forces, dissipation, strict=True)]
    for particle in model.particles:
        for component, position in zip(particle.force, particle.position, strict=False):
            if component != 0:
                slopes = gradient(position, model.q)
                totals = [total + component * own for total, own in zip(totals, slopes, strict=True)]
    return totals


def symmetric_matrix(
    momenta: Sequence[sympy.Expr], v: Sequence[sympy.Expr], order: Order
) -> tuple[tuple[sympy.Expr, ...], ...]:
    """The mass matrix dp_i/dv_j, each entry derived once."""
    upper = [[tidy(one, order) for one in gradient(p, v[i:])] for i, p in enumerate(momenta)]
    return tuple(tuple(upper[min(i, j)][abs(i - j)] for j in range(len(v))) for i in range(len(v)))
