"""Events, switches, impacts and constraints with steps on rates (ias15, DOP853, Radau): closed forms."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipj, ellipk

from lagrange_cli.integrate.ending import Ending
from lagrange_cli.native.rates.watching import terms_of
from lagrange_cli.native.stepping.roots import points_of
from tests.motions.test_events import BALL, OSCILLATOR
from tests.motions.test_normal_forces import BLOCK, TENSION
from tests.support.motion import Motion, follow

FALL = """
parameters: {y0: 1, k: 1e6, c: 400}
coordinates: {y: {initial: y0}}
masses: {b: 1}
positions: {b: y}
potential: 9.81*y + k*max(0, -y)**2/2
generalized_forces: {y: "where(y < 0, -c*y_dot, 0)"}
events: {rest: y_dot}
"""
METHODS = pytest.mark.parametrize(
    ("method", "tolerance"), [("ias15", 2.0**-52), ("DOP853", 1e-12), ("Radau", 1e-10)]
)
PENDULUM = """
coordinates: {a: {initial: 1}}
lagrangian: a_dot**2/2 + cos(a)
events: {down: a}
"""
IN_THE_PLANE = """
coordinates: {x: {initial: sin(1)}, y: {initial: -cos(1)}}
masses: {bob: 1}
embedding: {bob: [x, y]}
potential: bob.y
constraints: {rod: x**2 + y**2 - 1}
events: {down: x}
"""
HARD = """
parameters: {k: 1e6, c: 200}
coordinates: {y: {initial: 1}}
masses: {b: 1}
embedding: {b: [0, y]}
potential: 9.81*b.y + k*min(y, 0)**2/2
dissipation: where(y < 0, c*y_dot**2/2, 0)
events:
  floor: {when: y, direction: falling}
  low: {when: y_dot, direction: rising}
  lift: {when: y, direction: rising}
  top: {when: y_dot, direction: falling}
