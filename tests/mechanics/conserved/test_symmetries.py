"""What is conserved although no coordinate is cyclic: found, proven, and kept by motions."""

from __future__ import annotations

import random

import numpy as np
import pytest

from lagrange_cli.expression.exact import ExactGraphAlgebra
from lagrange_cli.expression.node import factors_of, reachable
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conservation import conservation
from lagrange_cli.mechanics.conserved.symmetries import symmetries
from lagrange_cli.model.build import build_model
from lagrange_cli.run.derive import derive_system
from tests.support.families import begun
from tests.support.motion import consistent, follow, prepared, residual_of, run, spec_of

PLANE = """
parameters: {{a: 1.3, m: 2, k: 3, w: 0.7}}
coordinates: {{x: {{initial: 1.2, velocity: 0.1}}, y: {{initial: 0.3, velocity: 0.8}}}}
masses: {{p: m}}
positions: {{p: [x, y]}}
potential: {}
"""
DRIVEN = """
parameters: {{m: 2, k: 3, w: 0.7, b: 0.4}}
coordinates: {{x: {{initial: 1.2, velocity: 0.1}}}}
lagrangian: m*x_dot**2/2 - ({})
dissipation: ({})*x_dot**2/2
"""
SPACE = """
parameters: {{pitch: 1.3, q: 2, B: 1.7, m: 2}}
coordinates: {{x: {{initial: 1}}, y: {{velocity: 0.5}}, z: {{initial: 0.2}}}}
masses: {{p: m}}
positions: {{p: [x, y, z]}}
potential: {}
"""
LINE = """
parameters: {{m: 1.3, M: 2, k: 3}}
coordinates: {{x: {{initial: 1.5}}, y: {{velocity: 0.2}}}}
masses: {{p: m, q: M}}
positions: {{p: [x], q: [y]}}
potential: {}
"""
BODIES = """
sizes: {N: 3}
parameters: {G: 1}
coordinates:
  x[i in range(N)]: {initial: i**2}
  y[i in range(N)]: {initial: i, velocity: 0.2*i}
  z[i in range(N)]: {initial: -i**3/3, velocity: 0.3 - 0.1*i}
masses: {p[i in range(N)]: 1 + i}
positions: {p[i in range(N)]: [x[i], y[i], z[i]]}
potential: sum(-G*(1 + i)*(1 + j)/norm(p[i] - p[j]) for i in range(N) for j in range(i))
"""
TEN = ("P_x", "P_y", "P_z", "K_x", "K_y", "K_z", "L_x", "L_y", "L_z")
CHAIN = """
coordinates: {x: {initial: 1}, y: {velocity: 1}, a: {velocity: 0.5}, b: {initial: 1}}
masses: {p: 1, q: 2, r: 3}
positions:
  p: [x, y]
  q: [x + cos(a), y + sin(a)]
  r: [x + cos(a) + cos(b), y + sin(a) + sin(b)]
"""
DUMBBELL = """
coordinates: {x: {initial: 1}, y: {velocity: 0.4}, u: {initial: 0}, v: {velocity: 1}}
masses: {p: 1, q: 2}
positions: {p: [x, y], q: [u, v]}
constraints: {rod: dot(p - q, p - q) - 1}
"""
SPHERICAL = """
coordinates: {x: {initial: 0.6}, y: {velocity: 1.0}, z: {initial: -0.8}}
masses: {p: 1}
positions: {p: [x, y, z]}
potential: 9.81*z
constraints: {rod: x**2 + y**2 + z**2 - 1}
"""
ON_A_SPHERE = """
coordinates: {theta: {initial: 1, velocity: 0.3}, phi: {velocity: 1}}
masses: {p: 1}
positions: {p: [sin(theta)*cos(phi), sin(theta)*sin(phi), cos(theta)]}
"""
PLANET = """
parameters: {m: 1.5, k: 2.0}
coordinates: {r: {initial: 1, velocity: 0.3}, th: {initial: 0.9, velocity: 0.7}, ph: {velocity: 0.8}}
masses: {p: m}
positions: {p: [r*sin(th)*cos(ph), r*sin(th)*sin(ph), r*cos(th)]}
potential: -k/r
"""
STARS = """
parameters: {m: 1.5, M: 2.5, G: 1.3}
coordinates: {x: {initial: 1}, y: {velocity: 0.8}, u: {initial: -1}, v: {velocity: -0.9}}
masses: {p: m, q: M}
positions: {p: [x, y], q: [u, v]}
potential: -G*m*M/norm(p - q)
"""
ROTATING = """
parameters: {w: 2}
coordinates: {x: {initial: 3}, y: {velocity: 1}}
masses: {p: 1}
positions: {p: [x*cos(w*t) - y*sin(w*t), x*sin(w*t) + y*cos(w*t)]}
"""
ELLIPTIC = """
parameters: {a: 1.2, k: 0.7, b: 0.4}
coordinates: {u: {initial: 0.8, velocity: 0.1}, w: {initial: 0.9, velocity: 0.6}}
masses: {p: 1}
positions: {p: [a*cosh(u)*cos(w), a*sinh(u)*sin(w)]}
potential: -k/(a*(cosh(u) - cos(w))) - b/(a*(cosh(u) + cos(w)))
"""
JACOBI = """
parameters: {m: 2, M: 3}
coordinates: {X: {}, Y: {velocity: 1}, r: {initial: 1}, phi: {velocity: 1}}
masses: {p: m, s: M}
positions:
  p: [X + M/(m + M)*r*cos(phi), Y + M/(m + M)*r*sin(phi)]
  s: [X - m/(m + M)*r*cos(phi), Y - m/(m + M)*r*sin(phi)]
potential: -1/r
"""
RATIO = """
parameters: {k: 1, c: 2, d: 3}
coordinates: {a: {initial: 1}, b: {velocity: 1}}
lagrangian: a_dot**2/2 + b_dot**2 + cos(c*a - k*d*b) - 0.1*(c*a - k*d*b)**4
"""
DISC = """
parameters: {m: 1, I: 1, J: 2, R: 0.3}
coordinates: {x: {velocity: R}, y: {}, phi: {velocity: 1}, psi: {velocity: 1}}
lagrangian: m*(x_dot**2 + y_dot**2)/2 + I*phi_dot**2/2 + J*psi_dot**2/2
nonholonomic: {a: x_dot - R*cos(phi)*psi_dot, b: y_dot - R*sin(phi)*psi_dot}
"""
SLEIGH = """
parameters: {m: 1, I: 1, g: 0.5}
coordinates: {x: {velocity: 1}, y: {}, theta: {velocity: 1}}
lagrangian: m*(x_dot**2 + y_dot**2)/2 + I*theta_dot**2/2 - m*g*x
nonholonomic: {blade: y_dot*cos(theta) - x_dot*sin(theta)}
"""
HELD = """
coordinates: {x: {velocity: 1}, y: {}}
lagrangian: (x_dot**2 + y_dot**2)/2 + x*y
constraints: {table: y}
"""
BAR = PLANE.format("(x*cos(w*t) + y*sin(w*t))**2 + 2*(y*cos(w*t) - x*sin(w*t))**4")
TOP = """
parameters: {A: 1, B: 2, C: 2.5}
coordinates:
  w: {initial: 1}
  x: {initial: 0, velocity: 0.15}
  y: {initial: 0, velocity: 0.1}
  z: {initial: 0, velocity: 0.6}
bodies: {top: {mass: 1, position: [0, 0, 0], inertia: [A, B, C], orientation: {quaternion: [w, x, y, z]}}}
"""
THROWN = """
parameters: {m: 1.2, l: 0.7}
coordinates:
  x: {initial: 0, velocity: 1}
  y: {initial: 0, velocity: 0.3}
  phi: {initial: 0.1, velocity: 1}
  theta: {initial: 1, velocity: 0.2}
  psi: {initial: 0, velocity: 5}
bodies:
  top:
    mass: m
    position: [x, y, 0]
    inertia: [1, 1, 0.5]
    orientation: {euler: [phi, theta, psi], sequence: zxz}
potential: m*top.at(0, 0, l).z
"""
FLYING = """
coordinates:
  x: {initial: 0, velocity: 1}
  y: {initial: 0, velocity: 0.3}
  z: {initial: 0, velocity: 2}
  phi: {initial: 0.1, velocity: 1}
  theta: {initial: 1, velocity: 0.2}
  psi: {initial: 0, velocity: 5}
bodies:
  top: {mass: 1, position: [x, y, z], inertia: [1, 1.5, 1.2], orientation: {euler: [phi, theta, psi]}}
potential: 9.81*top.z
"""
COLLISION = """
coordinates: {x: {velocity: 1}, y: {initial: 1, velocity: -1}}
masses: {p: 1, q: 2}
positions: {p: [x], q: [y]}
events:
  hit:
    when: y - x
    direction: falling
    action: {set: {x_dot: (4*y_dot - x_dot)/3, y_dot: (2*x_dot + y_dot)/3}}
"""
ON_A_LINE = """
coordinates: {x: {initial: 1, velocity: 0.3}}
masses: {p: 1}
positions: {p: [x]}
potential: 2/x**2
"""
TUMBLING = """
parameters: {m: 1, M: 2, l: 1.2, g: 9.81}
coordinates:
  x: {velocity: 1}
  y: {velocity: 0.5}
  z: {velocity: 3}
  X: {initial: l, velocity: 1}
  Y: {velocity: 1.5}
  Z: {velocity: 2}
masses: {a: m, b: M}
positions: {a: [x, y, z], b: [X, Y, Z]}
potential: g*(m*a.z + M*b.z)
constraints: {rod: dot(a - b, a - b) - l**2}
"""
BOX = """
parameters: {g: 9.81}
coordinates:
  X: {velocity: 1}
  Y: {velocity: 0.5}
  Z: {velocity: 3}
  w: {initial: 1}
  x: {velocity: 0.3}
  y: {velocity: 0.6}
  z: {velocity: 1.1}
bodies:
  box: {mass: 2, inertia: [1.0, 1.6, 2.1], position: [X, Y, Z], orientation: {quaternion: [w, x, y, z]}}
potential: 2*g*box.z
"""
BALL = """
parameters: {R: 0.5}
coordinates:
  X: {velocity: 1}
  Y: {velocity: 0.5}
  w: {initial: 1}
  x: {velocity: -0.5}
  y: {velocity: 1}
  z: {velocity: 1.1}
bodies: {ball: {mass: 2, solid: {sphere: R}, position: [X, Y, R], orientation: {quaternion: [w, x, y, z]}}}
nonholonomic: {along: ball.vx - R*ball.wy, across: ball.vy + R*ball.wx}
"""
ROLLING = """
parameters: {m: 1.3, g: 9.81, R: 0.3, D: 2, I: 0.2, J: 0.3}
coordinates: {COORDINATES, al: {initial: pi/2}, be: {initial: TILT}, ga: {initial: 0.7, velocity: 2}}
bodies:
  ball: {mass: m, inertia: [I, I, I], position: [CENTRE], orientation: {euler: [al, be, ga], sequence: zxz}}
potential: m*g*ball.z
nonholonomic: {along: ALONG, across: ACROSS}
"""
ROLLING_ON_A_SPHERE = (
    ROLLING.replace("COORDINATES", "th: {initial: 0.7}, ph: {}")
    .replace("TILT", "0.7")
    .replace("CENTRE", "(D + R)*sin(th)*cos(ph), (D + R)*sin(th)*sin(ph), (D + R)*cos(th)")
    .replace("ALONG", "(D + R)*th_dot - R*(ball.wy*cos(ph) - ball.wx*sin(ph))")
    .replace(
        "ACROSS", "(D + R)*sin(th)*ph_dot + R*((ball.wx*cos(ph) + ball.wy*sin(ph))*cos(th) - ball.wz*sin(th))"
    )
)
ROLLING_IN_A_CYLINDER = (
    ROLLING.replace("COORDINATES", "s: {}, z: {}")
    .replace("TILT", "pi/2")
    .replace("CENTRE", "(D - R)*cos(s), (D - R)*sin(s), z")
    .replace("ALONG", "ball.vy*cos(s) - ball.vx*sin(s) + R*ball.wz")
    .replace("ACROSS", "ball.vz + R*(ball.wx*sin(s) - ball.wy*cos(s))")
)
ROLLING_WITH_A_RATIO = ROLLING_IN_A_CYLINDER.replace(
    "ball.vy*cos(s) - ball.vx*sin(s) + R*ball.wz", "(D - R)*s_dot + R*ball.wz"
)
DECIMAL = """
coordinates: {a: {velocity: 1}, b: {initial: 1, velocity: 0.3}, c: {velocity: 0.2}}
bodies:
  top:
    mass: 1
    inertia: [[1, 0.1, -0.2], [0.1, 1.4, 0.15], [-0.2, 0.15, 1.6]]
    position: [0, 0, 0]
    orientation: {euler: [a, b, c], sequence: yzy}
"""
WITH_A_ROTOR = """
parameters: {A: 1, B: 1.3, C: 1.7, l: 0.5}
coordinates:
  {x: {}, y: {}, z: {}, a: {velocity: 1}, b: {initial: 1}, c: {velocity: 0.2}, s: {velocity: 9}, u: {}}
bodies:
  hull: {mass: 2, inertia: [A, B, C], position: [x, y, z], orientation: {euler: [a, b, c]}}
  rotor: {mass: 0.3, inertia: [0.1, 0.1, 0.2], position: [x, y, z], orientation: {euler: [a, b, c + s]}}
masses: {tip: 1}
positions:
  tip:
    - x + l*(cos(a)*cos(c + u) - sin(a)*cos(b)*sin(c + u))
    - y + l*(sin(a)*cos(c + u) + cos(a)*cos(b)*sin(c + u))
    - z + l*sin(b)*sin(c + u)
"""
ON_ITS_TIP = (
    ROLLING.replace("COORDINATES", "x: {}, y: {initial: 0, velocity: -2*R*sin(0.7)}")
    .replace("TILT", "0.7")
    .replace("I, I, I", "I, I, J")
    .replace("CENTRE", "x - 0.1*sin(al)*sin(be), y + 0.1*cos(al)*sin(be), R - 0.1*cos(be)")
    .replace("ALONG", "x_dot - R*ball.wy")
    .replace("ACROSS", "y_dot + R*ball.wx")
)
ROUTH = """
parameters: {m: 1, R: 0.2, e: 0.05, A: 0.02, C: 0.015, g: 9.81}
coordinates: {x: {}, y: {}, phi: {velocity: 1}, th: {initial: 0.6, velocity: 0.1}, psi: {velocity: 5}}
bodies:
  ball:
    mass: m
    inertia: [A, A, C]
    position: [x, y, R - e*cos(th)]
    orientation: {euler: [phi, th, psi], sequence: zxz}
potential: m*g*ball.z
nonholonomic:
  along: ball.vx - ball.wy*(R - e*cos(th)) + ball.wz*e*cos(phi)*sin(th)
  across: ball.vy + ball.wx*(R - e*cos(th)) + ball.wz*e*sin(phi)*sin(th)
"""
IN_A_FLUID = """
parameters: {m1: 1, m2: 1.5, m3: 2, I1: 1, I2: 1.3, I3: 0.7}
coordinates: {x: {velocity: 0.3}, y: {}, z: {}, a: {}, b: {initial: 1, velocity: 0.2}, c: {velocity: 0.5}}
definitions:
  e1: [cos(a)*cos(c) - sin(a)*cos(b)*sin(c), sin(a)*cos(c) + cos(a)*cos(b)*sin(c), sin(b)*sin(c)]
  e2: [-cos(a)*sin(c) - sin(a)*cos(b)*cos(c), -sin(a)*sin(c) + cos(a)*cos(b)*cos(c), sin(b)*cos(c)]
  e3: [sin(a)*sin(b), -cos(a)*sin(b), cos(b)]
  u: (x_dot, y_dot, z_dot)
lagrangian: >-
  (m1*dot(u, e1)**2 + m2*dot(u, e2)**2 + m3*dot(u, e3)**2 + I1*(a_dot*sin(b)*sin(c) + b_dot*cos(c))**2
  + I2*(a_dot*sin(b)*cos(c) - b_dot*sin(c))**2 + I3*(a_dot*cos(b) + c_dot)**2)/2
"""
BOUND = """
coordinates: {w: {initial: 1}, x: {velocity: 0.3}, y: {velocity: 0.5}, z: {}}
bodies: {b: {mass: 1, inertia: [2.0, 1.1, 1.5], position: [0, 0, 0], orientation: {quaternion: [w, x, y, z]}}}
nonholonomic: {axis: b.AXIS}
"""
GIMBALS = """
coordinates: {a: {velocity: 0.4}, b: {initial: 0.7, velocity: 0.2}, c: {velocity: 5.0}}
bodies:
  outer: {mass: 1, inertia: [0.2, 0.2, 0.3], position: [0, 0, 0], orientation: {euler: [a, 0, 0]}}
  inner: {mass: 1, inertia: [0.2, 0.25, 0.3], position: [0, 0, 0], orientation: {euler: [a, b, 0]}}
  rotor: {mass: 1, inertia: [0.5, 0.5, 0.9], position: [0, 0, 0], orientation: {euler: [a, b, c]}}
"""
HELD_APART = """
parameters: {l: 2}
coordinates: {x: {initial: 1.2, velocity: 0.4}, y: {initial: 1.6, velocity: -0.3}, s: {}, u: {velocity: 1}}
masses: {a: 1, b: 1, c: 1, d: 1}
positions: {a: [x, 0], b: [0, y], c: [s], d: [u]}
potential: 9.81*y + (c.x - d.x)**2
constraints: {rod: x**2 + y**2 - l**2, DRIVE}
"""
GEARS = """
parameters: {R: 1.0, r: 0.4}
coordinates: {a: {velocity: 1}, b: {velocity: -R/r}, c: {velocity: 0.4}}
lagrangian: a_dot**2/4 + b_dot**2/10 + c_dot**2/20 - (1 - cos(b - c))
nonholonomic: {mesh: R*a_dot + r*b_dot}
"""
TIPPE_TOP = """
parameters: {m: 0.02, R: 0.02, e: 0.003, A: 3.1e-6, C: 3.3e-6, g: 9.81, c: 0.02}
coordinates:
  x: {}
  y: {}
  phi: {velocity: 0.5}
  theta: {initial: 0.4}
  psi: {velocity: 100}
bodies: {top: {mass: m, inertia: [A, A, C], position: [x, y, R - e*cos(theta)],
  orientation: {euler: [phi, theta, psi]}}}
potential: m*g*top.z
forces: {top: [-c*UX, -c*UY, 0]}
torques: {top: [c*(e*top.R33 - R)*UY, -c*(e*top.R33 - R)*UX, c*e*(top.R23*UX - top.R13*UY)]}
"""
"""It slides with friction at its lowest point, along which the body has the coordinates of UX and UY."""
for axis in "xy":
    slip = f"top.at(-R*top.R31, -R*top.R32, e - R*top.R33).v{axis}"
    TIPPE_TOP = TIPPE_TOP.replace(f"U{axis.upper()}", slip)
