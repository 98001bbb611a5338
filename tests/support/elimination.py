"""Systems with constraints that are linear in the coordinates, and how to follow them without elimination."""

from __future__ import annotations

from contextlib import nullcontext
from unittest.mock import patch

from lagrange_cli.api.motion import Motion
from lagrange_cli.api.solve import solve

GEARS = """
parameters: {I1: 2.0, I2: 0.7, R1: 0.3, R2: 0.8, k: 5}
coordinates: {a: {initial: 1.3}, b: {}}
lagrangian: I1*a_dot**2/2 + I2*b_dot**2/2 + k*cos(a)
constraints: {mesh: R1*a + R2*b}
"""
PULLEYS = """
parameters: {m1: 2.0, m2: 0.7, m3: 0.4, L: 3, g: 9.81, k: 40}
coordinates: {a: {initial: 1}, b: {initial: 0.2}, c: {}, y: {}}
masses: {p: m1, q: m2, r: m3}
positions: {p: [0, -a], q: [1, -b], r: [2, -c]}
potential: m1*g*p.y + m2*g*q.y + m3*g*r.y + k*(a - 1)**2/2 + k*(b - c)**4/90
constraints: {rope: a + y - L, other: b + c - 2*y - L}
"""
SHAKEN = """
parameters: {m: 2.0, M: 0.7, w: 3, A: 0.3, l: 1.1, g: 9.81}
coordinates: {x: {}, th: {initial: 1}}
masses: {p: m, s: M}
positions: {s: [x, 0], p: [x + l*sin(th), -l*cos(th)]}
potential: m*g*p.y
constraints: {drive: x - A*cos(w*t)}
"""
BELTS = """
parameters: {k: 5, u: 0.3}
coordinates: {a: {initial: 1.3}, b: {}, c: {}, d: {}}
lagrangian: (a_dot**2 + b_dot**2 + c_dot**2 + d_dot**2)/2 + k*cos(a - b) - a**2*c + a*d - 2**sin(a)
constraints: {belt: b - u*t, ramp: c - u*t**2, post: d - 2}
"""
CART = """
parameters: {m: 1.0, M: 2.0, R: 0.5, l: 0.7, g: 9.81}
coordinates: {x: {initial: 0, velocity: 1}, phi: {initial: 0.1}, th: {initial: 0.4}}
lagrangian: >-
  (m + M)*x_dot**2/2 + M*R**2*phi_dot**2/4 + m*l*cos(th)*x_dot*th_dot + m*l**2*th_dot**2/2 + m*g*l*cos(th)
nonholonomic: {roll: x_dot - R*phi_dot + 0.1}
"""
PUSHED = """
parameters: {m: 1.0, M: 2.0, l: 0.7, g: 9.81}
coordinates: {x: {initial: 0}, th: {initial: 0.4}}
masses: {cart: M, bob: m}
embedding: {cart: [x, 0], bob: [x + l*sin(th), -l*cos(th)]}
potential: m*g*bob.y
constraints: {drive: "x - max(0, t - 0.7)**2 - max(0, -1.2 - t)**2"}
"""
DISC = """
parameters: {m: 2.0, R: 0.4, g: 9.81, al: 0.3, k: 30}
coordinates: {x: {initial: 0.2, velocity: 0.1}, phi: {initial: 1}}
bodies:
  disc:
    mass: m
    inertia: [m*R**2/4, m*R**2/4, m*R**2/2]
    position: [x*cos(al), -x*sin(al), 0]
    orientation: {euler: [0, 0, -phi], sequence: zxz}
potential: m*g*disc.y + k*x**4
nonholonomic: {roll: x_dot - R*phi_dot}
"""
MIXED = """
parameters: {m: 2.0, M: 0.7, l: 1.1, g: 9.81, k: 3}
coordinates: {x: {initial: 0.1}, x2: {}, px: {initial: 0.732455532033676}, py: {initial: -0.9}}
masses: {p: m, s: M, s2: M}
positions: {s: [x, 0], s2: [x2, 1], p: [px, py]}
potential: m*g*p.y + k*x**2/2
constraints: {pair: x + 2*x2 - 1, rod: (px - x)**2 + py**2 - l**2}
"""
EQUAL = """
coordinates: {a: {initial: 1.3}, b: {}, c: {}}
lagrangian: (a_dot**2 + b_dot**2 + 3*c_dot**2)/2 + 5*cos(a) + sin(b) - c**4 + a*b
constraints: {ab: a - b, ac: a - c}
"""
DRAGGED = """
parameters: {I1: 2.0, I2: 0.7, R1: 0.3, R2: 0.8, k: 5, mu: 0.3}
coordinates: {a: {initial: 1.3}, b: {}}
lagrangian: I1*a_dot**2/2 + I2*b_dot**2/2 + k*cos(a)
constraints: {mesh: R1*a + R2*b}
dissipation: mu*b_dot**2/2
generalized_forces: {b: mu*sin(t)*b_dot**2 - mu*sign(b_dot), a: 0.1*b}
"""
STRUCK = """
parameters: {I1: 2.0, I2: 0.7, R1: 0.3, R2: 0.8, k: 5}
coordinates: {a: {initial: 1.3}, b: {}}
lagrangian: I1*a_dot**2/2 + I2*b_dot**2/2 + k*cos(a)
constraints: {mesh: R1*a + R2*b}
events:
  hit: {when: b + 0.2, direction: falling, action: {set: {b_dot: -b_dot}}}
  seen: {when: a_dot*b + 0.01}
"""
LANDING = """
parameters: {m1: 2.0, m2: 1.2, L: 3, g: 9.81, w: 7}
coordinates: {a: {initial: 1}, b: {}}
masses: {p: m1, q: m2}
positions: {p: [0, -a], q: [1, -b]}
potential: m1*g*p.y + m2*g*q.y
constraints: {rope: a + b - L}
forces: {p: [0, 12*sin(w*t/9)]}
events: {floor: {when: p.y + 2, direction: falling, action: {set: {a_dot: -a_dot/2}}}}
"""
STEEP = """
coordinates: {x: {initial: -2, velocity: 1}, y: {}}
lagrangian: (x_dot**2 + 2*y_dot**2)/2 - 0.3*exp(-(20*(y - 1))**2) - x**2/9
constraints: {line: x + 2*y}
"""
TRAIN = """
sizes: {N: 4}
parameters: {k: 3}
coordinates:
  a: {initial: 0.4}
  th[i in range(N)]: {}
lagrangian: a_dot**2/5 + sum((1 + i)*th_dot[i]**2/2 for i in range(N)) + k*cos(th[0]) + cos(th[2])/10
constraints:
  first: a - th[0]
  mesh[i in range(N - 1)]: (1 + i/10)*th[i] + (1 + (i + 1)/10)*th[i + 1]
"""
SYSTEMS = {
    "gears": GEARS, "pulleys": PULLEYS, "shaken": SHAKEN, "belts": BELTS, "cart": CART, "disc": DISC,
    "mixed": MIXED, "equal": EQUAL, "dragged": DRAGGED, "struck": STRUCK, "landing": LANDING, "steep": STEEP,
    "train": TRAIN, "pushed": PUSHED,
}  # fmt: skip
"""Systems some of whose constraints are solved for coordinates, by name."""


def motion_of(text: str, *, eliminated: bool = True, **asked: object) -> Motion:
    """The motion of a system, compiled anew; with a multiplier for every constraint if not ``eliminated``."""
    whole = patch("lagrange_cli.native.elimination.reduced", lambda residual: None)
    with nullcontext() if eliminated else whole:
        return solve(f"{text}\n# {eliminated}\n", cache=False, **asked)  # type: ignore[arg-type]