"""
QUARTER = float(ellipk(math.sin(0.5) ** 2))


def angle(t: np.ndarray) -> np.ndarray:
    """That of a pendulum let go at an angle of 1."""
    k = math.sin(0.5)
    return np.asarray(2 * np.arcsin(k * ellipj(QUARTER - t, k * k)[0]))


def stepped(
    text: str, stop: float, method: str, tolerance: float, samples: int = 11, **more: object
) -> Motion:
    return follow(text, stop, samples, method=method, tolerance=tolerance, **more)  # type: ignore[arg-type]


@pytest.mark.parametrize("degree", [3, 7, 8])
def test_polynomials_have_the_values_that_they_are_made_from(degree: int) -> None:
    points, chance = np.array(points_of(degree)), random.Random(degree)
    c = [chance.uniform(-1, 1) for _ in range(degree + 1)]
    values = np.polynomial.polynomial.polyval(points, c)
    found = np.array(terms_of(list(points))) @ (values[1:] - values[0])
    assert found == pytest.approx(c[1:], abs=1e-15 * 16**degree**0.9)


@pytest.mark.exhaustive(keep=1)
@METHODS
@pytest.mark.parametrize("direction", ["rising", "falling", "either"])
def test_crossings_are_those_of_a_sine(method: str, tolerance: float, direction: str) -> None:
    text = OSCILLATOR.format(x=0, v=1, when="x - 0.6", direction=direction, action="record")
    motion = stepped(text, 30.0, method, tolerance)
    way, turns = math.asin(0.6), 2 * np.pi * np.arange(5)
    sides = {"rising": [way], "falling": [math.pi - way], "either": [way, math.pi - way]}[direction]
    known = np.sort(np.concatenate([one + turns for one in sides]))
    assert motion["events/crossing/t"].shape == known.shape
    assert np.abs(motion["events/crossing/t"] - known).max() < 100 * tolerance
    assert np.abs(motion["events/crossing/q/x"] - 0.6).max() < 1e-15


@pytest.mark.exhaustive(keep=2)
@METHODS
def test_an_event_may_be_faster_than_the_motion(method: str, tolerance: float) -> None:
    text = OSCILLATOR.format(x=1, v=0, when="sin(60*t)", direction="either", action="record")
    motion = stepped(text, 5.0, method, tolerance)
    known = np.pi / 60 * np.arange(1, 96)
    assert motion["events/crossing/t"] == pytest.approx(known, abs=1e-13)


@pytest.mark.exhaustive(keep=0.65)
@pytest.mark.parametrize(
    ("method", "order", "tolerances"), [("DOP853", 8, (1e-5, 1e-9)), ("Radau", 5, (1e-5, 1e-9))]
)
def test_times_of_events_are_as_precise_as_ends_of_steps(
    method: str, order: int, tolerances: tuple[float, float]
) -> None:
    """Not as the polynomials within steps, whose order is 7, and 4."""
    errors, steps = [], []
    for tolerance in tolerances:
        motion = stepped(PENDULUM, 6 * QUARTER, method, tolerance)
        t = motion["events/down/t"]
        errors.append(np.abs(t - QUARTER * (1 + 2 * np.arange(3))).max())
        steps.append(motion.outcome.steps)
        assert errors[-1] < 10 * tolerance
    assert math.log(errors[0] / errors[1]) / math.log(steps[1] / steps[0]) > order - 0.5


@pytest.mark.exhaustive(keep=1)
@METHODS
def test_a_ball_bounces_when_it_should(method: str, tolerance: float) -> None:
    motion = stepped(BALL.format(y=1, v=0, e=0.9, A=0, w=1), 3.0, method, tolerance)
    first = math.sqrt(2 / 9.81)
    flights = 2 * first * 0.9 ** np.arange(1, 4)
    known = first + np.concatenate([[0], np.cumsum(flights)])
    assert motion["events/floor/t"] == pytest.approx(known, abs=1e-12)
    assert np.abs(motion["events/floor/q/y"]).max() < 1e-14


@pytest.mark.exhaustive(keep=0.75)
@METHODS
def test_bounces_that_accumulate_end_in_rest(method: str, tolerance: float) -> None:
    motion = stepped(BALL.format(y=1, v=0, e=0.5, A=0, w=1), 3.0, method, tolerance)
    end = math.sqrt(2 / 9.81) * (1 + 2 * 0.5 / (1 - 0.5))
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["events/floor/t"][-1] == pytest.approx(end, abs=1e-8)
    assert not motion["q/y"][motion.t > end + 1e-7].any()
    assert motion["q/x"] == pytest.approx(motion.t, abs=1e-10)


@pytest.mark.exhaustive(keep=0.8)
@METHODS
def test_an_event_stops_the_motion(method: str, tolerance: float) -> None:
    text = OSCILLATOR.format(x=0, v=1, when="x_dot", direction="falling", action="stop")
    motion = stepped(text, 30.0, method, tolerance, 101)
    assert motion.outcome.ending is Ending.STOPPED
    assert motion.outcome.final.t == pytest.approx(math.pi / 2, abs=100 * tolerance)
    assert motion.t[-1] <= motion.outcome.final.t


@pytest.mark.exhaustive(keep=1)
@METHODS
def test_friction_holds_where_it_should(method: str, tolerance: float) -> None:
    """A half swing ends 2 mu g/k nearer to 0, and the third one within the zone where friction holds."""
    text = """
        coordinates: {x: {initial: 1}}
        lagrangian: (x_dot**2 - x**2)/2
        generalized_forces: {x: -0.2*sign(x_dot)}
        """
    motion = stepped(text, 20.0, method, tolerance, 201)
    assert not motion.outcome.undetected
    assert motion["q/x"][np.isclose(motion.t, 20)] == pytest.approx(0.2, abs=1e-9)
    turned = (motion.t > math.pi) & (motion.t < 2 * math.pi)
    known = -0.2 - 0.4 * np.cos(motion.t - math.pi)
    assert motion["q/x"][turned] == pytest.approx(known[turned], abs=1e-9)
    assert np.abs(motion["v/x"][motion.t > 2 * math.pi + 0.1]).max() < 1e-12


@pytest.mark.exhaustive(keep=1)
@METHODS
def test_a_rod_is_a_constraint(method: str, tolerance: float) -> None:
    """The pendulum in Cartesian coordinates, beside the closed form; and the force of the rod."""
    outputs = ("q", "v", "multipliers", "constraints", "ledger")
    motion = stepped(IN_THE_PLANE, 10.0, method, tolerance, 51, outputs=outputs)
    known = angle(motion.t)
    assert motion["q/x"] == pytest.approx(np.sin(known), abs=1e3 * tolerance)
    assert motion["multipliers/rod"] == pytest.approx(-1.5 * np.cos(known) + math.cos(1), abs=1e4 * tolerance)
    assert motion.outcome.projections > 0
    t = motion["events/down/t"]
    assert t == pytest.approx(QUARTER * (1 + 2 * np.arange(len(t))), abs=1e3 * tolerance)
    assert np.abs(motion["diagnostics/ledger/h"]).max() < 1e4 * tolerance
    off = np.hypot(motion["events/down/q/x"], motion["events/down/q/y"]) - 1
    assert np.abs(off).max() < 1e-15


@pytest.mark.exhaustive(keep=0.55)
@pytest.mark.parametrize("method", ["ias15", "DOP853", "Radau"])
@pytest.mark.parametrize("tolerance", [1e-7, 1e-9, 1e-11])
def test_an_impact_on_a_hard_spring_with_friction(method: str, tolerance: float) -> None:
    """Several guards have the same argument, and none of them is passed over."""
    known = follow(HARD, 1.0, 11)
    found = stepped(HARD, 1.0, method, tolerance, outputs=("q", "v", "ledger"))
    for name in ("floor", "low", "lift", "top"):
        assert found[f"events/{name}/t"] == pytest.approx(known[f"events/{name}/t"], abs=100 * tolerance)
    assert np.abs(found["diagnostics/ledger/h"]).max() < 1000 * tolerance


def test_what_rests_beside_constraints_does_not_make_steps_short() -> None:
    """Some velocities of the linkage are 0 up to rounding where it turns back."""
    motion = stepped("four_bar", 4.0, "ias15", 2.0**-52, 5)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion.outcome.steps < 1000


@pytest.mark.exhaustive(keep=1)
@METHODS
def test_a_block_stops_on_an_incline_and_stays(method: str, tolerance: float) -> None:
    """Friction by the force of a constraint: what step control knew before the block stopped says nothing."""
    motion = stepped(BLOCK, 3.0, method, tolerance, 7)
    rate = 9.81 * (math.sin(0.5) + 0.8 * math.cos(0.5))
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["q/x"][1:] == pytest.approx(3.0**2 / (2 * rate), abs=1e-9)


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(("method", "tolerance"), [("DOP853", 1e-10), ("Radau", 1e-8)])
def test_friction_by_a_tension_holds_what_it_has_stopped(method: str, tolerance: float) -> None:
    """It is brought to rest where friction exceeds gravity along the circle, after two turns."""
    motion = stepped(TENSION, 10, method, tolerance)
    assert motion.outcome.ending is Ending.COMPLETE
    assert abs(motion["v/x"][2]) > 1
    assert np.max(np.abs([motion["v/x"][3:], motion["v/y"][3:]])) < 1e-30
    sine = motion["q/x"][-1] / 1.5
    normal = 2 * 9.81 * math.sqrt(1 - sine**2)
    assert 2 * 9.81 * abs(sine) < 0.05 * normal**1.5 and np.ptp(motion["q/x"][3:]) == 0


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize(("method", "tolerance"), [("DOP853", 1e-8), ("Radau", 1e-8)])
def test_short_steps_in_which_something_moves_are_no_sticking(method: str, tolerance: float) -> None:
    """Thousands of short steps behind a long one: a fast oscillation begins where a slow one is over."""
    text = """
    parameters: {w: 6e5}
    coordinates: {x: {initial: 1}}
    lagrangian: x_dot**2/2 - where(t < 3, 1, w**2)*x**2/2
    """
    motion = stepped(text, 3.02, method, tolerance)
    assert motion.outcome.ending is Ending.COMPLETE and motion.outcome.steps > 10000


@pytest.mark.exhaustive(keep=0.55)
@pytest.mark.parametrize(
    ("method", "tolerance", "steps"),
    [("ias15", 2.0**-52, 12000), ("DOP853", 1e-12, 5000), ("Radau", 1e-9, 2000)],
)
@pytest.mark.parametrize(
    "force", ["max(0, -k*x - c*x_dot*where(x < 0, 1, 0))", "where(x < 0, -k*x - c*x_dot, 0)"]
)
def test_what_rests_on_a_hard_spring_rests(method: str, tolerance: float, steps: int, force: str) -> None:
    """Its acceleration is nothing but rounding, and so are the zeros of its velocity."""
    text = f"""
    parameters: {{k: 1e6, c: 400}}
    coordinates: {{x: {{initial: 1}}}}
    masses: {{b: 1}}
    embedding: {{b: [0, x]}}
    generalized_forces: {{x: "-9.81 + {force}"}}
    events: {{turn: x_dot}}
    """
    motion = stepped(text, 4.0, method, tolerance)
    assert motion.outcome.ending is Ending.COMPLETE and motion.outcome.steps < steps
    assert motion["q/x"][-4:] == pytest.approx(-9.81e-6, abs=10 * tolerance)
    known = follow(text, 1.5, 3)["events/turn/t"]
    assert motion["events/turn/t"][:4] == pytest.approx(known[:4], abs=1e-7)


@pytest.mark.exhaustive(keep=0.2)
def test_what_rests_on_a_spring_rests_to_any_end(request: pytest.FixtureRequest) -> None:
    """The last step ends where the motion does: within a longer one, rounding was taken for a critical
    point, in one of twenty motions."""
    source = random.Random(request.config.option.seed)
    for _ in range(8):
        motion = follow(
            FALL, source.uniform(2.5, 4.5), 3, sets={"y0": source.uniform(1.0, 1.06)}, method="ias15"
        )
        assert motion.outcome.ending is Ending.COMPLETE


@pytest.mark.exhaustive(keep=2)
@METHODS
def test_steps_are_not_shorter_than_rounding_explains(method: str, tolerance: float) -> None:
    """Forces of 1e10 cancel: no step is as precise as the tolerance asks."""
    text = """
    coordinates: {x: {initial: 1.001}}
    lagrangian: x_dot**2/2 - 1e10*(x - 1/3)**2/2 + 1e10*x*2/3
    dissipation: 1e4*x_dot**2/2
    """
    motion = stepped(text, 0.05, method, tolerance, 6)
    assert motion.outcome.ending is Ending.COMPLETE and motion.outcome.steps < (
        10000 if method == "ias15" else 50000
    )
    assert motion["q/x"][1:] == pytest.approx(1, abs=1e-12)


@pytest.mark.exhaustive(keep=0.9)
@pytest.mark.parametrize("method", ["ias15", "DOP853", "Radau"])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-7, 1e-8])
def test_nothing_falls_through_a_floor(method: str, tolerance: float) -> None:
    """Impacts become so low that the motion between them is below the error of a longer step's polynomial."""
    text = """
    coordinates: {x: {initial: -0.6, velocity: -0.937}}
    lagrangian: x_dot**2/2 - 17.254*x**2/2 - 0.3*sqrt(1 + x**2) - 0.5*cos(2*x)
    dissipation: 0.05*x_dot**2/2
    events: {floor: {when: x - 0.08, direction: falling, action: {set: {x_dot: -0.5*x_dot}}}}
    """
    motion = stepped(text, 5.0, method, tolerance, 41)
    assert motion["q/x"][motion.t > 3.31] == pytest.approx(0.08, abs=1e-15)


