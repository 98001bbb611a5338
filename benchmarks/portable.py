"""The cost of ``--portable``: integration alone with portable programs, relative to plain ones.

Portable programs are compiled for this processor, and for the simplest x86-64, where C's fma is called.
"""

from __future__ import annotations

import sys
import time
from argparse import Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from statistics import median
from unittest.mock import patch

import numpy as np

from benchmarks.benchmark import Benchmark
from benchmarks.report import ROOT, Report, Requirement, markdown_table
from lagrange_cli.cli.source import derive_system, read_system
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.methods.taylor import TaylorMethod
from lagrange_cli.integrate.program import write_run
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.compilation import llvm as compiler
from lagrange_cli.native.compilation.machine import compile_program
from lagrange_cli.native.functions.portable import portable
from lagrange_cli.records import replace
from lagrange_cli.spec.values import resolve_portable_values, resolve_values

SLOWER = 1.5
"""The largest time of a portable run, relative to a plain one, on a processor with fma."""
SHORTEST = 0.05
"""The least duration of a turn, in seconds."""
SCENES = {
    "pendulum": 100.0, "double_pendulum": 60.0, "driven_damped_pendulum": 100.0,
    "central_force_cartesian": 100.0, "spherical_pendulum": 60.0, "fpu_chain": 100.0, "solar_system": 1000.0,
}  # fmt: skip
"""Shipped systems, with their own initial values, and stop times."""
PLAIN, PORTABLE, SIMPLEST = "plain", "portable", "portable, no fma"
Run = Callable[[], int]
"""Integrates the motion and returns the number of steps."""


@contextmanager
def simplest_processor() -> Iterator[None]:
    """Compile for one that can do no more than all of its kind."""
    with patch.object(compiler, "processor_name", lambda: ""), patch.object(compiler, "features", lambda: ""):
        yield


def prepared(name: str, stop: float, *, own: bool) -> Run:
    """The integration of a shipped system, compiled before; ``own``: portably."""
    spec = read_system(str(ROOT / "systems" / f"{name}.yaml"))
    residual = derive_system(spec, portable=own)
    program, _ = write_run(residual, Compilation(method="taylor", tolerance=2.0**-52, outputs=frozenset()))
    method = TaylorMethod(compile_program(replace(program, text=portable(program.text)) if own else program))
    values = (resolve_portable_values if own else resolve_values)(spec)
    parameters = np.array([values.parameters[name] for name in program.parameters])
    state = np.concatenate([values.q, values.v, np.zeros(len(program.integrals))])

    def run() -> int:
        times = Times(0.0, stop, 2, stop)
        return method.follow(parameters, state, times, lambda t, x: None, lambda t: False).steps

    return run


def measure(options: Namespace) -> Report:
    """Milliseconds of every motion, in turns (a short run many times in one turn)."""
    rows, required = [], []
    for name, stop in SCENES.items():
        engines = {PLAIN: prepared(name, stop, own=False), PORTABLE: prepared(name, stop, own=True)}
        with simplest_processor():
            engines[SIMPLEST] = prepared(name, stop, own=True)
        seconds: dict[str, list[float]] = {called: [] for called in engines}
        for _ in range(options.runs):
            for called, run in engines.items():
                began, count = time.process_time(), 0
                while (spent := time.process_time() - began) < SHORTEST:
                    run()
                    count += 1
                seconds[called].append(spent / count)
        times = {called: median(each) for called, each in seconds.items()}
        ratios = {called: each / times[PLAIN] for called, each in times.items()}
        figures = f"{1e3 * times[PLAIN]:.2f}", f"{ratios[PORTABLE]:.2f}", f"{ratios[SIMPLEST]:.1f}"
        rows.append((name, *figures))
        required.append(
            Requirement(f"{name}: time of portable relative to plain", ratios[PORTABLE], "<=", SLOWER)
        )
    heads = ("motion", "plain, ms", "portable / plain", "portable without fma / plain")
    return Report((markdown_table(heads, rows),), tuple(required))


BENCHMARK = Benchmark("portable", measure, packages=("llvmlite", "numpy"), runs=7)

if __name__ == "__main__":
    sys.exit(BENCHMARK.main())
