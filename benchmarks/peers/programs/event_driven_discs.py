"""Elastic discs in a box, from impact to impact, with closed formulas in numpy. The arguments are the number
of discs, which is a square, and the time of the end. Prints the number of impacts, and the energy then."""

import sys

import numpy as np

count, stop = int(sys.argv[1]), float(sys.argv[2])
across, radius = round(count**0.5), 0.2
length = 0.5 * across
i = np.arange(count)
r = np.stack(
    [0.5 * (i % across) + 0.25 + 0.02 * np.sin(i), 0.5 * (i // across) + 0.25 + 0.03 * np.cos(i)], axis=1
)
v = np.stack([np.cos(7 * i * i + 1), np.sin(5 * i * i + 2)], axis=1)
since = np.zeros(count)
"""When each disc was at r: before its next impact it moves on straight."""


def meetings(k: int, now: float) -> np.ndarray:
    """When a disc meets each of the others."""
    dr = (r + v * (now - since)[:, None]) - (r[k] + v[k] * (now - since[k]))
    dv = v - v[k]
    b, c = np.sum(dr * dv, axis=1), np.sum(dr**2, axis=1) - 4.0 * radius**2
    inside = b**2 - np.sum(dv**2, axis=1) * c
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where((b < 0.0) & (inside >= 0.0), now + c / (-b + np.sqrt(inside)), np.inf)


def walls(k: int, now: float) -> tuple[float, int]:
    """When a disc comes to a wall, and along which axis."""
    place = r[k] + v[k] * (now - since[k])
    with np.errstate(divide="ignore"):
        times = now + np.where(v[k] > 0.0, length - radius - place, radius - place) / v[k]
    return float(np.min(times)), int(np.argmin(times))


pairs = np.array([meetings(k, 0.0) for k in range(count)])
first, partner = np.min(pairs, axis=1), np.argmin(pairs, axis=1)
at_wall = [walls(k, 0.0) for k in range(count)]
wall = np.array([time for time, _ in at_wall])
axis = [one for _, one in at_wall]
impacts = 0
while True:
    k, w = int(np.argmin(first)), int(np.argmin(wall))
    now = float(min(first[k], wall[w]))
    if now > stop:
        break
    impacts += 1
    changed = [w] if wall[w] < first[k] else [k, int(partner[k])]
    for one in changed:
        r[one] += v[one] * (now - since[one])
        since[one] = now
    if len(changed) == 1:
        v[w, axis[w]] *= -1.0
    else:
        a, b = changed
        dr = r[a] - r[b]
        push = (v[a] - v[b]) @ dr / (dr @ dr) * dr
        v[a] -= push
        v[b] += push
    stale = np.isin(partner, changed)
    for one in changed:
        pairs[one] = pairs[:, one] = meetings(one, now)
        wall[one], axis[one] = walls(one, now)
    for other in changed:  # they part from each other and from walls
        pairs[other, changed] = np.inf
        nearer = pairs[:, other] < first
        first[nearer], partner[nearer] = pairs[nearer, other], other
    for one in [*np.flatnonzero(stale), *changed]:
        first[one], partner[one] = np.min(pairs[one]), np.argmin(pairs[one])
print(impacts, 0.5 * np.sum(v**2))
