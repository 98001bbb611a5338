"""From a model to its equations of motion, by Euler-Lagrange applied to L in sympy.

Goldstein, Poole and Safko, Classical Mechanics (3rd ed.), eqs. 1.53, 1.70, 2.44, 2.53. Coordinates,
velocities and accelerations are symbols throughout; d/dt is the chain rule,
sum_k v_k d/dq_k + a_k d/dv_k + d/dt.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy

from lagrange_cli.errors import SingularCoordinate
from lagrange_cli.expression.vocabulary import acceleration_name
from lagrange_cli.model.model import Event as Occurrence
from lagrange_cli.model.model import Model
from lagrange_cli.symbolic.canonical import contract, to_terms
from lagrange_cli.symbolic.conservation import balance
from lagrange_cli.symbolic.equations import Equation, Equations, Event
from lagrange_cli.symbolic.grouping import LONGEST, group, neat, tidy
from lagrange_cli.symbolic.linear import solve
from lagrange_cli.symbolic.monomials import Terms, TooLargeError, common_factor, divide, term
from lagrange_cli.symbolic.order import Order, Role
from lagrange_cli.symbolic.work import check_size, size_of


def derive_equations(model: Model[sympy.Expr]) -> Equations:
    """The equations of motion of a model, its momenta, energy function and conservation laws."""
    q, v = model.q, model.v
    a = tuple(model.algebra.symbol(acceleration_name(name)) for name in model.coordinates)
    order = textbook_order(model, a)

    kinetic = potential = None
    if model.lagrangian is None:
        kinetic = tidy(kinetic_energy(model), order)
        potential = neat(model.potential, order, Role.COORDINATE)
        lagrangian = neat(kinetic - potential, order, Role.COORDINATE)
    else:
        lagrangian = neat(model.lagrangian, order, Role.VELOCITY)

    momenta = tuple(tidy(lagrangian.diff(velocity), order) for velocity in v)
    slopes = tuple(tidy(lagrangian.diff(coordinate), order) for coordinate in q)
    forces = tuple(tidy(force, order) for force in generalized_forces(model))
    mass_matrix = symmetric_matrix(momenta, v, order)
    for name, row in zip(model.coordinates, mass_matrix, strict=True):
        if all(entry == 0 for entry in row):
            raise SingularCoordinate(name)
    left_sides = tuple(
        sympy.Add(*(entry * own for entry, own in zip(row, a, strict=True)))
        + along_motion(momentum, q, v, model.time)
        - slope
        - force
        for momentum, row, slope, force in zip(momenta, mass_matrix, slopes, forces, strict=True)
    )
    at_rest = dict.fromkeys(a, sympy.S.Zero)
    force = tuple(tidy(-left.xreplace(at_rest), order) for left in left_sides)
    accelerations = solve(mass_matrix, force, order)
    transform = sympy.Add(*(p * own for p, own in zip(momenta, v, strict=True))) - lagrangian
    h = neat(transform, order, Role.COORDINATE)
    conserved, changing = balance(
        model, order, (kinetic, potential, lagrangian, h), (momenta, slopes, forces), accelerations
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
    )


def shown_event(event: Occurrence[sympy.Expr], order: Order) -> Event:
    """An event with its expressions in textbook form."""
    changes = {name: neat(value, order, Role.VELOCITY) for name, value in event.changes.items()}
    return Event(
        event.name, neat(event.argument, order, Role.VELOCITY), event.direction, event.stops, changes
    )


def textbook_order(model: Model[sympy.Expr], a: Sequence[sympy.Expr]) -> Order:
    """Roles and ranks of the model's symbols: parameters in the file's order, coordinates in that of q."""
    roles = (
        (Role.PARAMETER, model.parameters.values()),
        (Role.TIME, (model.time,)),
        (Role.COORDINATE, model.q),
        (Role.VELOCITY, model.v),
        (Role.ACCELERATION, a),
    )
    return Order({symbol: (role, rank) for role, symbols in roles for rank, symbol in enumerate(symbols)})


def kinetic_energy(model: Model[sympy.Expr]) -> sympy.Expr:
    """T = sum m v^2/2 over the particles."""
    return sympy.Add(
        *(particle.mass * component**2 / 2 for particle in model.particles for component in particle.velocity)
    )


def generalized_forces(model: Model[sympy.Expr]) -> list[sympy.Expr]:
    """Q_k = (given) + sum_i F_i . dr_i/dq_k - dD/dv_k, with Rayleigh's function D."""
    totals = []
    for coordinate, velocity, given in zip(model.q, model.v, model.generalized_forces, strict=True):
        total = given - model.dissipation.diff(velocity)
        for particle in model.particles:
            for component, position in zip(particle.force, particle.position, strict=False):
                total += component * position.diff(coordinate)
        totals.append(total)
    return totals


def symmetric_matrix(
    momenta: Sequence[sympy.Expr], v: Sequence[sympy.Expr], order: Order
) -> tuple[tuple[sympy.Expr, ...], ...]:
    """The mass matrix dp_i/dv_j, each entry derived once."""
    upper = [
        [tidy(momentum.diff(v[j]), order) if j >= i else None for j in range(len(v))]
        for i, momentum in enumerate(momenta)
    ]
    return tuple(tuple(upper[min(i, j)][max(i, j)] for j in range(len(v))) for i in range(len(v)))


def along_motion(
    expression: sympy.Expr, q: Sequence[sympy.Expr], v: Sequence[sympy.Expr], time: sympy.Expr
) -> sympy.Expr:
    """d/dt of an expression as far as q and t change, v held: sum_k v_k d/dq_k + d/dt."""
    rates = (expression.diff(coordinate) * velocity for coordinate, velocity in zip(q, v, strict=True))
    return sympy.Add(*rates, expression.diff(time))


def textbook_form(left: sympy.Expr, order: Order) -> Equation:
    """``left = 0`` without common factors of parameters, what does not depend on the motion on the right.

    The factor may be divided out although a parameter could be zero: it then makes the mass matrix singular.
    """
    try:
        terms = contract(to_terms(check_size(left)))
    except TooLargeError:
        return Equation(left, sympy.S.Zero, sympy.S.One)
    content, number = common_factor(terms)
    content = frozenset((base, e) for base, e in content if order.role(base) is Role.PARAMETER)
    if accelerated := [c for m, c in terms.items() if any(order.role(b) is Role.ACCELERATION for b, _ in m)]:
        number = abs(number) if accelerated[0] > 0 else -abs(number)
    terms = divide(terms, content, number)
    moving: Terms = {}
    given: Terms = {}
    for monomial, coefficient in terms.items():
        if any(order.role(base) >= Role.COORDINATE for base, _ in monomial):
            moving[monomial] = coefficient
        else:
            given[monomial] = -coefficient
    form = Equation(group(moving, order), group(given, order), term(content, number))
    longer = size_of(form.left) > max(LONGEST, size_of(left))
    return Equation(left, sympy.S.Zero, sympy.S.One) if longer else form
