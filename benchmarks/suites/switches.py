"""An oscillator with dry friction that turns back again and again: integration alone, beside events."""

from __future__ import annotations

import math
import sys
from argparse import Namespace
from functools import partial
from typing import Any

import numpy as np

from benchmarks.harness.report import Report
from benchmarks.suites.impacts import (
    DIGITS,
    HEYOKA,
    LAGRANGE,
    SCIPY,
    TOLERANCE,
    Engines,
    Follow,
    compared,
    compared_suite,
    lagrange,
    next_zero,
)

FREQUENCY, FORCE, FRICTION = 2.5, 2.0, 0.2
BEGIN = -0.3, 0.2
LEAST = 40
"""How much longer scipy takes at least."""
TEXT = f"""
parameters: {{w: {FREQUENCY}, F: {FORCE}, f: {FRICTION}}}
coordinates: {{x: {{initial: {BEGIN[0]}, velocity: {BEGIN[1]}}}}}
masses: {{mass: 1}}
positions: {{mass: [x]}}
potential: x**2/2 - F*x*cos(w*t)
dissipation: f*abs(x_dot)
events: {{turn: {{when: x_dot}}}}
"""


def heyoka(stop: float) -> Follow:
    """Its Taylor method; a callback changes the sign of friction, a parameter."""
    import heyoka as hy

    x, v = hy.make_vars("x", "v")
    count = [0]

    def turn(integrator: hy.taylor_adaptive, sign: int) -> bool:
        integrator.pars[0] = math.copysign(FRICTION, -integrator.pars[0])
        count[0] += 1
        return True

    rates = [(x, v), (v, FORCE * hy.cos(FREQUENCY * hy.time) - x - hy.par[0])]
    integrator = hy.taylor_adaptive(rates, [*BEGIN], t_events=[hy.t_event(v, callback=turn)])

    def follow() -> tuple[float, int]:
        integrator.time, integrator.state[:], count[0] = 0.0, BEGIN, 0
        integrator.pars[0] = math.copysign(FRICTION, BEGIN[1])
        integrator.reset_cooldowns()
        integrator.propagate_until(stop)
        return float(integrator.state[0]), count[0]

    return follow


def scipy(stop: float) -> Follow:
    """``solve_ivp`` with a terminal event, again and again."""
    from scipy.integrate import solve_ivp

    def follow() -> tuple[float, int]:
        t, y, side, count = 0.0, np.array(BEGIN), math.copysign(1.0, BEGIN[1]), 0

        def rates(t: float, y: np.ndarray) -> list[float]:
            return [y[1], FORCE * math.cos(FREQUENCY * t) - y[0] - side * FRICTION]

        def turn(t: float, y: np.ndarray) -> float:
            return float(y[1])

        turn.terminal = True  # type: ignore[attr-defined]
        while True:
            turn.direction = -side  # type: ignore[attr-defined]
            found = solve_ivp(
                rates, (t, stop), y, "DOP853", events=turn, rtol=TOLERANCE, atol=TOLERANCE, t_eval=[stop]
            )
            if found.status != 1:
                return float(found.y[0, -1]), count
            assert found.t_events is not None and found.y_events is not None
            t, y = float(found.t_events[0][0]), found.y_events[0][0]
            side, count = -side, count + 1

    return follow


ENGINES: Engines = {LAGRANGE: partial(lagrange, text=TEXT, event="turn"), HEYOKA: heyoka, SCIPY: scipy}


def true_end(stop: float) -> float:
    """x at the end by the closed form between turns, whose times are found with many digits. Friction is less
    than the force that drives the oscillator when it turns, so that it does not stay there."""
    import mpmath

    with mpmath.workdps(DIGITS):
        w, force, friction = (mpmath.mpf(str(one)) for one in (FREQUENCY, FORCE, FRICTION))
        x, v = (mpmath.mpf(str(one)) for one in BEGIN)
        t, side, driven = mpmath.mpf(0), math.copysign(1.0, BEGIN[1]), force / (1 - w**2)
        while True:
            a = x + side * friction - driven * mpmath.cos(w * t)
            b = v + driven * w * mpmath.sin(w * t)

            def back(
                s: Any,
                with_digits: bool = True,
                begin: Any = t,
                given: tuple[Any, Any] = (a, b),
                to: float = side,
            ) -> Any:
                number, functions = (mpmath.mpf, mpmath) if with_digits else (float, math)
                since, left, right = number(s) - number(begin), *map(number, given)
                free = right * functions.cos(since) - left * functions.sin(since)
                return -to * (free - number(driven * w) * functions.sin(number(w) * number(s)))

            end = next_zero(back, float(t), stop)
            last = mpmath.mpf(stop) if end is None else end
            free = a * mpmath.cos(last - t) + b * mpmath.sin(last - t)
            x = free + driven * mpmath.cos(w * last) - side * friction
            if end is None:
                return float(x)
            v, t, side = mpmath.mpf(0), end, -side


def measure(options: Namespace) -> Report:
    """All engines."""
    return compared(ENGINES, options, true_end, "turn", LEAST)


SUITE = compared_suite("switches", measure)

if __name__ == "__main__":
    sys.exit(SUITE.main())
