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


@pytest.mark.exhaustive(keep=0.55)
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


@pytest.mark.exhaustive(keep=0.45)
@pytest.mark.parametrize("stop", [0.6, 0.52])
@pytest.mark.parametrize(
    ("method", "precision", "bound"),
    [("taylor", "double", 1e-14), ("taylor", "double-double", 1e-30), ("DOP853", "double", 1e-13)],
)
def test_ledgers_balance_while_it_is_held_and_when_it_is_let_go(
    method: str, precision: str, bound: float, stop: float
) -> None:
    """What holds it cancels the force but for rounding; DOP853's steps would be as long as 1e11 here. The
    motion may end on the way on which sliding begins."""
    motion = lagrange.solve(
        "coordinates: {x: {initial: 0}, y: {initial: 0}}\nmasses: {puck: 1}\n"
        "positions: {puck: [x, y]}\npotential: 0\n"
        'definitions: {v: "(x_dot, y_dot)"}\nforces: {puck: "(3*t, 0) - 1.5*v/norm(v)"}',
        stop=stop, samples=5, outputs="q,ledger", method=method, precision=precision,
    )  # fmt: skip
    assert motion.q["x"] == pytest.approx(np.maximum(motion.t - 0.5, 0) ** 3 / 2, abs=1e-15)
    for name in ("h", "p/x", "p/y"):
        assert np.max(np.abs(motion.datasets[f"diagnostics/ledger/{name}"])) < bound


@pytest.mark.exhaustive(keep=0.3)
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


ON_PLANE = """
parameters: {{g: 9.81, mu: {mu}, al: 0.4}}
coordinates:
  x: {{initial: 0, velocity: "{velocity}*cos(al)"}}
  y: {{initial: 0, velocity: 1.5}}
  z: {{initial: 0, velocity: "{velocity}*sin(al)"}}
masses: {{block: 1}}
positions: {{block: [x, y, z]}}
potential: g*block.z
constraints: {{plane: z*cos(al) - x*sin(al)}}
definitions: {{v: "(x_dot, y_dot, z_dot)"}}
forces: {{block: -mu*plane.multiplier*v/norm(v)}}
"""


@pytest.mark.exhaustive(keep=0.7)
@pytest.mark.parametrize("method", ["taylor", "DOP853"])
def test_a_block_on_a_plane_comes_to_rest_where_its_constraint_sets_the_limit(method: str) -> None:
    # along the slope w: |v| + p w falls at the rate p**2 - 1 in units of the friction, p = tan(al)/mu
    mu, al, w = 0.6, 0.4, 0.8
    motion = follow(ON_PLANE.format(mu=mu, velocity=w), 1, 21, method=method, tolerance=TOLERANCES[method])
    assert motion.outcome.ending is Ending.COMPLETE
    p, friction = np.tan(al) / mu, mu * 9.81 * np.cos(al)
    rest = (hypot(1.5, w) - p * w) / (friction * (1 - p**2))
    speed = np.sqrt(motion["v/x"] ** 2 + motion["v/y"] ** 2 + motion["v/z"] ** 2)
    assert np.all(speed[motion.t > rest] < 1e-12)
    assert np.all(speed[motion.t < rest - 0.01] > 1e-4)
    assert motion["q/z"] == pytest.approx(motion["q/x"] * np.tan(al), abs=1e-14)


@pytest.mark.exhaustive(keep=0.8)
def test_at_the_angle_of_friction_a_block_keeps_half_its_speed() -> None:
    motion = follow(ON_PLANE.format(mu="tan(al)", velocity=0), 20, 21)
    speed = np.sqrt(motion["v/x"] ** 2 + motion["v/y"] ** 2 + motion["v/z"] ** 2)
    assert speed - motion["v/x"] / np.cos(0.4) == pytest.approx(np.full(21, 1.5), abs=1e-12)
    assert speed[-1] == pytest.approx(0.75, abs=1e-10)


