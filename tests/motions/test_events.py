"""Events against closed forms: what is recorded, stops a motion, or acts on it; impacts, and rest."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from lagrange_cli import solve
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.spec.values import resolve_long_values, resolve_values
from tests.support.motion import FULL, follow, prepared, run, spec_of

OSCILLATOR = """
name: an oscillator
parameters: {{k: 1}}
coordinates: {{x: {{initial: {x}, velocity: {v}}}}}
masses: {{p: 1}}
embedding: {{p: [x]}}
potential: k*x**2/2
events:
  crossing: {{when: "{when}", direction: {direction}, action: {action}}}
"""
BALL = """
name: a ball
parameters: {{e: {e}, A: {A}, w: {w}}}
coordinates:
  y: {{initial: {y}, velocity: {v}}}
  x: {{initial: 0, velocity: 1}}
masses: {{p: 2}}
embedding: {{p: [x, y]}}
potential: 2*9.81*y
events:
  floor:
    when: y - A*sin(w*t)
    direction: falling
    action: {{set: {{y_dot: A*w*cos(w*t) - e*(y_dot - A*w*cos(w*t))}}}}
"""
G = 9.81

FALLING = """
coordinates: {x: {initial: 1}, y: {initial: 0.5}}
masses: {p: 1, q: 1}
positions: {p: x, q: y}
potential: x**2/2 + 9.81*y
events:
"""
KICK = "{{when: {0}, direction: falling, action: {{set: {{x_dot: x_dot + 0.01}}}}}}"


@pytest.fixture
def source(request) -> random.Random:
    return random.Random(request.config.option.seed)


def oscillator(x: float, v: float, when: str, direction: str = "either", action: str = "record") -> str:
    return OSCILLATOR.format(x=repr(x), v=repr(v), when=when, direction=direction, action=action)


def ball(y: float, v: float, e: float, A: float = 0.0, w: float = 1.0) -> str:
    return BALL.format(y=repr(y), v=repr(v), e=repr(e), A=repr(A), w=repr(w))


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(("direction", "sides"), [("rising", [1]), ("falling", [-1]), ("either", [1, -1])])
def test_crossings_are_those_of_a_sine(direction, sides, source):
    """x = a sin(t + b) is c where t + b = asin(c/a) on the way up, pi - asin(c/a) on the way down."""
    a, b, c = source.uniform(1, 2), source.uniform(-1, 1), source.uniform(-0.9, 0.9)
    motion = follow(oscillator(a * math.sin(b), a * math.cos(b), f"x - {c!r}", direction), 300.0, 11)
    turns = 2 * np.pi * np.arange(-1, 60)
    way = math.asin(c / a)
    known = np.sort(np.concatenate([(way if s > 0 else math.pi - way) + turns - b for s in sides]))
    known = known[(known > 0) & (known < 300)]
    assert motion["events/crossing/t"].shape == known.shape
    assert np.abs(motion["events/crossing/t"] - known).max() < 2e-13
    assert np.abs(motion["events/crossing/q/x"] - c).max() < 1e-15
    assert np.abs(np.abs(motion["events/crossing/v/x"]) - math.sqrt(a * a - c * c)).max() < 1e-13
    assert motion.outcome.happened["crossing"].count == len(known)


def test_many_crossings_in_a_step(source):
    """The motion is slow, the event is not; and two events at the same time both happen."""
    omega = source.uniform(50, 90)
    text = oscillator(1.0, 0.0, f"sin({omega!r}*t)") + f"  same: {{when: sin({omega!r}*t)}}\n"
    motion = follow(text, 5.0, 11)
    known = np.arange(1, math.floor(5 * omega / math.pi) + 1) * math.pi / omega
    for name in ("crossing", "same"):
        assert motion[f"events/{name}/t"] == pytest.approx(known, rel=1e-14)
    assert motion.outcome.happened["same"].grazing == 0


def test_a_zero_at_the_start_is_no_event():
    motion = follow(oscillator(0.0, 1.0, "x"), 3.0, 4)
    assert "events/crossing/t" not in motion.data
    assert follow(oscillator(0.3, 1.0, "x - 0.1*3", "rising"), 3.0, 4).outcome.happened["crossing"].count == 0


@pytest.mark.exhaustive(keep=0.55)
def test_a_motion_that_turns_at_the_event_grazes_it():
    motion = follow(oscillator(0.0, 1.0, "(x - 1/2)**2*(x + 2)"), 20.0, 5)
    assert motion.outcome.happened["crossing"].count % 2 == 0
    motion = follow(oscillator(0.0, 1.0, "x - 1", "rising"), 20.0, 5)
    happened = motion.outcome.happened["crossing"]
    assert happened.count == 0 or happened.grazing
    motion = follow(oscillator(0.0, 1.0, "(x - 1/2)**2", "either", "stop"), 20.0, 5)
    happened = motion.outcome.happened["crossing"]
    assert happened.count == 0 or happened.grazing


def test_a_motion_stops_at_an_event(source):
    c = source.uniform(0.2, 0.8)
    motion = follow(oscillator(0.0, 1.0, f"x - {c!r}", "rising", "stop"), 10.0, 1001)
    assert motion.outcome.ending is Ending.STOPPED
    assert motion.outcome.ending.status == "stopped"
    assert motion.outcome.t == pytest.approx(math.asin(c), rel=1e-14)
    assert motion.t[-1] <= motion.outcome.t < motion.t[-1] + 0.01
    final = motion.outcome.final  # at the event, not at the last sample
    assert final.t == motion.outcome.t and final.q["x"] == pytest.approx(c, rel=1e-14)
    assert final.v["x"] == motion["events/crossing/v/x"][0]
    assert motion["events/crossing/t"] == pytest.approx([math.asin(c)], rel=1e-14)


def test_an_elastic_wall_reflects(source):
    """Between walls at 0 and a; steps: one more at each impact, and energy is kept."""
    a, v = source.uniform(1, 2), source.uniform(2, 3)
    text = f"""
    name: a box
    coordinates: {{x: {{initial: {a / 3!r}, velocity: {v!r}}}}}
    masses: {{p: 1}}
    embedding: {{p: [x]}}
    potential: 0
    events:
      wall: {{when: "x*({a!r} - x)", direction: falling, action: {{set: {{x_dot: -x_dot}}}}}}
    """
    motion = follow(text, 50.0, 777)
    place = (a / 3 + v * motion.t) % (2 * a)
    assert motion["q/x"] == pytest.approx(np.minimum(place, 2 * a - place), abs=1e-12)
    assert motion.outcome.h_drift == 0.0
    assert motion.outcome.steps <= motion.outcome.happened["wall"].count + 3


@pytest.mark.exhaustive(keep=0.65)
@pytest.mark.parametrize("precision", ["double", "double-double"])
def test_a_ball_comes_to_rest(precision, source):
    """Impact n is at t1 (1 + 2 (e + ... + e^n)); infinitely many take t1 (1 + e)/(1 - e)."""
    e, y = source.uniform(0.3, 0.7), source.uniform(0.5, 2)
    text, first = ball(y, 0.0, e), math.sqrt(2 * y / G)
    stop = first * (1 + e) / (1 - e) + 2
    outputs = ("q", "v", "h", "p", "ledger")
    ready = prepared(
        text, "taylor", FULL if precision == "double" else 2.0**-100, outputs, precision=precision
    )
    resolve = resolve_values if precision == "double" else resolve_long_values
    motion = run(ready, resolve(spec_of(text), {}), 0.0, stop, 501)
    happened = motion.outcome.happened["floor"]
    n = np.arange(happened.count)
    known = first * (1 + 2 * e * (1 - e**n) / (1 - e))
    assert motion["events/floor/t"] == pytest.approx(known, rel=3e-15)
    assert happened.accumulations == 1
    assert happened.accumulates == pytest.approx(first * (1 + e) / (1 - e), rel=1e-14)
    assert motion["q/y"][-1] == motion["v/y"][-1] == 0.0
    assert motion["q/x"] == pytest.approx(motion.t, rel=1e-14)
    given = 2 * G * stop  # what gravity adds to the momentum, rounded at each impact
    limit = happened.count * 2.0**-53 * given if precision == "double" else 1e-27
    for path in ("ledger/h", "ledger/p/y", "ledger/p/x"):
        assert np.abs(motion[f"diagnostics/{path}"]).max() < limit


@pytest.mark.parametrize("e", [0.0, 0.5])
def test_a_ball_that_lies_on_the_floor_stays_there(e):
    motion = follow(ball(0.0, 0.0, e), 10.0, 11)
    assert np.array_equal(motion["q/y"], np.zeros(11))
    assert motion.outcome.steps <= 2


def test_a_floor_without_bounce_takes_all_speed(source):
    y = source.uniform(0.5, 2)
    motion = follow(ball(y, 0.0, 0.0), 10.0, 11)
    assert motion.outcome.happened["floor"].count == 1
    assert np.abs(motion["q/y"][2:]).max() < 1e-14


def test_a_table_throws_what_lies_on_it(source):
    """It leaves where the table's acceleration is -g: sin(w t) = g/(A w^2)."""
    A, w = source.uniform(0.05, 0.08), source.uniform(20, 25)
    text = ball(0.0, A * w, 0.0, A, w)
    left = math.asin(G / (A * w * w)) / w
    motion = follow(text, left + 0.01, 3)
    after = 0.01
    y = G / w**2 + A * w * math.cos(w * left) * after - G * after**2 / 2
    assert motion["q/y"][-1] == pytest.approx(y, abs=1e-14)


