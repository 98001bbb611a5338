"""Constraints: run time against error on the squeezer and a chain, and steps of chains."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from math import inf
from statistics import median

import numpy as np

from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import in_turns, medians_in_turns, timed, timed_by_both
from benchmarks.motions.constrained_motion import SQUEEZER, ConstrainedMotion, angles, chain
from benchmarks.peers import Array
from benchmarks.peers.constrained import Followed, Ours, derived, with_ida, with_scipy

MOTIONS = {
    "Andrews' squeezer, 0.03 s": SQUEEZER,
    "Chain of 10 bobs in Cartesian coordinates, 1 s": chain(10, 1.0),
}
TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12)
SIZES = (10, 50, 200, 1000)
QUICK_SIZES = SIZES[:2]
SPAN = 2.0
"""Seconds that chains are followed for: some forty steps."""
REPEATS = 5
MOTION, FINE, ACCURATE = "lagrange", 1e-6, 1e-10
"""Ours; from the error ``FINE`` on it must be the fastest, at ``ACCURATE`` by the factor ``FACTOR``."""
FACTOR = 20.0
RATIOS = {10: 2.0, 50: 1.0, 200: 1.0, 1000: 1.0}
"""The time of a step relative to that in angles, by number of links."""


@dataclass(frozen=True)
class Measured:
    """A program at one tolerance: seconds, and the error of q at the end, relative to its size."""

    seconds: float
    error: float


def measure(options: Namespace) -> Report:
    """Two parts: work and precision, and steps of chains."""
    parts, requirements = [], []
    for title, motion in MOTIONS.items():
        results = work_precision(motion, options.runs)
        parts += [f"**{title}**:", work_table(results)]
        requirements += work_requirements(title.partition(",")[0], results)
    chains = steps(options)
    return Report((*parts, *chains.parts), (*requirements, *chains.requirements))


def contenders(motion: ConstrainedMotion) -> Iterator[tuple[str, float, Callable[[], Array]]]:
    """Each program's name, a tolerance, and what finds q at the end."""
    for tolerance in (*TOLERANCES, 2.0**-52):
        yield MOTION, tolerance, Ours(motion, tolerance=tolerance).end
    for tolerance in TOLERANCES:
        yield "sympy, scipy DOP853", tolerance, partial(with_scipy, motion, "DOP853", tolerance)
    for tolerance in TOLERANCES:
        yield "sympy, SUNDIALS IDA", tolerance, partial(with_ida, motion, tolerance)
    for tolerance in TOLERANCES[:3]:
        yield "sympy, scipy Radau", tolerance, partial(with_scipy, motion, "Radau", tolerance)


def work_precision(motion: ConstrainedMotion, turns: int) -> Mapping[tuple[str, float], Measured]:
    """Every program at every tolerance, in turns. A run that fails has an infinite error."""
    known = Ours(motion, precision="double-double").end()
    derived(motion)
    runs = {(name, tolerance): run for name, tolerance, run in contenders(motion)}

    def attempt(run: Callable[[], Array]) -> Measured:
        try:
            seconds, end = timed(run)
        except RuntimeError:
            return Measured(inf, inf)
        return Measured(seconds, float(np.abs(end - known).max() / np.abs(known).max()))

    results = in_turns({key: partial(attempt, run) for key, run in runs.items()}, turns)
    return {
        key: Measured(median(one.seconds for one in each), each[0].error) for key, each in results.items()
    }


def work_table(results: Mapping[tuple[str, float], Measured]) -> str:
    """One line for each program and tolerance."""
    rows = [
        (name, f"{tolerance:.2g}", f"{1e3 * one.seconds:.2f}", f"{one.error:.1e}")
        for (name, tolerance), one in results.items()
    ]
    return markdown_table(("", "tolerance", "run, ms", "error of q"), rows)


def least_time(results: Mapping[tuple[str, float], Measured], error: float, ours: bool) -> float:
    """The seconds of the quickest run, of ours or of the others, that is as accurate as ``error``."""
    return min(
        (
            one.seconds
            for (name, _), one in results.items()
            if (name == MOTION) == ours and one.error <= error
        ),
        default=inf,
    )


def work_requirements(title: str, results: Mapping[tuple[str, float], Measured]) -> list[Requirement]:
    """How much sooner we are than the quickest of the others that is as accurate."""
    made = []
    for error, factor in ((FINE, 1.0), (1e-8, 1.0), (ACCURATE, FACTOR)):
        ratio = least_time(results, error, False) / least_time(results, error, True)
        what = f"{title}, error of {error:g}: time of the quickest other program relative to lagrange"
        made.append(Requirement(what, ratio, ">=", factor))
    return made


def steps(options: Namespace) -> Report:
    """The processor time of a step of chains."""
    sizes = QUICK_SIZES if options.quick else SIZES
    runs: dict[tuple[str, int], Callable[[], Followed]] = {}
    for size in sizes:
        runs["x, y", size] = Ours(chain(size, SPAN), outputs=()).follow
        runs["angles", size] = Ours(angles(size, SPAN), outputs=()).follow
    counts = {key: run().outcome.steps for key, run in runs.items()}

    def seconds(run: Callable[[], object]) -> float:
        return min(timed_by_both(run)[1] for _ in range(REPEATS))

    found = medians_in_turns({key: partial(seconds, run) for key, run in runs.items()}, options.runs)
    each = {key: found[key] / count for key, count in counts.items()}
    rows = [
        (
            str(size),
            f"{1e6 * each['x, y', size]:.1f}",
            f"{1e6 * each['x, y', size] / size:.2f}",
            f"{1e6 * each['angles', size]:.1f}",
        )
        for size in sizes
    ]
    table = markdown_table(
        ("links", "x, y: us per step", "us per step and link", "angles: us per step"), rows
    )
    requirements = [
        Requirement(
            f"N = {size}: time of a step in x, y relative to angles",
            each["x, y", size] / each["angles", size],
            "<=",
            RATIOS[size],
        )
        for size in sizes
    ]
    if SIZES[-1] in sizes:
        growth = each["x, y", 1000] / each["x, y", 50] * 50 / 1000
        requirements.append(
            Requirement("time per step and link, N = 1000 relative to N = 50", growth, "<=", 1.5)
        )
    return Report(("**The time of a step of chains**:", table), tuple(requirements))


SUITE = Suite(
    "constraints",
    measure,
    packages=("llvmlite", "numpy", "scipy", "sympy", "scikit-sundae"),
    runs=3,
    quick="chains of no more than 50 links",
)

if __name__ == "__main__":
    sys.exit(SUITE.main())
