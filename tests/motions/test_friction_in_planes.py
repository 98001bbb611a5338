"""Friction against a velocity with several components: where it stops a puck, holds it, and lets it go."""

from __future__ import annotations

from math import hypot, sqrt

import numpy as np
import pytest

import lagrange_cli as lagrange
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


FALLING = """
parameters: {m: 2, g: 9.81, c: 0.2}
coordinates: {x: {initial: 0}, y: {initial: 0}}
masses: {ball: m}
positions: {ball: [x, y]}
potential: m*g*y
forces: {ball: "-c*norm((x_dot, y_dot))*(x_dot, y_dot)FORCE"}
"""


@pytest.mark.parametrize(("method", "bound"), [("taylor", 2e-14), ("Radau", 1e-9)])
def test_a_ball_falls_from_rest_through_air(method: str, bound: float) -> None:
    """|v| has no series where v is 0, but the motion has one: v = v1 tanh(g t/v1) (Taylor, sec. 2.4)."""
    text, tolerance = FALLING.replace("FORCE", ""), TOLERANCES[method]
    motion = follow(text, 1004, 3, start=1000, method=method, tolerance=tolerance)
    assert motion.outcome.ending is Ending.COMPLETE
    last = sqrt(2 * 9.81 / 0.2)
    fallen = last**2 / 9.81 * np.log(np.cosh(9.81 * (motion.t - 1000) / last))
    assert motion["q/y"] == pytest.approx(-fallen, rel=bound)


def test_what_air_does_not_move_yet_begins_to_move_later() -> None:
    motion = follow(FALLING.replace("FORCE", " + (max(0, t - 1), m*g)"), 3, 4)
    assert motion["q/x"][:2].tolist() == [0, 0] and not motion["q/y"].any()
    late = follow(FALLING.replace("FORCE", " + (t, m*g)"), 2, 3)
    assert motion["q/x"][2:] == pytest.approx(late["q/x"][1:], rel=1e-11)


def test_bodies_on_a_rod_begin_to_move_together_in_air() -> None:
    """Each is braked from the first moment on, also while series of the other one's speed begin."""
    motion = follow(
        """
parameters: {g: 9.81}
coordinates: {x: {initial: 0}, y: {initial: 0}, u: {initial: 1}, v: {initial: 0}}
masses: {light: 1, heavy: 2}
positions: {light: [x, y], heavy: [u, v]}
potential: g*y + 2*g*v
constraints: {rod: norm(light - heavy) - 1}
forces: {light: "-0.3*norm((x_dot, y_dot))*(x_dot, y_dot)", heavy: "-0.3*norm((u_dot, v_dot))*(u_dot, v_dot)"}
""",
        2,
        5,
        outputs=("q", "ledger"),
    )
    assert np.max(np.abs(motion["diagnostics/ledger/h"])) < 1e-11


@pytest.mark.parametrize("precision", ["double", "double-double"])
def test_a_pendulum_in_air_turns_where_its_velocity_vanishes(precision: str) -> None:
    """On a rod, both components of the velocity are 0 at each end of a swing. With its angle as the
    coordinate, |v| is the absolute value of one number."""
    air = 'forces: {bob: "-0.1*norm((bob.vx, bob.vy))*(bob.vx, bob.vy)"}\nmasses: {bob: 1}\n'
    by_angle = lagrange.solve(
        "coordinates: {a: {initial: 0.6}}\npositions: {bob: [sin(a), -cos(a)]}\n"
        f"potential: 9.81*bob.y\n{air}",
        stop=4, samples=5,
    )  # fmt: skip
    by_rod = lagrange.solve(
        "coordinates: {x: {initial: sin(0.6)}, y: {initial: -cos(0.6)}}\npositions: {bob: [x, y]}\n"
        f"potential: 9.81*y\nconstraints: {{rod: (x**2 + y**2 - 1)/2}}\n{air}",
        stop=4, samples=5, outputs="q,ledger", precision=precision,
    )  # fmt: skip
    assert by_rod.q["x"] == pytest.approx(np.sin(by_angle.q["a"]), abs=1e-13)
    assert np.max(np.abs(by_rod.datasets["diagnostics/ledger/h"])) < (
        1e-12 if precision == "double" else 1e-28
    )
