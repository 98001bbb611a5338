"""Multipliers where impacts lose speed: they are written unless the force of a contact may change them."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.errors import NotDefined
from lagrange_cli.integrate.ending import Ending
from tests.support.motion import follow

WALL = """
name: a pendulum at a wall
parameters: {l: 1.0, g: 9.81}
coordinates: {x: {initial: 0.6}, y: {initial: -0.8}}
masses: {p: 1}
positions: {p: [x, y]}
potential: g*p.y
constraints: {rod: x**2 + y**2 - l**2}
events: {wall: {when: x, direction: falling, action: {set: {x_dot: -x_dot/2}}}}
"""
BEAD = """
name: a bead on a vertical wire, in a wind
coordinates: {x: {initial: 0}, y: {initial: 1}}
masses: {p: 3}
positions: {p: [x, y]}
potential: 10*p.y - 2*p.x
constraints: {wire: x}
events: {floor: {when: y, direction: falling, action: {set: {y_dot: -y_dot/2}}}}
"""


@pytest.mark.exhaustive(keep=0.65)
def test_multipliers_of_a_pendulum_whose_impacts_lose_speed():
    """At the lowest point the wall has the direction of the motion, and its force does not pull at the rod:
    2 lambda l = -(m v^2 + m g cos(theta))/l."""
    motion = follow(WALL, 3.0, 61, outputs=("q", "v", "multipliers"))
    x, y, u, w = (motion[name] for name in ("q/x", "q/y", "v/x", "v/y"))
    assert len(motion["events/wall/t"]) > 1
    assert motion["multipliers/rod"] == pytest.approx((9.81 * y - u**2 - w**2) / 2, rel=1e-12)
    assert np.abs(x**2 + y**2 - 1).max() < 1e-14


def test_multipliers_while_a_bead_rests_on_the_floor():
    motion = follow(BEAD, 3.0, 31, outputs=("q", "v", "multipliers"))
    assert motion["v/y"][-1] == 0.0
    assert motion["multipliers/wire"] == pytest.approx(-2.0, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "output"), [(WALL.replace("when: x", "when: x - l/4"), "multipliers"), (BEAD, "reactions")]
)
def test_forces_that_depend_on_a_contact_are_refused_with_its_event(text, output):
    """The wall pulls at the rod where this is not vertical; the floor carries the bead."""
    event = "wall" if output == "multipliers" else "floor"
    said = f"no output '{output}': the motion may come to rest at event '{event}', as its action may reduce"
    with pytest.raises(NotDefined, match=said):
        follow(text, 1.0, 3, outputs=("q", output))


ROPE = """
sizes: {N: 10}
coordinates:
  x[i in range(N)]: {initial: d*i}
  y[i in range(N)]: {initial: 0.5 + A*sin(i)}
parameters: {A: 0.02, d: 0.1}
masses: {bead[i in range(N)]: 0.1}
positions: {bead[i in range(N)]: [x[i], y[i]]}
potential: sum(0.981*y[i] for i in range(N))
constraints:
  rod[i in range(N - 1)]: norm(bead[i + 1] - bead[i]) - sqrt(d**2 + (A*sin(i + 1) - A*sin(i))**2)
events:
  hit[i in range(N)]: {when: "y[i]", direction: falling, action: {set: {"y_dot[i]": "-0.5*y_dot[i]"}}}
"""


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("amplitude", [0.022, 0.0301])
def test_a_rope_that_is_nearly_straight_falls_on_the_floor(amplitude):
    """Rods that are nearly along a line turn the rounding of an impulse into that of others: a state is at
    the constraints if it no longer comes nearer."""
    motion = follow(ROPE.replace("A: 0.02", f"A: {amplitude}"), 0.33, 14)
    assert motion.outcome.ending is Ending.COMPLETE
    assert sum(one.count for one in motion.outcome.happened.values()) > 1
    x, y = (motion[f"q/{name}"].T for name in "xy")
    lengths = np.hypot(np.diff(x, axis=0), np.diff(y, axis=0))
    assert np.abs(lengths - lengths[:, :1]).max() < 1e-15
    u, v = (motion[f"v/{name}"].T for name in "xy")
    energy = (u**2 + v**2).sum(axis=0) / 20 + 0.981 * y.sum(axis=0)
    assert energy[-1] < energy[0] and np.all(np.diff(energy) < 1e-13)
