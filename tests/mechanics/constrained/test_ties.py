"""Constraints that depend on each other along a direction that turns: a ball rolls in pipes and bowls."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from math import sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lagrange_cli as lagrange
from tests.support.draws import examples

BALL = """
parameters: {{m: 0.3, r: 0.1, R: 1.1, g: {gravity}, a: R - r}}
coordinates:
{coordinates}
  qw: {{initial: 1}}
  qx: {{initial: 0}}
  qy: {{initial: 0}}
  qz: {{initial: 0}}
definitions:
  n: {normal}
  slip: "(ball.vx, ball.vy, ball.vz) + cross((ball.wx, ball.wy, ball.wz), r*n)"
bodies:
  ball:
    mass: m
    solid: {{sphere: r}}
    position: {position}
    orientation: {{quaternion: [qw, qx, qy, qz]}}
potential: m*g*ball.z
nonholonomic:
"""
PIPE = """
  phi: {{initial: {angle}, velocity: {rate}}}
  z: {{initial: 0}}"""
SPHERE = """
  theta: {{initial: {angle}, velocity: 0.3}}
  phi: {{initial: 0.2, velocity: {rate}}}"""
IN_A_PIPE = "(cos(phi), sin(phi), 0)"
IN_A_SPHERE = "(sin(theta)*cos(phi), sin(theta)*sin(phi), -cos(theta))"


def pipe(angle: float, rate: float, gravity: float = 9.81) -> str:
    """A ball in a vertical pipe, without the constraints."""
    coordinates = PIPE.format(angle=angle, rate=rate)
    return BALL.format(
        coordinates=coordinates, normal=IN_A_PIPE, position="[a*cos(phi), a*sin(phi), z]", gravity=gravity
    )


def sphere(angle: float, rate: float, gravity: float = 9.81) -> str:
    """A ball within a sphere, without the constraints."""
    coordinates = SPHERE.format(angle=angle, rate=rate)
    position = "[a*sin(theta)*cos(phi), a*sin(theta)*sin(phi), -a*cos(theta)]"
    return BALL.format(coordinates=coordinates, normal=IN_A_SPHERE, position=position, gravity=gravity)


def rolling(text: str, constraints: str, stop: float) -> lagrange.Motion:
    """The motion of a ball with constraints."""
    outputs = ["q", "h", "multipliers"]
    with warnings.catch_warnings():  # of the constraint that follows from others
        warnings.simplefilter("ignore", lagrange.LagrangeWarning)
        motion = lagrange.solve(text + constraints, stop=stop, samples=41, outputs=outputs)
    assert motion.status == "complete"
    assert "singular_configurations" not in motion.attributes
    return motion


@examples(3)
@given(angle=st.floats(-3, 3), rate=st.floats(1.5, 4))
def test_a_ball_in_a_vertical_pipe_comes_up_again(angle: float, rate: float) -> None:
    """z'' = -5/7 g - 2/7 phi'^2 z without spin along the normal at the start, where phi' is constant (E. J.
    Routh, Advanced Part of a Treatise on the Dynamics of a System of Rigid Bodies, 1884, art. 225)."""
    motion = rolling(pipe(angle, rate), "  roll: slip\n", 4)
    turned, lowest = rate * sqrt(2 / 7), -2.5 * 9.81 / rate**2
    assert motion.q["phi"] == pytest.approx(angle + rate * motion.t, abs=1e-12)
    assert motion.q["z"] == pytest.approx(lowest * (1 - np.cos(turned * motion.t)), abs=1e-12 * rate**2)
    tangential, along = motion.datasets["multipliers/roll.x"], motion.datasets["multipliers/roll.y"]
    assert tangential * np.cos(motion.q["phi"]) + along * np.sin(motion.q["phi"]) == pytest.approx(
        0, abs=1e-12
    )


TANGENTIAL = {
    pipe: "  a: dot(slip, (-sin(phi), cos(phi), 0))\n  b: slip.z\n",
    sphere: "  a: dot(slip, (-sin(phi), cos(phi), 0))\n"
    "  b: dot(slip, (cos(theta)*cos(phi), cos(theta)*sin(phi), sin(theta)))\n",
}


@pytest.mark.parametrize("surface", TANGENTIAL)
@examples(2)
@given(angle=st.floats(1, 2), rate=st.floats(3, 6))
def test_the_motion_is_that_of_constraints_along_the_surface(
    surface: Callable[[float, float], str], angle: float, rate: float
) -> None:
    """The components of the rolling constraint, of which one follows from the others, and those along two
    tangents; the sphere's equator is crossed."""
    text = surface(angle, rate)
    whole, along = rolling(text, "  roll: slip\n", 3), rolling(text, TANGENTIAL[surface], 3)
    for name in whole.q:
        assert whole.q[name] == pytest.approx(along.q[name], abs=1e-11)
    assert whole.attributes["steps"] <= 1.2 * along.attributes["steps"] + 2
