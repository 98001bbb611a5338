"""What events leave alone although they change what it is made of: found, and kept by motions."""

from __future__ import annotations

import numpy as np
import pytest

from lagrange_cli.mechanics.conservation import conservation
from lagrange_cli.mechanics.conserved.symmetries import symmetries
from lagrange_cli.mechanics.contacts import without_contacts
from tests.support.motion import follow, residual_of

BILLIARD = """
parameters: {{m: 1.3, a: 2, b: 1.2, c: 1.6, k: 0.8}}
coordinates: {{x: {{initial: 0.3, velocity: 1}}, y: {{initial: 0.2, velocity: 0.7}}}}
definitions:
  f: 2*(x_dot*x/a**2 + y_dot*y/b**2)/(x**2/a**4 + y**2/b**4)
masses: {{p: m}}
positions: {{p: [x, y]}}
potential: {}
events:
  wall:
    when: x**2/a**2 + y**2/b**2 - 1
    direction: rising
    action: {{set: {{x_dot: x_dot - f*x/a**2, y_dot: y_dot - f*y/b**2}}}}
"""
SUPERBALL = """
parameters: {m: 1, R: 0.1, k: 0.4, g: 9.81, e: 0.9, f: 1.5}
coordinates: {x: {initial: 0, velocity: 1}, y: {initial: 1}, th: {initial: 0, velocity: 3}}
definitions: {slip: x_dot + R*th_dot}
lagrangian: m*(x_dot**2 + y_dot**2)/2 + k*m*R**2*th_dot**2/2 - m*g*y
events:
  floor:
    when: y - R
    direction: falling
    action: {set: {y_dot: -e*y_dot, x_dot: x_dot - f*k/(1 + k)*slip, th_dot: th_dot - f/(1 + k)*slip/R}}
"""
DISCS = """
parameters: {m: 1, M: 2, I: 0.3, J: 0.5, R: 0.1, e: 0.9, mu: 0.2}
coordinates:
  x: {initial: 0, velocity: 1}
  y: {initial: 0.1}
  a: {initial: 0, velocity: 2}
  u: {initial: 1}
  v: {initial: 0}
  b: {initial: 0}
definitions:
  nx: (u - x)/(2*R)
  ny: (v - y)/(2*R)
  push: (1 + e)*((u_dot - x_dot)*nx + (v_dot - y_dot)*ny)/(1/m + 1/M)
  slip: (v_dot - y_dot)*nx - (u_dot - x_dot)*ny - R*(a_dot + b_dot)
  rub: sign(slip)*min(mu*abs(push), 0.1*abs(slip))
lagrangian: m*(x_dot**2 + y_dot**2)/2 + M*(u_dot**2 + v_dot**2)/2 + I*a_dot**2/2 + J*b_dot**2/2
events:
  hit:
    when: sqrt((u - x)**2 + (v - y)**2) - 2*R
    direction: falling
    action:
      set:
        x_dot: x_dot + (push*nx - rub*ny)/m
        y_dot: y_dot + (push*ny + rub*nx)/m
        u_dot: u_dot - (push*nx - rub*ny)/M
        v_dot: v_dot - (push*ny + rub*nx)/M
        a_dot: a_dot + R*rub/I
        b_dot: b_dot + R*rub/J
"""
ROD = """
parameters: {M: 1, m: 0.5, l: 1, e: 0.8, J: M*l**2/3}
coordinates:
  X: {initial: 0}
  Y: {initial: 0}
  phi: {initial: 0}
  x: {initial: 0.6}
  y: {initial: -1, velocity: 2}
lagrangian: M*(X_dot**2 + Y_dot**2)/2 + J*phi_dot**2/2 + m*(x_dot**2 + y_dot**2)/2
definitions:
  nx: -sin(phi)
  ny: cos(phi)
  s: (x - X)*cos(phi) + (y - Y)*sin(phi)
  approach: (x_dot - X_dot)*nx + (y_dot - Y_dot)*ny - phi_dot*s
  push: (1 + e)*approach/(1/m + 1/M + s**2/J)
events:
  hit:
    when: (x - X)*nx + (y - Y)*ny
    direction: rising
    action:
      set:
        x_dot: x_dot - push*nx/m
        y_dot: y_dot - push*ny/m
        X_dot: X_dot + push*nx/M
        Y_dot: Y_dot + push*ny/M
        phi_dot: phi_dot + push*s/J
"""
ELLIPSOID = """
parameters: {m: 1.3, a: 3, b: 2, c: 1.1}
coordinates:
  x: {initial: 0.3, velocity: 1}
  y: {initial: 0.2, velocity: 0.7}
  z: {initial: 0.1, velocity: 0.2}
definitions:
  f: 2*(x_dot*x/a**2 + y_dot*y/b**2 + z_dot*z/c**2)/(x**2/a**4 + y**2/b**4 + z**2/c**4)
masses: {p: m}
positions: {p: [x, y, z]}
potential: 0
events:
  wall:
    when: x**2/a**2 + y**2/b**2 + z**2/c**2 - 1
    direction: rising
    action: {set: {x_dot: x_dot - f*x/a**2, y_dot: y_dot - f*y/b**2, z_dot: z_dot - f*z/c**2}}
"""
CENTRES = (
    BILLIARD.replace("b: 1.2, ", "").replace("b**2", "(a**2 - c**2)").replace("b**4", "(a**2 - c**2)**2")
)
PARABOLA = """
parameters: {m: 1, g: 2, l: 0.7}
coordinates: {x: {initial: 0.3, velocity: 1}, y: {initial: 2.2, velocity: 0.7}}
definitions: {f: 2*(y_dot - x_dot*x/l)/(1 + x**2/l**2)}
masses: {p: m}
positions: {p: [x, y]}
potential: m*g*y
events:
  wall:
    when: y - x**2/(2*l)
    direction: falling
    action: {set: {x_dot: x_dot + f*x/l, y_dot: y_dot - f}}
"""
SHARED = [
    "p_x + p_u",
    "p_y + p_v",
    "t*p_x + t*p_u - m*x - M*u",
    "t*p_y + t*p_v - m*y - M*v",
    "-p_a + p_b",
    "-t*p_a + t*p_b + I*a - J*b",
    "-y*p_x + x*p_y + 2*p_a - v*p_u + u*p_v",
]
CASES = {
    "an elliptic billiard": (BILLIARD.format("0"), ["(a + b)*(a - b)*p_y**2 - L_z**2"]),
    "with a spring": (BILLIARD.format("k*(x**2 + y**2)/2"), ["L_z**2 + 2*m*(a + b)*(a - b)*h_x"]),
    "with two centres": (CENTRES.format("-k/sqrt((x - c)**2 + y**2) - m*k/sqrt((x + c)**2 + y**2)"), None),
    "with weight": (BILLIARD.format("m*k*y"), []),
    "an ellipsoid": (ELLIPSOID, None),
    "a parabola with weight": (PARABOLA, ["l*p_x**2 - 2*m*A_y"]),
    "a ball with spin": (SUPERBALL, ["-R*p_x + p_th", "-R*t*p_x + t*p_th - m*R**2*k*th + m*R*x"]),
    "two discs with friction": (DISCS, SHARED),
    "two rough discs": (DISCS.replace("sign(slip)*min(mu*abs(push), 0.1*abs(slip))", "mu*slip"), SHARED),
    "a rod and a ball": (
        ROD,
        [
            "p_X + p_x",
            "p_Y + p_y",
            "t*p_X + t*p_x - M*X - m*x",
            "t*p_Y + t*p_y - M*Y - m*y",
            "-Y*p_X + X*p_Y + p_phi - y*p_x + x*p_y",
        ],
    ),
}
COUNTS = {"with two centres": 1, "an ellipsoid": 2}


