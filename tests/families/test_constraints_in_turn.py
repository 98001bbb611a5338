"""Families with constraints that follow from others in turn: carriages whose two wheels roll each, and rings
on two ball joints each. Every member moves as it does alone."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lagrange_cli as lagrange
from tests.support.draws import examples

CARRIAGES = """
sizes: {{N: {count}}}
parameters: {{m: 2, w: 0.3, r: 0.1}}
coordinates:
  x[i in range(N)]: {{initial: 0}}
  y[i in range(N)]: {{initial: 0}}
  th[i in range(N)]: {{initial: 0.3*(i + {first}), velocity: 0.7 + {faster}*(i + {first})}}
  p[i in range(N)]: {{initial: 0, velocity: 3}}
  s[i in range(N)]: {{initial: 0}}
definitions:
  ahead[i in range(N)]: (cos(th[i]), sin(th[i]))
masses:
  body[i in range(N)]: m
  turn[i in range(N)]: 0.2
  one[i in range(N)]: 0.2
  two[i in range(N)]: 0.2
{more}
positions:
  body[i in range(N)]: (x[i], y[i]) + {off}*ahead[i]
  turn[i in range(N)]: [0.5*th[i]]
  one[i in range(N)]: [p[i]]
  two[i in range(N)]: [s[i]]
{also}
nonholonomic:
  left[i in range(N)]: (x_dot[i], y_dot[i]) - (w*th_dot[i] + r*p_dot[i])*ahead[i]
  right[i in range(N)]: (x_dot[i], y_dot[i]) + (w*th_dot[i] - r*s_dot[i])*ahead[i]
generalized_forces:
  p[i in range(N)]: 0.1*sin(t)
  s[i in range(N)]: -0.05*s_dot[i]
  th[i in range(N)]: -0.01*th_dot[i]
"""
KICKS = """
events:
  kick[i in range(N)]: {when: sin(2*t - 0.1), action: {set: {"p_dot[i]": "p_dot[i] + 0.5"}}}
"""
SHAPES = {
    "M is diagonal": {"off": 0, "more": "", "also": ""},
    "M is constant": {
        "off": 0, "more": "  both[i in range(N)]: 0.3", "also": "  both[i in range(N)]: [x[i] + y[i]]",
    },
    "M changes": {"off": 0.05, "more": "", "also": ""},
}  # fmt: skip
NAMES = "x", "y", "th", "p", "s"
METHODS = {"taylor": 1e-12, "ias15": 1e-12, "DOP853": 1e-6, "radau": 1e-7}


def solved(text: str, **options: object) -> lagrange.Motion:
    """The motion, without the warning of constraints that depend on others."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lagrange.LagrangeWarning)
        motion = lagrange.solve(text, samples=41, **options)
    assert motion.status == "complete"
    assert "singular_configurations" not in motion.attributes
    return motion