@pytest.mark.exhaustive(keep=2)
@METHODS
def test_fast_forces_at_a_late_time(method: str, tolerance: float) -> None:
    """The force is known to 1e-8, as the time is; the Taylor method has no more."""
    text = """
    coordinates: {x: {initial: 1}}
    lagrangian: x_dot**2/2 - x**2/2 + x*cos(50*t)
    """
    found, known = (
        stepped(text, 1e6 + 2, *how, start=1e6) for how in ((method, tolerance), ("taylor", 2.0**-52))
    )
    assert found.outcome.ending is Ending.COMPLETE and found.outcome.steps < 6000
    assert found["q/x"] == pytest.approx(known["q/x"], abs=1e-8)


@pytest.mark.exhaustive(keep=1)
@METHODS
def test_friction_lets_go_with_no_speed_and_no_acceleration(method: str, tolerance: float) -> None:
    """From there on v = 0.6 (cos(t0) - cos(t)) - (t - t0)/2, with 0.6 sin(t0) = 1/2."""
    text = """
    coordinates: {x: {initial: 1}, y: {initial: 0.3}}
    lagrangian: (x_dot**2 - x**2 + y_dot**2)/2
    generalized_forces: {y: -sign(y_dot)/2 + 0.6*sin(t)}
    """
    motion = stepped(text, 2.0, method, tolerance, 41)
    free, let_go = motion.t > math.asin(5 / 6), math.asin(5 / 6)
    known = 0.6 * (math.cos(let_go) - np.cos(motion.t)) - (motion.t - let_go) / 2
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["v/y"] == pytest.approx(np.where(free, known, 0), abs=1e-9)