SLIP = " + ".join(f"(A.w{axis} - B.w{axis})**2" for axis in "xyz")
CLUTCH = f"""
parameters: {{k: 0.1}}
coordinates:
  phi: {{initial: 0.1, velocity: 1}}
  theta: {{initial: 0.9}}
  psi: {{velocity: 2}}
  a: {{initial: 1}}
  b: {{velocity: 0.3}}
  c: {{}}
  d: {{velocity: -0.5}}
bodies:
  A: {{mass: 1, inertia: [1, 2, 2.5], position: [0, 0, 0], orientation: {{euler: [phi, theta, psi]}}}}
  B: {{mass: 1, inertia: [1, 1.5, 2], position: [0, 0, 0], orientation: {{quaternion: [a, b, c, d]}}}}
dissipation: k*({SLIP})
"""
"""Two bodies that brake each other."""
HELD_AT_R = """
parameters: {m: 1.3, g: 9.81, l: 0.7}
coordinates: {r: {initial: l}, theta: {initial: 0.4}, phi: {velocity: 1}}
masses: {bob: m}
positions: {bob: [r*sin(theta)*cos(phi), r*sin(theta)*sin(phi), -r*cos(theta)]}
potential: m*g*bob.z
constraints: {rod: r - l}
"""
"""r*p_phi is nothing new."""
GEODESICS = """
coordinates: {u: {initial: 1, velocity: 0.2}, phi: {velocity: 0.5}}
lagrangian: (u_dot**2 + SINE(u)**2*phi_dot**2)/2
"""
TOP_BY_L = """
parameters: {A: 1, B: 0.7, C: 0.4}
coordinates: {a: {velocity: 0.5}, b: {initial: 1, velocity: 0.3}, c: {velocity: 2}}
definitions:
  w1: a_dot*sin(b)*sin(c) + b_dot*cos(c)
  w2: a_dot*sin(b)*cos(c) - b_dot*sin(c)
lagrangian: (A*w1**2 + B*w2**2 + C*(c_dot + cos(b)*a_dot)**2)/2
"""
MONOPOLE = """
parameters: {m: 1.5, q: 0.6}
coordinates: {r: {initial: 1}, a: {initial: 1.2, velocity: 0.3}, b: {velocity: 0.5}}
lagrangian: m/2*(r_dot**2 + r**2*a_dot**2 + r**2*sin(a)**2*b_dot**2) + q*(1 - cos(a))*b_dot
"""
RELATIVISTIC = """
parameters: {m: 1.5, c: 2}
coordinates: {x: {velocity: 1}, y: {velocity: 0.4}, z: {velocity: 0.1}}
lagrangian: -m*c**2*sqrt(1 - (x_dot**2 + y_dot**2 + z_dot**2)/c**2)
"""
CASES = {
    "geodesics of a sphere": (GEODESICS.replace("SINE", "sin"), {"C_1", "C_2"}),
    "geodesics of a hyperbolic plane": (GEODESICS.replace("SINE", "sinh"), {"C_1", "C_2"}),
    "geodesics of another surface": (GEODESICS.replace("SINE(u)**2", "(2 + sin(u))**2"), set()),
    "a top by its Lagrangian": (TOP_BY_L, {"C_1", "C_2"}),
    "a monopole in a gauge": (MONOPOLE, {"C_1", "C_2", "C_3"}),
    "a relativistic particle": (RELATIVISTIC, {"C_1", "C_2", "C_3", "C_4", "C_5"}),
    "scaling near a dipole": (SPACE.format("q*z/norm(p)**3"), {"L_z", "C_1", "I_1"}),
    "a clutch": (CLUTCH, {"L_x", "L_y", "L_z"}),
    "a coordinate that is held": (HELD_AT_R, set()),
    "a ball that is thrown in space": (SPACE.format("m*q*z"), {"A_z", "L_z", "C_1", "C_2"}),
    "twice the frequency": (
        SPACE.format("x**2 + y**2 + 4*z**2"),
        {"L_z", "h_x", "h_y", "h_z", "F_xy", "A_z"},
    ),
    "geared rotors": (GEARS, {"C_1", "C_2"}),
    "Jellett's integral of a tippe top": (TIPPE_TOP, {"C_1"}),
    "a dumbbell that is thrown": (TUMBLING, {"P_x", "P_y", "K_x", "K_y", "L_z", "S_x", "S_y", "C_1", "K_z"}),
    "a box that is thrown": (BOX, {"L_z", "S_x", "S_y", "S_z", "C_1", "h_Z", "h_w", "C_2"}),
    "a ball that rolls": (BALL, {"S_z", "p_X", "p_Y", "I_1"}),
    "a ball on a sphere": (ROLLING_ON_A_SPHERE, {"S_n", "C_1"}),
    "another one on a sphere": (ROLLING_ON_A_SPHERE.replace("I, I, I", "I, I, J"), {"C_1"}),
    "a ball in a cylinder": (ROLLING_IN_A_CYLINDER, {"p_s", "p_al", "C_1"}),
    "a ball in a cylinder, by the ratio of radii": (ROLLING_WITH_A_RATIO, {"p_s", "p_al", "C_1"}),
    "a body with decimal products of inertia": (DECIMAL, {"L_x", "L_z"}),
    "a satellite with a rotor and an arm": (WITH_A_ROTOR, {"L_x", "L_y", "L_z", "K_x", "K_y", "K_z"}),
    "a ball in a horizontal cylinder (Routh)": (
        ROLLING_IN_A_CYLINDER.replace("m*g*ball.z", "-m*g*ball.x"),
        {"I_1"},
    ),
    "Rosenberg's particle, in a field": (
        SPACE.format("m*q*y") + "nonholonomic: {plane: z_dot - y*x_dot}\n",
        {"C_1", "C_2", "C_3"},
    ),
    "Routh's ball": (ON_ITS_TIP, {"C_1"}),
    "Routh's ball, with names": (ROUTH, {"C_1", "I_1"}),
    "Kirchhoff's body in a fluid": (IN_A_FLUID, {"C_1", "C_2", "C_3"}),
    "Veselova's body": (BOUND.replace("AXIS", "wz"), {"L_x", "L_y"}),
    "Suslov's body": (BOUND.replace("AXIS", "w3 - 0.1*b.w1"), set()),
    "a gyroscope in gimbals": (GIMBALS, set()),
    "parts with constraints": (HELD_APART.replace(", DRIVE", ""), {"h_x", "h_s", "C_1", "C_2"}),
    "a part that is driven": (HELD_APART.replace("DRIVE", "drive: x - 1.2 - 0.4*t"), {"h_s", "C_1", "C_2"}),
    "a flying body": (FLYING, {"L_z", "S_x", "S_y", "C_1", "h_z", "h_phi", "C_2"}),
    "a collision": (COLLISION, {"P_x", "K_x", "C_1", "I_1"}),
    "scaling on a line": (ON_A_LINE, {"C_1"}),
    "a ball that is thrown": (PLANE.format("m*k*y"), {"C_1", "A_y", "C_2"}),
    "a free top": (TOP, {"L_x", "L_y", "L_z"}),
    "a heavy top": (THROWN, {"L_z"}),
    "Kepler": (PLANE.format("-k/norm(p)"), {"L_z", "A_x", "A_y"}),
    "Kepler in a rotating frame": (ROTATING + "potential: -2/norm(p)", {"L_z", "A_x", "A_y"}),
    "two centres in elliptic coordinates": (ELLIPTIC, {"I_1"}),
    "Kepler about another point": (PLANE.format("-k/sqrt((x - a)**2 + y**2)"), {"C_1", "I_1"}),
    "isotropic oscillator": (PLANE.format("k*dot(p, p)"), {"L_z", "h_x", "h_y", "F_xy"}),
    "anisotropic oscillator": (PLANE.format("k*x**2 + y**2"), {"h_x", "h_y"}),
    "scaling": (PLANE.format("k/dot(p, p)"), {"L_z", "C_1"}),
    "a bar that turns": (BAR, {"C_1"}),
    "Henon-Heiles": (PLANE.format("x**2*y - y**3/3 + (x**2 + y**2)/2"), set()),
    "driven": (PLANE.format("-k*cos(t)/norm(p)"), {"L_z"}),
    "drag": (PLANE.format("-k/norm(p)") + "forces: {p: -0.1*(p.vx, p.vy)}", {"D_1"}),
    "a magnetic field": (SPACE.format("-q*B*(x*p.vy - y*p.vx)/2"), {"L_z", "C_1", "C_2"}),
    "crossed fields": (PLANE.format("-k*x*y_dot + a*x"), {"C_1"}),
    "a helix": (SPACE.format("x*cos(2*pi*z/pitch) + y*sin(2*pi*z/pitch) + (x**2 + y**2)**2"), {"C_1"}),
    "two masses and a spring": (LINE.format("k*(q.x - p.x)**2/2"), {"P_x", "K_x"}),
    "and a damper": (LINE.format("k*(q.x - p.x)**2/2") + "dissipation: (x_dot - y_dot)**2", {"P_x", "K_x"}),
    "and the ground": (LINE.format("k*(q.x - p.x)**2/2 + p.x**2"), {"I_1"}),
    "three bodies": (BODIES, set(TEN)),
    "a chain on a plane": (CHAIN, {"K_x", "K_y", "L_z"}),
    "a dumbbell": (DUMBBELL, {"P_x", "P_y", "K_x", "K_y", "L_z"}),
    "a spherical pendulum": (SPHERICAL, {"L_z"}),
    "a pendulum": (SPHERICAL.replace("rod: ", "plane: z + 0.8*x - 0*y, rod: "), set()),
    "a sphere": (ON_A_SPHERE, {"L_x", "L_y"}),
    "a rotating frame": (ROTATING, {"P_x", "P_y", "L_z"}),
    "relative coordinates": (JACOBI, {"K_x", "K_y", "L_z", "A_x", "A_y"}),
    "a ratio": (RATIO, {"C_1", "C_2"}),
    "a rolling disc": (DISC, {"p_psi", "I_1", "I_2"}),
    "a sleigh": (SLEIGH.replace("- m*g*x", ""), {"C_1", "I_1", "I_2"}),
    "a sleigh on an incline": (SLEIGH, {"I_1"}),
    "a table": (HELD, {"p_x"}),
    "a planet in angles": (PLANET, {"L_x", "L_y", "A_x", "A_y", "A_z"}),
    "two stars": (STARS, {"P_x", "P_y", "K_x", "K_y", "L_z", "A_x", "A_y"}),
    "another power": (PLANE.format("-k*m/norm(p)**1.5"), {"L_z"}),
    "two fixed centres": (PLANE.format("k/sqrt((x - a)**2 + y**2) + 2*k/sqrt((x + a)**2 + y**2)"), {"I_1"}),
    "Stark's effect": (SPACE.format("-q/norm(p) - B*z"), {"L_z", "A_z"}),
    "a planet in a gauge": (
        PLANE.format("-k*m/norm(p) + a*(x*y_dot + y*x_dot)*cos(w*t) - a*w*x*y*sin(w*t)"),
        {"h_0", "L_z_0", "A_x_0", "A_y_0"},
    ),
    "a planet with a kink": (PLANE.format("-k*m/norm(p) + abs(x - 9)"), set()),
}


