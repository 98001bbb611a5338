"""Motions whose forces are narrow functions of small differences: of slips, and of distances between bodies
that fly side by side."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks import ROOT


@dataclass(frozen=True)
class Cancelling:
    """A system file, until when it is followed, whether its members are followed in loops (heyoka has none),
    and whether proofs of its steps have to be asked for."""

    text: str
    stop: float
    loops: bool = False
    proven: bool = False


TIPPE_TOP = """
parameters: {m: 0.02, R: 0.02, a: 0.3*R, g: 9.81, mu: 0.3, eps: 1e-3}
coordinates:
  x: {initial: 0}
  y: {initial: 0}
  phi: {initial: 0}
  th: {initial: 0.1}
  psi: {initial: 0, velocity: 150}
bodies:
  top:
    mass: m
    inertia: [131/350*m*R**2, 131/350*m*R**2, 2/5*m*R**2]
    position: [x, y, R - a*cos(th)]
    orientation: {euler: [phi, th, psi], sequence: zxz}
definitions:
  arm: (a*top.R13, a*top.R23, -R + a*cos(th))
  slip: (top.vx, top.vy, 0) + cross((top.wx, top.wy, top.wz), arm)
  force: -mu*m*g*slip/(norm(slip) + eps)
potential: m*g*top.z
forces: {top: "(force.x, force.y, 0)"}
torques: {top: "cross(arm, (force.x, force.y, 0))"}
"""
BALL = """
parameters: {m: 7, R: 0.11, g: 9.81, mu: 0.2, eps: 1e-3}
coordinates: {x: {initial: 0, velocity: 6}, phi: {initial: 0}}
lagrangian: m*x_dot**2/2 + 2/5*m*R**2*phi_dot**2/2 + 2*m*x*cos(5*t)
definitions: {F: -mu*m*g*tanh((x_dot - R*phi_dot)/eps)}
generalized_forces: {x: F, phi: -R*F}
"""
SATELLITE = """
parameters: {GS: 2.959122e-4, GE: 8.887692e-10, GM: 1.0932e-11, eps: 1e-5, k: 1e-7}
coordinates:
  xe: {initial: 1}
  ye: {initial: 0, velocity: 0.0172}
  xm: {initial: 1.00257}
  ym: {initial: 0, velocity: 0.01779}
masses: {earth: GE, moon: GM}
positions: {earth: [xe, ye], moon: [xm, ym]}
definitions: {r: norm(earth - moon)}
potential: -GS*GE/norm(earth) - GS*GM/norm(moon) - GE*GM/sqrt(r**2 + eps**2)
forces: {moon: -k*GM*exp(-r/1e-3)*(moon.vx, moon.vy)}
"""
GAS = """
sizes: {{N: {count}}}
coordinates:
  x[i in range(N)]: {{initial: 1.2*(i % 3), velocity: {drift} + sin(3*i)/3}}
  y[i in range(N)]: {{initial: 1.2*(i//3), velocity: 2*{drift} + cos(7*i)/3}}
masses: {{ball[i in range(N)]: 1}}
positions: {{ball[i in range(N)]: "[x[i], y[i]]"}}
definitions: {{r[i in range(N), j in range(i)]: "norm(ball[i] - ball[j])"}}
potential: sum(1/r[i, j]**12 - 1/r[i, j]**6 for i in range(N) for j in range(i))
"""
SWARM = """
sizes: {{N: {count}}}
parameters: {{w: 0.3, v: {drift}}}
coordinates:
  x[i in range(N)]: {{initial: sin(5*i), velocity: v + cos(3*i)/5}}
  y[i in range(N)]: {{initial: cos(5*i), velocity: 2*v + sin(3*i)/5}}
masses: {{"bead[i in range(N)]": 1}}
positions: {{"bead[i in range(N)]": "[x[i], y[i]]"}}
definitions: {{X: sum(x[i] for i in range(N))/N, Y: sum(y[i] for i in range(N))/N}}
potential: -sum(exp(-((x[i] - X)**2 + (y[i] - Y)**2)/w) for i in range(N))
"""
PLANETS = (ROOT / "systems" / "solar_system.yaml").read_text(encoding="utf-8")
MOTIONS = {
    "tippe top": Cancelling(TIPPE_TOP, 1.0),
    "ball that slides, then rolls": Cancelling(BALL, 10.0),
    "the Earth and the Moon in thin air": Cancelling(SATELLITE, 365.0),
    "six balls in flight": Cancelling(GAS.format(count=6, drift=100), 2.0),
    "forty beads in flight, drawn to their mean": Cancelling(
        SWARM.format(count=40, drift=100), 5.0, loops=True
    ),
    "the Sun and 8 planets, with --proven": Cancelling(PLANETS, 3652.5, loops=True, proven=True),
}
