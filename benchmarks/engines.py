"""Engines that integrate a motion: from its description to machine code and to samples.

Every function prepares one engine, in the current process: call it in a process of its own, without warm
caches. Imports are done before the clock starts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.problems import Problem
from benchmarks.turns import timed

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """One run: the steps it took, and q and v (coordinates, n), the first sample at the start."""

    steps: int
    q: Array
    v: Array


@dataclass(frozen=True)
class Engine:
    """Seconds it took to prepare; and what follows the motion from q and v at the start."""

    prepare: float
    follow: Callable[[Array, Array], Motion]


def lagrange(problem: Problem, *, tolerance: float | None = None) -> Engine:
    """This project, as ``lagrange solve`` uses it: default outputs, nothing cached, and the default tolerance
    if none is given.

    Preparing reads the system file, derives and compiles; a run is all of ``integrate``, its samples
    and diagnostics included.
    """
    import lagrange_cli.integrate.methods.taylor
    import lagrange_cli.integrate.program
    import lagrange_cli.native.compilation.llvm  # noqa: F401 - what prepare would import
    from lagrange_cli.expression.graph_algebra import GraphAlgebra
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.integrate.precision import FULL_PRECISION
    from lagrange_cli.integrate.prepare import prepare
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.integrate.run import integrate
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.mechanics.derive import derive
    from lagrange_cli.model.build import build_model
    from lagrange_cli.run.settings import DEFAULT_OUTPUTS
    from lagrange_cli.spec.read import read_spec
    from lagrange_cli.spec.values import Values

    text, _ = problem.text, problem.values

    def make() -> Prepared:
        residual = derive(build_model(read_spec(text, problem.system, problem.sizes), GraphAlgebra()))
        wanted = FULL_PRECISION if tolerance is None else tolerance
        return prepare(
            residual, Compilation(method="taylor", tolerance=wanted, outputs=frozenset(DEFAULT_OUTPUTS))
        )

    seconds, prepared = timed(make)
    times = Times(0.0, problem.stop, len(problem.grid), problem.stop / (len(problem.grid) - 1))

    def follow(q: Array, v: Array) -> Motion:
        chunks: list[dict[str, Array]] = []

        def keep(chunk: dict[str, Array]) -> None:
            chunks.append({path: series.copy() for path, series in chunk.items()})

        start = Values(problem.values.parameters, tuple(q), tuple(v))
        outcome = integrate(prepared, start, times, keep, lambda: False)
        if outcome.ending.status != "complete":
            raise RuntimeError(outcome.message)
        states = {
            kind: np.concatenate(
                [
                    np.concatenate([chunk[path].reshape(len(chunk["t"]), -1) for path in paths], axis=1)
                    for chunk in chunks
                ]
            ).T
            for kind, paths in by_kind.items()
        }
        return Motion(outcome.steps, states["q"], states["v"])

    paths = [dataset.path for dataset in prepared.datasets]
    by_kind = {kind: [path for path in paths if path.startswith(f"{kind}/")] for kind in "qv"}
    return Engine(seconds, follow)


def heyoka(problem: Problem, *, equations: str, **mode: bool) -> Engine:
    """heyoka's Taylor method at its default tolerance, 2^-52, with its caches of compiled code off.

    Preparing is to write ``equations`` (a function of ``heyoka_equations``) and to construct
    ``taylor_adaptive``. Samples are taken by integrating up to each of them, which for motions as long as
    ours is faster than ``propagate_grid``.
    """
    import heyoka as hy

    from benchmarks import heyoka_equations

    hy.llvm_state.set_diskcache_enabled(False)
    hy.llvm_state.clear_memcache()
    initial = [*problem.values.q, *problem.values.v]
    write = getattr(heyoka_equations, equations)
    seconds, integrator = timed(lambda: hy.taylor_adaptive(write(problem), initial, **mode))
    grid = problem.grid

    def follow(q: Array, v: Array) -> Motion:
        integrator.time, integrator.state[:] = 0.0, [*q, *v]
        states, steps = [integrator.state.copy()], 0
        for t in grid[1:]:
            steps += integrator.propagate_until(t)[3]
            states.append(integrator.state.copy())
        return Motion(steps, *np.split(np.array(states).T, 2))

    return Engine(seconds, follow)


def exact_end(problem: Problem, equations: str, stop: float) -> Array:
    """q and v at ``stop`` from the problem's start, by heyoka in quadruple precision."""
    import heyoka as hy

    from benchmarks import heyoka_equations

    initial = [hy.real128(each) for each in (*problem.values.q, *problem.values.v)]
    integrator = hy.taylor_adaptive(
        getattr(heyoka_equations, equations)(problem), initial, fp_type=hy.real128, compact_mode=True
    )
    integrator.propagate_until(hy.real128(stop))
    return np.array([float(each) for each in integrator.state])
