"""The motions as a user of heyoka writes them: [(variable, rate), ...], first of q, then of v.

Numbers are constants, and masses and lengths of 1 are omitted, because heyoka runs faster this way.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations
from typing import Any

import heyoka as hy

from benchmarks.problems import Problem, gravitation

Equations = list[tuple[Any, Any]]
Writer = Callable[[Problem], Equations]


def variables(letter: str, count: int) -> list[Any]:
    """``count`` numbered variables."""
    return [hy.expression(f"{letter}{i}") for i in range(count)]


def of_lagrangian(lagrangian: Any, q: Sequence[Any], v: Sequence[Any]) -> Equations:
    """What heyoka derives."""
    derived: Equations = hy.lagrangian(lagrangian, q, v)
    return derived


def pendulums_derived(problem: Problem) -> Equations:
    """Pendulums hung one from the other, from their Lagrangian."""
    g, q, v = problem.values.parameters["g"], *states(problem)
    vx = vy = height = lagrangian = hy.expression(0.0)
    for angle, rate in zip(q, v):
        vx, vy = vx + hy.cos(angle) * rate, vy + hy.sin(angle) * rate
        height = height - hy.cos(angle)
        lagrangian = lagrangian + 0.5 * (vx**2 + vy**2) - g * height
    return of_lagrangian(lagrangian, q, v)


def states(problem: Problem) -> tuple[list[Any], list[Any]]:
    """The variables for q and for v."""
    count = len(problem.values.q)
    return variables("q", count), variables("v", count)


def double_pendulum_by_hand(problem: Problem) -> Equations:
    """The accelerations, solved by hand from the textbook's equations."""
    g, (q1, q2), (v1, v2) = problem.values.parameters["g"], *states(problem)
    cosine, sine = hy.cos(q1 - q2), hy.sin(q1 - q2)
    upper = -(v2**2) * sine - 2 * g * hy.sin(q1)  # 2 a1 + a2 cosine
    lower = v1**2 * sine - g * hy.sin(q2)  # a1 cosine + a2
    determinant = 2 - cosine**2
    a1 = (upper - cosine * lower) / determinant
    a2 = (2 * lower - cosine * upper) / determinant
    return [(q1, v1), (q2, v2), (v1, a1), (v2, a2)]


def hoop_constants(problem: Problem) -> tuple[float, float]:
    """omega^2 and g/a."""
    parameters = problem.values.parameters
    return parameters["omega"] ** 2, parameters["g"] / parameters["a"]


def hoop_derived(problem: Problem) -> Equations:
    """The bead on the turned hoop, from its Lagrangian (over m a^2; t has gone by hand)."""
    (squared, pull), (q,), (v,) = hoop_constants(problem), *states(problem)
    return of_lagrangian(0.5 * v**2 + 0.5 * squared * hy.sin(q) ** 2 + pull * hy.cos(q), [q], [v])


def hoop_by_hand(problem: Problem) -> Equations:
    """The bead on the turned hoop."""
    (squared, pull), (q,), (v,) = hoop_constants(problem), *states(problem)
    return [(q, v), (v, hy.sin(q) * (squared * hy.cos(q) - pull))]


def kepler_polar_derived(problem: Problem) -> Equations:
    """A planet in polar coordinates, from its Lagrangian per unit of mass."""
    mu, (r, theta), (u, w) = problem.values.parameters["mu"], *states(problem)
    return of_lagrangian(0.5 * (u**2 + (r * w) ** 2) + mu / r, [r, theta], [u, w])


def kepler_polar_by_hand(problem: Problem) -> Equations:
    """A planet in polar coordinates."""
    mu, (r, theta), (u, w) = problem.values.parameters["mu"], *states(problem)
    return [(r, u), (theta, w), (u, r * w**2 - mu / r**2), (w, -2 * u * w / r)]


def kepler_by_hand(problem: Problem) -> Equations:
    """A planet in Cartesian coordinates."""
    q, v = states(problem)
    pull = -problem.values.parameters["mu"] * hy.sum([x**2 for x in q]) ** -1.5
    return [*zip(q, v), *((rate, pull * x) for rate, x in zip(v, q))]


def point_masses_derived(problem: Problem) -> Equations:
    """Point masses in their mutual gravity, from their Lagrangian."""
    constant, masses = gravitation(problem.values.parameters)
    count, (q, v) = len(masses), states(problem)
    kinetic = hy.sum([0.5 * masses[i % count] * rate**2 for i, rate in enumerate(v)])
    pulls = [
        constant
        * masses[i]
        * masses[j]
        * hy.sum([(a - b) ** 2 for a, b in zip(q[i::count], q[j::count])]) ** -0.5
        for i, j in combinations(range(count), 2)
    ]
    return of_lagrangian(kinetic + hy.sum(pulls), q, v)


def point_masses_by_hand(problem: Problem) -> Equations:
    """Point masses in as many dimensions as they move in, the distance of each pair computed once."""
    constant, masses = gravitation(problem.values.parameters)
    count, (q, v) = len(masses), states(problem)
    pulls: list[list[Any]] = [[] for _ in q]
    for i, j in combinations(range(count), 2):
        apart = [b - a for a, b in zip(q[i::count], q[j::count])]
        inverse = hy.sum([each**2 for each in apart]) ** -1.5
        for axis, each in enumerate(apart):
            pull = each * inverse
            pulls[axis * count + i].append(constant * masses[j] * pull)
            pulls[axis * count + j].append(-constant * masses[i] * pull)
    return [*zip(q, v), *((rate, hy.sum(pull)) for rate, pull in zip(v, pulls))]


def point_masses_of_model(problem: Problem) -> Equations:
    """heyoka's own model of point masses, its states in our order."""
    constant, masses = gravitation(problem.values.parameters)
    rates = {
        str(variable): (variable, rate) for variable, rate in hy.model.nbody(len(masses), constant, masses)
    }
    order = [f"{kind}{axis}_{i}" for kind in ("", "v") for axis in "xyz" for i in range(len(masses))]
    return [rates[name] for name in order]
