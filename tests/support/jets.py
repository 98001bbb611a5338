"""The Taylor coefficients that the compiled code computes at one state."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lagrange_cli.integrate.guards.one_state import space_at
from lagrange_cli.integrate.workspace import outer_rows
from tests.support.motion import prepared, values_of


def coefficients(
    system: str,
    q: Sequence[float] | None = None,
    v: Sequence[float] | None = None,
    *,
    t: float = 0.0,
    outputs: tuple[str, ...] = ("q",),
) -> NDArray[np.float64]:
    """Rows q, q_dot and quadratures; column m holds coefficient m, up to the order that q is known to."""
    machine, values = prepared(system, outputs=outputs).machine, values_of(system)
    program = machine.program
    parameters = np.array([values.parameters[name] for name in program.parameters])
    state = np.zeros(program.rows)
    state[program.state.motion] = [*(values.q if q is None else q), *(values.v if v is None else v)]
    space = space_at(machine, parameters, t, state)
    _, regular = space.accelerated.rates(machine)
    assert regular
    width, order = space.layout.width, program.order
    kept = space.work[: width * (order + 1)].reshape(order + 1, width)
    result = kept[:, outer_rows(program)].T.copy()
    result[:, 0] = state
    return result
