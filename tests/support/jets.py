"""The Taylor coefficients that the compiled code computes at one state."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lagrange_cli.integrate.arrays import aligned
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
    constants, state = aligned(max(1, program.constants)), aligned(program.state.memory)
    work, rates = aligned(program.work), np.empty(program.rows)
    machine.prepare(parameters.ctypes.data, constants.ctypes.data)
    state[: 2 * program.degrees] = [*(values.q if q is None else q), *(values.v if v is None else v)]
    regular = machine.accelerate(
        constants.ctypes.data, t, state.ctypes.data, work.ctypes.data, rates.ctypes.data
    )
    assert regular
    kept = work[: program.state.width * (program.order + 1)].reshape(program.order + 1, program.state.width)
    result = kept[:, : program.rows].T.copy()
    result[:, 0] = state[: program.rows]
    return result
