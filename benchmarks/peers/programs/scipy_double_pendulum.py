"""Ten seconds of the double pendulum with sympy and scipy, at the tightest tolerance of DOP853, to HDF5."""

import h5py
import numpy as np
import sympy
from scipy.integrate import solve_ivp
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

g, t = 9.81, dynamicsymbols._t
q, v = dynamicsymbols("q:2"), dynamicsymbols("q:2", 1)
x1, y1 = sympy.sin(q[0]), -sympy.cos(q[0])
x2, y2 = x1 + sympy.sin(q[1]), y1 - sympy.cos(q[1])
kinetic = sum(each.diff(t) ** 2 for each in (x1, y1, x2, y2)) / 2
potential = g * (y1 + y2)
method = LagrangesMethod(kinetic - potential, q)
method.form_lagranges_equations()
state = sympy.symbols("s:4")
named = dict(zip([*v, *q], [*state[2:], *state[:2]]))
rates = [sympy.simplify(rate).subs(named) for rate in method.rhs()]
momenta = [(kinetic - potential).diff(rate) for rate in v]
diagnostics = [each.subs(named) for each in (*momenta, kinetic + potential)]
right_hand_side = sympy.lambdify([t, state], rates, "math", cse=True)
diagnose = sympy.lambdify([t, state], diagnostics, "numpy", cse=True)

times = np.linspace(0.0, 10.0, 1001)
solution = solve_ivp(
    right_hand_side,
    (0.0, 10.0),
    [2.0, 2.5, 0.0, 0.0],
    method="DOP853",
    t_eval=times,
    rtol=2.3e-14,
    atol=1e-14,
)
theta1, theta2, omega1, omega2 = solution.y
p1, p2, h = diagnose(solution.t, solution.y)
with h5py.File("scipy.h5", "w") as file:
    file["t"] = times
    file["q/theta1"], file["q/theta2"], file["v/theta1"], file["v/theta2"] = theta1, theta2, omega1, omega2
    file["diagnostics/p/theta1"], file["diagnostics/p/theta2"], file["diagnostics/h"] = p1, p2, h