CARRIAGE = """
parameters: {m: 2, R: 0.1, w: 0.25, l: 0.1, J: 0.05, C: 0.0015}
coordinates:
  x: {}
  y: {}
  th: {initial: 0.2, velocity: 0.7}
  p1: {}
  p2: {velocity: 9}
lagrangian: >
  m/2*((x_dot - l*sin(th)*th_dot)**2 + (y_dot + l*cos(th)*th_dot)**2) + J/2*th_dot**2
  + C/2*(p1_dot**2 + p2_dot**2)
nonholonomic:
  side: y_dot*cos(th) - x_dot*sin(th)
  left: x_dot*cos(th) + y_dot*sin(th) - w*th_dot - R*p1_dot
  right: x_dot*cos(th) + y_dot*sin(th) + w*th_dot - R*p2_dot
"""
IN_A_CYLINDER = """
parameters: {m: 1, r: 0.1, R: 0.6, g: 9.81, Om: 1}
coordinates:
  ph: {velocity: 5}
  Z: {}
  w: {initial: 1, velocity: 0}
  x: {velocity: 0}
  y: {}
  z: {initial: 0}
bodies:
  ball: {mass: m, solid: {sphere: r}, position: [(R - r)*cos(ph), (R - r)*sin(ph), Z],
         orientation: {quaternion: [w, x, y, z]}}
potential: m*g*ball.z
nonholonomic:
  vertical: ball.vz + r*(ball.wx*sin(ph) - ball.wy*cos(ph))
  around: ball.vy*cos(ph) - ball.vx*sin(ph) + r*ball.wz - R*Om
"""
DRAG = """
parameters: {{m: 1.5, c: 0.3, g: 2, B: 0.7}}
coordinates: {{x: {{initial: 1, velocity: 0.4}}, y: {{initial: 0.3, velocity: 0.9}}}}
masses: {{p: m}}
positions: {{p: [x, y]}}
potential: {}
dissipation: c*(x_dot**2 + y_dot**2)/2
"""
SPRINGS = """
parameters: {{m1: 1.5, m2: 2, m3: 1.2, k: 2, K: 0.3, g: 0.7}}
coordinates: {{x: {{initial: 1}}, y: {{initial: 0.2, velocity: 0.5}}, z: {{}}}}
masses: {{a: m1, b: m2, d: m3}}
positions: {{a: [x], b: [y], d: [z]}}
potential: k*x**2/2 + K*(x - y)**2/2 + k*(y - z)**2/2 + {}
"""
CASES |= {
    "a carriage": (CARRIAGE, set()),
    "a carriage with its centre of mass on the axle": (
        CARRIAGE.replace("l: 0.1", "l: 0").replace("l*sin", "0*sin").replace("l*cos", "0*cos"),
        {"p_th", "p_p1", "p_p2", "I_1", "I_2"},
    ),
    "a ball in a cylinder that turns": (
        IN_A_CYLINDER.replace("z: {initial: 0}", "z: {}"),
        {"p_ph", "h", "I_1"},
    ),
    "a projectile": (
        "parameters: {m: 1, g: 9.81}\ncoordinates: {x: {velocity: 1}, y: {velocity: 2}}\n"
        "masses: {p: m}\npositions: {p: [x, y]}\npotential: m*g*y\n",
        {"C_1", "A_y", "C_2"},
    ),
    "Kepler with a mass that is lost (Gylden, Meshcherskii)": (
        PLANE.format("-k/((1 + a*t)*norm(p))"),
        {"L_z", "A_x", "A_y", "I_1"},
    ),
    "another law of the loss": (PLANE.format("-k/((1 + a*t**2)*norm(p))"), {"L_z"}),
    "a loss that leaves an oscillator": (PLANE.format("-k/(sqrt(1 + a*t)*norm(p))"), {"L_z", "C_1"}),
    "Emden's equation in a plane": (PLANE.format("norm(p)**4/sqrt(w*t + a)"), {"L_z"}),
    "drag in the plane": (DRAG.format("m*g*y"), {"C_1", "C_2", "D_1", "D_2"}),
    "drag and a spring": (DRAG.format("g*(x**2 + y**2)"), {"D_1", "D_2", "I_1", "F_xy"}),
    "drag and springs along the axes": (DRAG.format("g*(x**2 + 2*y**2)"), {"D_1", "I_1"}),
    "drag of two kinds": (DRAG.format("0").replace("y_dot**2", "3*y_dot**2"), {"C_1", "C_2"}),
    "drag that grows with the speed": (DRAG.format("0").replace("_dot**2", "_dot**4"), set()),
    "drag in a magnetic field": (DRAG.format("-B*(x*y_dot - y*x_dot)/2"), {"C_1", "C_2", "D_1"}),
    "three masses on springs": (SPRINGS.format("m1*g*x + m2*g*y + m3*g*z"), {"I_1", "I_2"}),
    "masses on a spring that is hard": (SPRINGS.format("z**4"), set()),
    "a free particle": (
        "coordinates: {x: {velocity: 1}, y: {velocity: 2}}\nmasses: {p: 2}\npositions: {p: [x, y]}\n",
        {"L_z"},
    ),
    "geodesics of a sphere by stereographic projection": (
        "coordinates: {x: {initial: 0.1, velocity: 0.3}, y: {initial: 0.2, velocity: 0.1}}\n"
        "lagrangian: 2*(x_dot**2 + y_dot**2)/(1 + x**2 + y**2)**2\n",
        {"C_1", "C_2"},
    ),
    "a charge of relativity in parallel fields": (
        RELATIVISTIC.replace("c: 2", "c: 2, B: 1, E: 0.2") + "  + B*x*y_dot + E*z\n",
        {"C_1", "C_2", "C_3"},
    ),
    "three stars that fall": (
        "sizes: {N: 3}\nparameters: {m: 1, g: 2}\ncoordinates: {x[i in range(N)]: {initial: 0.7*i}, "
        "y[i in range(N)]: {initial: i*i}, z[i in range(N)]: {initial: 0.1*i}}\n"
        "masses: {p[i in range(N)]: m}\npositions: {p[i in range(N)]: [x[i], y[i], z[i]]}\n"
        "potential: sum(m*g*p[i].z for i in range(N)) - "
        "sum(1/norm(p[i] - p[j]) for i in range(N) for j in range(i))\n",
        {"P_x", "P_y", "L_z", "K_x", "K_y", "S_x", "S_y", "C_1", "K_z"},
    ),
    "a driven oscillator": (DRIVEN.format("k*x**2/2 - m*x*cos(w*t)", "0"), {"C_1", "C_2"}),
    "a driven oscillator that is unstable": (
        DRIVEN.format("-w*x**2/2 - m*x*t*exp(-w*t)", "0"),
        {"C_1", "C_2"},
    ),
    "a driven oscillator with friction": (DRIVEN.format("k*x**2/2 - m*x*cos(w*t)", "b"), {"C_1", "C_2"}),
    "a driven body with friction": (DRIVEN.format("-m*x*cos(w*t)", "b"), {"C_1", "C_2"}),
    "forces that fall with the time": (DRIVEN.format("-m*x*(1/(2 + t) + sqrt(2 + t))", "0"), {"C_1"}),
    "a force that grows drives a body": (DRIVEN.format("-m*x*t**3", "0"), {"C_1"}),
    "weight, friction and a drive": (DRIVEN.format("m*w*x - m*x*cos(k*t)", "b"), {"C_1", "C_2"}),
    "an oscillator in resonance": (DRIVEN.format("k*x**2/2 - m*x*cos(sqrt(k/m)*t)", "0"), {"C_1", "C_2"}),
    "two masses on a spring, driven": (
        LINE.format("k*(p.x - q.x)**2/2 - m*p.x*sin(k*t)"),
        {"C_1", "C_2", "C_3", "C_4"},
    ),
    "a square wave drives an oscillator": (DRIVEN.format("k*x**2/2 - m*x*sign(cos(w*t))", "0"), set()),
    "two driven oscillators, coupled": (
        PLANE.format("k*(x**2 + y**2 + (x - y)**2)/2 - m*x*cos(w*t)"),
        {"C_1", "C_2", "C_3", "C_4"},
    ),
    "two particles in a frame that turns": (
        "parameters: {m: 1.3, n: 0.4, w: 0.7, k: 2}\n"
        "coordinates: {x: {initial: 1}, y: {velocity: 1}, u: {initial: -1}, z: {initial: 0.3}}\n"
        "lagrangian: m*((x_dot - w*y)**2 + (y_dot + w*x)**2)/2 + n*((u_dot - w*z)**2 + (z_dot + w*u)**2)/2"
        " - k*((x - u)**2 + (y - z)**2)**2\n",
        {"C_1", "C_2", "C_3", "C_4"},
    ),
    "a free particle of relativity": (
        "parameters: {c: 3}\ncoordinates: {x: {velocity: 1}, y: {velocity: 0.5}}\n"
        "lagrangian: -c**2*sqrt(1 - (x_dot**2 + y_dot**2)/c**2)\n",
        {"C_1", "C_2", "C_3"},
    ),
}


