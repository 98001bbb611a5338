"""Constraints that follow from others in turn: a ball rolls in pipes and bowls, linkages move although they
have as many constraints as coordinates, rings have two hinges each."""

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


BENNETT = """
parameters: {{a: 1, b: {ratio}, alpha: {twist}, beta: asin(b*sin(alpha)/a), m: 1, g: 9.81}}
coordinates:
  t1: {{initial: {angle}, velocity: {rate}}}
  t2: {{}}
  t3: {{}}
definitions:
  along: [cos(t1), sin(t1), 0]
  across: [-sin(t1)*cos(beta), cos(t1)*cos(beta), sin(beta)]
masses: {{first: m, second: m}}
positions:
  first: b*along
  second: b*along + a*(cos(t2)*along + sin(t2)*across)
potential: m*g*(first.y + second.y)
constraints:
  joint: second - [a + b*cos(t3), b*cos(alpha)*sin(t3), b*sin(alpha)*sin(t3)]
"""
METHODS = "taylor", "DOP853", "ias15", "radau"


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("method", METHODS)
@examples(2)
@given(ratio=st.floats(0.4, 0.8), twist=st.floats(0.5, 1.2), angle=st.floats(0.5, 2), rate=st.floats(6, 7))
def test_bennetts_linkage_turns(method: str, ratio: float, twist: float, angle: float, rate: float) -> None:
    """It is movable although three constraints act on three angles (G. T. Bennett, Engineering 76, 1903): the
    ratio of the tangents of half the angles is constant, and opposite ones are equal. Where it is folded,
    the x components of all velocities are 0, and the constraint on x is the one that follows from others."""
    text = BENNETT.format(ratio=ratio, twist=twist, angle=angle, rate=rate)
    outputs = ["q", "h", "constraints"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lagrange.LagrangeWarning)
        motion = lagrange.solve(text, stop=3, samples=200, outputs=outputs, method=method)
    assert motion.status == "complete"
    assert "singular_configurations" not in motion.attributes
    first, second = (
        np.array([np.cos(motion.q[name] / 2), np.sin(motion.q[name] / 2)]) for name in ("t1", "t2")
    )
    ratio_of_tangents = second[1, 0] * first[0, 0] / (second[0, 0] * first[1, 0])
    # samples of DOP853 are of a polynomial within its steps, which constraints do not correct
    error = {"DOP853": 1e-7, "radau": 1e-9}.get(method, 1e-12)
    assert second[1] * first[0] == pytest.approx(ratio_of_tangents * second[0] * first[1], abs=error)
    assert np.sin(motion.q["t2"] - motion.q["t3"]) == pytest.approx(0, abs=error)
    assert np.ptp(motion.q["t1"]) > 2 * np.pi
    most = {"taylor": 250, "ias15": 1000, "DOP853": 400, "radau": 5000}[method]
    assert motion.attributes["steps"] <= most
    assert np.ptp(motion.h) <= {"taylor": 1e-12, "ias15": 1e-12, "DOP853": 1e-6, "radau": 1e-7}[method]


def test_check_says_so() -> None:
    """And what depends on others; the printed equations are without it."""
    found = lagrange.check(BENNETT.format(ratio=0.6, twist=1, angle=1, rate=6))
    assert "follow from others in turn" in "\n".join(found.engine)


RINGS = """
parameters: {a: 1, b: 0.8, T: 0.3}
bodies:
"""
HINGED = """
  outer:
    {{mass: 1, inertia: [0.5, 0.5, 1], position: [x, y, z], orientation: {{quaternion: [w, e1, e2, e3]}}}}
  inner:
    {{mass: 1, inertia: [0.3, 0.4, 0.6], position: [X, Y, Z], orientation: {{quaternion: [W, E1, E2, E3]}}}}
coordinates:
  x: {{initial: 0}}
  y: {{initial: 0}}
  z: {{initial: 0}}
  w: {{initial: 1}}
  e1: {{initial: 0}}
  e2: {{initial: 0}}
  e3: {{initial: 0, velocity: {turning}/2}}
  X: {{initial: 0}}
  Y: {{initial: 0}}
  Z: {{initial: 0}}
  W: {{initial: 1}}
  E1: {{initial: 0, velocity: {tilting}/2}}
  E2: {{initial: 0}}
  E3: {{initial: 0, velocity: {turning}/2}}
constraints:
  top: outer.at(0, 0, a) - (0, 0, a)
  bottom: outer.at(0, 0, -a) - (0, 0, -a)
  left: inner.at(b, 0, 0) - outer.at(b, 0, 0)
  right: inner.at(-b, 0, 0) - outer.at(-b, 0, 0)
"""
BY_ANGLES = """
  outer: {{mass: 1, inertia: [0.5, 0.5, 1], position: [0, 0, 0], orientation: {{euler: [phi, 0, 0]}}}}
  inner: {{mass: 1, inertia: [0.3, 0.4, 0.6], position: [0, 0, 0], orientation: {{euler: [phi, theta, 0]}}}}
coordinates:
  phi: {{initial: 0, velocity: {turning}}}
  theta: {{initial: 0, velocity: {tilting}}}
"""
ACTING = """
torques: {inner: "T*(inner.R13, inner.R23, inner.R33)"}
observables: {third: inner.R13, other: inner.R31, turned: outer.R11}
"""


@examples(2)
@given(turning=st.floats(0.5, 2), tilting=st.floats(0.5, 2))
def test_rings_with_two_hinges_each(turning: float, tilting: float) -> None:
    """A gimbal: each hinge is given by two points, so that along its axis there is one constraint too many.
    The axis of the inner ring turns. The motion is that of the two angles."""
    motions = []
    for bodies in (HINGED, BY_ANGLES):
        text = RINGS + bodies.format(turning=turning, tilting=tilting) + ACTING
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", lagrange.LagrangeWarning)
            motions.append(lagrange.solve(text, stop=10, samples=101, outputs=["q", "observables"]))
    hinged, free = motions
    for name in free.observables:
        assert hinged.observables[name] == pytest.approx(free.observables[name], abs=1e-12)
    assert hinged.attributes["steps"] <= 2 * free.attributes["steps"] + 20


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", METHODS)
@examples(1)
@given(angle=st.floats(-3, 3), rate=st.floats(2, 3), friction=st.floats(0.6, 1))
def test_friction_beside_them(method: str, angle: float, rate: float, friction: float) -> None:
    """A block that sticks and slides is drawn along by a ball in a pipe."""
    more = f"""masses: {{block: 0.2}}
positions: {{block: [s, 0, 0]}}
generalized_forces: {{s: -{friction}*sign(s_dot), phi: -0.02*sign(phi_dot)}}
"""
    text = pipe(angle, rate).replace("potential: m*g*ball.z", more + "potential: m*g*ball.z + 2*(s - z)**2")
    text = text.replace("coordinates:\n", "coordinates:\n  s: {initial: 0, velocity: 1}\n")
    motions = []
    for constraints in ("  roll: slip\n", TANGENTIAL[pipe]):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", lagrange.LagrangeWarning)
            motions.append(lagrange.solve(text + constraints, stop=4, samples=41, method=method))
    whole, along = motions
    error = {"DOP853": 1e-6, "radau": 1e-8}.get(method, 1e-10)
    for name in whole.q:
        assert whole.q[name] == pytest.approx(along.q[name], abs=error)
    assert whole.attributes["steps"] <= 1.1 * along.attributes["steps"] + 5