STICKS = """
parameters: {mu: 0.3, g: 9.81, F: 4, w: 1.3}
coordinates: {x: {initial: 0, velocity: 1}}
masses: {block: 1}
embedding: {block: [x]}
generalized_forces: {x: -mu*g*sign(x_dot) + F*sin(w*t)}
events:
  up: {when: x_dot, direction: rising}
  down: {when: x_dot, direction: falling}
  both: {when: 2*x_dot}
"""
EVERY = [("taylor", 2.0**-52), ("ias15", 2.0**-52), ("DOP853", 1e-12), ("Radau", 1e-10)]


def stop_after(start: float, speed: float) -> float:
    """When the block stops that slides at a time with a speed, in the direction of that."""
    way, drag, force, w = math.copysign(1.0, speed), 0.3 * 9.81, 4.0, 1.3

    def v(t: float) -> float:
        swing = force / w * (math.cos(w * start) - math.cos(w * t))
        return way * (speed - way * drag * (t - start) + swing)

    times = np.linspace(start + 0.05, start + 5.0, 1000)
    after = next(t for t in times if v(t) < 0)
    return float(brentq(v, after - times[1] + times[0], after, xtol=1e-14))


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(("method", "tolerance"), EVERY)
def test_a_velocity_that_friction_holds_at_0_has_crossed_it_when_it_stopped(method, tolerance):
    """Once, from its side; and not when the block slides on, where the force is mu g again."""
    motion = stepped(STICKS, 12.0, method, tolerance, samples=121)
    period, first = math.pi / 1.3, math.asin(0.3 * 9.81 / 4.0) / 1.3
    stops, slides = [stop_after(0.0, 1.0)], [first + k * period for k in range(1, 4)]
    stops += [stop_after(t, -1e-300 if k % 2 == 0 else 1e-300) for k, t in enumerate(slides)]
    known = {"down": stops[::2], "up": stops[1::2], "both": stops}
    for name, times in known.items():
        assert motion[f"events/{name}/t"] == pytest.approx(times, abs=1e-7 if method == "Radau" else 1e-10)
    held = [t for t in motion.t if any(a < t < b for a, b in zip(stops, slides))]
    assert len(held) > 15 and not np.any(motion["v/x"][np.isin(motion.t, held)])


