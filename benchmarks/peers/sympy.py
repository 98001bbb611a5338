"""sympy: derives equations of motion and writes them as Python functions for a method of scipy."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, NamedTuple

import sympy
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

from benchmarks.motions.equations import Algebra
from benchmarks.motions.motion import Motion
from benchmarks.motions.printed import TIME, Printed

Rates = Callable[[float, Any], Any]
"""dy/dt as a function of t and the state y (2 n,)."""
ALGEBRA = Algebra(
    sympy.sin, sympy.cos, lambda x: 1 / sympy.sqrt(x), lambda terms: sympy.Add(*terms), sympy.Rational(1, 2)
)


class Derived(NamedTuple):
    """Lagrange's equations, formed, and the symbols of q and q'."""

    method: Any
    q: list[Any]
    v: list[Any]


def lagranges_equations(motion: Motion, symbols: Mapping[str, Any] | None = None) -> Derived:
    """sympy's ``LagrangesMethod`` on T - U; ``symbols`` take the place of the values of parameters."""
    q, v = dynamicsymbols(f"q:{motion.degrees}"), dynamicsymbols(f"q:{motion.degrees}", 1)
    kinetic, potential = motion.energies({**motion.parameters, **(symbols or {})}, q, v, ALGEBRA)
    method = LagrangesMethod(kinetic - potential, q)
    method.form_lagranges_equations()
    return Derived(method, q, v)


@cache
def rates(motion: Motion) -> Rates:
    """What sympy derives, solved for the accelerations: once in a process, for all methods and tolerances.

    Of the ways to call ``lambdify`` this is the fastest: simplified first, ``cse=True``, and the functions of
    ``math`` rather than numpy's, which are slow on single numbers.
    """
    method, q, v = lagranges_equations(motion)
    state = sympy.symbols(f"s:{2 * len(q)}")
    named = dict(zip([*v, *q], [*state[len(q) :], *state]))
    solved = [sympy.simplify(rate).subs(named) for rate in method.rhs()]
    made: Rates = sympy.lambdify([TIME, state], solved, "math", cse=True)
    return made


def printed_rates(equations: Printed) -> Rates:
    """The same for printed equations, which are solved for the accelerations."""
    accelerations = [each.subs(equations.values) for each in equations.accelerations]
    state = [*equations.q, *equations.v]
    made: Rates = sympy.lambdify([TIME, state], [*equations.v, *accelerations], "math", cse=True)
    return made
