"""Three ways to follow the pendulums, each from its description to its motion.

Every function measures its engine alone, in the process it is called in: call it in a process of its own.
Imports are done before the clock starts.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from typing import Any, TypeVar

import numpy as np

from benchmarks.pendulums import GRAVITY, SAMPLES, Pendulums

T = TypeVar("T")


@dataclass(frozen=True)
class Measurement:
    """Seconds to prepare and to integrate, the steps taken, and the largest relative energy error."""

    prepare: float
    run: float
    steps: int
    energy_error: float


def timed(function: Callable[[], T]) -> tuple[float, T]:
    """The seconds it takes, and what it returns."""
    began = time.perf_counter()
    result = function()
    return time.perf_counter() - began, result


def median_of_runs(function: Callable[[], T], repeats: int) -> tuple[float, T]:
    """The median of the seconds of ``repeats`` runs that all give the same; and what they give."""
    runs = [timed(function) for _ in range(repeats)]
    return median(seconds for seconds, _ in runs), runs[-1][1]


def lagrange(pendulums: Pendulums, repeats: int) -> Measurement:
    """This project, as ``lagrange solve`` uses it: default tolerance, default outputs, nothing cached.

    Preparing reads the system file, derives and compiles; a run is all of ``integrate``, its samples
    and diagnostics included.
    """
    import lagrange_cli.integrate.taylor
    import lagrange_cli.integrate.writing
    import lagrange_cli.native.compiler  # noqa: F401 - what prepare would import
    from lagrange_cli.cli.settings import DEFAULT_OUTPUTS, FULL_PRECISION
    from lagrange_cli.expression.graph import GraphAlgebra
    from lagrange_cli.integrate.prepare import prepare
    from lagrange_cli.integrate.run import Outcome, Prepared, Times, integrate
    from lagrange_cli.mechanics.derive import derive
    from lagrange_cli.model.build import build_model
    from lagrange_cli.spec.read import read_spec
    from lagrange_cli.spec.values import Values, resolve_values

    text = pendulums.system_file()

    def make() -> tuple[Prepared, Values]:
        spec = read_spec(text, "pendulums.yaml")
        residual = derive(build_model(spec, GraphAlgebra()))
        prepared = prepare(
            residual, method="taylor", tolerance=FULL_PRECISION, outputs=frozenset(DEFAULT_OUTPUTS)
        )
        return prepared, resolve_values(spec, {})

    seconds, (prepared, values) = timed(make)
    times = Times(0.0, pendulums.stop, SAMPLES, pendulums.stop / (SAMPLES - 1))
    chunks: list[dict[str, np.ndarray]] = []

    def keep(chunk: dict[str, np.ndarray]) -> None:
        chunks.append({path: series.copy() for path, series in chunk.items()})

    def follow() -> Outcome:
        chunks.clear()
        return integrate(prepared, values, times, keep, lambda: False)

    run, outcome = median_of_runs(follow, repeats)
    if outcome.ending.status != "complete":
        raise RuntimeError(outcome.message)
    series = {path: np.concatenate([chunk[path] for chunk in chunks]) for path in chunks[0]}
    q, v = (np.stack([series[f"{kind}/{name}"] for name in prepared.recording.coordinates]) for kind in "qv")
    return Measurement(seconds, run, outcome.steps, pendulums.energy_error(q, v))


def heyoka(
    pendulums: Pendulums,
    repeats: int,
    *,
    compact_mode: bool = False,
    equations: Callable[[Pendulums], list[tuple[Any, Any]]] | None = None,
) -> Measurement:
    """heyoka's Taylor method at its default tolerance, 2^-52, with its caches of compiled code off.

    Preparing is ``equations`` (by default those that ``lagrangian()`` derives) and the construction of
    ``taylor_adaptive``.
    """
    import heyoka as hy

    hy.llvm_state.set_diskcache_enabled(False)
    hy.llvm_state.clear_memcache()
    initial = [*pendulums.angles, *np.zeros(pendulums.count)]

    def make() -> hy.taylor_adaptive:
        system = (equations or equations_of_lagrangian)(pendulums)
        return hy.taylor_adaptive(system, initial, compact_mode=compact_mode)

    seconds, integrator = timed(make)

    def follow() -> tuple[int, np.ndarray]:
        integrator.time, integrator.state[:] = 0.0, initial
        *_, steps, _, states = integrator.propagate_grid(pendulums.grid)
        return steps, states

    run, (steps, states) = median_of_runs(follow, repeats)
    q, v = np.split(states.T, 2)
    return Measurement(seconds, run, steps, pendulums.energy_error(q, v))


def equations_of_lagrangian(pendulums: Pendulums) -> list[tuple[Any, Any]]:
    """heyoka's ``lagrangian()`` of the pendulums; masses and lengths are left out, since they are 1."""
    import heyoka as hy

    q = [hy.expression(f"q{i}") for i in range(pendulums.count)]
    v = [hy.expression(f"v{i}") for i in range(pendulums.count)]
    vx = vy = height = lagrangian = hy.expression(0.0)
    for angle, rate in zip(q, v):
        vx, vy = vx + hy.cos(angle) * rate, vy + hy.sin(angle) * rate
        height = height - hy.cos(angle)
        lagrangian = lagrangian + 0.5 * (vx**2 + vy**2) - GRAVITY * height
    derived: list[tuple[Any, Any]] = hy.lagrangian(lagrangian, q, v)
    return derived


