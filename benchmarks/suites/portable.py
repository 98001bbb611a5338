"""The cost of ``--portable``: integration alone with portable programs, relative to plain ones.

Portable programs are compiled for this processor, and for the simplest x86-64, where C's fma is called.
"""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from statistics import median
from unittest.mock import patch

from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import in_turns, processor_seconds
from benchmarks.peers.lagrange import steps_of
from lagrange_cli.native.compilation import llvm as compiler

SLOWER = 1.5
"""The largest time of a portable run, relative to a plain one, on a processor with fma."""
SCENES = {
    "pendulum": 100.0, "double_pendulum": 60.0, "driven_damped_pendulum": 100.0,
    "central_force_cartesian": 100.0, "spherical_pendulum": 60.0, "fpu_chain": 100.0, "solar_system": 1000.0,
}  # fmt: skip
"""Shipped systems, with their own initial values, and stop times."""
PLAIN, PORTABLE, SIMPLEST = "plain", "portable", "portable, no fma"


@contextmanager
def simplest_processor() -> Iterator[None]:
    """Compile for one that can do no more than all of its kind."""
    with patch.object(compiler, "processor_name", lambda: ""), patch.object(compiler, "features", lambda: ""):
        yield


def measure(options: Namespace) -> Report:
    """Milliseconds of every motion, in turns (a short run many times in one turn)."""
    rows, required = [], []
    for name, stop in SCENES.items():
        engines = {PLAIN: steps_of(name, stop), PORTABLE: steps_of(name, stop, portable=True)}
        with simplest_processor():
            engines[SIMPLEST] = steps_of(name, stop, portable=True)
        tasks = {called: partial(processor_seconds, run) for called, run in engines.items()}
        times = {called: median(each) for called, each in in_turns(tasks, options.runs).items()}
        ratios = {called: each / times[PLAIN] for called, each in times.items()}
        figures = f"{1e3 * times[PLAIN]:.2f}", f"{ratios[PORTABLE]:.2f}", f"{ratios[SIMPLEST]:.1f}"
        rows.append((name, *figures))
        required.append(
            Requirement(f"{name}: time of portable relative to plain", ratios[PORTABLE], "<=", SLOWER)
        )
    heads = ("motion", "plain, ms", "portable / plain", "portable without fma / plain")
    return Report((markdown_table(heads, rows),), tuple(required))


SUITE = Suite("portable", measure, packages=("llvmlite", "numpy"), runs=7)

if __name__ == "__main__":
    sys.exit(SUITE.main())