@pytest.mark.exhaustive(keep=0.2)
def test_a_bead_in_a_turning_bowl_slides_like_one_on_a_ring() -> None:
    turning = "parameters: {g: 9.81, mu: 0.3, w: 0.4}\nmasses: {bead: 1}\n"
    bowl = """
coordinates: {x: {initial: 0}, y: {initial: 0}, z: {initial: -1}}
positions: {bead: [x, y, z]}
potential: g*(z*cos(w*t) - x*sin(w*t))
constraints: {bowl: 1 - sqrt(x**2 + y**2 + z**2)}
definitions: {v: "(x_dot, y_dot, z_dot)"}
forces: {bead: -mu*bowl.multiplier*v/norm(v)}
"""
    ring = """
coordinates: {p: {initial: 0}}
positions: {bead: [sin(p), -cos(p)]}
potential: -g*cos(p - w*t)
generalized_forces: {p: -mu*(p_dot**2 + g*cos(p - w*t))*sign(p_dot)}
"""
    space, plane = follow(turning + bowl, 3, 31), follow(turning + ring, 3, 31)
    assert np.ptp(plane["q/p"]) > 0.5
    assert not np.any(space["q/x"][space.t < np.arctan(0.3) / 0.4])
    assert space["q/x"] == pytest.approx(np.sin(plane["q/p"]), abs=1e-12)
    assert not np.any(space["q/y"])


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize("method", TOLERANCES)
def test_a_bead_on_a_wire_slides_from_the_start(method: str) -> None:
    common = "parameters: {g: 9.81, mu: 0.5}\nmasses: {bead: 1}\npotential: g*bead.y\n"
    by_places = """
coordinates: {x: {initial: 0.8}, y: {initial: -0.6}}
positions: {bead: [x, y]}
constraints: {wire: 1 - x**2 - y**2}
definitions: {v: "(x_dot, y_dot)"}
forces: {bead: -2*mu*abs(wire.multiplier)*v/norm(v)}
"""
    by_angle = """
coordinates: {p: {initial: "asin(0.8)"}}
positions: {bead: [sin(p), -cos(p)]}
generalized_forces: {p: -mu*abs(p_dot**2 + g*cos(p))*sign(p_dot)}
"""
    first = follow(common + by_places, 1.5, 301, method=method, tolerance=TOLERANCES[method])
    other = follow(common + by_angle, 1.5, 301)
    exact = method in ("taylor", "ias15")
    assert first["q/x"] == pytest.approx(np.sin(other["q/p"]), abs=1e-13 if exact else 1e-8)
    assert np.all(other["v/p"][-20:] == 0)


@pytest.mark.exhaustive(keep=0.6)
def test_a_normal_force_that_falls_lets_a_block_go() -> None:
    text = """
coordinates: {x: {initial: 0}, y: {initial: 0}, z: {initial: 0}}
masses: {block: 2}
positions: {block: [x, y, z]}
potential: 20*z
constraints: {plane: z}
definitions: {v: "(x_dot, y_dot, z_dot)"}
forces: {block: "(3, 4, 5*t) - 0.5*plane.multiplier*v/norm(v)"}
observables: {along_x: -0.5*plane.multiplier*v.x/norm(v)}
"""
    motion = follow(text, 3, 13, outputs=("q", "v", "multipliers", "observables"))
    past = np.fmax(motion.t - 2, 0)
    assert motion["multipliers/plane"] == pytest.approx(20 - 5 * motion.t, abs=1e-13)
    limit = 0.6 * 0.5 * (20 - 5 * motion.t)  # the component of the limit along x
    assert motion["observables/along_x"] == pytest.approx(-np.fmin(3, limit), abs=1e-13)
    assert motion["q/x"] == pytest.approx(0.6 * 1.25 * past**3 / 6, abs=1e-14)
    assert motion["q/y"] == pytest.approx(0.8 * 1.25 * past**3 / 6, abs=1e-14)


PAIR = """
parameters: {mu: 0.3, g: 9.81}
coordinates: {x: {initial: 0}, y: {initial: 0}, a: {initial: 1}, b: {initial: 0}}
masses: {one: 1, other: 1}
positions: {one: [x, y], other: [a, b]}
potential: 7*(norm(other - one) - 1)**2
definitions: {u: "(x_dot, y_dot)", w: "(a_dot, b_dot)"}
forces:
  one: (0, 3*t) - mu*g*u/norm(u)
  other: (0, 3*t) - mu*g*w/norm(w)
"""


