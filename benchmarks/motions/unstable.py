"""Motions that begin at or near unstable equilibria, on unstable orbits, or where roundings of the input grow
for another reason; with random numbers."""

from __future__ import annotations

import random
from collections.abc import Mapping


def unstable(seed: int) -> Mapping[str, tuple[str, float]]:
    """By name the system file, and when to stop."""
    source = random.Random(seed)

    def n(low: float, high: float) -> str:
        return f"{source.uniform(low, high):.4g}"

    def fraction() -> str:
        return f"{source.randint(1, 9)}/{source.choice((3, 7, 11, 13))}"

    return {
        "pendulum upside down": (f"""
parameters: {{g: {n(9, 10)}, l: 1/{source.choice((3, 5, 7))}}}
coordinates: {{th: {{initial: pi}}}}
lagrangian: l**2*th_dot**2/2 + g*l*cos(th)
""", 4.0),
        "pendulum near the top": (f"""
parameters: {{g: {n(9, 10)}, l: {fraction()}}}
coordinates: {{th: {{initial: pi - {n(1e-6, 1e-3)}}}}}
lagrangian: l**2*th_dot**2/2 + g*l*cos(th)
""", 8.0),
        "damped pendulum upside down": (f"""
parameters: {{g: {n(9, 10)}, c: {n(0.05, 0.5)}}}
coordinates: {{th: {{initial: 3*pi}}}}
lagrangian: th_dot**2/2 + g*cos(th)
dissipation: c*th_dot**2/2
""", 20.0),
        "double pendulum, outer upside down": (f"""
parameters: {{g: {n(9, 10)}, l: {n(0.5, 2)}}}
coordinates: {{a: {{initial: {n(0.001, 0.1)}}}, b: {{initial: pi}}}}
masses: {{u: 1, w: {n(0.5, 2)}}}
embedding: {{u: [l*sin(a), -l*cos(a)], w: [l*(sin(a) + sin(b)), -l*(cos(a) + cos(b))]}}
potential: g*(u.y + w.y)
""", 8.0),
        "hilltop": (f"""
coordinates: {{x: {{initial: {fraction()}, velocity: 0}}}}
lagrangian: x_dot**2/2 + {n(1, 4)}*(x - {n(0.1, 1)})**2/2
""", 20.0),
        "up a hill, to the top": (f"""
parameters: {{a: {n(0.5, 2)}}}
coordinates: {{x: {{initial: -a, velocity: a*sqrt({(k := n(1, 4))})}}}}
lagrangian: x_dot**2/2 + {k}*x**2/2
""", 15.0),
        "saddle": (f"""
coordinates: {{x: {{initial: {n(0.1, 1)}}}, y: {{initial: {n(0.1, 1)}, velocity: {n(-1, 1)}}}}}
lagrangian: (x_dot**2 + y_dot**2)/2 - {n(1, 4)}*x**2 + {n(0.5, 2)}*(y - 1/3)**2/2 - x**2*y**2/10
""", 10.0),
        "circular orbit, U = -1/(3 r^3)": (f"""
parameters: {{a: {n(0.8, 1.5)}}}
coordinates: {{r: {{initial: a}}, phi: {{initial: 0, velocity: a**(-5/2)}}}}
lagrangian: (r_dot**2 + r**2*phi_dot**2)/2 + 1/(3*r**3)
""", 12.0),
        "Lagrange's triangle": (f"""
parameters: {{w: sqrt(sqrt(3))*{n(0.9, 1.1)}}}
coordinates:
  a: {{initial: 1, velocity: 0}}
  b: {{initial: 0, velocity: w/sqrt(3)}}
  c: {{initial: -1/2, velocity: -w/2}}
  d: {{initial: sqrt(3)/2, velocity: -w/(2*sqrt(3))}}
  e: {{initial: -1/2, velocity: w/2}}
  f: {{initial: -sqrt(3)/2, velocity: -w/(2*sqrt(3))}}
lagrangian: >-
  (a_dot**2 + b_dot**2 + c_dot**2 + d_dot**2 + e_dot**2 + f_dot**2)/2
  + 1/sqrt((a - c)**2 + (b - d)**2) + 1/sqrt((a - e)**2 + (b - f)**2) + 1/sqrt((c - e)**2 + (d - f)**2)
""", 8.0),
        "middle axis": (f"""
parameters: {{w: {n(2, 4)}}}
coordinates: {{th: {{initial: pi/2}}, ph: {{initial: 0}}, ps: {{initial: pi/2, velocity: 0}}}}
lagrangian: >-
  ({n(2.9, 3.1)}*(ph_dot*sin(th)*sin(ps) + (th_dot + w)*cos(ps))**2
  + {n(1.9, 2.1)}*(ph_dot*sin(th)*cos(ps) - (th_dot + w)*sin(ps))**2
  + {n(0.9, 1.1)}*(ph_dot*cos(th) + ps_dot)**2)/2
""", 12.0),
        "bead on top of a rotating hoop": (f"""
parameters: {{g: {n(9, 10)}, w: {n(1, 6)}}}
coordinates: {{th: {{initial: pi, velocity: {source.choice(("0", "1/10**9"))}}}}}
lagrangian: (th_dot**2 + w**2*sin(th)**2)/2 + g*cos(th)
""", 8.0),
        "on the edge of a wall": (f"""
parameters: {{a: {n(0.2, 0.9)}, k: {n(100, 1e4)}}}
coordinates: {{x: {{initial: a, velocity: 0}}}}
lagrangian: x_dot**2/2 + {n(1, 3)}*(x - a)**2/2 - k*max(0, x - {n(1.5, 2)})**2/2 + {n(1e-9, 1e-7)}*x
""", 20.0),
        "phase of a long oscillation": (f"""
parameters: {{k: {n(1, 4)}, m: {n(1, 4)}}}
coordinates: {{x: {{initial: {n(0.5, 2)}}}}}
lagrangian: m*x_dot**2/2 - k*x**2/2
""", 2000.0),
        "fall": (f"""
parameters: {{g: {n(9, 10)}}}
coordinates:
  z: {{initial: {n(1, 1000)}, velocity: {n(-10, 10)}}}
  x: {{initial: {n(0, 1)}, velocity: {n(1, 9)}}}
lagrangian: (x_dot**2 + z_dot**2)/2 - g*z
""", 100.0),
        "resonance": (f"""
parameters: {{w: {n(1, 3)}, a: 1/3}}
coordinates: {{x: {{initial: 0}}}}
lagrangian: x_dot**2/2 - w**2*x**2/2 + a*x*cos(w*t)
""", 300.0),
    }  # fmt: skip
