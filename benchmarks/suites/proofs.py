"""What it costs to prove steps where forces are narrow functions of small differences: integration alone.

heyoka proves nothing. Errors are the largest ones of q at the end, relative to a motion in double-double.
"""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median

import numpy as np

from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import in_own_process, processor_seconds
from benchmarks.motions.cancelling import MOTIONS, Cancelling
from benchmarks.motions.motion import Array

PROVEN, UNPROVEN, HEYOKA = "lagrange", "lagrange, steps that are not proven", "heyoka"
PROGRAMS = PROVEN, UNPROVEN, HEYOKA
STEPS = 4.0
"""How many times as many steps may be taken as without proofs."""


@dataclass(frozen=True)
class Figures:
    """Steps, processor seconds, and q at the end."""

    steps: int
    run: float
    end: Array


Run = Callable[[], "tuple[int, Array]"]
"""A motion: the number of steps, and q at the end."""


def lagrange(motion: Cancelling, *, unproven: bool = False, double: bool = True) -> Run:
    """This project, without samples between."""
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.integrate.method import Start
    from lagrange_cli.integrate.precision import DOUBLE, DOUBLE_DOUBLE, FULL_DOUBLE_DOUBLE, FULL_PRECISION
    from lagrange_cli.integrate.prepare import prepare_system
    from lagrange_cli.integrate.times import Times
    from lagrange_cli.run.derive import derive_system
    from lagrange_cli.spec.read import read_spec
    from lagrange_cli.spec.values import resolve_long_values, resolve_values

    spec = read_spec(motion.text, "motion")
    precision, tolerance = (DOUBLE, FULL_PRECISION) if double else (DOUBLE_DOUBLE, FULL_DOUBLE_DOUBLE)
    proven = motion.proven and not unproven
    asked = Compilation(
        "taylor", tolerance, frozenset(), unproven=unproven, proven=proven, precision=precision
    )
    prepared = prepare_system(spec, derive_system, None, asked)
    values = (resolve_values if double else resolve_long_values)(spec)
    times = Times(0.0, motion.stop, 2, motion.stop)
    start = Start.of(prepared.machine.program, values, times)

    def run() -> tuple[int, Array]:
        end = prepared.follower.follow(start)
        if end.ending.status != "complete":
            raise RuntimeError(end.ending.name)
        return end.steps, end.state[: len(values.q)]

    return run


def heyoka(motion: Cancelling) -> Run:
    """heyoka on the equations that ``lagrange equations`` prints."""
    from benchmarks.motions.printed import printed_equations
    from benchmarks.peers import printed

    equations = printed_equations(motion.text, "motion", {})
    engine = printed("heyoka", equations, np.array([0.0, motion.stop]))

    def run() -> tuple[int, Array]:
        course = engine.follow(equations.initial)
        return int(course.steps), course.states[: len(equations.q), -1]

    return run


def figures(program: str, name: str, runs: int) -> Figures:
    """Those of a program: the median time of the runs."""
    motion = MOTIONS[name]
    run = heyoka(motion) if program == HEYOKA else lagrange(motion, unproven=program == UNPROVEN)
    steps, end = run()
    return Figures(steps, median(processor_seconds(run) for _ in range(runs)), end)


def reference(name: str) -> Array:
    """q at the end in double-double."""
    return lagrange(MOTIONS[name], double=False)()[1]


def measure(options: Namespace) -> Report:
    """Steps, milliseconds and errors of each motion."""
    rows, requirements = list[tuple[str, ...]](), list[Requirement]()
    for name in MOTIONS:
        exact = in_own_process(reference, name)
        programs = PROGRAMS[:2] if MOTIONS[name].loops else PROGRAMS
        found = {one: in_own_process(figures, one, name, options.runs) for one in programs}
        for one, figure in found.items():
            error = float(np.abs(figure.end - exact).max())
            rows.append((name, one, f"{figure.steps}", f"{1e3 * figure.run:.3g}", f"{error:.0e}"))
        proven, plain, *peers = found.values()
        steps = proven.steps / plain.steps
        requirements.append(Requirement(f"{name}: steps relative to unproven ones", steps, "<=", STEPS))
        requirements += [
            Requirement(f"{name}: time of unproven steps relative to heyoka", plain.run / peer.run, "<", 1.0)
            for peer in peers
        ]
    heads = "motion", "program", "steps", "ms", "error of q"
    return Report((markdown_table(heads, rows),), tuple(requirements))


SUITE = Suite("proofs", measure, packages=("llvmlite", "numpy", "heyoka"), runs=5)

if __name__ == "__main__":
    sys.exit(SUITE.main())
