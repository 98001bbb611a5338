"""The way across a place where a force has no series: it is short, or there is none."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.integrate.method import Start
from lagrange_cli.integrate.methods.compiled import CompiledEquations
from lagrange_cli.integrate.methods.stepper import Stepper
from lagrange_cli.integrate.precision import DOUBLE_DOUBLE
from lagrange_cli.integrate.times import Times
from tests.support.motion import prepared

BARRIER = """
coordinates: {x: {initial: 0}}
masses: {ball: 1}
embedding: {ball: [x]}
potential: exp(-abs(x - 0.5148)*463)
"""


@pytest.mark.exhaustive(keep=0.8)
def test_a_corner_that_is_far_is_not_what_stops_a_motion():
    """Nothing of the barrier is felt at first."""
    machine = prepared(BARRIER, tolerance=2.0**-104, precision=DOUBLE_DOUBLE).machine
    state = np.zeros((2, machine.program.rows))
    state[0, :2] = -1.05, 1.7314
    stepper = Stepper(
        CompiledEquations(machine), Start(np.empty(0), state.ravel(), Times(0.0, 10.0, 2, 10.0)), 2
    )
    assert stepper._settling is not None
    assert not stepper._settling.cross()
    assert stepper.space.t == 0.0
