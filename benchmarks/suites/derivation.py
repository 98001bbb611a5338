"""The derivation of the equations of 2, 4 and 6 pendulums, by lagrange and by sympy's LagrangesMethod."""

from __future__ import annotations

import sys
from argparse import Namespace
from functools import partial
from statistics import median

from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import in_own_process, medians_in_turns, timed
from benchmarks.motions.motion import Motion, n_pendulum
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.mechanics.dalembert import from_embedding
from lagrange_cli.mechanics.derive import derive
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.build import build_model
from lagrange_cli.spec.read import read_spec

SIZES = (2, 4, 6)
SPEEDUP = 100
REPEATS = 5


def equations(motion: Motion) -> float:
    """Seconds from what is read of the file to the equations and the mass matrix in the formulation that is
    chosen for them, d'Alembert's: what sympy's derivation comes to. Nothing is kept between the repeats."""
    spec = read_spec(motion.text, motion.system, motion.sizes)
    assert derive(build_model(spec, GraphAlgebra())).formulation == "embedding"

    def form() -> object:
        model = build_model(spec, GraphAlgebra())
        return from_embedding(model, graph_of(model))

    return median(timed(form)[0] for _ in range(REPEATS))


def choice(motion: Motion) -> float:
    """The same with all that ``solve`` needs: the other formulations, which of them takes the fewest
    convolutions, what is cyclic and what is conserved."""
    spec = read_spec(motion.text, motion.system, motion.sizes)
    return median(timed(lambda: derive(build_model(spec, GraphAlgebra())))[0] for _ in range(REPEATS))


def sympys(motion: Motion) -> float:
    """Seconds to form Lagrange's equations and to take the mass matrix and the forcing from them: once, since
    sympy keeps what it has computed."""
    from benchmarks.peers.sympy import lagranges_equations

    def form() -> object:
        method = lagranges_equations(motion).method
        return method.mass_matrix, method.forcing

    return timed(form)[0]


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


SUITE = Suite("derivation", measure, packages=("sympy",), runs=5)

if __name__ == "__main__":
    sys.exit(SUITE.main())