@pytest.mark.exhaustive(keep=0.8)
def test_two_pucks_that_are_pulled_alike_begin_to_slide_together() -> None:
    motion = follow(PAIR, 2, 21)
    past = np.maximum(motion.t - SLIDING / 3, 0)
    for name in "yb":
        assert motion[f"q/{name}"] == pytest.approx(past**3 / 2, abs=1e-13)
    assert np.all(motion["q/x"] == 0)
    assert np.all(motion["q/a"] == 1)


TURNTABLE = """
parameters: {limit: 4, al: 0.5}
coordinates: {x: {initial: 1}, y: {initial: 0}}
masses: {puck: 1}
positions: {puck: [x, y]}
potential: 0
definitions: {u: "(x_dot + al*t*y, y_dot - al*t*x)"}
forces: {puck: -limit*u/norm(u)}
"""


@pytest.mark.exhaustive(keep=0.3)
def test_a_turntable_that_turns_ever_faster_loses_a_puck() -> None:
    begins = 2 * (16 - 0.25) ** 0.25  # (w**2)**2 + al**2 = limit**2
    motions = [follow(TURNTABLE, 5, 51, method=m, tolerance=TOLERANCES[m]) for m in ("taylor", "Radau")]
    by_series, by_rates = motions
    carried = by_series.t <= begins
    angle = 0.25 * by_series.t**2
    assert by_series["q/x"][carried] == pytest.approx(np.cos(angle)[carried], abs=1e-13)
    assert hypot(by_series["q/x"][-1], by_series["q/y"][-1]) > 1.1
    for name in ("q/x", "q/y", "v/x", "v/y"):
        assert by_series[name] == pytest.approx(by_rates[name], abs=1e-8)


@pytest.mark.exhaustive(keep=0.75)
def test_a_sample_just_after_sliding_has_begun_is_as_exact_as_others() -> None:
    begins = 2 * (16 - 0.25) ** 0.25
    for soon in (1e-3, 1e-9, 1e-15):
        motion = follow(TURNTABLE, 1.25 * (begins + soon), 6)
        assert motion.outcome.ending is Ending.COMPLETE
        angle = 0.25 * motion.t[4] ** 2
        assert motion["q/x"][4] == pytest.approx(np.cos(angle), abs=1e-14 + soon**3)
        assert motion["v/y"][4] == pytest.approx(0.5 * motion.t[4] * np.cos(angle), abs=1e-14 + 20 * soon**2)


PLATE = """
parameters: {g: 9.81, mu: 0.14}
coordinates: {x: {initial: 0}, y: {initial: 0}, z: {initial: 0}}
masses: {puck: 1}
positions: {puck: [x, y, z]}
potential: g*z
constraints: {plate: z}
definitions: {u: "(x_dot - 0.3*cos(6*t), y_dot + 0.15*sin(5*t), z_dot)"}
forces: {puck: -mu*plate.multiplier*u/norm(u)}
"""


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("mu", [0.14, 0.1 + 64 * 0.09 / 149, 0.02 + 94 * 0.17 / 99])
def test_a_puck_sticks_to_a_shaking_plate_now_and_then(mu: float) -> None:
    motions = [
        follow(PLATE, 3, 61, method=method, tolerance=TOLERANCES[method], sets={"mu": mu})
        for method in ("taylor", "Radau")
    ]
    for motion in motions:
        assert motion.outcome.ending is Ending.COMPLETE
        x, y = motion["v/x"] - 0.3 * np.cos(6 * motion.t), motion["v/y"] + 0.15 * np.sin(5 * motion.t)
        slips = np.hypot(x, y)
        assert np.any(slips > 1e-3)
        assert np.any(slips < 1e-8)
    for name in ("q/x", "q/y", "v/x", "v/y"):
        assert motions[0][name] == pytest.approx(motions[1][name], abs=1e-6)


GROOVE = """
coordinates: {x: {initial: 0, velocity: 1}, y: {initial: 0}, z: {initial: 0}}
masses: {block: 1}
positions: {block: [x, y, z]}
potential: 8*z + 5*y
constraints: {floor: z, wall: y}
definitions: {v: "(x_dot, y_dot, z_dot)", along_floor: "(x_dot, y_dot, 0)", along_wall: "(x_dot, 0, z_dot)"}
"""


