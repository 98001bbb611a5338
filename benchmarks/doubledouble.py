"""Integration alone in double-double, in double precision, and in heyoka's quadruple precision.

Times are processor times: some runs are a thousand times as long as others, and other programs would disturb
them more often.
"""

from __future__ import annotations

import sys
import time
from argparse import Namespace
from collections.abc import Callable
from math import pi
from statistics import median
from typing import Any

import numpy as np

from benchmarks.benchmark import Benchmark
from benchmarks.motions import GRAVITY, double_pendulum_by_hand
from benchmarks.report import ROOT, Report, Requirement, markdown_table
from lagrange_cli.cli.source import derive_system, read_system
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.methods.taylor import TaylorMethod
from lagrange_cli.integrate.precision import DOUBLE, DOUBLE_DOUBLE
from lagrange_cli.integrate.program import write_run
from lagrange_cli.integrate.times import Times
from lagrange_cli.native.compilation.machine import compile_program
from lagrange_cli.spec.values import resolve_long_values, resolve_values

SLOWER = 60
"""The largest time of a run in double-double, relative to doubles."""
SHORTEST = 0.05
"""The least duration of a turn, in seconds."""
TOLERANCES = {DOUBLE: 2.0**-52, DOUBLE_DOUBLE: 2.0**-104}
OURS = {DOUBLE: "lagrange, double", DOUBLE_DOUBLE: "lagrange, double-double"}
HEYOKA = "heyoka, real128"
SCENES = {"pendulum": 100.0, "double_pendulum": 60.0, "central_force_cartesian": 100.0}
"""Shipped systems, with their own initial values, and stop times."""
Run = Callable[[], int]
"""Integrates the motion and returns the number of steps."""


def ours(name: str, stop: float, precision: str) -> Run:
    """Our integration of a shipped system, compiled before."""
    spec = read_system(str(ROOT / "systems" / f"{name}.yaml"))
    residual = derive_system(spec, exact=precision != DOUBLE)
    program, _ = write_run(
        residual,
        Compilation(
            method="taylor", tolerance=TOLERANCES[precision], outputs=frozenset(), precision=precision
        ),
    )
    method = TaylorMethod(compile_program(program))
    values = (resolve_values if precision == DOUBLE else resolve_long_values)(spec)
    parts = [values] if values.low is None else [values, values.low]
    parameters = np.array([one.parameters[name] for one in parts for name in program.parameters])
    held = np.zeros(len(program.integrals))
    state = np.concatenate([x for one in parts for x in (one.q, one.v, held)])

    def run() -> int:
        times = Times(0.0, stop, 2, stop)
        return method.follow(parameters, state, times, lambda t, x: None, lambda t: False).steps

    return run


def quadruple(name: str, stop: float) -> Run:
    """heyoka's, in quadruple precision with its own tolerance (1.9e-34)."""
    import heyoka as hy

    if name == "pendulum":
        q, v = hy.make_vars("q", "v")
        system, start = [(q, v), (v, -GRAVITY * hy.sin(q))], [170 * pi / 180, 0.0]
    elif name == "double_pendulum":
        a, b, va, vb = hy.make_vars("a", "b", "va", "vb")
        rates = double_pendulum_by_hand([a, b], [va, vb], hy)
        system, start = [(a, va), (b, vb), (va, rates[0]), (vb, rates[1])], [2.0, 2.5, 0.0, 0.0]
    else:
        x, y, vx, vy = hy.make_vars("x", "y", "vx", "vy")
        cube = (x**2 + y**2) ** -1.5
        system, start = [(x, vx), (y, vy), (vx, -x * cube), (vy, -y * cube)], [0.4, 0.0, 0.0, 2.0]
    begin = np.array(start, dtype=hy.real128)
    engine: Any = hy.taylor_adaptive(system, begin.copy(), fp_type=hy.real128)

    def run() -> int:
        engine.time = hy.real128(0)
        engine.state[:] = begin
        return int(engine.propagate_until(hy.real128(stop))[3])

    return run


def measure(options: Namespace) -> Report:
    """Milliseconds of every engine on every motion, in turns (a short run many times in one turn)."""
    rows, required = [], []
    for name, stop in SCENES.items():
        engines = {called: ours(name, stop, precision) for precision, called in OURS.items()}
        engines[HEYOKA] = quadruple(name, stop)
        seconds: dict[str, list[float]] = {called: [] for called in engines}
        steps: dict[str, int] = {}
        for _ in range(options.runs):
            for called, run in engines.items():
                began, count = time.process_time(), 0
                while (spent := time.process_time() - began) < SHORTEST:
                    steps[called] = run()
                    count += 1
                seconds[called].append(spent / count)
        plain = median(seconds[OURS[DOUBLE]])
        for called in engines:
            each, count = median(seconds[called]), steps[called]
            figures = f"{1e3 * each:.2f}", str(count), f"{1e6 * each / count:.1f}", f"{each / plain:.0f}"
            rows.append((name, called, *figures))
        ratio = median(seconds[OURS[DOUBLE_DOUBLE]]) / plain
        required.append(Requirement(f"{name}: time of double-double relative to double", ratio, "<=", SLOWER))
    heads = ("motion", "engine", "ms", "steps", "us per step", "relative to double")
    return Report((markdown_table(heads, rows),), tuple(required))


BENCHMARK = Benchmark("doubledouble", measure, packages=("llvmlite", "numpy", "heyoka"), runs=7)

if __name__ == "__main__":
    sys.exit(BENCHMARK.main())