def started(text):
    """The text with a place to start for every coordinate."""
    return text.replace(": {}", ": {initial: 0}").replace("{velocity", "{initial: 0, velocity")


@pytest.mark.exhaustive(keep=0.15)
@pytest.mark.parametrize("case", CASES)
def test_what_is_conserved(case):
    """That, and nothing else; and a motion keeps it, to rounding: of a vector, to that of its length."""
    text, names = CASES[case]
    residual = residual_of(started(text))
    found = symmetries(residual.model, residual.conserved)
    assert {one.conserved.quantity for one in found} == names
    if found:
        ready = prepared(started(text), outputs=("conserved",))
        motion = run(ready, consistent(started(text)), 0.0, 3.0, 31)
        lasting = {one.conserved.quantity for one in found if not one.conserved.breaks}
        kept = {name: motion[f"diagnostics/conserved/{name}"] for name in names & lasting}
        for name, series in kept.items():
            vector = name.partition("_")[0]
            size = max(np.abs(kept[one]).max() for one in kept if one.partition("_")[0] == vector)
            assert np.ptp(series) < 4e-13 * max(1, size), name


IN_A_BOWL = """
parameters: {m: 1.3, g: 9.81, a: 0.3, b: 2}
coordinates: {COORDINATES, w: {initial: 1}, i: {initial: 0}, j: {initial: 0}, k: {initial: 0}}
bodies: {ball: {mass: m, solid: {sphere: a}, position: [PLACE], orientation: {quaternion: [w, i, j, k]}}}
potential: m*g*ball.z
CONSTRAINTS
nonholonomic: {roll: "(ball.vx, ball.vy, ball.vz) + cross((ball.wx, ball.wy, ball.wz), a/b*ball)"}
"""
ANGLES = (
    IN_A_BOWL.replace("COORDINATES", "th: {initial: 0.7}, ph: {initial: 0, velocity: 3}")
    .replace("PLACE", "b*sin(th)*cos(ph), b*sin(th)*sin(ph), -b*cos(th)")
    .replace("CONSTRAINTS", "")
)
CARTESIAN = (
    IN_A_BOWL.replace(
        "COORDINATES", "x: {initial: 1}, y: {initial: 0, velocity: 3}, z: {initial: b - sqrt(b**2 - 1)}"
    )
    .replace("PLACE", "x, y, z - b")
    .replace("ball)", "(x, y, z - b))")
    .replace("CONSTRAINTS", "constraints: {bowl: x**2 + y**2 + (z - b)**2 - b**2}")
)


