"""Balls that lose speed on a shaking floor: they come to rest on it, and leave it when it falls faster than
they do."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from lagrange_cli.integrate.ending import Ending
from tests.support.motion import Motion, follow

BALLS = """
sizes: {{N: {count}}}
parameters: {{e: {e}, g: {g}, A: 0.2, w: 6}}
coordinates: {{"x[i in range(N)]": {{initial: {start} + 0.3*i}}}}
masses: {{"ball[i in range(N)]": 1}}
positions: {{"ball[i in range(N)]": "x[i]"}}
potential: sum(g*x[i] for i in range(N))
events:
  "floor[i in range(N)]":
    when: x[i] - A*sin(w*t)
    direction: falling
    action: {{set: {{"x_dot[i]": A*w*cos(w*t) - e*(x_dot[i] - A*w*cos(w*t))}}}}
"""
TOLERANCES = {"taylor": 2.0**-52, "ias15": 2.0**-52, "DOP853": 1e-12, "Radau": 1e-10}


def dropped(method: str, count: int, e: float, g: float, start: float, stop: float) -> Motion:
    text = BALLS.format(count=count, e=e, g=g, start=start)
    return follow(text, stop, 801, method=method, tolerance=TOLERANCES[method])


def heights(motion: Motion) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """How high balls are above the floor."""
    found: np.ndarray[tuple[int, int], np.dtype[np.float64]] = (
        motion["q/x"] - 0.2 * np.sin(6 * motion.t)[:, None]
    )
    return found


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
def test_balls_leave_the_floor_when_it_falls_faster(method: str) -> None:
    """They have come to rest by t = 2.1, and let go where A w^2 sin(w t) = g, both at once."""
    g, w, amplitude = 6.111, 6.0, 0.2
    motion = dropped(method, 2, 0.3, g, 0.6, 2.6)
    assert motion.outcome.ending is Ending.COMPLETE
    leaves = (math.asin(g / (amplitude * w**2)) + 4 * math.pi) / w
    t, above = motion.t, heights(motion)
    rests = (t > 2.1) & (t < leaves)
    assert np.count_nonzero(rests) > 10
    assert np.abs(above[rests]).max() < 1e-8
    flies = (t > leaves) & (t < leaves + 0.3)
    y, v = amplitude * math.sin(w * leaves), amplitude * w * math.cos(w * leaves)
    free = y + v * (t[flies] - leaves) - g / 2 * (t[flies] - leaves) ** 2
    assert motion["q/x"][flies] == pytest.approx(np.stack([free, free], axis=1), abs=1e-8)
    assert above[flies].max() > 0.01


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("method", TOLERANCES)
@pytest.mark.parametrize("count", [1, 3])
def test_no_ball_falls_through(method: str, count: int, request: pytest.FixtureRequest) -> None:
    chance = random.Random(f"{request.config.option.seed} {method} {count}")
    given = {"e": chance.uniform(0.1, 0.8), "g": chance.uniform(3, 12), "start": chance.uniform(0.3, 1.5)}
    motion = dropped(method, count, **given, stop=4.0)
    assert motion.outcome.ending is Ending.COMPLETE, given
    assert heights(motion).min() > -1e-7, given


PUSHED = """
parameters: {e: 0.3, A: 9, w: 1, p: 0}
coordinates: {x: {initial: 0, velocity: 0.3}}
masses: {ball: 1}
positions: {ball: x}
potential: -A*sin(w*t + p)*x
events:
  right: {when: x - 0.5, direction: rising, action: {set: {x_dot: -e*x_dot}}}
  left: {when: x + 0.5, direction: falling, action: {set: {x_dot: -e*x_dot}}}
