"""The equations of the motions, written once for numpy, sympy and heyoka: T and U, and accelerations.

Every function takes the parameters, coordinates q, velocities v and an ``Algebra``. ``..._by_hand`` gives the
accelerations as one solves for them on paper. Masses and lengths of 1 are omitted.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import combinations
from operator import add
from typing import Any

Parameters = Mapping[str, Any]
Values = Sequence[Any]
"""Expressions, or arrays of numbers."""


@dataclass(frozen=True)
class Algebra:
    """Functions of an algebra, the sum of a list, and 1/2."""

    sin: Callable[[Any], Any]
    cos: Callable[[Any], Any]
    inverse_root: Callable[[Any], Any]
    total: Callable[[Sequence[Any]], Any]
    half: Any


Energies = Callable[[Parameters, Values, Values, Algebra], tuple[Any, Any]]
Accelerations = Callable[[Parameters, Values, Values, Algebra], list[Any]]


def plain_sum(terms: Sequence[Any]) -> Any:
    """One term after the other."""
    return reduce(add, terms)


def of_numpy() -> Algebra:
    """numpy, for numbers of any of its types."""
    import numpy as np

    return Algebra(np.sin, np.cos, lambda x: 1 / np.sqrt(x), plain_sum, 0.5)


def pendulums(p: Parameters, q: Values, v: Values, f: Algebra) -> tuple[Any, Any]:
    """Pendulums hung one from the other, all of mass 1 and length 1; angles from the downward vertical."""
    vx = vy = height = 0
    kinetic, heights = [], []
    for angle, rate in zip(q, v):
        vx, vy = vx + f.cos(angle) * rate, vy + f.sin(angle) * rate
        height = height - f.cos(angle)
        kinetic.append(f.half * (vx**2 + vy**2))
        heights.append(p["g"] * height)
    return f.total(kinetic), f.total(heights)


def pendulum_by_hand(p: Parameters, q: Values, v: Values, f: Algebra) -> list[Any]:
    """One pendulum."""
    return [-p["g"] * f.sin(q[0])]


def double_pendulum_by_hand(p: Parameters, q: Values, v: Values, f: Algebra) -> list[Any]:
    """2 a1 + c a2 = upper, c a1 + a2 = lower, solved by Cramer's rule."""
    cosine, sine = f.cos(q[0] - q[1]), f.sin(q[0] - q[1])
    upper = -(v[1] ** 2) * sine - 2 * p["g"] * f.sin(q[0])
    lower = v[0] ** 2 * sine - p["g"] * f.sin(q[1])
    determinant = 2 - cosine**2
    return [(upper - cosine * lower) / determinant, (2 * lower - cosine * upper) / determinant]


def hoop(p: Parameters, q: Values, v: Values, f: Algebra) -> tuple[Any, Any]:
    """A bead on a rotating hoop, in the frame that rotates with it, per m a^2."""
    squared, pull = p["omega"] ** 2, p["g"] / p["a"]
    return f.half * v[0] ** 2, -(f.half * squared * f.sin(q[0]) ** 2 + pull * f.cos(q[0]))


def hoop_by_hand(p: Parameters, q: Values, v: Values, f: Algebra) -> list[Any]:
    """The bead on the rotating hoop."""
    return [f.sin(q[0]) * (p["omega"] ** 2 * f.cos(q[0]) - p["g"] / p["a"])]


def henon_heiles(p: Parameters, q: Values, v: Values, f: Algebra) -> tuple[Any, Any]:
    """A star in the plane of a galaxy (M. Henon and C. Heiles 1964)."""
    x, y = q
    well = f.half * (x**2 + y**2) + x**2 * y - y**3 / 3
    return f.half * (v[0] ** 2 + v[1] ** 2), well


def henon_heiles_by_hand(p: Parameters, q: Values, v: Values, f: Algebra) -> list[Any]:
    """x'' = -x - 2 x y, y'' = -y - x^2 + y^2."""
    x, y = q
    return [-x - 2 * x * y, -y - x**2 + y**2]


def kepler_polar(p: Parameters, q: Values, v: Values, f: Algebra) -> tuple[Any, Any]:
    """A planet in polar coordinates r, theta, per unit of mass."""
    return f.half * (v[0] ** 2 + (q[0] * v[1]) ** 2), -p["mu"] / q[0]


def kepler_polar_by_hand(p: Parameters, q: Values, v: Values, f: Algebra) -> list[Any]:
    """r'' = r theta'^2 - mu/r^2, theta'' = -2 r' theta'/r."""
    return [q[0] * v[1] ** 2 - p["mu"] / q[0] ** 2, -2 * v[0] * v[1] / q[0]]


def kepler(p: Parameters, q: Values, v: Values, f: Algebra) -> tuple[Any, Any]:
    """A planet in Cartesian coordinates, per unit of mass."""
    distance = f.inverse_root(f.total([x**2 for x in q]))
    return f.half * f.total([rate**2 for rate in v]), -p["mu"] * distance


def kepler_by_hand(p: Parameters, q: Values, v: Values, f: Algebra) -> list[Any]:
    """The planet in Cartesian coordinates."""
    pull = -p["mu"] * f.total([x**2 for x in q]) ** -1.5
    return [pull * x for x in q]


def gravitation(p: Parameters) -> tuple[Any, list[Any]]:
    """The constant of gravity, and the masses, of a file of point masses."""
    masses = [value for name, value in p.items() if name.startswith("m[")]
    return p["G"] if "G" in p else p["k"] ** 2, masses


def point_masses(p: Parameters, q: Values, v: Values, f: Algebra) -> tuple[Any, Any]:
    """Point masses in their mutual gravity: q is all x, then all y, then, in space, all z."""
    constant, masses = gravitation(p)
    count = len(masses)
    kinetic = [f.half * masses[i % count] * rate**2 for i, rate in enumerate(v)]
    pulls = [
        constant
        * masses[i]
        * masses[j]
        * f.inverse_root(f.total([(a - b) ** 2 for a, b in zip(q[i::count], q[j::count])]))
        for i, j in combinations(range(count), 2)
    ]
    return f.total(kinetic), -f.total(pulls)


def point_masses_by_hand(p: Parameters, q: Values, v: Values, f: Algebra) -> list[Any]:
    """Newton's law, the distance of each pair computed once."""
    constant, masses = gravitation(p)
    count = len(masses)
    pulls: list[list[Any]] = [[] for _ in q]
    for i, j in combinations(range(count), 2):
        apart = [b - a for a, b in zip(q[i::count], q[j::count])]
        inverse = f.total([each**2 for each in apart]) ** -1.5
        for axis, each in enumerate(apart):
            pull = each * inverse
            pulls[axis * count + i].append(constant * masses[j] * pull)
            pulls[axis * count + j].append(-constant * masses[i] * pull)
    return [f.total(pull) for pull in pulls]
