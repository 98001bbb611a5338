"""Pages do what solve does where friction holds a motion, where events happen at one time, at edges, and with
constraints that follow from others."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import lagrange_cli as lagrange
from lagrange_cli.run.request import Request
from lagrange_cli.run.view.motion import read_shown
from lagrange_cli.run.view.page import view
from tests.integrate.impacts.test_one_time import COMES_BACK, COUNTS, STANDSTILL, TURNS, WALLS
from tests.support.v8 import Engine

DRIVEN = """
parameters: {A: 0.8, mu: 0.25, b: 0.38}
coordinates: {x: {initial: 0.45, velocity: 0.22}, y: {initial: -0.35, velocity: -0.36}}
masses: {p: 1, q: 1.4}
positions: {p: x, q: y}
potential: "(x**2 + y**2)/2 + abs(x - b)*0.4"
generalized_forces: {x: "A*sin(4*t) - mu*sign(x_dot)", y: "-mu*sign(y_dot)"}
events:
  v: {when: x_dot, direction: rising, action: {set: {y_dot: y_dot + 0.3}}}
  w: {when: x_dot, action: {set: {x: x + 0.05}}}
"""
BRAKED = """
parameters: {mu: 2, k: 30}
coordinates: {x: {initial: 0}, y: {initial: 0}, z: {initial: 0}}
masses: {p: 1, q: 1.4, r: 1}
positions: {p: x, q: y, r: z}
potential: k*(x - y)**2/2 + k*(y - z)**2/2
definitions: {F: "where(0.5 < t < 1.3, 0, mu)"}
dissipation: F*(abs(x_dot) + abs(y_dot) + abs(z_dot))
generalized_forces: {x: 3*sin(t)}
"""
FALLS = """
coordinates: {y: {initial: 0, velocity: -1}}
masses: {ball: 1}
positions: {ball: [0, y]}
potential: 9.81*y
events: {floor: {when: y, direction: falling, action: {set: {y_dot: -0.9*y_dot}}}}
"""
WIRE = """
coordinates: {x: {initial: 0.5, velocity: 1}}
masses: {bead: 1}
positions: {bead: [x, "(2 - x)**1.5"]}
potential: 0
"""


def compared(text, stop, **values):
    """The end of a motion on a page, and by solve."""
    page = view(read_shown(text.encode(), "a.yaml", Request(times={"stop": str(stop)})))
    assert page.live
    motion = lagrange.solve(text, stop=stop, samples=3, set=values)
    events = sum(len(motion.events[k]) for k in motion.events if k.endswith("/t"))
    q, v = ([float(one[k][-1]) for k in one] for one in (motion.q, motion.v))
    return Engine(page.text).end(**values), events, q, v


@pytest.mark.exhaustive(keep=0.4)
@pytest.mark.parametrize(
    ("text", "stop", "values"),
    [
        (STANDSTILL, 5.0, {"mu": 0.41, "a": 0.7}),
        (DRIVEN, 2.0, {}),
        (BRAKED, 2.0, {}),
        (BRAKED, 2.0, {"mu": 0}),
        (WALLS + TURNS + COUNTS, 2.0, {"c": 0.73, "k": 1.21}),
        (WALLS + COMES_BACK + TURNS, 2.0, {"c": 0.73, "k": 1.21}),
        (FALLS, 0.7, {}),
    ],
)
def test_pages_do_what_solve_does_at_events(text, stop, values):
    page, events, q, v = compared(text, stop, **values)
    assert page["reason"] == "" and page["events"] == events
    assert page["q"] == pytest.approx(q, abs=1e-12)
    assert page["v"] == pytest.approx(v, abs=1e-12)


LINKAGE = """
parameters: {a: 1, b: 0.6, alpha: 1, beta: asin(b*sin(alpha)/a)}
coordinates: {t1: {initial: 1, velocity: 6}, t2: {}, t3: {}}
definitions:
  along: [cos(t1), sin(t1), 0]
  across: [-sin(t1)*cos(beta), cos(t1)*cos(beta), sin(beta)]
masses: {one: 1, two: 1}
positions: {one: b*along, two: b*along + a*(cos(t2)*along + sin(t2)*across)}
potential: 9.81*(one.y + two.y)
constraints: {joint: "two - (a + b*cos(t3), b*cos(alpha)*sin(t3), b*sin(alpha)*sin(t3))"}
"""


def test_on_pages_constraints_follow_from_others_in_turn():
    """Bennett's linkage, which is folded on the way."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lagrange.LagrangeWarning)
        page, _, q, v = compared(LINKAGE, 2.0)
    assert page["reason"] == "" and q[0] > 2 * np.pi
    assert page["q"] == pytest.approx(q, abs=1e-12)
    assert page["v"] == pytest.approx(v, abs=1e-11)


def test_a_page_ends_a_motion_at_the_edge_of_a_domain():
    page = Engine(view(read_shown(WIRE.encode(), "a.yaml", Request(times={"stop": "9"}))).text).end()
    assert "has no value beyond" in page["reason"]
    assert page["q"][0] < 2.0 and page["t"] > 1.0