"""


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize(("method", "count"), [("taylor", 20), ("ias15", 4)])
def test_a_ball_is_let_go_where_what_pushes_it_to_a_wall_becomes_0(
    method: str, count: int, request: pytest.FixtureRequest
) -> None:
    """Rounding decides to which side that is. Then x'' = A sin(w s), s after the force was 0."""
    source = random.Random(request.config.option.seed)
    for _ in range(count):
        sets = {"p": source.uniform(0.0, 6.0), "A": source.uniform(6.0, 12.0), "w": source.uniform(0.7, 1.0)}
        motion = follow(PUSHED, 20.0, 201, sets=sets, method=method)
        assert motion.outcome.ending is Ending.COMPLETE, sets
        p, A, w = sets.values()
        half = np.floor((w * motion.t + p) / np.pi)  # how often the force has been 0
        s = motion.t - (half * np.pi - p) / w
        sign = 1.0 - 2.0 * (half % 2.0)
        moved = np.minimum(A / w * (s - np.sin(w * s) / w), 1.0) - 0.5
        flies = (moved < 0.5) & (half > half[0] + 1.0)
        assert np.count_nonzero(flies) > 5
        assert motion["q/x"][flies] == pytest.approx((sign * moved)[flies], abs=1e-9), sets


SLIDING = """
coordinates: {x: {initial: 0, velocity: 1}, y: {initial: 1}}
masses: {ball: 1}
positions: {ball: [x, y]}
potential: 2*y
events: {floor: {when: y, direction: falling, action: {set: {y_dot: -y_dot/2, x_dot: ALONG}}}}
"""


@pytest.mark.exhaustive(keep=0.5)
@pytest.mark.parametrize("method", ["taylor", "DOP853"])
def test_impacts_that_drag_however_slow_they_are_have_no_limit(method: str) -> None:
    """Those that change x' in proportion to their speeds 2, 1, 1/2 .. have one, and then the floor takes no
    more; of 9/10, 9/10 .. it depends on how many are counted."""
    motion = follow(SLIDING.replace("ALONG", "0.9*x_dot"), 9.0, 10, method=method)
    assert motion.outcome.ending is Ending.DRAGGED and motion.t[-1] == 2.0
    motion = follow(SLIDING.replace("ALONG", "x_dot + y_dot/5"), 3.0, 4, method=method)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["v/x"][-1] == pytest.approx(1.0 - (2.0 + 2.0) / 5, abs=1e-7)


RUBBING = SLIDING.replace("velocity: 1", "velocity: 3").replace("when: y, direction: falling", "when: WHEN")


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("along", ["-abs(y_dot)", "min(y_dot, 0)", "y_dot"])
@pytest.mark.parametrize("when", ["y, direction: falling", "-2*y"])
def test_impulses_of_friction_have_its_force_as_their_limit(when: str, along: str) -> None:
    """Whatever tells that the speed is one of approach: x' = 3 - f g t in the end, of impulses of f."""
    text = RUBBING.replace("WHEN", when).replace("ALONG", f"x_dot + 0.2*1.5*{along}*sign(x_dot)")
    motion = follow(text, 6.0, 7)
    assert motion.outcome.ending is Ending.COMPLETE and abs(motion["q/y"][-1]) < 1e-15
    assert motion["v/x"][-3:] == pytest.approx(3.0 - 0.2 * 2.0 * motion.t[-3:], abs=1e-9)


STOPPED = """
parameters: {e: 0.5, mu: 0.3, g: 9.81, a: 0, c: 0}
coordinates: {x: {initial: 0, velocity: SPEED}, y: {initial: 1}}
masses: {ball: 1}
positions: {ball: [x, y]}
potential: g*y - a*x
generalized_forces: {x: FORCE}
events:
  floor:
    when: y
    direction: falling
    action: {set: {y_dot: -e*y_dot, x_dot: "x_dot - sign(x_dot)*min(abs(x_dot), mu*(1 + e)*abs(y_dot))"}}
"""


def slid(v: float, push: float, limit: float, time: float) -> float:
    """The velocity after a time, under a push and dry friction of this limit."""
    if v != 0.0:
        slows = push - math.copysign(limit, v)
        if v * slows >= 0.0 or -v / slows >= time:
            return v + slows * time
        time += v / slows
    return math.copysign(max(abs(push) - limit, 0.0), push) * time


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize(("method", "count"), [("taylor", 4), ("ias15", 1), ("DOP853", 1), ("Radau", 1)])
@pytest.mark.parametrize("beside", [False, True])
def test_what_impulses_of_friction_have_stopped_rests_unless_it_is_pushed_by_more(
    method: str, count: int, beside: bool, request: pytest.FixtureRequest
) -> None:
    """Its impulses one by one, with the flights between; then mu g, ``beside`` a force of dry friction."""
    chance = random.Random(f"{request.config.option.seed} {method} {beside}")
    for case in range(count):
        e, mu, g = chance.uniform(0.3, 0.7), chance.uniform(0.1, 0.6), chance.uniform(5.0, 12.0)
        c, v = beside * chance.uniform(0.1, 1.0), chance.uniform(-6.0, 6.0)
        a = (case + beside) % 2 * chance.uniform(-1.5, 1.5) * (mu * g + c)
        text = STOPPED.replace("SPEED", f"{v}").replace("FORCE", "-c*sign(x_dot)" if beside else "0")
        sets = {"e": e, "mu": mu, "g": g, "a": a, "c": c}
        motion = follow(text, 8.0, 33, sets=sets, method=method, tolerance=TOLERANCES[method])
        assert motion.outcome.ending is Ending.COMPLETE, (v, sets)
        speed = math.sqrt(2.0 * g)
        at, flight = 0.0, speed / g
        while flight > 1e-15:
            v, at = slid(v, a, c, flight), at + flight
            v -= math.copysign(min(abs(v), mu * (1.0 + e) * speed), v)
            speed *= e
            flight = 2.0 * speed / g
        later = motion.t > at + 1e-6
        assert np.count_nonzero(later) > 8
        expected = [slid(v, a, mu * g + c, t - at) for t in motion.t[later]]
        assert motion["v/x"][later] == pytest.approx(expected, abs=1e-6), (v, sets)


