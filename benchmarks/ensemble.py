"""An ensemble: 10,000 double pendulums from nearby angles, 10 s each, to full double precision.

Both programs integrate several members at once in the lanes of a vector. The best mode of heyoka is not known
beforehand: it is measured with batches of four and of eight, and with its own threads. Only the final states
are computed.
"""

from __future__ import annotations

import sys
import time
from argparse import Namespace
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.benchmark import Benchmark
from benchmarks.problems import DOUBLE_PENDULUM
from benchmarks.report import Report, Requirement, markdown_table
from benchmarks.turns import in_own_process, in_turns, timed

Array = NDArray[np.float64]

PENDULUMS = replace(DOUBLE_PENDULUM, stop=10.0)
SPREAD = 0.1
"""Standard deviation of the angles (rad)."""
SPEEDUP = 1.5
TWO_CORES = 1.85
WARM = 64
"""Members that are followed before the clock starts."""
MEMBERS, FEWER = 10_000, 800
"""Multiples of 8."""


@dataclass(frozen=True)
class Measurement:
    """Seconds to prepare, of the wall's clock and of all processors, and what each member came to."""

    prepare: float
    wall: float
    processors: float
    steps: float
    energy_error: float


def initial_states(members: int) -> Array:
    """Angles and velocities of every member, shape (4, members)."""
    noise = np.random.default_rng(1).standard_normal((2, members))
    angles = np.array(PENDULUMS.values.q)[:, None] + SPREAD * noise
    return np.concatenate([angles, np.zeros((2, members))])


def measured(prepare: float, follow: Callable[[Array], tuple[Array, float]], members: int) -> Measurement:
    """The measurement of ``follow``, which takes initial states (4, members) to their ends and mean steps."""
    states = initial_states(members)
    follow(states[:, :WARM])
    began = time.process_time()
    wall, (ends, steps) = timed(lambda: follow(states))
    spent = time.process_time() - began
    parameters = PENDULUMS.values.parameters
    start, end = (PENDULUMS.energy(parameters, *np.split(each, 2)) for each in (states, ends))
    error = float(np.sqrt(np.mean((end / start - 1) ** 2)))
    return Measurement(prepare, wall, spent, steps, error)


def lagrange(threads: int, members: int) -> Measurement:
    """This project, as ``lagrange sweep`` uses it, without reading and writing files."""
    import lagrange_cli.native.compilation.llvm  # noqa: F401 - what prepare would import
    from lagrange_cli.expression.graph_algebra import GraphAlgebra
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.integrate.ensemble.method import Batch, Starts
    from lagrange_cli.integrate.methods.selection import ensemble_method
    from lagrange_cli.integrate.prepare import prepare
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.mechanics.derive import derive
    from lagrange_cli.model.build import build_model
    from lagrange_cli.spec.read import read_spec

    residual = derive(build_model(read_spec(PENDULUMS.text, PENDULUMS.system), GraphAlgebra()))
    seconds, prepared = timed(
        lambda: prepare(
            residual,
            Compilation(method="taylor", tolerance=2.0**-52, outputs=frozenset({"p", "h"}), ensemble=True),
        )
    )
    values = [*PENDULUMS.values.parameters.values()]
    method, times = (
        ensemble_method(prepared, lambda: prepared.follower),
        Times(0.0, PENDULUMS.stop, 2, PENDULUMS.stop),
    )

    def follow(states: Array) -> tuple[Array, float]:
        ends, steps = np.empty_like(states), np.empty(states.shape[1])

        def accept(batch: Batch) -> None:
            ends[:, batch.index], steps[batch.index] = batch.state.T, batch.steps

        parameters = np.tile(values, (states.shape[1], 1))
        method.follow(Starts(parameters, states.T, times, False), accept, lambda done: False, threads)
        return ends, float(steps.mean())

    return measured(seconds, follow, members)


def heyoka(batch: int, members: int, *, threads: int | None = None) -> Measurement:
    """heyoka's batches, one after the other or, with ``threads``, by its ``ensemble_propagate_until_batch``.

    Masses and lengths, which are 1, are left out of its equations, which were solved by hand.
    """
    import heyoka as hy

    from benchmarks.heyoka_equations import double_pendulum_by_hand

    hy.llvm_state.set_diskcache_enabled(False)
    system, zeros = double_pendulum_by_hand(PENDULUMS), np.zeros((4, batch))
    seconds, integrator = timed(lambda: hy.taylor_adaptive_batch(system, zeros, force_avx512=batch == 8))

    def load(one: Any, states: Array, first: int) -> Any:
        one.set_time(0.0)
        one.state[:] = states[:, first : first + batch]
        return one

    def follow(states: Array) -> tuple[Array, float]:
        ends, steps, starts = np.empty_like(states), [], range(0, states.shape[1], batch)
        if threads is None:
            for first in starts:
                load(integrator, states, first).propagate_until(PENDULUMS.stop)
                ends[:, first : first + batch] = integrator.state
                steps += [result[3] for result in integrator.propagate_res]
        else:
            followed = hy.ensemble_propagate_until_batch(
                integrator,
                PENDULUMS.stop,
                len(starts),
                lambda one, i: load(one, states, batch * i),
                max_workers=threads,
            )
            for first, (one, *_) in zip(starts, followed):
                ends[:, first : first + batch] = one.state
                steps += [result[3] for result in one.propagate_res]
        return ends, float(np.mean(steps))

    return measured(seconds, follow, members)


ONE, TWO = "lagrange, 1 thread", "lagrange, 2 threads"
CONTENDERS: dict[str, Callable[[int], Measurement]] = {
    ONE: partial(lagrange, 1),
    TWO: partial(lagrange, 2),
    "heyoka, batches of 4": partial(heyoka, 4),
    "heyoka, batches of 8": partial(heyoka, 8),
    "heyoka, ensemble of batches of 8, 2 threads": partial(heyoka, 8, threads=2),
}


def measure(options: Namespace) -> Report:
    """Every engine with every member."""
    members = FEWER if options.quick else MEMBERS
    tasks = {name: partial(in_own_process, each, members) for name, each in CONTENDERS.items()}
    results = in_turns(tasks, options.runs)

    def rate(name: str, clock: str) -> float:
        """Members per second of that clock."""
        return float(members / median(getattr(each, clock) for each in results[name]))

    best = max(rate(name, "processors") for name in CONTENDERS if name.startswith("heyoka"))
    rows = [
        (
            name,
            f"{1e3 * median(each.prepare for each in measurements):.0f}",
            f"{rate(name, 'processors'):.0f}",
            f"{rate(name, 'wall'):.0f}",
            f"{measurements[0].steps:.0f}",
            f"{measurements[0].energy_error:.1e}",
        )
        for name, measurements in results.items()
    ]
    head = ("", "prepare, ms", "members/s per core", "members/s", "steps per member", "energy error, rms")
    requirements = (
        Requirement(
            "members/s per core, relative to the best of heyoka",
            rate(ONE, "processors") / best,
            ">=",
            SPEEDUP,
        ),
        Requirement(
            "members/s of lagrange, 2 threads relative to 1",
            rate(TWO, "wall") / rate(ONE, "wall"),
            ">=",
            TWO_CORES,
        ),
    )
    return Report((markdown_table(head, rows),), requirements)


BENCHMARK = Benchmark(
    "ensemble",
    measure,
    packages=("llvmlite", "numpy", "heyoka"),
    runs=5,
    quick=f"{FEWER} members only",
)

if __name__ == "__main__":
    sys.exit(BENCHMARK.main())