def equations_by_hand(pendulums: Pendulums) -> list[tuple[Any, Any]]:
    """The explicit accelerations of two pendulums, solved by hand from the textbook's equations."""
    import heyoka as hy

    if pendulums.count != 2:
        raise ValueError("only the double pendulum has been solved by hand")
    q1, q2, v1, v2 = hy.make_vars("q1", "q2", "v1", "v2")
    cosine, sine = hy.cos(q1 - q2), hy.sin(q1 - q2)
    upper = -(v2**2) * sine - 2 * GRAVITY * hy.sin(q1)  # 2 a1 + a2 cosine
    lower = v1**2 * sine - GRAVITY * hy.sin(q2)  # a1 cosine + a2
    determinant = 2 - cosine**2
    a1 = (upper - cosine * lower) / determinant
    a2 = (2 * lower - cosine * upper) / determinant
    return [(q1, v1), (q2, v2), (v1, a1), (v2, a2)]


def sympy_and_scipy(pendulums: Pendulums) -> Measurement:
    """What one does without either: sympy derives, ``lambdify`` writes Python, scipy's DOP853 steps.

    Of the ways to call ``lambdify`` this is the fastest: simplified first, ``cse=True``, and the
    functions of ``math`` rather than numpy's, which are slow on single numbers. rtol = atol = 1e-12; the
    energy is compared at the method's own steps, not at interpolated ones.
    """
    import sympy
    from scipy.integrate import solve_ivp
    from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

    initial = [*pendulums.angles, *np.zeros(pendulums.count)]

    def make() -> Callable[..., list[float]]:
        q = dynamicsymbols(f"q:{pendulums.count}")
        v = dynamicsymbols(f"q:{pendulums.count}", 1)
        t = dynamicsymbols._t
        x = y = lagrangian = sympy.Integer(0)
        for angle in q:
            x, y = x + sympy.sin(angle), y - sympy.cos(angle)
            lagrangian += (x.diff(t) ** 2 + y.diff(t) ** 2) / 2 - GRAVITY * y
        method = LagrangesMethod(lagrangian, q)
        method.form_lagranges_equations()
        state = sympy.symbols(f"s:{2 * pendulums.count}")
        named = dict(zip([*v, *q], [*state[pendulums.count :], *state]))
        rates = [sympy.simplify(rate).subs(named) for rate in method.rhs()]
        made: Callable[..., list[float]] = sympy.lambdify([t, state], rates, "math", cse=True)
        return made

    seconds, right_hand_side = timed(make)
    run, solution = timed(
        lambda: solve_ivp(
            right_hand_side, (0.0, pendulums.stop), initial, method="DOP853", rtol=1e-12, atol=1e-12
        )
    )
    q, v = np.split(solution.y, 2)
    return Measurement(seconds, run, len(solution.t) - 1, pendulums.energy_error(q, v))
