"""Motions with constraints: this project, and SUNDIALS IDA and scipy on what sympy's LagrangesMethod derives.

sympy's equations are the linear system for q', q'' and lambda (of index 1: constraints are differentiated
twice), compiled by ``lambdify``. scipy solves it for the rates; IDA takes it as a residual.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
import sympy
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

from benchmarks.motions.constrained_motion import ConstrainedMotion
from benchmarks.peers import Array
from benchmarks.peers.scipy import solve
from lagrange_cli.expression.symbolic import SympyAlgebra
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.outcome import Outcome
from lagrange_cli.integrate.precision import DOUBLE, FULL_DOUBLE_DOUBLE, FULL_PRECISION
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.run import integrate
from lagrange_cli.integrate.times import Times
from lagrange_cli.model.build import build_model
from lagrange_cli.records import replace
from lagrange_cli.run.derive import derive_system
from lagrange_cli.run.start import consistent_values
from lagrange_cli.spec.values import resolve_long_values

MOST_STEPS = 10**6
Samples = dict[str, Array]


class Followed(NamedTuple):
    """The samples of a run by path, and how it went."""

    samples: Samples
    outcome: Outcome


class Ours:
    """This project: compiled at once, followed as often as one likes."""

    def __init__(
        self,
        motion: ConstrainedMotion,
        *,
        tolerance: float = FULL_PRECISION,
        outputs: tuple[str, ...] = ("q", "v"),
        precision: str = DOUBLE,
    ) -> None:
        exact = precision != DOUBLE
        self.motion = motion
        values = resolve_long_values(motion.spec) if exact else motion.values
        _, self.values, _ = consistent_values(motion.spec, values, 0.0, (), exact=exact)
        self.prepared = prepare_system(
            motion.spec,
            partial(derive_system, exact=exact),
            None,
            Compilation(
                "taylor", FULL_DOUBLE_DOUBLE if exact else tolerance, frozenset(outputs), precision=precision
            ),
        )

    def with_values(self, parameters: Mapping[str, float], v: tuple[float, ...]) -> Ours:
        """The same with other values of parameters, and other velocities."""
        other = copy(self)
        other.values = replace(self.values, parameters={**self.values.parameters, **parameters}, v=v)
        return other

    def until(self, stop: float) -> Ours:
        """The same, followed until another time."""
        other = copy(self)
        other.motion = ConstrainedMotion(self.motion.system, stop, self.motion.size)
        return other

    def follow(self, samples: int = 2) -> Followed:
        """To the end. Raises ``RuntimeError`` where it is not reached."""
        chunks: list[Samples] = []
        stop = self.motion.stop

        def keep(chunk: Samples) -> None:
            chunks.append({path: np.array(values) for path, values in chunk.items()})

        times = Times(0.0, stop, samples, stop / (samples - 1))
        outcome = integrate(self.prepared, self.values, times, keep, lambda: False)
        if outcome.ending.status != "complete":
            raise RuntimeError(outcome.message)
        return Followed({path: np.concatenate([one[path] for one in chunks]) for path in chunks[0]}, outcome)

    def end(self) -> Array:
        """q at the end."""
        samples = self.follow().samples
        paths = [path for path in samples if path.startswith("q/")]
        return np.concatenate([samples[path][-1].ravel() for path in paths])


class Derived(NamedTuple):
    """A x = b for x = (q', q'', lambda): A and b from t and (q, q'); and the state at the start."""

    system: Callable[[float, Array], tuple[Array, Array]]
    initial: Array
    size: int


@cache
def derived(motion: ConstrainedMotion) -> Derived:
    """What sympy derives from the Lagrangian and the constraints of the file."""
    model = build_model(motion.spec, SympyAlgebra())
    if model.lagrangian is not None:
        lagrangian = model.lagrangian
    else:
        kinetic = sum(one.mass * sum(v**2 for v in one.velocity) / 2 for one in model.particles)
        lagrangian = kinetic - model.potential
    size = len(model.q)
    q, v = dynamicsymbols(f"q:{size}"), dynamicsymbols(f"q:{size}", 1)
    moving = dict(zip([*model.q, *model.v], [*q, *v]))
    values = {symbol: motion.values.parameters[name] for name, symbol in model.parameters.items()}

    def along(expression: Any) -> Any:
        return sympy.sympify(expression).subs(values).subs(moving)

    method = LagrangesMethod(
        along(lagrangian),
        q,
        hol_coneqs=[along(one.expression) for one in model.constraints],
        forcelist=[],
        bodies=None,
    )
    method.form_lagranges_equations()
    state = sympy.symbols(f"s:{2 * size}")
    back = dict(zip([*v, *q], [*state[size:], *state[:size]]))
    forces = sympy.Matrix([0] * size + [*map(along, model.generalized_forces)] + [0] * len(model.constraints))
    right = (method.forcing_full + forces).subs(back)
    matrix, time = method.mass_matrix_full.subs(back), dynamicsymbols._t
    function = sympy.lambdify([time, state], [matrix, right], "numpy", cse=True)
    return Derived(function, np.array([*motion.values.q, *motion.values.v]), size)


def with_scipy(motion: ConstrainedMotion, method: str, tolerance: float) -> Array:
    """q at the end."""
    equations = derived(motion)
    size = equations.size

    def rates(t: float, y: Array) -> Array:
        matrix, right = equations.system(t, y)
        return np.asarray(np.linalg.solve(matrix, right)[: 2 * size, 0])

    span = (0.0, motion.stop)
    found = solve(rates, span, equations.initial, method=method, rtol=tolerance, atol=tolerance)
    if not found.success:
        raise RuntimeError(found.message)
    return np.asarray(found.y[:size, -1])


def with_ida(motion: ConstrainedMotion, tolerance: float) -> Array:
    """q at the end; the multipliers are not under control of the error."""
    from sksundae.ida import IDA

    equations = derived(motion)
    state = 2 * equations.size
    start = np.linalg.solve(*equations.system(0.0, equations.initial))[:, 0]
    multipliers = np.arange(state, len(start))

    def residual(t: float, y: Array, yp: Array, out: Array) -> None:
        x = np.concatenate([yp[:state], y[state:]])
        matrix, right = equations.system(t, y[:state])
        out[:] = matrix @ x - right[:, 0]

    allowed = np.full(len(start), tolerance)
    allowed[state:] = 1e10
    solver = IDA(residual, algebraic_idx=multipliers, rtol=tolerance, atol=allowed, max_num_steps=MOST_STEPS)
    rates = np.concatenate([start[:state], np.zeros(len(multipliers))])
    found = solver.solve(
        np.array([0.0, motion.stop]), np.concatenate([equations.initial, start[state:]]), rates
    )
    if not found.success:
        raise RuntimeError(found.message)
    return np.asarray(found.y[-1, : equations.size])
