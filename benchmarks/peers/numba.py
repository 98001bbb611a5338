"""What one writes by hand for a large system: accelerations in numba, and DOP853 around them.

Two programs of that kind: scipy's own DOP853, and its steps (E. Hairer, S. P. Norsett and G. Wanner, Solving
Ordinary Differential Equations I, sec. II.10) compiled as well, in which stages are sums over pieces of the
state that fit the cache.
"""

from __future__ import annotations

from collections.abc import Callable

import numba
import numpy as np
from scipy.integrate import DOP853
from scipy.integrate._ivp import dop853_coefficients as tableau

from benchmarks.harness.turns import timed_by_both
from benchmarks.motions.lattices import Lattice
from benchmarks.peers import Array, Course, Engine

PIECE = 2048
"""Numbers of a state that are worked on at once."""
STAGES, EVERY = tableau.N_STAGES, tableau.N_STAGES + 1
A = np.ascontiguousarray(tableau.A[:EVERY, :EVERY])
E3, E5 = np.ascontiguousarray(tableau.E3), np.ascontiguousarray(tableau.E5)
FINEST = 1e-13
"""The tolerance of the first step."""
SAFETY, LEAST, MOST = 0.9, 0.2, 10.0


def engine(lattice: Lattice, *, tolerance: float, by_scipy: bool = False) -> Engine:
    """The lattice, followed to its end alone; what is compiled is compiled before, for a short motion."""
    rates = RATES[lattice.system](lattice.shape)
    whole = by_scipy_itself if by_scipy else compiled
    _, seconds, follow = timed_by_both(lambda: ready(whole(rates, tolerance), lattice))
    return Engine(seconds, lambda state: follow(state, lattice.stop))


Follow = Callable[[Array, float], Course]


def ready(follow: Follow, lattice: Lattice) -> Follow:
    """The same, compiled."""
    follow(lattice.start(0), 1e-3)
    return follow


def by_scipy_itself(rates: Callable[[float, Array], Array], tolerance: float) -> Follow:
    """scipy's solver."""

    def follow(state: Array, stop: float) -> Course:
        solver, steps = DOP853(rates, 0.0, state, stop, rtol=tolerance, atol=tolerance), 0
        while solver.status == "running":
            solver.step()
            steps += 1
        return Course(solver.y[:, None], steps)

    return follow


def compiled(rates: Callable[[float, Array], Array], tolerance: float) -> Follow:
    """The same steps, but for the first one, in numba."""

    def follow(state: Array, stop: float) -> Course:
        first = DOP853(rates, 0.0, state, stop, rtol=FINEST, atol=FINEST).h_abs
        end, steps = steps_of(rates, state, stop, tolerance, min(first, stop))
        return Course(end[:, None], steps)

    return follow


@numba.njit(fastmath=True, boundscheck=False)
def added(y: Array, k: Array, weights: Array, h: float, out: Array) -> None:
    """out = y + h * weights . k, piece by piece."""
    used = np.flatnonzero(weights)
    for first in range(0, len(y), PIECE):
        last = min(first + PIECE, len(y))
        piece = out[first:last]
        piece[:] = y[first:last]
        for j in used:
            factor, row = h * weights[j], k[j, first:last]
            for i in range(last - first):
                piece[i] += factor * row[i]


@numba.njit(fastmath=True, boundscheck=False)
def error_of(y: Array, end: Array, k: Array, h: float, tolerance: float) -> float:
    """The error of a step over what is allowed."""
    fifth, third = 0.0, 0.0
    five, three = np.empty(PIECE), np.empty(PIECE)
    for first in range(0, len(y), PIECE):
        count = min(PIECE, len(y) - first)
        five[:], three[:] = 0.0, 0.0
        for j in range(STAGES + 1):
            if E5[j] != 0.0 or E3[j] != 0.0:
                row = k[j, first : first + count]
                for i in range(count):
                    five[i] += E5[j] * row[i]
                    three[i] += E3[j] * row[i]
        for i in range(count):
            scale = 1.0 / (tolerance * (1.0 + max(abs(y[first + i]), abs(end[first + i]))))
            fifth += (five[i] * scale) ** 2
            third += (three[i] * scale) ** 2
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return h * fifth / np.sqrt((fifth + 0.01 * third) * len(y))


@numba.njit
def steps_of(rates, state, stop, tolerance, h):
    """The state at ``stop``, and the number of steps that are accepted."""
    k, stage, y = np.empty((STAGES + 1, len(state))), np.empty_like(state), state.copy()
    t, steps, refused = 0.0, 0, False
    k[0] = rates(t, y)
    while t < stop:
        h = min(h, stop - t)
        for s in range(1, STAGES):
            added(y, k, A[s], h, stage)
            k[s] = rates(t, stage)
        added(y, k, A[STAGES], h, stage)
        k[STAGES] = rates(t + h, stage)
        error = error_of(y, stage, k, h, tolerance)
        factor = MOST if error == 0.0 else SAFETY * error ** (-1 / 8)
        if error < 1.0:
            t = stop if h == stop - t else t + h
            y, stage = stage, y
            k[0] = k[STAGES]
            steps += 1
            h *= min(1.0 if refused else MOST, factor)
            refused = False
        else:
            h *= max(LEAST, factor)
            refused = True
    return y, steps


def chain(shape: tuple[int, ...]) -> Callable[[float, Array], Array]:
    """Beads between two walls."""

    @numba.njit(fastmath=True, boundscheck=False)
    def rates(t, state):
        n = len(state) // 2
        found = np.empty_like(state)
        found[:n] = state[n:]
        for i in range(1, n - 1):
            left, right = state[i] - state[i - 1], state[i + 1] - state[i]
            found[n + i] = (right - left) * (1.0 + 0.25 * (right + left))
        left, right = state[0], state[1] - state[0]
        found[n] = (right - left) * (1.0 + 0.25 * (right + left))
        left, right = state[n - 1] - state[n - 2], -state[n - 1]
        found[2 * n - 1] = (right - left) * (1.0 + 0.25 * (right + left))
        return found

    return rates


def pendulums(shape: tuple[int, ...]) -> Callable[[float, Array], Array]:
    """Pendulums on a torus."""
    rows, columns = shape

    @numba.njit(fastmath=True, boundscheck=False)
    def rates(t, state):
        n = rows * columns
        u, found = state[:n].reshape(rows, columns), np.empty_like(state)
        found[:n] = state[n:]
        force = found[n:].reshape(rows, columns)
        for i in range(rows):
            above, below = u[i - 1 if i else rows - 1], u[i + 1 if i + 1 < rows else 0]
            row, out = u[i], force[i]
            for j in range(1, columns - 1):
                out[j] = 2 * (row[j - 1] + row[j + 1] + above[j] + below[j] - 4 * row[j])
            for j, left, right in ((0, columns - 1, 1), (columns - 1, columns - 2, 0)):
                out[j] = 2 * (row[left] + row[right] + above[j] + below[j] - 4 * row[j])
            for j in range(columns):
                out[j] -= np.sin(row[j])
        return found

    return rates


RATES = {"fpu_chain": chain, "lattice": pendulums}
