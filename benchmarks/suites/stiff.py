"""Stiff motions by implicit methods: integration alone, and errors.

Tolerances are relative and absolute ones. The error is the largest one of q at the end. That of van der Pol's
oscillator is relative to a motion by Taylor series at full precision, others to closed forms.
"""

from __future__ import annotations

import math
import sys
from argparse import Namespace
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from statistics import median
from typing import Any

import numpy as np

from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import in_own_process, in_turns, processor_seconds
from benchmarks.motions.motion import Array
from benchmarks.motions.stiff import MOTIONS, Stiff
from benchmarks.peers import Engine

TOLERANCES = 1e-4, 1e-6, 1e-8, 1e-10
OURS, SCIPY = "lagrange Radau", "scipy Radau, rates in numba"
CVODE = "SUNDIALS CVODE, rates in numba"
FASTER = {SCIPY: 3.0, CVODE: 1.0}
"""How many times as long as ours with an error no larger others are to take at least."""


@dataclass(frozen=True)
class Figures:
    """Processor seconds of a motion; its steps, or evaluations where these are not known; q at the end."""

    run: float
    steps: float
    end: Array


def engine(name: str, motion: Stiff, tolerance: float) -> Engine:
    """A program for a motion."""
    peer = {OURS: "lagrange", SCIPY: "scipy", CVODE: "sundials"}[name]
    options: dict[str, Any] = {"method": "Radau"} if name == OURS else {}
    made: Engine = import_module(f"benchmarks.peers.{peer}").stiff(motion, tolerance=tolerance, **options)
    return made


def figures(name: str, motion: Stiff, tolerance: float, runs: int) -> Figures:
    """Those of a program: of the runs the median."""
    made = engine(name, motion, tolerance)
    start = motion.start if name == OURS else motion.pairs
    course = made.follow(start)  # once more than it is measured
    run = median(processor_seconds(lambda: made.follow(start)) for _ in range(runs))
    end = course.states[: motion.count, 0] if name == OURS else course.states[::2, 0]
    return Figures(run, course.steps, end)


def true_end(motion: Stiff) -> Array:
    """q at the end."""
    if motion.end is not None:
        return motion.end(motion)
    from benchmarks.peers.lagrange import stiff

    found: Array = stiff(motion, method="taylor", tolerance=2.0**-52).follow(motion.start).states
    return found[: motion.count, 0]


def measure(options: Namespace) -> Report:
    """A table for each motion; every program in a process of its own."""
    parts, requirements = list[str](), list[Requirement]()
    for motion in MOTIONS[:2] if options.quick else MOTIONS:
        true = in_own_process(true_end, motion)
        tasks: dict[tuple[str, float], Callable[[], Figures]] = {
            (name, tolerance): partial(in_own_process, figures, name, motion, tolerance, options.runs)
            for tolerance in TOLERANCES
            for name in (OURS, *FASTER)
        }
        found = {key: one[0] for key, one in in_turns(tasks, 1).items()}
        errors = {key: float(np.max(np.abs(one.end - true))) for key, one in found.items()}
        rows = [
            (name, f"{tolerance:.0e}", f"{1e3 * one.run:.2f}", f"{one.steps:.0f}", f"{error:.1e}")
            for name in (OURS, *FASTER)
            for tolerance in TOLERANCES
            for one, error in [(found[name, tolerance], errors[name, tolerance])]
        ]
        parts += [f"**{motion.name}**, {motion.stop:g} units of time:"]
        parts += [markdown_table(("", "tolerance", "run, ms", "steps", "error"), rows)]
        for name, factor in FASTER.items():
            ratio = min(least_ratio(found, errors, name, tolerance) for tolerance in TOLERANCES)
            requirements.append(
                Requirement(f"{motion.name}: time of {name}, relative to lagrange", ratio, ">=", factor)
            )
    return Report(tuple(parts), tuple(requirements))


def least_ratio(
    found: dict[tuple[str, float], Figures],
    errors: dict[tuple[str, float], float],
    name: str,
    tolerance: float,
) -> float:
    """The time of a run, relative to our fastest one whose error is no larger; none where it is more accurate
    than all of ours."""
    ours = [found[OURS, one].run for one in TOLERANCES if errors[OURS, one] <= errors[name, tolerance]]
    return found[name, tolerance].run / min(ours) if ours else math.inf


SUITE = Suite(
    "stiff",
    measure,
    packages=("llvmlite", "numpy", "scipy", "numba", "scikit-sundae"),
    runs=3,
    quick="without the chain of 300 beads",
)

if __name__ == "__main__":
    sys.exit(SUITE.main())