@pytest.mark.exhaustive(keep=1.5)
@pytest.mark.parametrize(("method", "tolerance"), EVERY)
def test_what_is_done_when_friction_stops_a_block(method, tolerance):
    """It is pushed on each time: v^2/(2 mu g) further, twice in all."""
    text = STICKS.partition("events")[0].replace("F: 4", "F: 0")
    push = "{set: {x_dot: where(x < 0.3, 1, 0)}}"
    motion = stepped(f"{text}events: {{on: {{when: x_dot, action: {push}}}}}", 2.0, method, tolerance)
    drag = 0.3 * 9.81
    assert motion["events/on/t"] == pytest.approx([1 / drag, 2 / drag], abs=1e-9)
    assert motion["q/x"][-1] == pytest.approx(1 / drag, abs=1e-9)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize(
    ("method", "tolerance"), [("DOP853", 1e-12), *[("Radau", 10.0**-k) for k in range(6, 12)]]
)
def test_a_body_that_is_lifted_leaves_the_floor_in_few_steps(method, tolerance):
    """Its acceleration is 0 at first: polynomials of long steps have roots there that are their errors."""
    text = """
coordinates: {y: {initial: 0}, x: {initial: 0, velocity: 1}}
lagrangian: y_dot**2/2 + x_dot**2/2 - x**2/2
generalized_forces: {y: x - 0.5}
events: {floor: {when: y, direction: falling, action: {set: {y_dot: -0.5*y_dot}}}}
"""
    motion, begins = stepped(text, 1.5, method, tolerance, samples=61), math.pi / 6
    passed = np.maximum(motion.t - begins, 0.0)
    known = np.cos(begins) * passed + 0.5 - np.sin(begins + passed) - passed**2 / 4
    assert motion["q/y"] == pytest.approx(known, abs=10 * tolerance)
    assert motion.outcome.steps < 300