SLOPE = """
parameters: {{e: {e}, mu: 0.3, g: 9.81}}
coordinates: {{u: {{initial: {u}, velocity: 0.5}}, v: {{initial: {v}, velocity: {w}}}}}
definitions:
  down: (4*ball.vx - 3*ball.vy)/5
  across: (3*ball.vx + 4*ball.vy)/5
  rubbed: sign(down)*min(abs(down), mu*(1 + e)*abs(across))
  a: ball.vx - 3*(1 + e)*across/5 - 4*rubbed/5
  b: ball.vy - 4*(1 + e)*across/5 + 3*rubbed/5
masses: {{ball: 1}}
positions: {{ball: [{x}, {y}]}}
potential: g*ball.y
events:
  slope: {{when: 4*ball.y + 3*ball.x - 4, direction: falling, action: {{set: {{u_dot: {p}, v_dot: {q}}}}}}}
"""
CURVED = {
    "u + v**2/2": {"u": "0.955", "v": "0.3", "w": "0", "x": "u + v**2/2", "y": "v", "p": "a - v*b", "q": "b"},
    "v + u**2/2": {"u": "1", "v": "-0.2", "w": "-0.5", "x": "u", "y": "v + u**2/2", "p": "a", "q": "b - u*a"},
}


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("method", ["taylor", "ias15"])
@pytest.mark.parametrize("e", [0.0, 0.5])
@pytest.mark.parametrize("form", CURVED)
def test_impulses_of_friction_are_recognized_in_curved_coordinates(form: str, e: float, method: str) -> None:
    """On a slope of 3 to 4, x'' = 4/5 (3/5 - 4/5 mu) g in the end: signs of the speed of approach, which is 0
    there but for rounding, do not count."""
    same = {"u": "1", "v": "0.3", "w": "0", "x": "u", "y": "v", "p": "a", "q": "b"}
    texts = SLOPE.format(e=e, **CURVED[form]), SLOPE.format(e=e, **same)
    curved, straight = (follow(text, 3.0, 31, method=method) for text in texts)
    u, v = curved["q/u"], curved["q/v"]
    found = [u + v**2 / 2, v] if form == "u + v**2/2" else [u, v + u**2 / 2]
    expected = [straight[f"q/{one}"] for one in "uv"]
    assert np.array(found) == pytest.approx(np.array(expected), abs=1e-8)
    assert np.diff(found[0][-12:], 2) == pytest.approx(0.8 * (0.6 - 0.8 * 0.3) * 9.81 * 0.01, abs=1e-9)


STOPS = """
coordinates: {{x: {{initial: 1}}, y: {{initial: 0.3, velocity: {v}}}}}
definitions: {{across: (3*b.vx + 4*b.vy)/5}}
masses: {{b: 1}}
positions: {{b: [x, y]}}
potential: 9.81*b.y
forces: {{b: "-9*(b.vx, b.vy)/norm((b.vx, b.vy))"}}
events:
  slope:
    when: 4*y + 3*x - 4
    direction: falling
    action: {{set: {{x_dot: x_dot - 3*across/5, y_dot: y_dot - 4*across/5}}}}
"""


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853", "Radau"])
@pytest.mark.parametrize("v", [-0.3, 0.0, 0.1, 0.7])
def test_friction_along_a_vector_stops_what_slides_on_a_contact(v: float, method: str) -> None:
    """Friction and contact hold the same velocity then, and the contact has the force along it."""

    def flies(_: float, y: np.ndarray) -> list[float]:
        speed = float(np.hypot(y[2], y[3])) or np.inf
        return [y[2], y[3], -9.0 * y[2] / speed, -9.81 - 9.0 * y[3] / speed]

    def hits(_: float, y: np.ndarray) -> float:
        return float(4.0 * y[1] + 3.0 * y[0] - 4.0)

    hits.terminal, hits.direction = True, -1.0  # type: ignore[attr-defined]
    given = {"rtol": 1e-12, "atol": 1e-14, "max_step": 1e-3}
    flight = solve_ivp(flies, (0.0, 1.0), [1.0, 0.3, 0.0, v], method="DOP853", events=hits, **given)
    place, speed = flight.y[:2, -1], flight.y[2:, -1] @ [0.8, -0.6]
    place = place + np.array([0.8, -0.6]) * speed**2 / (2.0 * (9.0 - 0.6 * 9.81))
    tolerance = {"DOP853": 1e-12, "Radau": 1e-10}.get(method, 2.0**-52)
    motion = follow(STOPS.format(v=v), 1.2, 13, method=method, tolerance=tolerance)
    assert motion.outcome.ending is Ending.COMPLETE
    assert [motion["q/x"][-1], motion["q/y"][-1]] == pytest.approx(place, abs=1e-8)
    assert motion["v/x"][-1] == motion["v/y"][-1] == 0.0
    assert motion.outcome.steps < 1500
