"""Balls that slide on a table, and roll in the end: just before, the direction of friction is rounding."""

from __future__ import annotations

import random

import numpy as np
import pytest

from lagrange_cli.integrate.ending import Ending
from tests.support.motion import follow

BALL = """
parameters: {m: 2, R: 0.3, k: 2, vx: 7, vy: 0, wa: 5, wb: 3}
coordinates:
  x: {initial: 0, velocity: vx}
  y: {initial: 0, velocity: vy}
  a: {initial: 0, velocity: wa}
  b: {initial: 0, velocity: wb}
lagrangian: m*(x_dot**2 + y_dot**2)/2 + m*R**2*(a_dot**2 + b_dot**2)/5
definitions: {u: "(x_dot - R*b_dot, y_dot + R*a_dot)"}
generalized_forces:
  {x: -k*u.x/norm(u), y: -k*u.y/norm(u), a: -k*R*u.y/norm(u), b: k*R*u.x/norm(u)}
"""
TOLERANCES = {"taylor": 2.0**-52, "ias15": 2.0**-52, "DOP853": 1e-12, "Radau": 1e-10}


@pytest.mark.exhaustive(keep=0.55)
@pytest.mark.parametrize("method", TOLERANCES)
def test_a_ball_that_slides_rolls_in_the_end(method: str) -> None:
    # the angular momentum about the line of contact is kept: v = (5 v0 + 2 R w0)/7
    motion = follow(BALL, 4, 5, method=method, tolerance=TOLERANCES[method])
    assert motion["v/x"][-1] == pytest.approx((5 * 7 + 2 * 0.3 * 3) / 7, abs=1e-9)
    assert motion["v/y"][-1] == pytest.approx(-2 * 0.3 * 5 / 7, abs=1e-9)
    assert motion["v/x"][-1] == pytest.approx(0.3 * motion["v/b"][-1], abs=1e-14)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", TOLERANCES)
def test_balls_of_any_size_roll_in_the_end(method: str, request: pytest.FixtureRequest) -> None:
    """Where the velocity of contact is 0 but for rounding, friction is not taken for a rounding error."""
    source = random.Random(request.config.option.seed)
    for _ in range(8):
        sets = {
            "m": source.uniform(0.3, 4), "R": source.uniform(0.1, 1), "k": source.uniform(0.5, 4),
            "vx": source.uniform(-9, 9), "vy": source.uniform(-4, 4),
            "wa": source.uniform(-5, 5), "wb": source.uniform(-5, 5),
        }  # fmt: skip
        v = np.array([sets["vx"], sets["vy"]])
        u = v + sets["R"] * np.array([-sets["wb"], sets["wa"]])
        friction = -sets["k"] / sets["m"] * u / np.hypot(*u)
        end = np.hypot(*u) / 3.5 / np.hypot(*friction)
        motion = follow(BALL, 2 * end, 5, method=method, tolerance=TOLERANCES[method], sets=sets)
        assert motion.outcome.ending is Ending.COMPLETE
        expected = 2 * v * end + 1.5 * friction * end**2
        found = np.array([motion["q/x"][-1], motion["q/y"][-1]])
        assert found == pytest.approx(expected, rel=1e-8, abs=1e-8), sets


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize(("method", "tolerance"), [("ias15", 1e-6), ("ias15", 2.0**-52), ("DOP853", 1e-9)])
def test_balls_on_a_slope_roll_in_the_end(method: str, tolerance: float) -> None:
    """Which way they slide changes, so that none of their velocities is 0 where they begin to roll."""
    text = BALL.replace("{x: -k*u.x/norm(u)", "{x: f - k*u.x/norm(u)").replace("k: 2,", "k: 2, f: 0.3,")
    for vx, wa in ((7, 5), (-2.3, 1.9), (0.7, -3.1), (3.13, 0.77)):
        sets = {"vx": vx, "wa": wa, "f": 0.31, "R": 0.7}
        exact, motion = (
            follow(text, 6, 7, method=one, tolerance=most, sets=sets)
            for one, most in (("taylor", 2.0**-52), (method, tolerance))
        )
        assert exact.outcome.ending is motion.outcome.ending is Ending.COMPLETE
        assert exact.outcome.steps < 150 and motion.outcome.steps < 1000
        # rolling on, 5/7 of the force accelerates it
        assert exact["v/x"][-1] - exact["v/x"][-2] == pytest.approx(0.31 / 2 * 5 / 7, rel=1e-13)
        for name in ("q/x", "q/y", "v/x", "v/y"):
            assert motion[name] == pytest.approx(exact[name], rel=30 * tolerance, abs=30 * tolerance + 1e-12)


BILLIARDS = """
parameters: {m: 1, R: 0.1, mu: 0.2, g: 9.81}
coordinates:
  x: {initial: 0, velocity: 3}
  y: {initial: 0}
  z: {initial: R}
  qw: {initial: 1}
  qx: {initial: 0, velocity: -10}
  qy: {initial: 0}
  qz: {initial: 0, velocity: 5}
bodies:
  ball: {mass: m, solid: {sphere: R}, position: [x, y, z], orientation: {quaternion: [qw, qx, qy, qz]}}
potential: m*g*z
constraints: {floor: z - R}
definitions:
  arm: (0, 0, -R)
  slip: (ball.vx, ball.vy, ball.vz) + cross((ball.wx, ball.wy, ball.wz), arm)
  F: -mu*floor.multiplier*(slip.x, slip.y, 0)/norm((slip.x, slip.y, 0))
forces: {ball: F}
torques: {ball: "cross(arm, F)"}
"""


@pytest.mark.parametrize("m", [1.0, 0.1, 2.0**-20, 2.0**20])
def test_how_a_ball_rolls_does_not_depend_on_its_mass(m: float) -> None:
    motion = follow(BILLIARDS, 1, 5, sets={"m": m})
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["v/x"][-1] == pytest.approx(3 * 5 / 7, abs=1e-12)
    assert motion["v/y"][-1] == pytest.approx(0.1 * 20 * 2 / 7, abs=1e-12)
