"""Impacts after which the motion may rest, in compiled code and in Python: both give the same bits."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.impacts.happenings import Happenings
from lagrange_cli.native import events
from tests.motions.test_piles import IMPULSE, PILE, dropped
from tests.support.motion import Motion, follow, prepared

BALL = """
parameters: {{g: {g!r}, e: {e!r}, w: 3.7, A: 0.06}}
coordinates: {{y: {{initial: {height!r}}}}}
masses: {{ball: 2}}
embedding: {{ball: [y]}}
potential: 2*g*y
events: {{floor: {{when: {floor}, direction: falling, action: {{set: {{y_dot: {after}}}}}}}{more}}}
"""
REST, SHAKEN = ("y", "-e*y_dot"), ("y - A*sin(w*t)", "-e*y_dot + (1 + e)*A*w*cos(w*t)")
KICK = ", kick: {when: sin(w*t), direction: rising, action: {set: {y_dot: y_dot + 1}}}"
PENDULUM = """
parameters: {{g: {g!r}, e: {e!r}}}
coordinates: {{a: {{initial: -0.5 - {height!r}}}, b: {{initial: 0.1}}}}
masses: {{upper: 1, lower: 0.4}}
embedding: {{upper: "[sin(a), -cos(a)]", lower: "[sin(a) + sin(b), -cos(a) - cos(b)]"}}
potential: -1.4*g*cos(a) - 0.4*g*cos(b)
events:
  stopper:
    when: a - 0.3
    direction: rising
    action: {{set: {{a_dot: -e*a_dot, b_dot: b_dot + (1 + e)*a_dot*cos(a - b)}}}}
"""
SLIDING = """
parameters: {{g: {g!r}, e: {e!r}, f: 0.2, w: 3.1}}
coordinates: {{x: {{initial: 0, velocity: 1}}, y: {{initial: {height!r}}}}}
masses: {{ball: 1}}
embedding: {{ball: [x, y]}}
potential: g*y + 2*x**2 + abs(x - 0.1)
generalized_forces: {{x: f*(sin(w*t) - sign(x_dot))}}
events:
  floor: {{when: y, direction: falling, action: {{set: {{y_dot: -e*y_dot}}}}}}
  far: {{when: x - 0.15}}
  turns: {{when: x_dot}}
"""
ROW = """
parameters: {{e: {e!r}, k: 0.7, g: {g!r}}}
coordinates: {{a: {{initial: 0, velocity: 1}}, b: {{initial: 1}}, c: {{initial: 1.9, velocity: -{height!r}}}}}
masses: {{p: 1, q: 3, r: 1}}
embedding: {{p: [a], q: [b], r: [c]}}
potential: k*(a**2 + b**2 + c**2)/2
events:
  left:
    when: b - a - 0.3
    direction: falling
    action: {{set: {{a_dot: (a_dot + 3*b_dot + 3*e*(b_dot - a_dot))/4,
      b_dot: (a_dot + 3*b_dot - e*(b_dot - a_dot))/4}}}}
  right:
    when: c - b - 0.3
    direction: falling
    action: {{set: {{b_dot: (3*b_dot + c_dot + e*(c_dot - b_dot))/4,
      c_dot: (3*b_dot + c_dot - 3*e*(c_dot - b_dot))/4}}}}