@pytest.mark.parametrize("text", [ANGLES, CARTESIAN], ids=["angles", "cartesian"])
def test_the_normal_of_a_sphere_is_short(text):
    """No more than a root of a sum of three squares, and radii by their own names."""
    residual = derive_system(begun(text)[0].independent)
    found = {one.conserved.quantity: one for one in symmetries(residual.model, residual.conserved)}
    inside = reachable([found["S_n"].node])
    factors = [factor for one in inside for factor in factors_of(one)]
    assert len({base for base, n in factors if n % 1}) == ("bowl:" in text)
    assert len(inside) < 120
    assert "where" not in found["C_1"].conserved.expression


@pytest.mark.exhaustive(keep=0.75)
@pytest.mark.parametrize("case", range(3))
def test_what_is_conserved_but_for_a_total_time_derivative(case):
    """h + dF/dt and p_x - dF/dx of L + dF/dt, F = c f(u), u = a x y + b x + w t**2."""
    source = random.Random(f"gauge {case}")
    a, b, w, c = (round(source.uniform(0.2, 1.5), 3) for _ in range(4))
    f, slope = source.choice([("sin", "cos({})"), ("exp", "exp({})"), ("atan", "1/(1 + ({})**2)")])
    u = f"{a}*x*y + {b}*x + {w}*t**2"
    rate = f"({a}*y + {b})*x_dot + {a}*x*y_dot + 2*{w}*t"
    text = f"""
    coordinates: {{x: {{initial: 0.1, velocity: 0.3}}, y: {{initial: 0.4, velocity: -0.2}}}}
    lagrangian: >-
      x_dot**2/2 + y_dot**2/2 - y**4 + {c}*{slope.format(u)}*({rate})
    """
    residual = residual_of(text)
    found = {one.conserved.quantity for one in symmetries(residual.model, residual.conserved)}
    assert {"h_0", "p_x_0"} <= found, (f, u)
    motion = follow(text, 3.0, 31, outputs=("conserved", "v", "q"))
    for name, expected in (
        ("h_0", (motion["v/x"] ** 2 + motion["v/y"] ** 2) / 2 + motion["q/y"] ** 4),
        ("p_x_0", motion["v/x"]),
    ):
        np.testing.assert_allclose(motion[f"diagnostics/conserved/{name}"], expected, rtol=0, atol=1e-10)


