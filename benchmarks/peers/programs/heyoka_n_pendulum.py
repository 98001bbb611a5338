"""One second of a chain of N pendulums with heyoka, without caches; the argument is N."""

import sys

import h5py
import heyoka as hy
import numpy as np

count, g = int(sys.argv[1]), 9.81
hy.llvm_state.set_diskcache_enabled(False)
q = [hy.expression(f"q{i}") for i in range(count)]
v = [hy.expression(f"v{i}") for i in range(count)]
vx = vy = height = lagrangian = hy.expression(0.0)
for angle, rate in zip(q, v):
    vx, vy = vx + hy.cos(angle) * rate, vy + hy.sin(angle) * rate
    height = height - hy.cos(angle)
    lagrangian = lagrangian + 0.5 * (vx**2 + vy**2) - g * height
released = [2.0 + 0.1 * i for i in range(count)]
integrator = hy.taylor_adaptive(
    hy.lagrangian(lagrangian, q, v), [*released, *np.zeros(count)], compact_mode=True
)

t = np.linspace(0.0, 1.0, 101)
theta, omega = np.split(integrator.propagate_grid(t)[-1], 2, axis=1)
vx, vy = np.cumsum(np.cos(theta) * omega, axis=1), np.cumsum(np.sin(theta) * omega, axis=1)


# p is the sum over the bob and those that hang from it
px, py = (np.cumsum(each[:, ::-1], axis=1)[:, ::-1] for each in (vx, vy))
with h5py.File("n_pendulum.h5", "w") as file:
    file["t"], file["q/theta"], file["v/theta"] = t, theta, omega
    file["diagnostics/p/theta"] = np.cos(theta) * px + np.sin(theta) * py
    heights = -np.cumsum(np.cos(theta), axis=1)
    file["diagnostics/h"] = ((vx**2 + vy**2) / 2 + g * heights).sum(axis=1)
