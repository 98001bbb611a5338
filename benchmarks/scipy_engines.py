"""Engines made of Python packages: equations from sympy, integration by scipy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.engines import Array, Engine, Motion
from benchmarks.problems import Problem
from benchmarks.turns import timed

Rates = Callable[..., Any]
FINEST = 1e-12
"""The tolerance of DOP853: what is tighter costs more than it gains."""


def sympy_and_scipy(problem: Problem) -> Engine:
    """What one does without any: sympy derives, ``lambdify`` writes Python, scipy's DOP853 steps.

    Of the ways to call ``lambdify`` this is the fastest: simplified first, ``cse=True``, and the
    functions of ``math`` rather than numpy's, which are slow on single numbers.
    """
    import sympy

    def make() -> Rates:
        method, q, v = pendulums_in_sympy(problem, problem.values.parameters["g"])
        state = sympy.symbols(f"s:{2 * len(q)}")
        named = dict(zip([*v, *q], [*state[len(q) :], *state]))
        rates = [sympy.simplify(rate).subs(named) for rate in method.rhs()]
        made: Rates = sympy.lambdify([sympy.Symbol("t"), state], rates, "math", cse=True)
        return made

    return with_dop853(problem, *timed(make))


def pydy(problem: Problem) -> Engine:
    """pydy at its fastest: the accelerations solved symbolically and compiled through C, DOP853 steps."""
    from pydy.codegen.ode_function_generators import generate_ode_function
    from sympy import Matrix, Symbol
    from sympy.physics.mechanics import dynamicsymbols

    def make() -> Rates:
        gravity = Symbol("g")  # pydy's compiled functions need a constant
        method, q, v = pendulums_in_sympy(problem, gravity)
        speeds = dynamicsymbols(f"u:{len(q)}")
        function = generate_ode_function(
            method.forcing.subs(dict(zip(v, speeds))), q, speeds, [gravity],
            mass_matrix=method.mass_matrix, coordinate_derivatives=Matrix(speeds),
            generator="cython", linear_sys_solver="sympy", constants_arg_type="array",
        )  # fmt: skip
        constants = np.array([problem.values.parameters["g"]])
        return lambda t, state: function(state, t, constants).copy()

    return with_dop853(problem, *timed(make))


def pendulums_in_sympy(problem: Problem, gravity: Any) -> tuple[Any, list[Any], list[Any]]:
    """sympy's LagrangesMethod of pendulums hung one from the other, its equations formed; q and q'."""
    import sympy
    from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

    count, t = len(problem.values.q), dynamicsymbols._t
    q, v = dynamicsymbols(f"q:{count}"), dynamicsymbols(f"q:{count}", 1)
    x = y = lagrangian = sympy.Integer(0)
    for angle in q:
        x, y = x + sympy.sin(angle), y - sympy.cos(angle)
        lagrangian += (x.diff(t) ** 2 + y.diff(t) ** 2) / 2 - gravity * y
    method = LagrangesMethod(lagrangian, q)
    method.form_lagranges_equations()
    return method, q, v


def with_dop853(problem: Problem, prepare: float, rates: Rates) -> Engine:
    """The energy is compared at the method's own steps, not at interpolated ones."""
    from scipy.integrate import solve_ivp

    def follow(q: Array, v: Array) -> Motion:
        solution = solve_ivp(rates, (0.0, problem.stop), [*q, *v], method="DOP853", rtol=FINEST, atol=FINEST)
        return Motion(len(solution.t) - 1, *np.split(solution.y, 2))

    return Engine(prepare, follow)
