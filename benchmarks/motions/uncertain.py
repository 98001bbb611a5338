"""More motions for testing the estimates in ``benchmarks.certified``.

The last six were not used to find the rule for the estimates.
"""

from __future__ import annotations

SYSTEMS = {
    "Henon-Heiles, h = 0.12": """
coordinates: {x: {initial: 0.1, velocity: 0.2}, y: {initial: 0.35, velocity: 0.1}}
lagrangian: (x_dot**2 + y_dot**2)/2 - (x**2 + y**2)/2 - x**2*y + y**3/3
""",
    "heavy top": """
coordinates: {th: {initial: 0.6}, ph: {initial: 0, velocity: 0.5}, ps: {initial: 0, velocity: 9}}
lagrangian: (th_dot**2 + ph_dot**2*sin(th)**2)/2 + (ps_dot + ph_dot*cos(th))**2/4 - 3*cos(th)
""",
    "spring pendulum": """
parameters: {g: 9.81, k: 37, l: 1.1}
coordinates: {r: {initial: 1.4}, th: {initial: 1.1}}
lagrangian: (r_dot**2 + r**2*th_dot**2)/2 + g*r*cos(th) - k*(r - l)**2/2
""",
    "driven Duffing oscillator": """
parameters: {w: 1.3, a: 0.37}
coordinates: {x: {initial: 0.7}}
lagrangian: x_dot**2/2 + x**2/2 - x**4/4 + a*x*cos(w*t)
""",
    "damped, coupled": """
parameters: {c: 0.07}
coordinates: {x: {initial: 0.7}, y: {initial: -0.3}}
lagrangian: (x_dot**2 + y_dot**2)/2 - (x**2 + 1.7*y**2)/2 - 0.2*x**2*y**2
dissipation: c*(x_dot**2 + y_dot**2)/2
""",
    "Kepler, e = 0.9": """
coordinates: {x: {initial: 0.1}, y: {initial: 0, velocity: 4.358898943540674}}
lagrangian: (x_dot**2 + y_dot**2)/2 + 1/sqrt(x**2 + y**2)
""",
    "swinging Atwood machine": """
parameters: {M: 3, m: 1, g: 9.81}
coordinates: {r: {initial: 1}, th: {initial: 1.57}}
lagrangian: (M + m)*r_dot**2/2 + m*r**2*th_dot**2/2 - M*g*r + m*g*r*cos(th)
""",
    "anharmonic, coupled": """
coordinates: {x: {initial: 1.1}, y: {initial: 0.4, velocity: 0.3}}
lagrangian: (x_dot**2 + y_dot**2)/2 - x**2/2 - y**2 - exp(-x*y)/3 - x**4/10
""",
    "driven, damped double well": """
parameters: {w: 0.9, a: 0.25, c: 0.1}
coordinates: {x: {initial: 1.2, velocity: 0.1}}
lagrangian: x_dot**2/2 + x**2/2 - x**4/4 + a*x*cos(w*t)
dissipation: c*x_dot**2/2
""",
    "three bodies": """
coordinates:
  a: {initial: 1}
  b: {initial: 0.1, velocity: 0.4}
  c: {initial: -1, velocity: 0.1}
  d: {initial: 0, velocity: -0.5}
  e: {initial: 0.1}
  f: {initial: 0.9, velocity: 0.1}
lagrangian: >-
  (a_dot**2 + b_dot**2 + c_dot**2 + d_dot**2)/2 + (e_dot**2 + f_dot**2)/4
  + 1/sqrt((a - c)**2 + (b - d)**2)
  + 0.5/sqrt((a - e)**2 + (b - f)**2) + 0.5/sqrt((c - e)**2 + (d - f)**2)
""",
    "x^2 y^2": """
coordinates: {x: {initial: 0.9}, y: {initial: 0.2, velocity: 0.7}}
lagrangian: (x_dot**2 + y_dot**2)/2 - x**2*y**2/2 - (x**2 + y**2)/20
""",
    "pendulum on a cart": """
parameters: {M: 2, m: 1, l: 0.8, g: 9.81, k: 3}
coordinates: {x: {initial: 0.3}, th: {initial: 2.2}}
lagrangian: (M + m)*x_dot**2/2 + m*l*x_dot*th_dot*cos(th) + m*l**2*th_dot**2/2 + m*g*l*cos(th) - k*x**2/2
""",
    "Stormer's charge": """
coordinates: {r: {initial: 1.2}, z: {initial: 0.1, velocity: 0.35}}
lagrangian: (r_dot**2 + z_dot**2)/2 - (1/r - r/(r**2 + z**2)**1.5)**2/2
""",
    "Kapitza's pendulum": """
parameters: {w: 37, a: 0.11, g: 9.81}
coordinates: {th: {initial: 2.9}}
lagrangian: th_dot**2/2 + (g - a*w**2*cos(w*t))*cos(th)
""",
}