@pytest.mark.exhaustive(keep=0.5)
def test_an_inclined_floor_with_restitution():
    """At rest across it, the ball slides with g sin(alpha) cos(alpha) along x."""
    text = """
    name: a slope
    parameters: {e: 0.5, m: 0.5}
    coordinates: {x: {initial: 0, velocity: 0}, y: {initial: 1, velocity: 0}}
    masses: {p: 1}
    embedding: {p: [x, y]}
    potential: 9.81*y
    events:
      slope:
        when: y + m*x
        direction: falling
        action:
          set:
            x_dot: x_dot - (1 + e)*(y_dot + m*x_dot)*m/(1 + m**2)
            y_dot: y_dot - (1 + e)*(y_dot + m*x_dot)/(1 + m**2)
    """
    motion = follow(text, 5.0, 101, outputs=("q", "v", "ledger"))
    rest = motion.t > 2
    slope = np.diff(motion["v/x"][rest]) / np.diff(motion.t[rest])
    assert slope == pytest.approx(np.full(len(slope), G * 0.5 / 1.25), rel=1e-11)
    assert np.abs(motion["q/y"] + 0.5 * motion["q/x"])[rest].max() < 1e-14
    for path in ("ledger/h", "ledger/p/x", "ledger/p/y"):
        assert np.abs(motion[f"diagnostics/{path}"]).max() < 1e-12


