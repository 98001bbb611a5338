"""Friction against a velocity with several components: where it stops a puck, holds it, and lets it go."""

from __future__ import annotations

from math import hypot, sqrt

import numpy as np
import pytest

from lagrange_cli.integrate.ending import Ending
from tests.support.motion import Motion, follow

PUCK = """
parameters: {{mu: 0.3, g: 9.81}}
coordinates:
  x: {{initial: 0, velocity: {velocity[0]}}}
  y: {{initial: 0, velocity: {velocity[1]}}}
  z: {{initial: 0, velocity: {velocity[2]}}}
masses: {{puck: 1}}
positions: {{puck: [x, y, z]}}
potential: 0
definitions: {{u: "(x_dot, y_dot - {belt}, z_dot)"}}
forces: {{puck: "({force}) - mu*g*u/norm(u)"}}
"""
SLIDING = 0.3 * 9.81
TOLERANCES = {"taylor": 2.0**-52, "ias15": 2.0**-52, "DOP853": 1e-12, "Radau": 1e-10}


def puck(
    velocity: tuple[float, ...], force: str = "0, 0, 0", belt: float = 0, method: str = "taylor"
) -> Motion:
    """The motion of a puck of mass 1 in 2 s, on a belt that moves along y."""
    text = PUCK.format(velocity=velocity, force=force, belt=belt)
    return follow(text, 2, 21, method=method, tolerance=TOLERANCES[method])


@pytest.mark.parametrize("method", TOLERANCES)
def test_a_puck_slides_to_rest_along_a_straight_line(method: str) -> None:
    motion, v = puck((1.2, 0.5, -0.3), method=method), sqrt(1.2**2 + 0.5**2 + 0.3**2)
    assert motion.outcome.ending is Ending.COMPLETE
    for name, speed in zip("xyz", (1.2, 0.5, -0.3)):
        assert motion[f"q/{name}"][-1] == pytest.approx(speed * v / SLIDING / 2, rel=1e-9)
        assert abs(motion[f"v/{name}"][-1]) < 1e-40


def test_it_comes_to_rest_on_an_incline_and_stays_there() -> None:
    # with slope p and friction f, |v| - v_x p/f falls at the rate f - p**2/f
    p = 1.9
    motion = puck((-1.2, 0.5, 0), f"{p}, 0, 0")
    rest = (hypot(1.2, 0.5) + 1.2 * -1 * p / SLIDING) / (SLIDING - p**2 / SLIDING)
    still = motion.t > rest
    assert np.all(np.abs(motion["v/x"][still]) < 1e-20)
    assert np.all(motion["v/y"][motion.t < rest - 0.05] != 0)
    assert np.ptp(motion["q/x"][still]) < 1e-20


def test_it_begins_to_slide_where_the_force_exceeds_the_limit() -> None:
    begins = SLIDING / 5
    motion = puck((0, 0, 0), "3*t, 4*t, 0")
    past = np.maximum(motion.t - begins, 0)
    assert motion["q/x"] == pytest.approx(0.6 * 5 * past**3 / 6, abs=1e-13)
    assert motion["q/y"] == pytest.approx(0.8 * 5 * past**3 / 6, abs=1e-13)


def test_a_force_that_turns_lets_it_go_alike_by_other_methods() -> None:
    force = "3*t*cos(t), 3*t*sin(t), 0"
    by_series, by_rates = (puck((0, 0, 0), force, method=m) for m in ("taylor", "Radau"))
    assert by_series["q/y"][-1] > 0.1
    for name in ("q/x", "q/y", "v/x", "v/y"):
        assert by_series[name] == pytest.approx(by_rates[name], abs=1e-7)


def test_it_is_taken_along_by_a_belt() -> None:
    motion = puck((0.3, 0, 0), belt=0.4)
    relative = hypot(0.3, 0.4)
    rest = relative / SLIDING
    assert motion["v/y"][-1] == pytest.approx(0.4, abs=1e-14)
    assert abs(motion["v/x"][-1]) < 1e-15
    assert motion["q/y"][-1] == pytest.approx(0.4 * (2 - rest / 2), abs=1e-13)
