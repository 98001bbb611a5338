"""The derivation of the equations of 2, 4 and 6 pendulums, by lagrange and by sympy's LagrangesMethod."""

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


def equations(problem: Problem) -> float:
    """Seconds from what is read of the file to the equations and the mass matrix in the formulation that is
    chosen for them, d'Alembert's: what sympy's derivation comes to. Nothing is kept between the repeats."""
    from lagrange_cli.expression.graph_algebra import GraphAlgebra
    from lagrange_cli.mechanics.derive import derive, from_embedding
    from lagrange_cli.mechanics.variables import graph_of
    from lagrange_cli.model.build import build_model
    from lagrange_cli.spec.read import read_spec

    spec = read_spec(problem.text, problem.system, problem.sizes)
    assert derive(build_model(spec, GraphAlgebra())).formulation == "embedding"

    def form() -> object:
        model = build_model(spec, GraphAlgebra())
        return from_embedding(model, graph_of(model))

    return median(timed(form)[0] for _ in range(REPEATS))


def choice(problem: Problem) -> float:
    """The same with all that ``solve`` needs: the other formulations, which of them takes the fewest
    convolutions, what is cyclic and what is conserved."""
    from lagrange_cli.expression.graph_algebra import GraphAlgebra
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
    """All for every size, each in a process of its own."""
    tasks = {
        (who, size): partial(in_own_process, who, n_pendulum(size, 1.0))
        for size in SIZES
        for who in (equations, choice, sympys)
    }
    seconds = medians_in_turns(tasks, options.runs)
    rows = []
    for size in SIZES:
        ours, chosen, theirs = (seconds[who, size] for who in (equations, choice, sympys))
        times = [f"{1e3 * each:.1f}" for each in (ours, chosen)]
        rows.append(
            (str(size), *times, f"{1e3 * theirs:.0f}", f"{theirs / ours:.0f}", f"{theirs / chosen:.0f}")
        )
    head = (
        "N",
        "equations, ms",
        "full derivation, ms",
        "sympy LagrangesMethod, ms",
        "sympy / equations",
        "sympy / full derivation",
    )
    return Report(
        (markdown_table(head, rows),),
        tuple(
            Requirement(
                f"N = {size}: time of sympy relative to lagrange, equations and mass matrix",
                seconds[sympys, size] / seconds[equations, size],
                ">=",
                SPEEDUP,
            )
            for size in SIZES
        ),
    )


BENCHMARK = Benchmark("derivation", measure, packages=("sympy",), runs=5)

if __name__ == "__main__":
    sys.exit(BENCHMARK.main())