@pytest.mark.exhaustive(keep=1)
@pytest.mark.parametrize("events", ["", KICKS], ids=["free", "kicked"])
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("method", METHODS)
@examples(1)
@given(faster=st.floats(0.005, 0.02), count=st.integers(24, 30))
def test_each_carriage_moves_as_it_does_alone(
    shape: str, method: str, events: str, faster: float, count: int
) -> None:
    """There are all headings among them, so that no fixed component may be left out."""
    given = {**SHAPES[shape], "faster": faster}
    text = CARRIAGES.format(count=count, first=0, **given) + events
    fleet = solved(text, stop=8, method=method)
    assert np.ptp(fleet.q["th"]) > 2 * np.pi
    for member in (0, count // 2, count - 1):
        alone = solved(CARRIAGES.format(count=1, first=member, **given) + events, stop=8, method=method)
        for name in NAMES:
            assert fleet.q[name][:, member] == pytest.approx(alone.q[name][:, 0], abs=METHODS[method])
        assert fleet.attributes["steps"] <= 2 * alone.attributes["steps"] + 40


def test_in_double_double() -> None:
    """To all digits."""
    given = {**SHAPES["M is constant"], "faster": 0.01}
    options = {"stop": 4, "precision": "double-double", "outputs": ["q"]}
    fleet = solved(CARRIAGES.format(count=24, first=0, **given), **options)
    alone = solved(CARRIAGES.format(count=1, first=17, **given), **options)
    for name in NAMES:
        low = fleet.datasets[f"low/q/{name}"][:, 17] - alone.datasets[f"low/q/{name}"][:, 0]
        rest = fleet.q[name][:, 17] - alone.q[name][:, 0] + low
        assert rest == pytest.approx(0, abs=1e-26)


RINGS = """
sizes: {{N: {count}}}
coordinates:
  x[i in range(N)]: {{initial: 0}}
  y[i in range(N)]: {{initial: 0}}
  z[i in range(N)]: {{initial: 0}}
  w[i in range(N)]: {{initial: 1}}
  e1[i in range(N)]: {{initial: 0, velocity: 0.3 + 0.05*(i + {first})}}
  e2[i in range(N)]: {{initial: 0}}
  e3[i in range(N)]: {{initial: 0, velocity: 0.5}}
  c[i in range(N)]: {{initial: 0, velocity: 1}}
definitions: {{axis[i in range(N)]: (cos(c[i]), sin(c[i]), 0)}}
bodies:
  ring[i in range(N)]:
    mass: 1
    inertia: [0.5, 0.6, 1]
    position: [x[i], y[i], z[i]]
    orientation: {{quaternion: [w[i], e1[i], e2[i], e3[i]]}}
masses: {{car[i in range(N)]: 1}}
positions: {{car[i in range(N)]: "2*axis[i]"}}
potential: sum(3*ring[i].R32 for i in range(N))
constraints:
  one[i in range(N)]: ring[i].at(0.3, 0, 0) - 0.3*axis[i]
  two[i in range(N)]: ring[i].at(-0.3, 0, 0) + 0.3*axis[i]
"""


def test_rings_on_two_ball_joints() -> None:
    """Each on an axis that a car turns; energy is conserved, and each moves as it does alone."""
    outputs = ["q", "h", "constraints"]
    many = solved(RINGS.format(count=12, first=0), stop=4, outputs=["q", "h"])
    assert np.ptp(many.h) <= 1e-12
    alone = solved(RINGS.format(count=1, first=9), stop=4, outputs=outputs)
    for name in ("w", "e1", "e2", "e3", "c"):
        assert many.q[name][:, 9] == pytest.approx(alone.q[name][:, 0], abs=1e-12)
    assert many.attributes["steps"] <= alone.attributes["steps"] + 20


HUNG = """
sizes: {{N: {count}}}
coordinates:
  x[i in range(N)]: {{initial: 0.3*i}}
  y[i in range(N)]: {{initial: -1}}
  u[i in range(N)]: {{initial: 0.3*i + 1}}
  w[i in range(N)]: {{initial: -1}}
masses: {{a[i in range(N)]: 1, b[i in range(N)]: 1}}
positions: {{"a[i in range(N)]": "(x[i], y[i])", "b[i in range(N)]": "(u[i], w[i])"}}
potential: sum(9.8*(a[i].y + b[i].y) for i in range(N))
constraints:
  left[i in range(N)]: norm(a[i] - (0.3*i - 1, 0)) - sqrt(2)
  right[i in range(N)]: norm(a[i] - (0.3*i + 1, 0)) - sqrt(2)
  rod[i in range(N)]: norm(a[i] - b[i]) - 1
"""


@pytest.mark.parametrize("precision", ["double", "double-double"])
def test_what_rods_hold_takes_no_steps(precision: str) -> None:
    """Pendulums hang from masses that two rods hold each: what moves there are rounding errors."""
    many, one = (
        solved(HUNG.format(count=count), stop=4, outputs=["q", "h"], precision=precision) for count in (20, 1)
    )
    assert many.attributes["steps"] <= 1.2 * one.attributes["steps"] + 5
    for name in ("u", "w"):
        assert many.q[name][:, 0] == pytest.approx(one.q[name][:, 0], abs=1e-12)
    assert np.ptp(many.q["y"], axis=0).max() <= 1e-14


@pytest.mark.parametrize("count", [7, 12])
def test_what_constraints_hold_takes_no_steps(count: int) -> None:
    """The centres of rings are held at 0: what moves there are rounding errors."""
    others = "  held[i in range(N)]: (x[i], y[i], z[i])\n  level[i in range(N)]: ring[i].R31\n"
    held = RINGS.partition("  one[i in range(N)]: ring")[0] + others
    motion = solved(held.format(count=count, first=0), stop=4, outputs=["q", "h"])
    assert motion.attributes["steps"] <= 60
    assert np.ptp(motion.h) <= 1e-12
    assert max(np.abs(motion.q[name]).max() for name in "xyz") <= 1e-16
