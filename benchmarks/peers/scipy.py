"""scipy's methods on what sympy derives, what one does without any other program."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import integrate

from benchmarks.harness.turns import timed
from benchmarks.motions.motion import Motion
from benchmarks.motions.printed import Printed
from benchmarks.motions.stiff import Stiff
from benchmarks.peers import Array, Course, Engine
from benchmarks.peers.sympy import Rates, printed_rates, rates

FINEST = 1e-12
"""The tolerance of DOP853: what is tighter costs more than it gains."""
MOST_STEPS = 10**6
SPARSE = 50
"""Coordinates from which on sparse matrices are faster than full ones."""


def engine(motion: Motion, *, method: str = "DOP853", tolerance: float = FINEST) -> Engine:
    """A method on sympy's equations: LSODA by ``odeint``, twice as fast as by ``solve_ivp``."""
    seconds, function = timed(lambda: rates(motion))
    if method == "LSODA":
        return Engine(seconds, with_odeint(function, motion.grid, tolerance))
    return Engine(seconds, at_own_steps(function, motion.stop, method, tolerance))


def at_own_steps(
    function: Rates, stop: float, method: str, tolerance: float = FINEST
) -> Callable[[Array], Course]:
    """What follows a motion to ``stop``, and shows it at the method's own steps: nothing is interpolated."""

    def follow(initial: Array) -> Course:
        solution = solve(function, (0.0, stop), initial, method=method, rtol=tolerance, atol=tolerance)
        return Course(solution.y, len(solution.t) - 1)

    return follow


def with_odeint(function: Rates, times: Array, tolerance: float) -> Callable[[Array], Course]:
    """What follows a motion by LSODA."""

    def follow(initial: Array) -> Course:
        states, told = integrate.odeint(
            function, initial, times, tfirst=True, rtol=tolerance, atol=tolerance, mxstep=MOST_STEPS,
            full_output=True,
        )  # fmt: skip
        return Course(np.asarray(states).T, int(told["nst"][-1]))

    return follow


def printed(equations: Printed, times: Array, *, method: str, tolerance: float) -> Engine:
    """A method on printed equations, sampled at ``times``; in place of steps, evaluations are counted."""
    seconds, function = timed(lambda: printed_rates(equations))

    def follow(initial: Array) -> Course:
        size = np.abs(initial).max() or 1.0
        solution = solve(
            function, (times[0], times[-1]), initial, method=method, t_eval=times, rtol=tolerance,
            atol=tolerance * size,
        )  # fmt: skip
        states = np.full((len(initial), len(times)), np.nan)
        states[:, : solution.y.shape[1]] = solution.y
        return Course(states, solution.nfev)

    return Engine(seconds, follow)


def solve(*arguments: Any, **options: Any) -> Any:
    """``solve_ivp``, whose types leave no room for a method by name."""
    function: Any = integrate.solve_ivp
    return function(*arguments, **options)


def stiff(motion: Stiff, *, tolerance: float) -> Engine:
    """Radau on rates by hand, in numba; of many coordinates the matrices are sparse ones."""
    import numba

    rates, y = numba.njit(motion.rates), motion.pairs
    seconds, _ = timed(lambda: rates(0.0, y, np.empty_like(y)))
    near = abs(np.subtract.outer(np.arange(len(y)), np.arange(len(y)))) <= motion.reach
    sparse = {"jac_sparsity": near} if motion.count >= SPARSE else {}

    def function(t: float, state: Array) -> Array:
        rates(t, state, found := np.empty_like(state))
        return found

    def follow(initial: Array) -> Course:
        solution = solve(
            function, (0.0, motion.stop), initial, method="Radau", rtol=tolerance, atol=tolerance, **sparse
        )
        return Course(solution.y[:, -1:], len(solution.t) - 1)

    return Engine(seconds, follow)
