"""The state nearest to a given one that satisfies the constraints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lagrange_cli.errors import SpecError
from lagrange_cli.records import replace
from lagrange_cli.spec.spec import Spec
from lagrange_cli.symbolic.direct import Bound, algebra_at, bindings
from lagrange_cli.symbolic.states import State

MOST_STEPS = 50
SETTLED = 1e-13
"""Newton's method has arrived where its step is as small as this beside the coordinates."""
DEPENDENT = 1e-9
"""Directions in which constraints change so little, relative to others, are none."""


def admissible(spec: Spec, state: State) -> State | None:
    """``state`` with coordinates, then velocities, projected onto the constraints of ``spec``; None where
    there is no such state that Newton's method finds."""
    if not spec.all_constraints:
        return state
    q, v = np.array(state.q), np.array(state.v)
    try:
        for _ in range(MOST_STEPS):
            holonomic = bound(spec, state, q, v)[: len(spec.constraints)]
            step = shortest(holonomic, [one.value for one in holonomic])
            q = q - step
            if np.abs(step).max(initial=0.0) <= SETTLED * (1.0 + np.abs(q).max()):
                break
        else:
            return None
        every = bound(spec, state, q, v)
        v = v - shortest(every, [one.speed for one in every])
        left = [one.speed for one in bound(spec, state, q, v)]
    except (ArithmeticError, ValueError, SpecError, np.linalg.LinAlgError):
        return None
    worst = max((abs(x) / (1.0 + np.abs(one.slopes).max()) for x, one in zip(left, every)), default=0.0)
    if not worst <= DEPENDENT * (1.0 + np.abs(v).max()):
        return None
    return replace(state, q=tuple(q.tolist()), v=tuple(v.tolist()))


def bound(spec: Spec, state: State, q: np.ndarray, v: np.ndarray) -> list[Bound]:
    """The constraints there."""
    rest = [0.0] * len(q)
    algebra = algebra_at(spec, state.parameters, state.t, q.tolist(), v.tolist(), rest)
    return bindings(spec, algebra, len(q))


def shortest(constraints: Sequence[Bound], values: Sequence[float]) -> np.ndarray:
    """The least x with slopes x = values; of no length where there are no constraints."""
    if not constraints:
        return np.zeros(1)
    slopes = np.array([one.slopes for one in constraints], dtype=float)
    found: np.ndarray = np.linalg.lstsq(slopes, np.array(values, dtype=float), rcond=DEPENDENT)[0]
    return found
