"""Combinations of coordinates that are cyclic, and parts that do not act on each other."""

from __future__ import annotations

import pytest

from lagrange_cli.mechanics.structure import structure
from tests.support.motion import residual_of

PENDULUMS = """
parameters: {m1: 1.0, m2: 2.0, l1: 1.0, l2: 0.7, g: 9.81}
coordinates: {a: {initial: 0.3}, b: {initial: 1.2}}
masses: {upper: m1, lower: m2}
positions:
  upper: [l1*sin(a), -l1*cos(a)]
  lower: [l1*sin(a) + l2*sin(b), -l1*cos(a) - l2*cos(b)]
"""
ROTORS = """
sizes: {N: 3}
parameters: {k: 3.0, I: 0.5, M: 1}
coordinates: {phi[i in range(N)]: {initial: 0.3*i}}
lagrangian: sum(I*phi_dot[i]**2/2 for i in range(N)) + sum(k*cos(phi[i + 1] - phi[i]) for i in range(N - 1))
"""
GEARS = """
parameters: {k: 3.0, n: 2}
coordinates: {a: {initial: 0.3}, b: {initial: 0.1}, c: {initial: 0.2}, d: {initial: 0}}
lagrangian: (a_dot**2 + b_dot**2 + c_dot**2 + d_dot**2)/2 - k*(a - 2*b)**2/2 - sin(c + d)
"""
BOUND = """
coordinates: {x: {initial: 1}, y: {initial: 0}, z: {initial: 1}, w: {initial: 3}}
masses: {a: 1, b: 2, c: 1}
positions: {a: [x, y], b: [z, 0], c: [w, 0]}
potential: (y - w)**2
constraints: {ring: x**2 + y**2 - 1, CONSTRAINT}
"""


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (PENDULUMS, ["a + b is cyclic, so that p_a + p_b is conserved"]),
        (PENDULUMS + "potential: m1*g*upper.y\n", []),
        (PENDULUMS + "generalized_forces: {a: -0.1*a_dot}\n", []),
        (PENDULUMS + "generalized_forces: {a: -0.1*(a_dot - b_dot), b: 0.1*(a_dot - b_dot)}\n",
         ["a + b is cyclic, so that p_a + p_b is conserved"]),
        (ROTORS, ["phi[0] + phi[1] + phi[2] is cyclic, so that p_phi[0] + p_phi[1] + p_phi[2] is conserved"]),
        (ROTORS + "generalized_forces: {phi[0]: M}\n", []),
        (GEARS, ["2*a + b is cyclic, so that 2*p_a + p_b is conserved",
                 "c - d is cyclic, so that p_c - p_d is conserved",
                 "parts that do not act on each other: {a, b}, {c, d}"]),
        (BOUND.replace("CONSTRAINT", "slider: x - z"), []),
        (BOUND.replace("CONSTRAINT", "slider: z - 2"),
         ["parts that do not act on each other: {x, y, w}, {z}"]),
    ],
)  # fmt: skip
def test_what_a_system_is_made_of(text, said):
    assert list(structure(residual_of(text))) == said
