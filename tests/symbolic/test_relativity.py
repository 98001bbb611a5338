"""Lagrangians that are not quadratic in the velocities, as textbooks write their equations."""

from __future__ import annotations

import pytest
import sympy

from lagrange_cli.run.equations import as_written, derive
from tests.support.motion import spec_of

OSCILLATOR = """
parameters: {m: 1, c: 2, k: 3}
coordinates: {x: {initial: 1}}
lagrangian: -m*c**2*sqrt(1 - x_dot**2/c**2) - k*x**2/2
"""
CHARGE = """
parameters: {m: 1, c: 2, q: 3, B: 4, k: 5}
coordinates: {x: {initial: 1}, y: {initial: 0.2}, z: {initial: 0.1, velocity: 0.3}}
lagrangian: >-
  -m*c**2*sqrt(1 - (x_dot**2 + y_dot**2 + z_dot**2)/c**2) + q*B*(x*y_dot - y*x_dot)/2
  - k*(x**2 + y**2 + z**2)/2
"""


@pytest.mark.parametrize(
    "line",
    [
        "p_x = m*x_dot/sqrt(1 - x_dot**2/c**2)",
        "m*x_ddot/(1 - x_dot**2/c**2)**(3/2) + k*x = 0   [x]",
        "x_ddot = -k*x*(1 - x_dot**2/c**2)**(3/2)/m",
        "h = m*c**2/sqrt(1 - x_dot**2/c**2) + k*x**2/2",
    ],
)
def test_an_oscillator_reads_as_in_goldstein(line: str) -> None:
    """Goldstein, Poole and Safko, Classical Mechanics, 3rd ed., section 7.9."""
    assert line in as_written(derive(spec_of(OSCILLATOR)), "text", "lagrange", {})


@pytest.mark.exhaustive(keep=0.55)
def test_accelerations_are_those_of_the_force() -> None:
    """a = (F - v (v.F)/c^2)/(gamma m) (Landau and Lifshitz, The Classical Theory of Fields, problem in
    section 17)."""
    equations = derive(spec_of(CHARGE)).equations
    m, c, q, B, k = (sympy.Symbol(name) for name in "mcqBk")
    (x, y, z), (u, v, w) = equations.q, equations.v
    force = (q * B * v - k * x, -q * B * u - k * y, -k * z)
    power = sum(one * own for one, own in zip(force, equations.v))
    root = sympy.sqrt(1 - (u**2 + v**2 + w**2) / c**2)
    for found, own, speed in zip(equations.accelerations, force, equations.v):
        expected = root / m * (own - speed * power / c**2)
        assert sympy.simplify(found / root - expected / root) == 0
        assert found.count_ops() < 40
    energy = m * c**2 / root + k * (x**2 + y**2 + z**2) / 2
    assert sympy.expand(equations.h - energy) == 0
