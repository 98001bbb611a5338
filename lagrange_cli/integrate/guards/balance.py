"""Which of many forces of friction hold what constraints bind together, all at once.

Let friction s_j D_j act on velocities u_j that are 0, where s_j is between -1 and 1. Times D, the rates of
these are D u' = g - Q s, where Q is symmetric and not negative. By Gauss's principle, the motion is that of
the least value of

    s Q s/2 - g s,    -1 <= s_j <= 1:

u_j' is 0 where s_j is between its bounds, and has its sign elsewhere (P. Loetstedt, SIAM J. Appl. Math. 42,
1982). All solutions have the same rates. Where friction can hold more than constraints leave free, Q is
singular, and forces may be shared in many ways. At a vertex of these solutions the columns of Q of all s_j
between the bounds are independent: what these hold determines the rest.

Active sets lead to a solution in finitely many steps (J. Nocedal and S. Wright, Numerical Optimization, 2nd
ed., sec. 16.5), and gradients with momentum near one (A. Beck and M. Teboulle, SIAM J. Imaging Sci. 2, 2009).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.arrays import Array

    Marks = NDArray[np.bool_]

GRADIENTS = 200
"""So many steps along gradients come first."""
CHANGES = 8
"""How often the set of free forces changes at most, for each of them."""
TRIES, ROOM = 8, 2.0**-8
"""How many vertices are looked at until all forces between the bounds have so much room."""
SINGULAR = 2.0**-36
"""An eigenvalue of Q that is this part of the largest one is 0."""
ROUNDED = 2.0**-40
"""A rate, or a coupling, that is so small beside its terms is a rounding error."""


def factors(slopes: Array) -> Array | None:
    """The D (n,) with which D times ``slopes`` (n, n) is symmetric: found from one force to the next, by what
    couples most. None where forces drive what they act on, as they do backward in time."""
    if not np.all(np.isfinite(slopes)) or not np.all(np.diag(slopes) < 0.0):
        return None
    own = np.sqrt(-np.diag(slopes))
    near = np.abs(slopes) / np.outer(own, own)
    found, couples = np.zeros(len(slopes)), np.zeros(len(slopes))
    by = np.zeros(len(slopes), dtype=np.intp)
    for _ in range(len(slopes)):
        k = int(np.argmax(np.where(found > 0.0, -1.0, couples)))
        across, back = abs(slopes[by[k], k]), abs(slopes[k, by[k]])
        coupled = couples[k] > ROUNDED and back > 0.0
        found[k] = found[by[k]] * across / back if coupled else 1.0 / own[k] ** 2
        nearer = near[k] > couples
        couples[nearer], by[nearer] = near[k][nearer], k
    return found


def balanced(matrix: Array, pushes: Array) -> Array | None:
    """A solution s (n,) for Q (n, n) and g (n,); None if it is not found."""
    s = near(matrix, pushes)
    least = ROUNDED * (np.abs(matrix).sum(axis=1) + np.abs(pushes))
    free = np.abs(s) < 1.0
    for _ in range(CHANGES * (len(s) + 1)):
        change, ends = newton(matrix, pushes - matrix @ s, free, least)
        farther = bounded(s, change) if change.any() else None
        if farther is not None and (not ends or farther[2] < 1.0):
            s, first, _ = farther
            free[first] = False
            continue
        if not ends:
            return None
        s = np.clip(s + change, -1.0, 1.0)
        back = np.where(free, 0.0, -s * (pushes - matrix @ s)) - least
        if not np.any(back > 0.0):
            return s
        free[int(np.argmax(back))] = True
    return None


def near(matrix: Array, pushes: Array) -> Array:
    """Near a solution."""
    size = float(np.linalg.norm(matrix, 2)) if matrix.size else 0.0
    s = ahead = np.zeros(len(pushes))
    momentum = 1.0
    for _ in range(GRADIENTS if size > 0.0 else 0):
        found = np.clip(ahead + (pushes - matrix @ ahead) / size, -1.0, 1.0)
        if (ahead - found) @ (found - s) > 0.0:
            momentum = 1.0
        following = (1.0 + (1.0 + 4.0 * momentum**2) ** 0.5) / 2.0
        ahead = found + (momentum - 1.0) / following * (found - s)
        s, momentum = found, following
    return s


def newton(matrix: Array, rest: Array, free: Marks, least: Array) -> tuple[Array, bool]:
    """The change of ``free`` forces after which nothing is left of the ``rest``, and True; or one along which
    the sum falls without end, and False."""
    change = np.zeros(len(rest))
    if not free.any():
        return change, True
    sizes, along = np.linalg.eigh(matrix[np.ix_(free, free)])
    singular = sizes <= SINGULAR * max(float(sizes[-1]), 0.0)
    parts = along.T @ rest[free]
    endless = along[:, singular] @ parts[singular]
    if np.any(np.abs(endless) > least[free]):
        change[free] = endless
        return change, False
    change[free] = along[:, ~singular] @ (parts[~singular] / sizes[~singular])
    return change, True


def bounded(s: Array, change: Array) -> tuple[Array, int, float]:
    """Forces changed until the first one is at a bound; which one that is, and after which part of the
    change."""
    with np.errstate(divide="ignore", invalid="ignore"):
        room = np.where(change > 0.0, 1.0 - s, -1.0 - s) / change
    room[change == 0.0] = np.inf
    first = int(np.argmin(room))
    part = max(float(room[first]), 0.0)
    found: Array = np.clip(s + part * change, -1.0, 1.0)
    found[first] = 1.0 if change[first] > 0.0 else -1.0
    return found, first, part


def vertex(matrix: Array, s: Array, still: Marks) -> Array:
    """A vertex of the solutions with the rates of ``s``, where some velocities are ``still`` 0: one where
    forces between the bounds have room, so that they do not reach these at once."""
    numbers = np.flatnonzero(still & (np.abs(s) < 1.0))
    if not len(numbers):
        return s
    sizes, along = np.linalg.eigh(matrix[np.ix_(numbers, numbers)])
    moves = along[:, sizes <= SINGULAR * max(float(sizes[-1]), 0.0)]
    source, most, best = np.random.default_rng(0), -1.0, s[numbers]
    for _ in range(TRIES):
        found = cornered(s[numbers], moves)
        size = np.abs(found)
        room = float((1.0 - size[size < 1.0]).min(initial=1.0))
        if room > most:
            most, best = room, found
        if most > ROOM or moves.shape[1] < 2:
            break
        moves = moves @ np.linalg.qr(source.standard_normal((moves.shape[1],) * 2))[0]
    changed: Array = s.copy()
    changed[numbers] = best
    return changed


def cornered(s: Array, moves: Array) -> Array:
    """Forces changed along all ``moves`` (n, m) until bounds end each, by the way that leaves others more
    room."""
    while moves.shape[1]:
        move = np.where(np.abs(moves[:, 0]) > ROUNDED * np.abs(moves[:, 0]).max(), moves[:, 0], 0.0)
        ends = [bounded(s, way)[:2] for way in (move, -move)]
        rooms = []
        for end, first in ends:
            others = np.flatnonzero(move)
            rooms.append(float((1.0 - np.abs(end[others[others != first]])).min(initial=1.0)))
        s, first = ends[int(rooms[1] > rooms[0])]
        moves = moves[:, 1:] - np.outer(moves[:, 0], moves[first, 1:] / moves[first, 0])
        moves[first] = 0.0
        lengths = np.linalg.norm(moves, axis=0)
        moves = moves / np.where(lengths > 0.0, lengths, 1.0)
    return s


def centred(matrix: Array, s: Array, still: Marks) -> Array:
    """A solution with the same rates in the middle between bounds, along each way in which forces may be
    shared by what is ``still``."""
    numbers = np.flatnonzero(still)
    if not len(numbers):
        return s
    sizes, along = np.linalg.eigh(matrix[np.ix_(numbers, numbers)])
    shares, found = s[numbers], np.array(s)
    for move in along[:, sizes <= SINGULAR * max(float(sizes[-1]), 0.0)].T:
        move = np.where(np.abs(move) > ROUNDED * np.abs(move).max(), move, 0.0)
        shares = (bounded(shares, move)[0] + bounded(shares, -move)[0]) / 2.0
    found[numbers] = shares
    return found


def independent(matrix: Array, room: Array) -> Marks:
    """Which forces to hold, of those with ``room`` until a bound: as many as are independent, those first
    that move much and have much of it (elimination with pivots)."""
    left, held = matrix.copy(), np.zeros(len(room), dtype=np.bool_)
    own = np.diag(matrix)
    for _ in range(len(room)):
        rest = np.where((room > 0.0) & ~held & (np.diag(left) > SINGULAR * own), np.diag(left), 0.0)
        k = int(np.argmax(rest * room))
        if not rest[k] * room[k] > 0.0:
            break
        held[k] = True
        left -= np.outer(left[:, k], left[k]) / left[k, k]
    return held


def determined(matrix: Array, held: Marks) -> Marks:
    """Which velocities stay 0 with those that are ``held``, as they follow from these."""
    found: Marks = held.copy()
    if held.any() and not held.all():
        own, across, sizes = matrix[np.ix_(held, held)], matrix[np.ix_(held, ~held)], np.diag(matrix)[~held]
        left = sizes - np.sum(across * np.linalg.lstsq(own, across, rcond=None)[0], axis=0)
        found[~held] = left <= SINGULAR * sizes
    return found
