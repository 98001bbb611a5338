"""An oscillator that hits a wall again and again: integration alone, beside events with callbacks."""

from __future__ import annotations

import math
import sys
from argparse import Namespace
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import Any

import numpy as np

from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import in_own_process, in_turns, timed_by_both

LAGRANGE, HEYOKA, SCIPY = "lagrange, taylor", "heyoka, a terminal event", "scipy, DOP853 from event to event"
FREQUENCY, RESTITUTION = 2.5, 0.8
STOP, LONG, SHORT = 2000.0, 20000.0, 200.0
"""Until when the motion is compared with the true one, and until when it is timed; in a quick run."""
BEGIN = -0.3, 0.2
TOLERANCE = 1e-13
"""The smallest that scipy takes as it is given, nearly."""
LEAST = 100
"""How much longer scipy takes at least."""
DIGITS, STEP = 60, 1 / 256
"""Of the true motion, and the steps in which its impacts are looked for."""
TEXT = f"""
parameters: {{w: {FREQUENCY}, e: {RESTITUTION}}}
coordinates: {{x: {{initial: {BEGIN[0]}, velocity: {BEGIN[1]}}}}}
masses: {{mass: 1}}
positions: {{mass: [x]}}
potential: x**2/2 - x*cos(w*t)
events: {{wall: {{when: x, direction: rising, action: {{set: {{x_dot: -e*x_dot}}}}}}}}
"""
Follow = Callable[[], tuple[float, int]]
"""x at the end, and how often the wall was hit."""
Engines = Mapping[str, Callable[[float], Follow]]


@dataclass(frozen=True)
class Figures:
    """What an engine takes: processor seconds until it is ready, and for an impact, or what else happens, the
    median; how often that did; and x at the end."""

    prepare: float
    impact: float
    count: int
    end: float


def lagrange(stop: float, text: str = TEXT, event: str = "wall") -> Follow:
    """This project, with a sample at each end, for a system with an event that is counted."""
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.integrate.precision import FULL_PRECISION
    from lagrange_cli.integrate.prepare import prepare_system
    from lagrange_cli.integrate.run import integrate
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.run.derive import derive_system
    from lagrange_cli.spec.read import read_spec
    from lagrange_cli.spec.values import resolve_values

    spec = read_spec(text, "oscillator")
    compilation = Compilation("taylor", FULL_PRECISION, frozenset({"q", "v"}))
    prepared = prepare_system(spec, partial(derive_system, resting=True), None, compilation)
    values = resolve_values(spec, {})

    def follow() -> tuple[float, int]:
        ends: list[float] = []
        outcome = integrate(
            prepared,
            values,
            Times(0.0, stop, 2, stop),
            lambda chunk: ends.extend(chunk["q/x"]),
            lambda: False,
        )
        return float(ends[-1]), outcome.happened[event].count

    return follow


def heyoka(stop: float) -> Follow:
    """Its Taylor method; a callback changes the velocity."""
    import heyoka as hy

    x, v = hy.make_vars("x", "v")
    count = [0]

    def bounce(integrator: hy.taylor_adaptive, sign: int) -> bool:
        integrator.state[1] *= -RESTITUTION
        count[0] += 1
        return True

    wall = hy.t_event(x, callback=bounce, direction=hy.event_direction.positive)
    rates = [(x, v), (v, hy.cos(FREQUENCY * hy.time) - x)]
    integrator = hy.taylor_adaptive(rates, [*BEGIN], t_events=[wall])

    def follow() -> tuple[float, int]:
        integrator.time, integrator.state[:], count[0] = 0.0, BEGIN, 0
        integrator.reset_cooldowns()
        integrator.propagate_until(stop)
        return float(integrator.state[0]), count[0]

    return follow


def scipy(stop: float) -> Follow:
    """``solve_ivp`` with a terminal event, again and again."""
    from scipy.integrate import solve_ivp

    def rates(t: float, y: np.ndarray) -> list[float]:
        return [y[1], math.cos(FREQUENCY * t) - y[0]]

    def wall(t: float, y: np.ndarray) -> float:
        return float(y[0])

    wall.terminal, wall.direction = True, 1  # type: ignore[attr-defined]

    def follow() -> tuple[float, int]:
        t, y, count = 0.0, np.array(BEGIN), 0
        while True:
            found = solve_ivp(
                rates, (t, stop), y, "DOP853", events=wall, rtol=TOLERANCE, atol=TOLERANCE, t_eval=[stop]
            )
            if found.status != 1:
                return float(found.y[0, -1]), count
            assert found.t_events is not None and found.y_events is not None
            t, count = float(found.t_events[0][0]), count + 1
            y = found.y_events[0][0] * np.array([0.0, -RESTITUTION])

    return follow


