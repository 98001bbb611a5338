"""Conserved quantities as formulas, and why they are conserved, in words."""

from __future__ import annotations

import pytest

from lagrange_cli.mechanics.conserved.reasons import times
from lagrange_cli.mechanics.conserved.symmetries import symmetries
from tests.support.motion import residual_of


def told(text: str) -> dict[str, str]:
    """What is conserved besides h and momenta, and why."""
    residual = residual_of(text)
    found = (one.conserved for one in symmetries(residual.model, residual.conserved))
    return {f"{one.quantity} = {one.expression}": one.because for one in found}


@pytest.mark.parametrize(
    ("product", "expected"),
    [
        ("F/2", "F*L_z/2"),
        ("1/m", "L_z/m"),
        ("a", "a*L_z"),
        ("a*(b/c)", "a*(b/c)*L_z"),
        ("a*(b/c)/(m*k)", "a*(b/c)*L_z/(m*k)"),
    ],
)
def test_what_has_a_name_stands_in_front_of_a_denominator(product: str, expected: str) -> None:
    assert times(product, "L_z") == expected


@pytest.mark.exhaustive(keep=0.4)
def test_a_single_particle_is_no_sum() -> None:
    found = told("""
        parameters: {m: 1, F: 2, k: 3}
        coordinates: {x: {initial: 1}, y: {initial: 0}, z: {initial: 1}}
        masses: {p: m}
        positions: {p: [x, y, z]}
        potential: -k/norm(p) - F*z
        """)
    assert found["L_z = x*m*vy - y*m*vx"] == "turning the particle about the z axis changes neither T nor U"
    (separated,) = [one for one in found if one.startswith("A_z = ")]
    assert "F*y**2/2" in separated


def test_a_given_lagrangian_has_momenta() -> None:
    found = told("""
        parameters: {m: 1, w: 2, k: 3}
        coordinates: {x: {initial: 1}, y: {initial: 0}}
        lagrangian: m*(x_dot**2 + y_dot**2)/2 + m*w*(x*y_dot - y*x_dot) - k*exp(x**2 + y**2)
        """)
    assert found["L_z = x*p_y - y*p_x"] == "turning the point (x, y) about the origin leaves L unchanged"


def test_a_shift_of_time() -> None:
    found = told("""
        parameters: {m: 1, l: 1, a: 3, g: 9.81}
        coordinates: {theta: {initial: 0.1}}
        masses: {bob: m}
        positions: {bob: [a*t**2/2 + l*sin(theta), -l*cos(theta)]}
        potential: m*g*bob.y
        """)
    assert [*found.values()] == ["a shift of t leaves the action unchanged"]


@pytest.mark.exhaustive(keep=0.4)
def test_what_constraints_on_velocities_keep_makes_nothing_new() -> None:
    """The turning of a carriage is constant, and so is its angle less that of its wheels; not told is their
    product."""
    found = told("""
        parameters: {M: 1, a: 0.1, b: 0.5, g: 9.81, alpha: 0.2, I: M*a**2/2}
        coordinates:
          x: {initial: 0}
          y: {initial: 0}
          th: {initial: 0.3, velocity: 0.4}
          p1: {initial: 0}
          p2: {initial: 0}
        lagrangian: >-
          M*(x_dot**2 + y_dot**2) + M*b**2*th_dot**2/4 + I*(p1_dot**2 + p2_dot**2)/2 + 2*M*g*sin(alpha)*y
        nonholonomic:
          n: x_dot*cos(th) + y_dot*sin(th)
          r1: x_dot*sin(th) - y_dot*cos(th) - a*p1_dot - b*th_dot/2
          r2: x_dot*sin(th) - y_dot*cos(th) - a*p2_dot + b*th_dot/2
        """)
    (integral,) = [one for one in found if one.startswith("I_")]
    assert "sin(alpha)*sin(th)" in integral


def test_what_is_0_wherever_constraints_hold_is_not_told() -> None:
    """The constraint times a momentum, for example."""
    found = told("""
        coordinates: {x: {initial: 0.6}, y: {initial: 0.8}}
        lagrangian: x_dot**2*(1 + x**2)/2 + y_dot**2/2 - x**4
        generalized_forces: {x: cos(t)}
        constraints: {c: x**2 + y**2 - 1}
        """)
    assert not found


PAIR = """
parameters: {{m: 1, M: 2, k: 3}}
coordinates: {{x: {{initial: 1}}, y: {{initial: 0}}, X: {{initial: 0}}, Y: {{initial: 2}}}}
masses: {{p: m, P: M}}
positions: {{p: [x, y], P: [X, Y]}}
potential: {}
"""


@pytest.mark.exhaustive(keep=0.8)
@pytest.mark.parametrize(("potential", "names"), [("0", set()), ("-k/norm(p - P)", {"A_x", "A_y"})])
def test_the_runge_lenz_vector_is_that_of_a_force(potential: str, names: set[str]) -> None:
    """Without a force v x L is made of conserved v and L, which are said already."""
    found = told(PAIR.format(potential))
    assert {one.partition(" = ")[0] for one in found if one[:2] in ("A_", "I_")} == names
