"""Chains of pendulums: preparation, run, and the time of a step as a function of their number."""

from __future__ import annotations

import sys
from argparse import Namespace
from functools import partial

from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.motions.motion import Motion, n_pendulum
from benchmarks.peers import Maker, engine
from benchmarks.peers.comparison import Measurement, compare, comparison_table

SPEEDUPS = {5: 6, 10: 15, 20: 35}
"""By number of pendulums."""
SECONDS = {5: 100.0, 10: 40.0, 20: 10.0, 30: 10.0, 50: 10.0, 100: 5.0, 1000: 5.0}
"""How long each number of them is followed: for tens of milliseconds of ours."""
RANGES = (10, 50), (100, 1000)
"""Within these the cost of a step must be linear in the number, within the factor ``LINEAR``."""
PREPARED = 1.0
"""Seconds that the preparation of the longest chain may take."""
LINEAR = 1.5
ENERGY_ERROR = 1e-12
REPEATS = 5

OURS, PEER = "lagrange", "heyoka, its lagrangian(), compact mode"


def measure(options: Namespace) -> Report:
    """A table for each size beside heyoka, and one of the cost of our steps."""
    results = compare(dict(contenders()), options.runs)
    parts, requirements = [], []
    for size, speedup in SPEEDUPS.items():
        ours, peer = results[named(OURS, size)], results[named(PEER, size)]
        both = {OURS: ours, PEER: peer}
        parts += [f"**{size} pendulums**, {SECONDS[size]:g} s:", comparison_table(both, OURS)]
        requirements += [
            Requirement(
                f"N = {size}: time of heyoka's run relative to lagrange", peer.run / ours.run, ">=", speedup
            ),
            Requirement(
                f"N = {size}: preparation time of lagrange relative to heyoka",
                ours.prepare / peer.prepare,
                "<",
                1,
            ),
            Requirement(f"N = {size}: energy error of lagrange", ours.energy_error, "<=", ENERGY_ERROR),
        ]
    steps = {size: results[named(OURS, size)] for size in SECONDS}
    parts += ["**The time of a step of lagrange**:", cost_table(steps)]
    for few, many in RANGES:
        growth = cost(steps, many) / cost(steps, few)
        requirements.append(
            Requirement(f"time per step and pendulum, N = {many} relative to N = {few}", growth, "<=", LINEAR)
        )
    longest = max(steps)
    requirements.append(Requirement(f"N = {longest}: preparation, s", steps[longest].prepare, "<=", PREPARED))
    return Report(tuple(parts), tuple(requirements))


def contenders() -> list[tuple[str, tuple[Maker, Motion, int]]]:
    """We at every size, heyoka where it is compared."""
    lagrange, by_heyoka = (
        partial(engine, "lagrange"),
        partial(engine, "heyoka", form="derived", compact_mode=True),
    )
    made: list[tuple[str, tuple[Maker, Motion, int]]] = []
    for size in SECONDS:
        made.append((named(OURS, size), (lagrange, n_pendulum(size, SECONDS[size]), REPEATS)))
        if size in SPEEDUPS:
            made.append((named(PEER, size), (by_heyoka, n_pendulum(size, SECONDS[size]), REPEATS)))
    return made


def named(program: str, size: int) -> str:
    """A contender."""
    return f"{program}, N = {size}"


def cost(steps: dict[int, Measurement], size: int) -> float:
    """Seconds per step and pendulum."""
    return steps[size].run / steps[size].steps / size


def cost_table(steps: dict[int, Measurement]) -> str:
    """Steps, the time that one takes, and its share for each pendulum."""
    return markdown_table(
        ("N", "steps", "run, ms", "us per step", "us per step and pendulum"),
        [
            (
                str(size),
                f"{each.steps:.0f}",
                f"{1e3 * each.run:.1f}",
                f"{1e6 * each.run / each.steps:.1f}",
                f"{1e6 * cost(steps, size):.2f}",
            )
            for size, each in steps.items()
        ],
    )


SUITE = Suite("chain", measure, packages=("llvmlite", "numpy", "heyoka"), runs=3)

if __name__ == "__main__":
    sys.exit(SUITE.main())
