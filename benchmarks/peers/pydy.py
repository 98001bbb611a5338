"""pydy at its fastest: the accelerations solved symbolically and compiled through C; scipy's DOP853 steps."""

from __future__ import annotations

import numpy as np
from pydy.codegen.ode_function_generators import generate_ode_function
from sympy import Matrix, Symbol
from sympy.physics.mechanics import dynamicsymbols

from benchmarks.harness.turns import timed
from benchmarks.motions.motion import Motion
from benchmarks.peers import Engine
from benchmarks.peers.scipy import at_own_steps
from benchmarks.peers.sympy import Rates, lagranges_equations


def engine(motion: Motion) -> Engine:
    """For motions whose only parameter in the equations is g: pydy's compiled functions need one."""
    seconds, function = timed(lambda: rates(motion))
    return Engine(seconds, at_own_steps(function, motion.stop, "DOP853"))


def rates(motion: Motion) -> Rates:
    """What pydy compiles."""
    gravity = Symbol("g")
    method, q, v = lagranges_equations(motion, {"g": gravity})
    speeds = dynamicsymbols(f"u:{len(q)}")
    function = generate_ode_function(
        method.forcing.subs(dict(zip(v, speeds))), q, speeds, [gravity],
        mass_matrix=method.mass_matrix, coordinate_derivatives=Matrix(speeds),
        generator="cython", linear_sys_solver="sympy", constants_arg_type="array",
    )  # fmt: skip
    constants = np.array([motion.values.parameters["g"]])
    return lambda t, state: function(state, t, constants).copy()