def test_what_a_floor_changes_where_the_ball_rests_is_not_conserved():
    """p_y + m g t is constant in flight only, h also while the ball lies on the floor."""
    text = """
    parameters: {g: 9.81, m: 0.3}
    coordinates: {x: {initial: 1, velocity: 2}, y: {initial: 0.01}}
    masses: {ball: m}
    embedding: {ball: [x, y]}
    potential: m*g*y
    events: {floor: {when: y, direction: falling, action: {set: {y_dot: -0.1*y_dot}}}}
    """
    motion = follow(text, 1.0, 11, outputs=("q", "v", "conserved"))
    assert np.all(motion["v/y"][2:] == 0.0)
    kept = [values[2:] for path, values in motion.data.items() if "conserved/" in path]
    assert len(kept) > 1
    for values in kept:
        assert values == pytest.approx(np.full(9, values[0]), abs=1e-15)


def test_a_kicked_rotor_is_the_standard_map(source):
    """p -> p + K sin(q), then q -> q + p; the samples are between the kicks."""
    K, q, p = 0.4, source.uniform(0, 3), source.uniform(0.1, 1)
    text = f"""
    name: a kicked rotor
    parameters: {{K: {K}}}
    coordinates: {{theta: {{initial: {q!r}, velocity: {p!r}}}}}
    lagrangian: theta_dot**2/2
    events:
      kick: {{when: sin(pi*t), action: {{set: {{theta_dot: theta_dot + K*sin(theta)}}}}}}
    """
    motion = follow(text, 20.5, 42, outputs=("q", "v", "p", "ledger"))
    grown = np.eye(2)  # the derivatives of the map: near (0, 0) errors double from kick to kick
    for n in range(1, 21):
        q += p
        p += K * math.sin(q)
        grown = np.array([[1, 1], [K * math.cos(q), 1 + K * math.cos(q)]]) @ grown
        most = 2.0**-45 * np.abs(grown).max()
        assert motion["q/theta"][2 * n + 1] == pytest.approx(q + p / 2, rel=most, abs=most)
        assert motion["diagnostics/p/theta"][2 * n + 1] == pytest.approx(p, rel=most, abs=most)
    assert np.abs(motion["diagnostics/ledger/h"]).max() < 1e-13
    assert motion.outcome.p_drift == {}  # it is conserved between kicks only