@pytest.mark.exhaustive(keep=0.75)
def test_a_block_in_a_groove_is_held_by_both_sides() -> None:
    force = "(2*t, 0, 0) - (0.4*floor.multiplier + 0.2*wall.multiplier)*v/norm(v)"
    motion = follow(GROOVE + f'forces: {{block: "{force}"}}', 3, 31)
    rest = (4.2 - sqrt(4.2**2 - 4)) / 2  # v = 1 + t**2 - 4.2 t
    still = (motion.t > rest) & (motion.t < 2.1)
    assert np.all(motion["v/x"][still] == 0)
    past = motion.t[-1] - 2.1
    assert motion["v/x"][-1] == pytest.approx(past**2, abs=1e-13)


@pytest.mark.exhaustive(keep=0.3)
def test_a_block_rests_by_shares_of_friction_that_do_not_follow() -> None:
    """The sum of 0.4 times 8 and 0.2 times 5 slows it down."""
    floor = "0.4*floor.multiplier*along_floor/norm(along_floor)"
    wall = "0.2*wall.multiplier*along_wall/norm(along_wall)"
    motion = follow(GROOVE + f'forces: {{block: "-{floor} - {wall}"}}', 1, 5)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["q/x"][-1] == pytest.approx(0.5 / 4.2, abs=1e-15)
    assert motion["v/x"][-1] == 0


PUCKS = """
parameters: {angle: 0.3, speed: 0, push: 0, rate: 0}
coordinates:
  ax: {initial: 0, velocity: speed*cos(angle)}
  ay: {initial: 0, velocity: speed*sin(angle)}
  bx: {initial: 0}
  by: {initial: 0}
masses: {a: 1, b: 1.5}
embedding: {a: [ax, ay], b: [bx, by]}
definitions: {u: "(ax_dot - bx_dot, ay_dot - by_dot)", v: "(ax_dot, ay_dot)", w: "(bx_dot, by_dot)"}
forces:
  a: -0.5*v/norm(v) - 0.3*u/norm(u) + (push + rate*t)*(cos(angle), sin(angle))
  b: -0.6*w/norm(w) + 0.3*u/norm(u)
"""


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
def test_pucks_that_rub_on_a_table_and_on_each_other(method: str) -> None:
    """All three forces hold: a circle of velocities. The motion ended where it began."""
    given = {"method": method, "tolerance": 1e-10 if method == "DOP853" else 2.0**-52}
    still = follow(PUCKS, 3, 7, sets={"push": 0.1}, **given)  # type: ignore[arg-type]
    stops = follow(PUCKS, 3, 7, sets={"speed": 1}, **given)  # type: ignore[arg-type]
    slides = follow(PUCKS, 3, 7, sets={"push": 1.2}, **given)  # type: ignore[arg-type]
    for motion, along in ((still, 0.0), (stops, 0.5 / 0.8), (slides, 0.4 / 2 * 9)):
        assert motion.outcome.ending is Ending.COMPLETE
        assert motion["q/ax"][-1] == pytest.approx(along * np.cos(0.3), abs=1e-9)
        assert motion["q/ay"][-1] == pytest.approx(along * np.sin(0.3), abs=1e-9)
        assert np.all(motion["q/bx"] == 0) and np.all(motion["q/by"] == 0)
    stuck = follow(PUCKS, 3, 7, sets={"rate": 2}, **given)  # type: ignore[arg-type]
    assert stuck.outcome.ending is Ending.UNDETERMINED and 0.3 < stuck.outcome.t < 0.4


FALLING = """
parameters: {m: 2, g: 9.81, c: 0.2}
coordinates: {x: {initial: 0}, y: {initial: 0}}
masses: {ball: m}
positions: {ball: [x, y]}
potential: m*g*y
forces: {ball: "-c*norm((x_dot, y_dot))*(x_dot, y_dot)FORCE"}
"""


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(("method", "bound"), [("taylor", 2e-14), ("Radau", 1e-9)])
def test_a_ball_falls_from_rest_through_air(method: str, bound: float) -> None:
    """|v| has no series where v is 0, but the motion has one: v = v1 tanh(g t/v1) (Taylor, sec. 2.4)."""
    text, tolerance = FALLING.replace("FORCE", ""), TOLERANCES[method]
    motion = follow(text, 1004, 3, start=1000, method=method, tolerance=tolerance)
    assert motion.outcome.ending is Ending.COMPLETE
    last = sqrt(2 * 9.81 / 0.2)
    fallen = last**2 / 9.81 * np.log(np.cosh(9.81 * (motion.t - 1000) / last))
    assert motion["q/y"] == pytest.approx(-fallen, rel=bound)