@pytest.mark.exhaustive(keep=0.5)
def test_they_are_given_in_formulas_and_words():
    def told(text):
        residual = residual_of(started(text))
        found = symmetries(residual.model, residual.conserved)
        return [(one.conserved.expression, one.conserved.because) for one in found]

    assert told(RATIO)[0] == (
        "k*d*p_a + c*p_b",
        "changing a and b together, in the ratio k*d : c, leaves L unchanged",
    )
    (turning,) = told(BAR)
    assert turning[0] == "h - w*L_z"
    assert turning[1] == (
        "turning the particle about the origin by w, and changing t by 1, leaves the action unchanged; "
        "L_z is x*m*vy - y*m*vx"
    )
    lagrangian = (
        "coordinates: {x: {initial: 1}, y: {initial: 0}}\nlagrangian: x_dot**2 + y_dot**2 - exp(x**2 + y**2)"
    )
    assert told(lagrangian)[0][1] == "turning the point (x, y) about the origin leaves L unchanged"
    assert told(CASES["two masses and a spring"][0])[0] == (
        "sum of m*vx",
        "moving all particles along x changes neither T nor U",
    )


def test_only_what_is_one_is_called_by_a_name():
    """The Laplace-Runge-Lenz vector."""
    for potential, whether in (("-k/norm(p)", True), ("m*k*y", False), ("k*(x**2 + 4*y**2)", False)):
        residual = residual_of(started(PLANE.format(potential)))
        found = [one.conserved for one in symmetries(residual.model, residual.conserved)]
        (because,) = (one.because for one in found if one.quantity == "A_y")
        assert ("Runge" in because) == whether
        assert ("separate in parabolic" in because) == (not whether)