def test_an_event_changes_a_parameter(source):
    """The spring is k1 to the right and k2 to the left of 0: half periods pi/sqrt(k)."""
    k = source.uniform(2, 4)
    action = f"{{set: {{k: 'where(k > 1.5, 1, {k!r})'}}}}"
    period = math.pi * (1 + 1 / math.sqrt(k))
    motion = follow(
        oscillator(1.0, 0.0, "x", "either", action), 10 * period, 11, outputs=("q", "v", "h", "ledger")
    )
    assert motion["q/x"] == pytest.approx(np.ones(11), abs=1e-12)
    assert motion["diagnostics/h"] == pytest.approx(np.full(11, 0.5), rel=1e-12)
    assert np.abs(motion["diagnostics/ledger/h"]).max() < 1e-13


def test_actions_where_friction_turns_happen_as_often_as_without_friction_there(source):
    """The motion has passed the zero of the velocity when friction has turned, by a rounding error: that is
    no jump. A record of the same zeros tells how many there are."""
    text = """
parameters: {A: 1, w: 1, mu: 1}
coordinates: {x: {initial: 0}, n: {initial: 0}}
masses: {block: 1, counter: 1}
positions: {block: x, counter: n}
potential: x**2/2
generalized_forces: {x: A*sin(w*t) - mu*sign(x_dot)}
events: {turns: """
    for _ in range(12):
        drawn = {"x_dot": source.uniform(-0.6, 0.6), "A": source.uniform(0.5, 1.2)}
        drawn |= {"w": source.uniform(1.0, 5.0), "mu": source.uniform(0.05, 0.4)}
        acted, noted = (
            solve(text + event, stop=3, samples=2, set=drawn)
            for event in ('{when: x_dot, action: {set: {n_dot: "n_dot + 1"}}}}', "x_dot}")
        )
        times = noted.events["turns/t"]
        assert list(acted.events["turns/t"]) == pytest.approx(times, abs=1e-12), drawn
        assert acted.v["n"][-1] == len(times)


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853"])
@pytest.mark.parametrize("also", ["{0}", "{{when: 2*({0}), direction: falling}}", KICK])
@pytest.mark.parametrize("floor", ["y", "y - 0.1*x", "y + 0.3*sin(t)"])
def test_events_with_the_same_zero_all_happen(floor, also, method):
    """Those after a bounce, too, which makes their argument turn: in whatever order they are written."""
    events = [
        f"  bounce: {{when: {floor}, direction: falling, action: {{set: {{y_dot: -0.9*y_dot}}}}}}\n",
        f"  other: {also.format(floor)}\n",
    ]
    for one, two in (events, reversed(events)):
        motion = solve(FALLING + one + two, stop=1.5, samples=2, method=method)
        times = motion.events["bounce/t"]
        assert len(times) > 1
        assert list(motion.events["other/t"]) == pytest.approx(times, abs=1e-12)


@pytest.mark.exhaustive(keep=0.25)
def test_an_action_that_leads_back_to_its_event_ends_the_motion():
    motion = follow(oscillator(1.0, 0.0, "x", "falling", "{set: {x: 8e-16}}"), 10.0, 11)
    assert motion.outcome.ending is Ending.RECURRING
    assert "'crossing'" in motion.outcome.message
    assert motion.outcome.t == pytest.approx(math.pi / 2)


def test_more_events_than_the_limit_end_the_motion(monkeypatch):
    monkeypatch.setenv("LAGRANGE_LIMITS", "events=50")
    motion = follow(oscillator(1.0, 0.0, "x"), 1000.0, 11)
    assert motion.outcome.ending is Ending.TOO_MANY_EVENTS
    assert motion.outcome.happened["crossing"].count == 51


def test_events_of_a_motion_followed_backward():
    forward = follow(oscillator(1.0, 0.0, "x", "rising"), 20.0, 11)
    there = float(forward["q/x"][-1]), float(forward["v/x"][-1])
    back = follow(oscillator(*there, "x", "rising"), 0.0, 11, start=20.0)
    assert back["events/crossing/t"][::-1] == pytest.approx(forward["events/crossing/t"], rel=1e-14)
    assert back["events/crossing/v/x"] == pytest.approx(np.full(3, 1.0))


