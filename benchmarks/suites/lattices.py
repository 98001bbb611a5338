"""Chains of 32 to 100,000 beads and lattices of up to 300 x 300 pendulums: integration alone, and errors.

All members have random velocities at the start. The error is the largest one of q and v at the end, relative
to the largest of these; the true motion is known to more digits (``benchmarks.motions.lattices``).
"""

from __future__ import annotations

import math
import sys
from argparse import Namespace
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import Any

import numpy as np

from benchmarks import peers
from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import in_own_process, in_turns, timed_by_both
from benchmarks.motions.lattices import Lattice

CASES = (
    Lattice("fpu_chain", (32,), 100.0),
    Lattice("fpu_chain", (1000,), 20.0),
    Lattice("fpu_chain", (10_000,), 10.0),
    Lattice("fpu_chain", (100_000,), 10.0),
    Lattice("lattice", (30, 30), 20.0),
    Lattice("lattice", (100, 100), 5.0),
    Lattice("lattice", (300, 300), 2.0),
)
OURS: dict[str, dict[str, Any]] = {
    "lagrange": {},
    "lagrange --tolerance 1e-10": {"tolerance": 1e-10},
    "lagrange --tolerance 1e-8": {"tolerance": 1e-8},
    "lagrange --tolerance 1e-6": {"tolerance": 1e-6},
}
PEERS: dict[str, dict[str, Any]] = {
    "DOP853 in numba, most accurate": {"tolerance": 1e-16},
    "DOP853 in numba, 1e-12": {"tolerance": 1e-12},
    "scipy DOP853, forces in numba, 1e-13": {"tolerance": 1e-13, "by_scipy": True},
}
FASTER, READY, BYTES = 5, 0.6, 200
"""What is required: how much faster, seconds to prepare, and bytes for each coordinate and order."""


@dataclass(frozen=True)
class Figures:
    """Processor seconds until an engine is ready and of a motion, its steps, its error, and the bytes that
    it works on for each coordinate and order, if they are known."""

    prepare: float
    run: float
    steps: float
    error: float
    bytes: float = math.nan


def ours(lattice: Lattice, **options: Any) -> peers.Engine:
    """This project: reading, deriving and compiling; then the integration, without samples between."""
    from benchmarks.peers.lagrange import large

    return large(lattice, **options)


def theirs(lattice: Lattice, **options: Any) -> peers.Engine:
    """What one writes by hand."""
    from benchmarks.peers.numba import engine

    return engine(lattice, **options)


def figures(make: Callable[[Lattice], peers.Engine], lattice: Lattice, runs: int) -> Figures:
    """Those of an engine: of the runs the median."""
    engine, start = make(lattice), lattice.start(0)
    results = [timed_by_both(lambda: engine.follow(start)) for _ in range(runs)]
    course, true = results[0][2], lattice.end(start)
    error = float(np.max(np.abs(course.states[:, -1] - true)) / np.max(np.abs(true)))
    return Figures(engine.prepare, median(one[1] for one in results), course.steps, error, engine.bytes)


def measure(options: Namespace) -> Report:
    """A table for each system; every engine in a process of its own."""
    parts, requirements = list[str](), list[Requirement]()
    for lattice in CASES[:2] if options.quick else CASES:
        makers = {name: partial(ours, **given) for name, given in OURS.items()}
        makers |= {name: partial(theirs, **given) for name, given in PEERS.items()}
        runs = max(1, min(options.runs, 200_000 // lattice.count))
        tasks = {name: partial(in_own_process, figures, make, lattice, runs) for name, make in makers.items()}
        found = {name: one[0] for name, one in in_turns(tasks, 1).items()}
        title = f"{' x '.join(map(str, lattice.shape))} {'beads' if len(lattice.shape) == 1 else 'pendulums'}"
        parts += [f"**{title}**, {lattice.stop:g} units of time:", table(found)]
        mine = found["lagrange"]
        requirements += [
            Requirement(
                f"{title}: time of {name}, relative to lagrange", found[name].run / best, ">=", FASTER
            )
            for name in PEERS
            for best in [fastest(found, found[name].error)]
        ]
        requirements += [
            Requirement(f"{title}: seconds to prepare", mine.prepare, "<=", READY),
            Requirement(f"{title}: bytes for each coordinate and order", mine.bytes, "<=", BYTES),
        ]
    return Report(tuple(parts), tuple(requirements))


def fastest(found: dict[str, Figures], error: float) -> float:
    """The time of lagrange's fastest run whose error is not larger than that of another program."""
    return min((found[name].run for name in OURS if found[name].error <= error), default=math.inf)


def table(found: dict[str, Figures]) -> str:
    """All figures of the engines."""
    rows = [
        (name, f"{one.prepare:.2f}", f"{1e3 * one.run:.2f}", f"{one.steps:.0f}", f"{one.error:.1e}")
        for name, one in found.items()
    ]
    return markdown_table(("", "prepare, s", "run, ms", "steps", "error"), rows)


SUITE = Suite(
    "lattices",
    measure,
    packages=("llvmlite", "numpy", "scipy", "numba"),
    runs=5,
    quick="chains of 32 and 1000 beads only",
)

if __name__ == "__main__":
    sys.exit(SUITE.main())