@pytest.mark.exhaustive(keep=0.2)
@pytest.mark.parametrize("case", CASES)
def test_what_lasts_is_found_and_kept(case):
    text, expected = CASES[case]
    model = without_contacts(residual_of(text))  # as ``check`` has it
    found = [one.conserved for one in symmetries(model, conservation(model)[1])]
    lasting = [one for one in found if not one.breaks]
    if expected is None:
        assert len(lasting) == COUNTS[case]
    else:
        assert {one.expression for one in lasting} == {*expected}
    motion = follow(text, 12.0, 121, outputs=("conserved", "v"))
    event = "hit" if "hit:" in text else "floor" if "floor:" in text else "wall"
    assert len(motion[f"events/{event}/t"]) > 0
    for one in lasting:
        series = motion[f"diagnostics/conserved/{one.quantity}"]
        assert np.ptp(series) < 1e-11 * max(1, np.abs(series).max()), one.quantity
    for one in found:
        if one.breaks and f"diagnostics/conserved/{one.quantity}" in motion.data:
            assert np.ptp(motion[f"diagnostics/conserved/{one.quantity}"]) > 1e-3, one.quantity


def test_an_event_is_looked_at_only_where_it_happens():
    """A particle that leaves at one side comes in again at the other, where U is the same."""
    text = """
    parameters: {L: 2, k: 1}
    coordinates: {x: {initial: 0.3, velocity: 1}}
    masses: {p: 1}
    positions: {p: x}
    potential: k*x*(L - x)
    events: {leaves: {when: x - L, direction: rising, action: {set: {x: 0}}}}
    """
    assert [one.breaks for one in residual_of(text).conserved] == [()]
    assert [one.breaks for one in residual_of(text.replace("x: 0}", "x: 0.1}")).conserved] == [("leaves",)]