@pytest.mark.parametrize("at_once", [False, True])
def test_equal_balls_on_a_line_exchange_their_velocities(at_once, source):
    """So their places are those of balls that pass through one another; also where several meet at once."""
    n = 5
    places = sorted(source.uniform(0.05, 0.95) for _ in range(n))
    speeds = [source.uniform(-1, 1) for _ in range(n)]
    if at_once:
        places, speeds = [0.1, 0.3, 0.5, 0.7, 0.9], [1, 0, 0, 0, -1]
    text = f"""
    name: balls in a box
    sizes: {{N: {n}}}
    parameters: {{X: {places}, V: {speeds}}}
    coordinates:
      x[i in range(N)]: {{initial: "X[i]", velocity: "V[i]"}}
    masses: {{b[i in range(N)]: 1}}
    embedding: {{b[i in range(N)]: ["x[i]"]}}
    potential: 0
    events:
      hit[i in range(N-1)]:
        when: x[i+1] - x[i]
        direction: falling
        action: {{set: {{"x_dot[i]": "x_dot[i+1]", "x_dot[i+1]": "x_dot[i]"}}}}
      left: {{when: "x[0]", direction: falling, action: {{set: {{"x_dot[0]": "-x_dot[0]"}}}}}}
      right: {{when: "1 - x[N-1]", direction: falling, action: {{set: {{"x_dot[N-1]": "-x_dot[N-1]"}}}}}}
    """
    motion = follow(text, 20.0, 101)
    free = (np.array(places) + np.array(speeds) * motion.t[:, None]) % 2
    assert np.abs(motion["q/x"] - np.sort(np.minimum(free, 2 - free), axis=1)).max() < 1e-12
    assert motion.outcome.h_drift < 1e-14


def test_restitution_may_depend_on_the_speed():
    """Its slope is infinite at rest, where no force of contact may be computed while there is none."""
    text = """
    name: a ball
    coordinates: {y: {initial: 1}}
    masses: {p: 1}
    embedding: {p: [y]}
    potential: 9.81*y
    events: {floor: {when: y, direction: falling, action: {set: {y_dot: -y_dot*exp(-1/y_dot**2)}}}}
    """
    motion = follow(text, 1.0, 11)
    speed = math.sqrt(2 * G)
    assert motion.outcome.ending is Ending.COMPLETE
    assert motion["events/floor/v/y"][0] == pytest.approx(-speed, rel=1e-14)
    flight = 2 * speed * math.exp(-1 / speed**2) / G
    assert np.diff(motion["events/floor/t"])[:1] == pytest.approx(
        [flight][: len(motion["events/floor/t"]) - 1]
    )


def test_a_kick_where_no_force_acts(source):
    """Every time that x rises through 0, where its force is 0, v becomes 1 + k v."""
    k, v = source.uniform(0.1, 0.6), source.uniform(0.5, 2)
    text = oscillator(0.0, v, "x", "rising", f"{{set: {{x_dot: 1 + {k!r}*x_dot}}}}")
    motion = follow(text, 60.0, 11)
    turns = np.arange(1, 10)
    assert motion["events/crossing/t"] == pytest.approx(2 * np.pi * turns, rel=1e-13)
    fixed = 1 / (1 - k)
    assert motion["events/crossing/v/x"] == pytest.approx(fixed + (v - fixed) * k ** (turns - 1), rel=1e-12)


