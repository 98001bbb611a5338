"""Arguments of events and of conditions that show nothing of themselves where a step begins."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.precision import DOUBLE_DOUBLE
from lagrange_cli.spec.values import resolve_long_values
from tests.support.motion import FULL, follow, prepared, run, spec_of

SYSTEM = """
coordinates: {{x: {{initial: 0, velocity: 1}}, y: {{initial: 0}}}}
masses: {{p: 1}}
positions: {{p: [x, y]}}
"""
EVENT = SYSTEM + 'events: {{e: "{argument}"}}\n'
FORCE = SYSTEM + 'generalized_forces: {{y: "where({argument} > 0, 1, 0)"}}\n'

PULSE = 0.1 * math.sqrt(math.log(2))
POWER = [math.asin(0.5 ** (1 / 60)), math.pi - math.asin(0.5 ** (1 / 60))]
HIDDEN = {
    # free motion with x = t: where the argument is 0, first on the way up
    "exp(-(t - 5)**2/0.01) - 0.5": [5 - PULSE, 5 + PULSE],
    "exp(-100*(x - 5)**2) - 0.5": [5 - PULSE, 5 + PULSE],
    "tanh(1000*(x - 3))": [3.0],
    "sin(x)**60 - 0.5": [root + k * math.pi for k in range(3) for root in POWER],
    "1/(1 + 1e4*(t - 7)**2) - 0.5": [6.99, 7.01],
}


@pytest.mark.exhaustive(keep=1.5)
@pytest.mark.parametrize("argument", HIDDEN)
def test_no_event_is_missed(argument):
    motion = follow(EVENT.format(argument=argument), 10.0, 2)
    assert np.allclose(motion["events/e/t"], HIDDEN[argument], rtol=0, atol=1e-13)


@pytest.mark.exhaustive(keep=1.5)
@pytest.mark.parametrize("argument", HIDDEN)
def test_no_change_of_a_condition_is_missed(argument):
    """y' is the time for which the argument was positive."""
    changes = [*HIDDEN[argument], 10.0] if len(HIDDEN[argument]) % 2 else HIDDEN[argument]
    motion = follow(FORCE.format(argument=argument), 10.0, 2)
    assert abs(motion["v/y"][-1] - sum(np.diff(changes)[::2])) < 1e-13


def test_nor_in_double_double():
    argument = "exp(-100*(x - 5)**2) - 0.5"
    system = EVENT.format(argument=argument)
    ready = prepared(system, tolerance=FULL**2, precision=DOUBLE_DOUBLE)
    motion = run(ready, resolve_long_values(spec_of(system)), 0.0, 10.0, 2)
    assert np.allclose(motion["events/e/t"], HIDDEN[argument], rtol=0, atol=1e-14)


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize(
    ("argument", "end", "events"),
    [
        ("tan(t) - 1", math.pi / 2, [math.pi / 4]),
        ("1/(x - 3.25) + 2", 3.25, [2.75]),
        ("1/(t - 3.25)**2 - 4", 3.25, [2.75]),
        ("log(3.25 - t)", 3.25, [2.25]),
    ],
)
def test_a_motion_ends_where_what_is_watched_has_no_value(argument, end, events):
    motion = follow(EVENT.format(argument=argument), 10.0, 2)
    assert motion.outcome.ending is Ending.STEP_UNDERFLOW
    assert abs(motion.outcome.t - end) < 1e-9
    assert np.allclose(motion["events/e/t"], events, rtol=0, atol=1e-13)
    held = follow(FORCE.format(argument=argument), 10.0, 2)
    assert held.outcome.ending is Ending.STEP_UNDERFLOW


def test_a_jump_over_0_is_no_event():
    """atan2(sin(t), cos(t)) goes from pi to -pi where t = pi."""
    motion = follow(EVENT.format(argument="atan2(sin(t), cos(t)) - 1"), 10.0, 2)
    assert np.allclose(motion["events/e/t"], [1.0, 1.0 + 2 * math.pi], rtol=0, atol=1e-13)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("power", [2, 3, 5])
def test_a_series_of_few_orders_is_known_no_farther_than_others(power):
    """cos(t^n) begins with the orders 0, 2n, 4n, and the last orders of a series may be none of these."""
    motion = follow(EVENT.format(argument=f"cos(t**{power})"), 3.0, 2)
    count = math.floor(3.0**power / math.pi + 0.5)
    expected = ((np.arange(count) + 0.5) * math.pi) ** (1 / power)
    assert np.allclose(motion["events/e/t"], expected, rtol=0, atol=1e-13)
