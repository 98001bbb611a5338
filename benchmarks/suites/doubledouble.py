"""Integration alone in double-double, in double precision, and in heyoka's quadruple precision.

Times are processor times: some runs are a thousand times as long as others, and other programs would disturb
them more often.
"""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from statistics import median

from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import in_turns, processor_seconds
from benchmarks.motions.motion import DOUBLE_PENDULUM, KEPLER, PENDULUM, Motion
from benchmarks.peers import engine
from benchmarks.peers.lagrange import steps_of
from lagrange_cli.integrate.precision import DOUBLE, DOUBLE_DOUBLE

SLOWER = 60
"""The largest time of a run in double-double, relative to doubles."""
OURS = {DOUBLE: "lagrange, double", DOUBLE_DOUBLE: "lagrange, double-double"}
HEYOKA = "heyoka, real128"
MOTIONS = tuple(
    replace(motion, samples=2) for motion in (PENDULUM, replace(DOUBLE_PENDULUM, stop=60.0), KEPLER)
)
Run = Callable[[], float]
"""Integrates the motion and returns the number of steps."""


def contenders(motion: Motion) -> dict[str, Run]:
    """Ours in both precisions, and heyoka at its own tolerance for quadruple precision (1.9e-34)."""
    made: dict[str, Run] = {
        called: steps_of(motion.system, motion.stop, precision=precision)
        for precision, called in OURS.items()
    }
    follow = engine("heyoka", motion, form="by hand", quadruple=True).follow
    made[HEYOKA] = lambda: follow(motion.initial).steps
    return made


def measure(options: Namespace) -> Report:
    """Milliseconds of every engine on every motion, in turns (a short run many times in one turn)."""
    rows, required = [], []
    for motion in MOTIONS:
        runs = contenders(motion)
        steps = {called: run() for called, run in runs.items()}
        turns = in_turns(
            {called: partial(processor_seconds, run) for called, run in runs.items()}, options.runs
        )
        seconds = {called: median(each) for called, each in turns.items()}
        plain = seconds[OURS[DOUBLE]]
        for called, each in seconds.items():
            count = steps[called]
            figures = f"{1e3 * each:.2f}", f"{count:.0f}", f"{1e6 * each / count:.1f}", f"{each / plain:.0f}"
            rows.append((motion.system, called, *figures))
        ratio = seconds[OURS[DOUBLE_DOUBLE]] / plain
        required.append(
            Requirement(f"{motion.system}: time of double-double relative to double", ratio, "<=", SLOWER)
        )
    heads = ("motion", "engine", "ms", "steps", "us per step", "relative to double")
    return Report((markdown_table(heads, rows),), tuple(required))


SUITE = Suite("doubledouble", measure, packages=("llvmlite", "numpy", "heyoka"), runs=7)

if __name__ == "__main__":
    sys.exit(SUITE.main())