ENGINES: Engines = {LAGRANGE: lagrange, HEYOKA: heyoka, SCIPY: scipy}


def figures(engine: Callable[[float], Follow], stop: float, long: float, runs: int) -> Figures:
    """Those of an engine, with the end at ``stop``, and the time of motions as ``long`` as that."""
    _, ready, follow = timed_by_both(lambda: engine(stop))
    end, count = follow()
    longer = engine(long)
    found = [timed_by_both(longer) for _ in range(runs)]
    return Figures(ready, median(spent / many for _, spent, (_, many) in found), count, end)


def true_end(stop: float) -> float:
    """x at the end by the closed form between impacts, whose times are found with many digits."""
    import mpmath

    with mpmath.workdps(DIGITS):
        w, e, t = (mpmath.mpf(str(one)) for one in (FREQUENCY, RESTITUTION, 0))
        x, v = (mpmath.mpf(str(one)) for one in BEGIN)
        driven = 1 / (1 - w**2)
        while True:
            a = x - driven * mpmath.cos(w * t)
            b = v + driven * w * mpmath.sin(w * t)

            def place(
                s: Any, with_digits: bool = True, begin: Any = t, given: tuple[Any, Any] = (a, b)
            ) -> Any:
                number, functions = (mpmath.mpf, mpmath) if with_digits else (float, math)
                since, left, right = number(s) - number(begin), *map(number, given)
                free = left * functions.cos(since) + right * functions.sin(since)
                return free + number(driven) * functions.cos(number(w) * number(s))

            hit = next_zero(place, float(t), stop)
            if hit is None:
                return float(place(stop))
            v = b * mpmath.cos(hit - t) - a * mpmath.sin(hit - t) - driven * w * mpmath.sin(w * hit)
            x, v, t = mpmath.mpf(0), -e * v, hit


def next_zero(place: Callable[..., Any], start: float, end: float) -> Any:
    """Where it rises through 0 next, after ``start``: found in doubles, then with many digits."""
    import mpmath

    now, before = start, place(start + STEP / 1024, with_digits=False)
    while now < end:
        now += STEP
        after = place(now, with_digits=False)
        if before < 0.0 <= after:
            found = mpmath.findroot(place, (now - STEP, now), solver="anderson", tol=mpmath.mpf(10) ** -90)
            return found if found < end else None
        before = after
    return None


def compared(
    engines: Engines, options: Namespace, true_end: Callable[[float], float], what: str, least: float
) -> Report:
    """Every engine in a process of its own, in turns. scipy is to take ``least`` times as long, or more."""
    stop, long = (SHORT, SHORT) if options.quick else (STOP, LONG)
    several = {**dict.fromkeys(engines, (long, 3)), SCIPY: (stop, 1)}  # it is the same from event to event
    tasks = {
        name: (lambda one=one, name=name: in_own_process(figures, one, stop, *several[name]))
        for name, one in engines.items()
    }
    found = {name: sorted(each, key=lambda one: one.impact)[len(each) // 2]
             for name, each in in_turns(tasks, options.runs).items()}  # fmt: skip
    true = true_end(stop)
    ours = found[LAGRANGE].impact
    rows = [
        (name, f"{one.prepare:.2f}", str(one.count), f"{1e6 * one.impact:.{int(one.impact < 1e-4)}f}",
         f"{one.impact / ours:.1f}", f"{abs(one.end - true):.1e}")
        for name, one in found.items()
    ]  # fmt: skip
    header = "", "prepare, s", f"{what}s", f"us for each {what}", "relative", "error of x"
    slower = Requirement("time of scipy relative to lagrange", found[SCIPY].impact / ours, ">=", least)
    return Report((markdown_table(header, rows),), (slower,))


def compared_suite(name: str, measure: Callable[[Namespace], Report]) -> Suite:
    """A suite that compares these engines."""
    packages = "llvmlite", "numpy", "heyoka", "scipy", "mpmath"
    return Suite(name, measure, packages, runs=3, quick="to t = 200")


def measure(options: Namespace) -> Report:
    """All engines."""
    return compared(ENGINES, options, true_end, "impact", LEAST)


SUITE = compared_suite("impacts", measure)

if __name__ == "__main__":
    sys.exit(SUITE.main())
