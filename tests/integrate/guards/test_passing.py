"""Switches that might hold the motion, in compiled code and in Python: both give the same bits."""

from __future__ import annotations

import random
from collections.abc import Iterator
from functools import partial

import numpy as np
import pytest

from lagrange_cli.integrate.guards.settling import Settling
from lagrange_cli.native.stepping.guards import GuardCode
from lagrange_cli.spec.values import resolve_long_values
from tests.support.motion import Motion, follow, prepared, run, spec_of

ONE = """
parameters: {{a: {a!r}, b: {b!r}, w: {w!r}}}
coordinates: {{x: {{initial: 0.4, velocity: {v!r}}}, y: {{initial: -0.3, velocity: 0.2}}}}
masses: {{p: 1, q: 0.7}}
positions: {{p: [x, 0], q: [x + cos(y), sin(y)]}}
"""
DRIVEN = "potential: x**2 - cos(y)\n"
FORCES = {
    "friction": DRIVEN + "generalized_forces: {{x: 2*cos(w*t) - a*sign(x_dot), y: -b*sign(y_dot)}}",
    "friction between both": DRIVEN + "dissipation: a*abs(x_dot - y_dot)",
    "kinks": "potential: abs(x) + (x + 0.1)**2 + a*abs(y - b) - cos(y)",
    "relays": DRIVEN + "generalized_forces: {{x: 2*cos(w*t) - a*sign(x - 0.1*y)}}",
    "a belt": DRIVEN + "generalized_forces: {{x: -a*sign(x_dot - b)*(1 + exp(-abs(x_dot - b)))}}",
    "events": DRIVEN + "dissipation: a*abs(x_dot) + b*abs(y_dot)\n"
    "events: {{turns: {{when: x_dot*y_dot, action: record}}, passes: {{when: y - 0.1}}}}",
}
NORMAL = """
parameters: {{a: {a!r}, b: {b!r}, w: {w!r}}}
coordinates: {{x: {{initial: 0.7, velocity: {v!r}}}, y: {{initial: 0.07}}}}
masses: {{p: 1}}
positions: {{p: [x, y]}}
constraints: {{plane: y - 0.1*x}}
potential: 9.81*y + 3*x**2
generalized_forces: {{x: 4*cos(w*t) - 0.3*a*abs(plane.multiplier)*sign(x_dot)}}
"""
CHAIN = """
sizes: {{N: 60}}
parameters: {{a: {a!r}, b: {b!r}, w: {w!r}}}
coordinates: {{"x[i in range(N)]": {{initial: 0.1*sin(3*i), velocity: {v!r}*cos(i)}}}}
masses: {{"p[i in range(N)]": 1}}
positions: {{"p[i in range(N)]": ["x[i]"]}}
potential: sum((x[i] - x[i - 1])**2/2 for i in range(1, N)) + sum(a*abs(x[i] - 0.03) for i in range(N))
"""
SYSTEMS = {**{name: ONE + text for name, text in FORCES.items()}, "a normal force": NORMAL, "a chain": CHAIN}
METHODS = {"taylor": 2.0**-52, "ias15": 2.0**-52, "DOP853": 1e-10, "Radau": 1e-10}


def drawn(kind: str, source: random.Random) -> str:
    """A system of this kind."""
    numbers = {"a": source.uniform(0.1, 0.4), "b": source.uniform(0.02, 0.1)}
    return SYSTEMS[kind].format(**numbers, w=source.uniform(1.5, 3), v=source.uniform(0.3, 0.9))


@pytest.fixture
def settled(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """The switches that Python decides on; by ``in_python``, all that may hold the motion."""
    asked, settle = list[int](), Settling.settle
    monkeypatch.setattr(Settling, "settle", lambda self, due: asked.append(due) or settle(self, due))
    prepared.cache_clear()
    yield asked
    prepared.cache_clear()


def both(way: partial[Motion], settled: list[int]) -> tuple[Motion, Motion, tuple[int, int]]:
    """A motion in compiled code and in Python, and how often Python decided."""
    fast, first = way(), len(settled)
    prepared.cache_clear()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(GuardCode, "passing", property(lambda self: False))
        slow = way()
    return fast, slow, (first, len(settled) - first)


def assert_same(fast: Motion, slow: Motion) -> None:
    assert fast.outcome.ending == slow.outcome.ending and fast.outcome.steps == slow.outcome.steps
    counts = ({name: one.count for name, one in each.outcome.happened.items()} for each in (fast, slow))
    assert next(counts) == next(counts)
    for name, samples in slow.data.items():
        assert np.array_equal(samples, fast.data[name], equal_nan=True), name


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("kind", SYSTEMS)
def test_both_give_the_same_bits(
    kind: str, method: str, settled: list[int], request: pytest.FixtureRequest
) -> None:
    system = drawn(kind, random.Random(request.config.option.seed))
    stop = 1.0 if kind == "a chain" else 4.0
    way = partial(follow, system, stop, 40, method=method, tolerance=METHODS[method])
    fast, slow, (asked, before) = both(way, settled)
    assert_same(fast, slow)
    assert asked <= before and before > 0
    if kind in ("kinks", "relays", "a chain"):  # places, which are passed with a velocity
        assert asked == 0


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("kind", [*FORCES])
def test_the_same_in_double_double(kind: str, settled: list[int], request: pytest.FixtureRequest) -> None:
    text = drawn(kind, random.Random(request.config.option.seed))

    def way() -> Motion:
        ready = prepared(text, "taylor", 2.0**-100, precision="double-double")
        return run(ready, resolve_long_values(spec_of(text), {}), 0.0, 2.0, 20)

    fast, slow, _ = both(partial(way), settled)
    assert_same(fast, slow)


def test_friction_that_is_as_large_as_the_force_but_for_its_last_digit_stops_the_motion(
    settled: list[int],
) -> None:
    """What is left of their difference accelerates it from then on."""
    text = """
    parameters: {F: 0.1 + 0.2, f: 0.3}
    coordinates: {x: {initial: 0, velocity: -1}}
    masses: {p: 1}
    positions: {p: [x]}
    generalized_forces: {x: F - f*sign(x_dot)}
    """
    motion = follow(text, 100.0)
    assert len(settled) == 2  # it is held, and let go
    assert motion["v/x"][-1] == pytest.approx((100 - 1 / 0.6) * (0.1 + 0.2 - 0.3), rel=1e-9)


def test_friction_that_never_holds_is_followed_by_compiled_code_alone(settled: list[int]) -> None:
    """A driven block on a rough floor, x'' = 2 cos t - f sign(x'): its velocity changes its sign with the
    force, so that it passes; and where f is larger than 2 it stays, as Python says."""
    text = """
    parameters: {{f: {f}}}
    coordinates: {{x: {{initial: 0, velocity: {v}}}}}
    masses: {{p: 1}}
    positions: {{p: [x]}}
    generalized_forces: {{x: 2*cos(t) - f*sign(x_dot)}}
    """
    assert follow(text.format(f=0.5, v=0), 40.0).outcome.steps > 25 and settled == []
    rest = follow(text.format(f=2.5, v=1), 40.0)
    assert len(settled) == 1 and rest["v/x"][-1] == 0.0
