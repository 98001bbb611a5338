"""The compiled equations as a plain function of one state: the other side of ``equations --verify``."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from lagrange_cli.integrate.arrays import Array, at_one_state
from lagrange_cli.integrate.guards.one_state import space_at
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.compilation.machine import QUICK, compile_program
from lagrange_cli.native.elimination import reduced
from lagrange_cli.native.orders import order_for
from lagrange_cli.native.program import Steps, write_program
from lagrange_cli.outputs.plan import make_plan

CompiledValues = Callable[
    [Sequence[float], float, Sequence[float], Sequence[float]], tuple[Array, Array, float, Array, Array]
]


def compiled_values(residual: Residual) -> CompiledValues:
    """f(parameters, t, q, v) -> (accelerations (n,), momenta (n,), h, multipliers (m,), constraints (m,)),
    from the code that ``solve`` runs.

    ``parameters`` are in the order of the model's, constraints in that of the file. Accelerations are nan
    where the mass matrix is singular.
    """
    model = residual.model
    constraints = [*model.spec.all_constraints] if model.spec else [one.name for one in model.constraints]
    further = {"multipliers", "constraints"} if constraints else set[str]()
    plan = make_plan(residual, frozenset({"p", "h"} | further), loose=True)
    places = {name: place for place, name in enumerate(plan.observed)}
    bound = [[places[f"{kind} {name}"] for name in constraints] for kind in ("multiplier", "constraint")]
    less = reduced(residual)
    followed = residual if less is None else less.after
    written = write_program(followed, Steps(order_for(2.0**-52)), {}, plan.observed, observing=residual)
    machine = compile_program(written, QUICK)  # a few states are evaluated
    program = machine.program
    n = program.degrees

    def values(
        parameters: Sequence[float], t: float, q: Sequence[float], v: Sequence[float]
    ) -> tuple[Array, Array, float, Array, Array]:
        state = np.zeros(program.rows)
        state[program.state.motion] = [*q, *v]
        space = space_at(machine, np.array(parameters, dtype=np.float64), t, state)
        rates, regular = space.accelerated.rates(machine)
        results = at_one_state(machine.observe, space.constants, np.array([t]), state, len(places))
        accelerations = rates[:n] if regular else np.full(n, np.nan)
        return accelerations, results[:n], float(results[n]), results[bound[0]], results[bound[1]]

    return values