KICKED = CHAIN + "events: {kick: {when: a - 2, action: {set: {x_dot: x_dot + 1}}}}\n"


FIELD = """
coordinates: {x: {initial: 1, velocity: 0.4}, y: {initial: 0.2, velocity: 0.3}}
parameters: {e: 1.6, B: 0.7, m: 1}
lagrangian: m*(x_dot**2 + y_dot**2)/2 + e*B*(x*y_dot - y*x_dot)/2
"""


def test_momenta_stand_without_a_common_number():
    residual = residual_of(FIELD)
    found = [one.conserved for one in symmetries(residual.model, residual.conserved)]
    expressions = {one.quantity: one.expression for one in found if one.quantity != "L_z"}
    assert expressions == {"C_1": "p_y + e*B*x/2", "C_2": "p_x - e*B*y/2"}


def test_events_may_change_them():
    residual = residual_of(started(KICKED))
    broken = {one.conserved.quantity: one.conserved.breaks for one in symmetries(residual.model)}
    assert broken["P_x"] == broken["K_x"] == broken["L_z"] == ("kick",)
    assert broken["P_y"] == ()


STEPS = """
coordinates: {x: {initial: 1.2}, y: {initial: 0.3}}
masses: {p: 1, q: 1}
positions: {p: [x], q: [y]}
potential: where(x + y > 3, 1, 1) * (x - y)**2 + sqrt((x + y - 2)**2)*0 + abs(x - y)
"""
JUMPS = """
coordinates: {x: {initial: 1.2}, y: {initial: 0.3}}
masses: {p: 1, q: 1}
positions: {p: [x], q: [y]}
potential: (x - y)**2
forces: {p: sign(x + y - 3)*(x - y), q: -sign(x + y - 3)*(x - y)}
dissipation: 0.1*abs(x_dot - y_dot)*(x_dot - y_dot)**2
"""