@pytest.mark.exhaustive(keep=0.6)
def test_balls_of_a_sweep_fall_like_single_ones() -> None:
    swept = lagrange.sweep(
        FALLING.replace("FORCE", ""), over={"c": [0.1, 0.2]}, stop=4, outputs="q", samples=2
    )
    last = np.sqrt(2 * 9.81 / np.array([0.1, 0.2]))
    fallen = last**2 / 9.81 * np.log(np.cosh(9.81 * 4 / last))
    assert swept.q["y"][:, -1] == pytest.approx(-fallen, rel=2e-14)


@pytest.mark.exhaustive(keep=0.3)
def test_what_air_does_not_move_yet_begins_to_move_later() -> None:
    motion = follow(FALLING.replace("FORCE", " + (max(0, t - 1), m*g)"), 3, 4)
    assert motion["q/x"][:2].tolist() == [0, 0] and not motion["q/y"].any()
    late = follow(FALLING.replace("FORCE", " + (t, m*g)"), 2, 3)
    assert motion["q/x"][2:] == pytest.approx(late["q/x"][1:], rel=1e-11)


@pytest.mark.exhaustive(keep=0.65)
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


@pytest.mark.exhaustive(keep=0.65)
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


LIGHT = """
parameters: {k: 30, mu: 0.1, g: 10}
coordinates: {x: {initial: 0.6}, y: {initial: SIDE}}
masses: {b: 1}
positions: {b: [x, y]}
potential: k*(x**2 + y**2)/2
forces: {b: "-mu*g*(b.vx, b.vy)/norm((b.vx, b.vy))"}
"""


@pytest.mark.parametrize(("k", "mu"), [(30, 1e-3), (3000, 1e-2), (3000, 1e-6)])
def test_what_turns_round_under_friction_far_smaller_than_other_forces_slides_on(k: float, mu: float) -> None:
    motion = lagrange.solve(
        LIGHT.replace("SIDE", "0.8"), set={"k": k, "mu": mu}, stop=10 / sqrt(k), samples=101
    )
    phase, loss = motion.t * sqrt(k), mu * 10 / k
    turns = np.floor(phase / np.pi)
    along = (-1) ** turns * ((1 - loss * (2 * turns + 1)) * np.cos(phase - turns * np.pi) + loss)
    np.testing.assert_allclose(motion.q["x"], 0.6 * along, rtol=0, atol=1e-12)
    np.testing.assert_allclose(motion.q["y"], 0.8 * along, rtol=0, atol=1e-12)


def test_the_same_on_a_wire_where_the_force_of_constraint_is_large() -> None:
    wire = LIGHT.replace("SIDE", "0.36") + "constraints: {wire: y - x**2}\n"
    values = {"k": 300, "mu": 1e-3}
    motion = lagrange.solve(wire, set=values, stop=0.5, samples=21, outputs="q,ledger")
    exact = lagrange.solve(wire, set=values, stop=0.5, samples=21, precision="double-double")
    np.testing.assert_allclose(motion.q["x"], exact.q["x"], rtol=0, atol=1e-12)
    assert np.abs(motion.ledger["h"]).max() < 1e-12 * 300


RUBBED = """
parameters: {F: 0.5}
coordinates: {x: {initial: 0, velocity: 0.75}, y: {initial: 0, velocity: 0.4}}
masses: {p: 1}
positions: {p: [x, y]}
potential: 0
dissipation: F*norm((p.vx, p.vy))
"""


def test_a_puck_rests_with_all_digits_that_steps_on_rates_keep() -> None:
    """What is behind the digits of a velocity that has become 0 moved it on, at 1e-24."""
    for force in np.linspace(0.3, 0.5, 41).tolist():
        motion = follow(RUBBED, 6.0, 3, method="ias15", tolerance=1e-13, outputs=("v",), sets={"F": force})
        assert motion["v/x"][-1] == motion["v/y"][-1] == 0.0, force
