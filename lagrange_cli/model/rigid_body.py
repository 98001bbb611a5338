"""Rigid bodies over any algebra: the particles that stand for their rotation.

With the unit vectors e_i along a body's axes and the second moments of its mass,

    J_ij = int x_i x_j dm = tr(I) delta_ij/2 - I_ij,

the kinetic energy of its rotation is T = sum_ij J_ij (de_i/dt . de_j/dt)/2. So a body moves as its mass at
its centre does together with masses J_ii at the e_i, if the axes are principal ones (equimomental systems:
E. J. Routh, The Elementary Part of a Treatise on the Dynamics of a System of Rigid Bodies, 7th ed., 1905,
ch. 1).
As 2 a.b = (a + b)^2 - a^2 - b^2, a product of inertia is a mass at e_i + e_j. What holds for particles then
holds for bodies: d'Alembert's principle, Lagrange's equations, the ledgers.

For a quaternion q, R(q) v = q v q* is not normalized, so that e_i has the length |q|^2. Then

    T = omega . I omega/2 + tr(J) (d|q|^2/dt)^2/2,    omega = 2 Im(q* dq/dt),

and the mass matrix is regular. The last term and its derivatives by q and q_dot vanish where |q|^2 stays 1,
and so do their rates, with d2|q|^2/dt2: it changes neither the equations of motion nor the multiplier of the
norm, nor any momentum or energy. So this is exact: the equations are those of Euler and Poincare.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from operator import add
from typing import Any

from lagrange_cli.expression.algebra import Algebra, E
from lagrange_cli.expression.operations import cross
from lagrange_cli.model.model import Particle
from lagrange_cli.model.orientation import Turning
from lagrange_cli.model.scope import Scope
from lagrange_cli.spec.body import Inertia
from lagrange_cli.spec.spec import Expression

PAIRS = ((0, 1), (0, 2), (1, 2))


def carriers(scope: Scope[E], name: str, torque: Sequence[E]) -> list[Particle[E]]:
    """The particles that stand for the rotation of the body ``name``; ``torque`` (3,) or (0,), in space.

    A torque tau is that of the forces tau x e_i/2 at the e_i: e_i x (tau x e_i) = tau - e_i (e_i . tau), and
    the sum over i is 2 tau.
    """
    algebra = scope.algebra
    turning = scope.turning(name)
    moments, products = moments_of(scope, name)
    half: Any = algebra.number("0.5")
    found = []
    for pair, mass, place, velocity in equimomental(algebra, turning, moments, products):
        i, *other = pair
        force = tuple(half * x for x in cross(torque, place)) if torque and not other else ()
        label = f"{name} axes {i + 1} {other[0] + 1}" if other else f"{name} axis {i + 1}"
        found.append(Particle(label, mass, place, velocity, force, name))
    return found


def equimomental(
    algebra: Algebra[E], turning: Turning[E], moments: Sequence[Any], products: Mapping[tuple[int, int], Any]
) -> Iterator[tuple[tuple[int, ...], Any, tuple[Any, ...], tuple[Any, ...]]]:
    """The masses that stand for the rotation of a body: the numbers of the axes whose sum is where each is,
    the mass, the place and the velocity."""
    axes, rates = turning.axes, turning.rates
    for i in range(3):
        sharing = [-products[pair] for pair in products if i in pair]
        yield (i,), algebra.total([moments[i], *sharing]), axes[i], rates[i]
    for (i, j), product in products.items():
        between, moving = (tuple(map(add, one[i], one[j])) for one in (axes, rates))
        yield (i, j), product, between, moving


def moments_of(scope: Scope[E], body: str) -> tuple[list[Any], dict[tuple[int, int], Any]]:
    """The second moments of a body."""
    inertia, mass = scope.spec.bodies[body].inertia, scope.spec.masses[body]
    return second_moments(scope.algebra, inertia, scope.scalar, lambda: scope.scalar(mass))


def second_moments(
    algebra: Algebra[E], inertia: Inertia, value: Callable[[Expression], Any], mass_of: Callable[[], Any]
) -> tuple[list[Any], dict[tuple[int, int], Any]]:
    """J_ii, and the J_ij of axes that are not principal ones, with the ``value`` of each expression."""
    half: Any = algebra.number("0.5")
    given: list[Any] = [value(one) for one in inertia.entries]
    if inertia.solid:
        mass = mass_of()
        return [mass * one for one in of_solid(algebra, inertia.solid, given)], {}
    products = {}
    if len(given) == 9:
        products = {(i, j): -given[3 * i + j] for i, j in PAIRS}
        given = given[::4]
    a, b, c = given
    return [half * (b + c - a), half * (c + a - b), half * (a + b - c)], products


def of_solid(algebra: Algebra[E], solid: str, sizes: Sequence[Any]) -> list[Any]:
    """The mean squares of x_1, x_2 and x_3 in a homogeneous solid."""
    number: Any = algebra.number
    zero, squares = number("0"), [size * size for size in sizes]
    if solid == "sphere":
        return [squares[0] / number("5")] * 3
    if solid == "box":
        return [square / number("12") for square in squares]
    if solid == "rod":
        return [zero, zero, squares[0] / number("12")]
    across = squares[0] / number("4")
    return [across, across, squares[1] / number("12") if solid == "cylinder" else zero]