def test_no_derivative_tells_of_a_jump():
    """What a branch depends on must not change either, unless the forces are the same on both sides."""
    model = residual_of(JUMPS).model
    assert not symmetries(model)
    assert {one.conserved.quantity for one in symmetries(residual_of(STEPS).model)} >= {"P_x"}


@pytest.mark.exhaustive(keep=0.4)
def test_numbers_may_be_exact():
    model = build_model(spec_of(started(CASES["a helix"][0])), ExactGraphAlgebra())
    assert [one.conserved.quantity for one in symmetries(model, conservation(model)[1])] == ["C_1"]


@pytest.mark.parametrize("size", ["0.7", "1/3", "1.37"])
def test_exact_numbers_need_no_finite_quotients(size):
    """10/7 is no double, but 10 p_x - 7 y is constant."""
    text = f"""
    coordinates: {{x: {{initial: 1}}, y: {{velocity: 1}}}}
    lagrangian: x_dot**2/2 + y_dot**2/2 + {size}*x*y_dot
    """
    model = build_model(spec_of(text), ExactGraphAlgebra())
    assert [one.conserved.quantity for one in symmetries(model, conservation(model)[1])] == ["C_1"]


@pytest.mark.exhaustive(keep=0.2)
def test_the_search_is_bounded():
    """Of many coordinates only displacements are tried, and all of them are proven together."""
    residual = residual_of(BODIES.replace("{N: 3}", "{N: 15}"))
    before = residual.graph.work.spent
    found = symmetries(residual.model, residual.conserved)
    assert {one.conserved.quantity for one in found} == set(TEN)
    assert residual.graph.work.spent - before < 1_200_000


FALLING = """
parameters: {m1: 1, m2: 2, m3: 4, M: 3, g: 9.81, alpha: 0.5, beta: 0.3}
coordinates: {u: {initial: 0.1, velocity: 0.4}, w: {initial: 0.2, velocity: 0.3}}
"""
BLOCKS = {
    "a block on an incline, and another one": (
        "lagrangian: m1/2*u_dot**2 + m1*g*sin(alpha)*u + m2/2*w_dot**2 - m2*g*tanh(beta)*w**2",
        "m1*u_dot - m1*g*sin(alpha)*t",
    ),
    "a wedge that slides": (
        "masses: {wedge: M, block: m1}\nembedding:\n  wedge: [u, 0]\n"
        "  block: [u + w*cos(alpha), -w*sin(alpha)]\npotential: m1*g*block.y",
        "m1*(w_dot + u_dot*cos(alpha)) - m1*g*sin(alpha)*t",
    ),
    "Atwood's double machine": (
        "masses: {a: m1, b: m2, c: m3}\nembedding: {a: [-u], b: [u - w], c: [u + w]}\n"
        "potential: g*(m1*a.x + m2*b.x + m3*c.x)",
        "m1*u_dot - m2*(w_dot - u_dot) + m3*(u_dot + w_dot) - g*(m1 - m2 - m3)*t",
    ),
    "two blocks with a spring on an incline": (
        "masses: {a: m1, b: m2}\nembedding: {a: [u*cos(beta), u*sin(beta)], b: [w*cos(beta), w*sin(beta)]}\n"
        "potential: m1*g*a.y + m2*g*b.y + M*cosh(w - u)",
        "m1*u_dot + m2*w_dot + (m1 + m2)*g*sin(beta)*t",
    ),
    "a field that swings": (
        "lagrangian: m1/2*u_dot**2 + m2/2*w_dot**2 - cosh(u - w) + g*cos(M*t)*(beta*u + alpha*w)",
        "M*(m1*u_dot + m2*w_dot) - g*(alpha + beta)*sin(M*t)",
    ),
    "a magnetic force": (
        "masses: {a: m1}\nembedding: {a: [u, w]}\npotential: -m2*norm(a)**1.5\n"
        "forces: {a: [g*M*w_dot, -g*M*u_dot]}",
        "m1*(u*w_dot - w*u_dot) + g*M*(u**2 + w**2)/2",
    ),
    "normal modes of different masses": (
        "lagrangian: m1/2*u_dot**2 + m2/2*w_dot**2 - M/2*u**2 - g/2*(u - w)**2",
        "-2*m1*m2*g*u_dot*w_dot + (m1*m2*M + (m2 - m1)*m1*g)*u_dot**2 + m2*g**2*w**2 - 2*m2*g*(M + g)*u*w"
        " + (m2*(M + g)**2 - m1*M*g)*u**2",
    ),
    "Stark's effect in a tilted field": (
        "masses: {a: m1}\nembedding: {a: [u, w]}\npotential: -M/norm(a) - g*(u*cos(beta) + w*sin(beta))",
        "2*m1*(u*w_dot - w*u_dot)*(w_dot*cos(beta) - u_dot*sin(beta))"
        " - 2*M*(u*cos(beta) + w*sin(beta))/norm(a) + g*(w*cos(beta) - u*sin(beta))**2",
    ),
}


@pytest.mark.exhaustive(keep=0.7)
@pytest.mark.parametrize("case", BLOCKS)
def test_coefficients_may_be_functions_of_parameters(case):
    """What is found holds for all values of the parameters."""
    text, expected = BLOCKS[case]
    model = residual_of(f'{FALLING}{text}\nobservables: {{known: "{expected}"}}\n').model
    found = [one.node for one in symmetries(model, conservation(model)[1])]
    known = model.observables["known"]
    factors = (1, -1, 2, -2, 0.5, -0.5)
    assert any(is_zero(one - factor * known) for one in found for factor in factors)
