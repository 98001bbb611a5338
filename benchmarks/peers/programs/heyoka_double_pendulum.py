"""Ten seconds of the double pendulum with heyoka, its compiled code cached on disk, to HDF5.

The equations are solved by hand; masses and lengths, which are 1, are omitted.
"""

import h5py
import heyoka as hy
import numpy as np

g = 9.81
q1, q2, v1, v2 = hy.make_vars("q1", "q2", "v1", "v2")
cosine, sine = hy.cos(q1 - q2), hy.sin(q1 - q2)
upper = -(v2**2) * sine - 2 * g * hy.sin(q1)
lower = v1**2 * sine - g * hy.sin(q2)
a1 = (upper - cosine * lower) / (2 - cosine**2)
a2 = (2 * lower - cosine * upper) / (2 - cosine**2)
integrator = hy.taylor_adaptive([(q1, v1), (q2, v2), (v1, a1), (v2, a2)], [2.0, 2.5, 0.0, 0.0])

t = np.linspace(0.0, 10.0, 1001)
theta1, theta2, omega1, omega2 = integrator.propagate_grid(t)[-1].T
coupling = np.cos(theta1 - theta2)
with h5py.File("heyoka.h5", "w") as file:
    file["t"] = t
    file["q/theta1"], file["q/theta2"], file["v/theta1"], file["v/theta2"] = theta1, theta2, omega1, omega2
    file["diagnostics/p/theta1"] = 2 * omega1 + coupling * omega2
    file["diagnostics/p/theta2"] = omega2 + coupling * omega1
    kinetic = omega1**2 + omega2**2 / 2 + coupling * omega1 * omega2
    file["diagnostics/h"] = kinetic - g * (2 * np.cos(theta1) + np.cos(theta2))