"""


def drawn(kind: str, source: random.Random) -> str:
    """A system of this kind."""
    numbers = {"g": source.uniform(2, 10), "e": source.uniform(0.75, 0.95), "height": source.uniform(0.4, 1)}
    texts = {"pendulum": PENDULUM, "row": ROW, "sliding": SLIDING}
    if kind in texts:
        return texts[kind].format(**numbers)
    floor, after = SHAKEN if kind == "shaken" else REST
    return BALL.format(**numbers, floor=floor, after=after, more=KICK if kind == "kicked" else "")


@pytest.fixture
def in_python(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """No action is done in compiled code, as where events are many."""
    monkeypatch.setattr(events, "FEW_EVENTS", 0)
    prepared.cache_clear()
    yield monkeypatch
    prepared.cache_clear()


def moved(system: str, method: str) -> Motion:
    """So far that it hits something, and does not rest."""
    tolerance = 2.0**-52 if method in ("taylor", "ias15") else 1e-10
    return follow(system, 3.0 if "stopper" in system else 1.5, 40, method=method, tolerance=tolerance)


@pytest.mark.exhaustive(keep=2)
@pytest.mark.parametrize("method", ["taylor", "ias15", "DOP853", "Radau"])
@pytest.mark.parametrize("kind", ["ball", "shaken", "kicked", "pendulum", "row", "sliding"])
def test_both_give_the_same_bits(
    kind: str, method: str, in_python: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    system = drawn(kind, random.Random(request.config.option.seed))
    slow = moved(system, method)
    in_python.undo()
    prepared.cache_clear()
    fast = moved(system, method)
    assert slow.outcome.ending == fast.outcome.ending
    found, known = ({name: one.count for name, one in each.outcome.happened.items()} for each in (fast, slow))
    assert found == known and sum(found.values()) > 0
    for name, samples in slow.data.items():
        assert np.array_equal(samples, fast.data[name], equal_nan=True), name


def test_python_is_asked_beside_switches_where_an_action_changes_their_sides(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked, done = [], Happenings._done
    monkeypatch.setattr(Happenings, "_done", lambda *given: asked.append(given[1]) or done(*given))
    system = drawn("sliding", random.Random(1))
    motion = follow(system, 4.0, 10)
    assert motion.outcome.happened["floor"].count > 1 and 0 not in asked
    spun = follow(system.replace("y_dot: -e*y_dot", "y_dot: -e*y_dot, x_dot: 0.9*x_dot"), 4.0, 10)
    assert asked.count(0) == spun.outcome.happened["floor"].count > 1


def test_python_is_asked_where_the_motion_may_rest_and_nowhere_else(monkeypatch: pytest.MonkeyPatch) -> None:
    """The ball of the closed form: impacts follow one another after times in the ratio e, until it rests."""
    asked = []
    done = Happenings._done
    monkeypatch.setattr(Happenings, "_done", lambda *given: asked.append(given) or done(*given))
    g, height = 9.81, 1.0
    fall = math.sqrt(2 * height / g)
    for e, most in ((0.9, 12), (0.5, 4)):  # of flights that take from 2^-29 to 2^-30 of a step, all together
        system = BALL.format(g=g, e=e, height=height, floor="y", after="-e*y_dot", more="")
        count = math.floor(math.log(1e-4) / math.log(e))  # impacts until a flight takes 1e-4 of the first one
        end = fall * (1 + 2 * e / (1 - e))
        for stop, least in ((end - 2 * fall * e ** (count + 1) / (1 - e), 0), (2 * end, 1)):
            asked.clear()
            motion = follow(system, stop, 10)
            assert motion.outcome.happened["floor"].count >= count and least <= len(asked) <= least * most
        assert motion.data["q/y"][-1] == 0.0 and motion.data["v/y"][-1] == 0.0


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("case", range(8))
def test_impacts_beside_contacts_are_those_of_python(
    case: int, in_python: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    source = random.Random(f"{request.config.option.seed} {case}")
    width = source.choice((1.7, 2.5))
    text = dropped(source, source.randint(2, 3), source.uniform(0.3, 0.5), width, speed=0.0)
    slow = follow(text, 0.8, 17)
    in_python.undo()
    prepared.cache_clear()
    fast = follow(text, 0.8, 17)
    assert slow.outcome.ending is fast.outcome.ending is Ending.COMPLETE, text
    for name in ("q/x", "q/y", "v/x", "v/y"):
        assert fast[name] == pytest.approx(slow[name], rel=1e-7, abs=1e-9), text


def test_balls_come_to_rest_beside_one_another_without_python(
    monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    """They fall onto the floor without touching, though they might: the impacts of each end where geometric
    series do, and then it lies there."""
    source = random.Random(request.config.option.seed)
    e, heights = source.uniform(0.3, 0.8), [source.uniform(0.1, 1.0) for _ in range(2)]
    given = {"count": 2, "e": e, "width": 5.0, "impulse": IMPULSE, "us": [0.0] * 2}
    text = PILE.format(xs=[1.0, 3.5], ys=[0.5 + one for one in heights], **given)
    asked, happen = [], Happenings.happen
    monkeypatch.setattr(Happenings, "happen", lambda *given: asked.append(given[1]) or happen(*given))
    ends = [math.sqrt(2.0 * one / 9.81) * (1.0 + e) / (1.0 - e) for one in heights]
    motion = follow(text, 1.2 * max(ends), 17)
    for i, end in enumerate(ends):
        one = motion.outcome.happened[f"floor[{i}]"]
        assert one.accumulations == 1 and one.accumulates == pytest.approx(end, rel=1e-12), text
        assert motion["q/y"][-1, i] == 0.5 and motion["v/y"][-1, i] == 0.0, text
    assert not asked, text


def test_python_is_hardly_asked_where_impacts_accumulate(monkeypatch: pytest.MonkeyPatch) -> None:
    """Between any two hits of one ball on another, dozens of impacts accumulate on the floor, where it then
    rests. And nothing happens at the wall where the lower one stands meanwhile."""
    given = {"count": 2, "e": 0.5, "width": 2.376, "impulse": IMPULSE, "us": [0.0] * 2}
    text = PILE.format(xs=[0.597, 0.736], ys=[0.6, 1.75], **given)
    asked, happen = [], Happenings.happen
    monkeypatch.setattr(Happenings, "happen", lambda *given: asked.append(given[1]) or happen(*given))
    happened = follow(text, 2.0, 17).outcome.happened
    assert happened["left[0]"].count < 40
    total = sum(one.count for one in happened.values())
    assert total > 500 and 15 * len(asked) < total