def test_a_ball_rests_however_long_the_run_is():
    """Where steps are long, small speeds are no rounding."""
    motion = follow(ball(1.0, 0.0, 0.5), 1e8, 3)
    assert np.abs(motion["q/y"][1:]).max() < 1e-14
    assert motion.outcome.happened["floor"].accumulations == 1


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("when", ["(1 + x**2)*x**{n}", "x**{n} + x**{m}", "x_dot**2*x**{n} + x**{m}/3"])
def test_multiple_zeros_are_found_as_exactly_as_simple_ones(when, source):
    """x = a sin(t + b) is 0 at t = k pi - b."""
    a, b, n = source.uniform(1, 2), source.uniform(0.5, 2.5), source.choice((3, 5, 9))
    motion = follow(oscillator(a * math.sin(b), a * math.cos(b), when.format(n=n, m=n + 2)), 30.0, 11)
    times = motion["events/crossing/t"]
    assert np.max(np.abs(times - (np.arange(1, len(times) + 1) * math.pi - b))) <= 1e-13
    assert len(times) == int((30 + b) / math.pi)


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize(
    "when",
    [
        "x**3 - 3*a*x**2 + 3*a**2*x - a**3",
        "x**3 - 3*{a}*x**2 + 3*{a}**2*x - {a}**3",
        "2*x**5 - 10*a*x**4 + 20*a**2*x**3 - 20*a**3*x**2 + 10*a**4*x - 2*a**5",
        "(x - {a})**2*(x**3 - 3*{a}*x**2 + 3*{a}**2*x - {a}**3)",
        "(3*x**2 - 6*{a}*x + 3*{a}**2)*(x**3 - 3*{a}*x**2 + 3*{a}**2*x - {a}**3)",
        "3*sin(x - {a}) - sin(3*x - 3*{a})",
    ],
)
def test_powers_that_are_multiplied_out_have_zeros_as_exact(when, source):
    """x = sin(t) is a where t = asin(a) and pi - asin(a). The last one is 4 sin(x - a)**3."""
    a = source.uniform(0.2, 0.8)
    text = oscillator(0.0, 1.0, when.format(a=repr(a)))
    motion = follow(text.replace("k: 1", f"k: 1, a: {a!r}"), 6.0, 11)
    expected = [math.asin(a), math.pi - math.asin(a)]
    assert motion["events/crossing/t"] == pytest.approx(expected, abs=1e-13)


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("when", ["sin(x - a) - (x - a)", "tan(x - a) - sin(x - a)", "(x - a)**3*(x - 2)"])
def test_a_multiple_zero_that_rounding_blurs_is_said_to_be_one(when, source):
    """How far off its time is, too, within a factor of 100; where it is a power, nothing is blurred."""
    a = source.uniform(0.2, 0.8)
    motion = follow(oscillator(0.0, 1.0, when).replace("k: 1", f"k: 1, a: {a!r}"), 1.0, 11)
    (t,), happened = motion["events/crossing/t"], motion.outcome.happened["crossing"]
    if "**3" in when:
        assert happened.blurred is None and abs(t - math.asin(a)) < 1e-14
    else:
        assert happened.grazes is None and happened.blurred == t
        assert 1e-8 < happened.error < 1e-4 and abs(t - math.asin(a)) < 10 * happened.error


def test_an_event_along_the_whole_motion_is_doubted():
    """The action leaves the motion on the ray where the angle is 1, on which it then stays."""
    text = """
    name: a ray
    coordinates: {x: {initial: 1, velocity: 0}, y: {initial: 0, velocity: 1}}
    lagrangian: (x_dot**2 + y_dot**2 - x**2 - y**2)/2
    events: {turn: {when: "atan2(y, x) - 1", direction: rising, action: {set: {x_dot: 0, y_dot: 0}}}}
    """
    motion = follow(text, 2.5, 11)
    happened, times = motion.outcome.happened["turn"], motion["events/turn/t"]
    assert times[0] == pytest.approx(1, abs=1e-15)
    assert len(times) == 1 or happened.doubtful


def test_balls_at_rest_that_touch_pass_an_impact_on():
    text = """
    name: three balls on a line
    coordinates: {x: {initial: -1, velocity: 1}, y: {initial: 0}, z: {initial: 0}}
    lagrangian: (x_dot**2 + y_dot**2 + z_dot**2)/2
    events:
      first: {when: y - x, direction: falling, action: {set: {x_dot: y_dot, y_dot: x_dot}}}
      second: {when: z - y, direction: falling, action: {set: {y_dot: z_dot, z_dot: y_dot}}}
    """
    motion = follow(text, 3.0, 7)
    assert motion.outcome.ending is Ending.COMPLETE
    assert [motion[f"q/{name}"][-1] for name in "xyz"] == pytest.approx([0, 0, 2], abs=1e-15)


def test_events_at_given_times_happen_then():
    """To the last bit, but where that of the step's beginning is rounded."""
    source = random.Random()
    times = [0.5, 0.1, *(round(source.uniform(0.1, 4.0), 3) for _ in range(10))]
    print("times:", times)
    text = OSCILLATOR.format(x=1, v=0.3, when="t - 4.25", direction="rising", action="record")
    text += "".join(f"  e{k}: {{when: t - {one}}}\n" for k, one in enumerate(times))
    motion = follow(text, 4.5, 2)
    found = np.array([motion[f"events/e{k}/t"].item() for k in range(len(times))])
    errors = np.abs(found - times) / np.spacing(times)
    assert errors.max() <= 1.0 and np.count_nonzero(errors) < 6
