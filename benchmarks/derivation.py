"""The derivation of 2, 4 and 6 pendulums hung one from the other: ours, and sympy's LagrangesMethod."""

from __future__ import annotations

import sys
from argparse import Namespace
from functools import partial
from statistics import median

from benchmarks.benchmark import Benchmark
from benchmarks.problems import Problem, n_pendulum
from benchmarks.report import Report, Requirement, markdown_table
from benchmarks.scipy_engines import pendulums_in_sympy
from benchmarks.turns import in_own_process, medians_in_turns, timed

SIZES = (2, 4, 6)
SPEEDUP = 100
REPEATS = 5


def ours(problem: Problem) -> float:
    """Seconds from what is read of the file to equations that can be compiled; nothing is kept between the
    repeats."""
    from lagrange_cli.expression.graph import GraphAlgebra
    from lagrange_cli.mechanics.derive import derive
    from lagrange_cli.model.build import build_model
    from lagrange_cli.spec.read import read_spec

    spec = read_spec(problem.text, problem.system, problem.sizes)
    return median(timed(lambda: derive(build_model(spec, GraphAlgebra())))[0] for _ in range(REPEATS))


def sympys(problem: Problem) -> float:
    """Seconds to form Lagrange's equations and to take the mass matrix and the forcing from them: once, since
    sympy keeps what it has computed."""
    import sympy.physics.mechanics  # noqa: F401 - before the clock starts

    def derive() -> object:
        method, _, _ = pendulums_in_sympy(problem, problem.values.parameters["g"])
        return method.mass_matrix, method.forcing

    return timed(derive)[0]


def measure(options: Namespace) -> Report:
    """Both, for every size, each in a process of its own."""
    tasks = {
        (who, size): partial(in_own_process, who, n_pendulum(size, 1.0))
        for size in SIZES
        for who in (ours, sympys)
    }
    seconds = medians_in_turns(tasks, options.runs)
    ratios = {size: seconds[sympys, size] / seconds[ours, size] for size in SIZES}
    rows = [
        (str(size), f"{1e3 * seconds[ours, size]:.1f}", f"{1e3 * seconds[sympys, size]:.0f}", f"{ratio:.0f}")
        for size, ratio in ratios.items()
    ]
    return Report(
        (markdown_table(("N", "lagrange, ms", "sympy LagrangesMethod, ms", "times ours"), rows),),
        tuple(
            Requirement(f"N = {size}: sympy's derivation over ours", ratio, ">=", SPEEDUP)
            for size, ratio in ratios.items()
        ),
    )


BENCHMARK = Benchmark("derivation", measure, packages=("sympy",), runs=5)

if __name__ == "__main__":
    sys.exit(BENCHMARK.main())
