"""Three motions for work-precision figures: each as a shipped system, as T and U, and solved by hand.

Other programs get the equations that one would write for them: masses, lengths and strengths of 1 are
omitted.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import pi
from typing import Any

GRAVITY = 9.81

Equations = list[tuple[Any, Any]]


@dataclass(frozen=True)
class Functions:
    """Those of an algebra, sympy's or heyoka's."""

    sin: Callable[[Any], Any]
    cos: Callable[[Any], Any]
    sqrt: Callable[[Any], Any]


@dataclass(frozen=True)
class System:
    """A shipped system from its own initial state to ``stop``; q is compared at ``known``, while it is known.

    ``energies`` gives T and U for coordinates, velocities and an algebra's functions; ``by_hand`` the
    accelerations, as one solves for them on paper.
    """

    name: str
    title: str
    span: str
    stop: float
    known_span: str
    known: float
    energies: Callable[[Sequence[Any], Sequence[Any], Functions], tuple[Any, Any]]
    by_hand: Callable[[Sequence[Any], Sequence[Any], Functions], list[Any]]


def double_pendulum(q: Sequence[Any], v: Sequence[Any], f: Functions) -> tuple[Any, Any]:
    """Two bobs, angles from the downward vertical."""
    vx = [f.cos(q[0]) * v[0], f.cos(q[0]) * v[0] + f.cos(q[1]) * v[1]]
    vy = [f.sin(q[0]) * v[0], f.sin(q[0]) * v[0] + f.sin(q[1]) * v[1]]
    kinetic = sum((0.5 * (x**2 + y**2) for x, y in zip(vx, vy)), start=vx[0] * 0)
    return kinetic, -GRAVITY * (2 * f.cos(q[0]) + f.cos(q[1]))


def double_pendulum_by_hand(q: Sequence[Any], v: Sequence[Any], f: Functions) -> list[Any]:
    """2 a1 + c a2 = upper, c a1 + a2 = lower, solved by Cramer's rule."""
    cosine, sine = f.cos(q[0] - q[1]), f.sin(q[0] - q[1])
    upper = -(v[1] ** 2) * sine - 2 * GRAVITY * f.sin(q[0])
    lower = v[0] ** 2 * sine - GRAVITY * f.sin(q[1])
    determinant = 2 - cosine**2
    return [(upper - cosine * lower) / determinant, (2 * lower - cosine * upper) / determinant]


def kepler(q: Sequence[Any], v: Sequence[Any], f: Functions) -> tuple[Any, Any]:
    """Polar coordinates r, theta."""
    return 0.5 * (v[0] ** 2 + q[0] ** 2 * v[1] ** 2), -1 / q[0]


def kepler_by_hand(q: Sequence[Any], v: Sequence[Any], f: Functions) -> list[Any]:
    """r'' = r theta'^2 - 1/r^2, theta'' = -2 r' theta'/r."""
    return [q[0] * v[1] ** 2 - 1 / q[0] ** 2, -2 * v[0] * v[1] / q[0]]


def three_bodies(q: Sequence[Any], v: Sequence[Any], f: Functions) -> tuple[Any, Any]:
    """Three equal masses in a plane: q is x of each, then y of each."""
    kinetic = sum((0.5 * rate**2 for rate in v[1:]), start=0.5 * v[0] ** 2)
    near = [1 / f.sqrt((q[i] - q[j]) ** 2 + (q[3 + i] - q[3 + j]) ** 2) for i, j in combinations(range(3), 2)]
    return kinetic, -(near[0] + near[1] + near[2])


def three_bodies_by_hand(q: Sequence[Any], v: Sequence[Any], f: Functions) -> list[Any]:
    """Newton's law: each pair's attraction is computed once."""
    accelerations = [q[0] * 0] * 6
    for i, j in combinations(range(3), 2):
        x, y = q[j] - q[i], q[3 + j] - q[3 + i]
        strength = (x * x + y * y) ** -1.5
        for body, sign in ((i, 1), (j, -1)):
            accelerations[body] += sign * strength * x
            accelerations[3 + body] += sign * strength * y
    return accelerations


SYSTEMS = (
    System(
        "double_pendulum", "Double pendulum", "100 s", 100.0, "8 s", 8.0,
        double_pendulum, double_pendulum_by_hand,
    ),
    System(
        "central_force", "Kepler, polar, e = 0.6", "100 periods", 200 * pi, "100 periods", 200 * pi,
        kepler, kepler_by_hand,
    ),
    System(
        "figure_eight", "Figure eight", "30 periods", 30 * 6.32591398, "30 periods", 30 * 6.32591398,
        three_bodies, three_bodies_by_hand,
    ),
)  # fmt: skip
"""A chaotic motion keeps its energy for long, but nobody knows for long where it is."""
