"""An ensemble: 10,000 double pendulums from nearby angles, 10 s each, to full double precision.

Both programs integrate several members at once in the lanes of a vector. The best mode of heyoka is not known
beforehand: it is measured with batches of four and of eight, and with its own threads. Only the final states
are computed.
"""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import in_own_process, in_turns, timed_by_both
from benchmarks.motions.motion import DOUBLE_PENDULUM
from benchmarks.peers import ensemble

Array = NDArray[np.float64]

PENDULUMS = replace(DOUBLE_PENDULUM, stop=10.0)
SPREAD = 0.1
"""Standard deviation of the angles (rad)."""
SPEEDUP = 1.5
TWO_CORES = 1.85
WARM = 64
"""Members that are followed before the clock starts."""
MEMBERS, FEWER = 10_000, 800
"""Multiples of 8."""


@dataclass(frozen=True)
class Measurement:
    """Seconds to prepare, of the wall's clock and of all processors, and what each member came to."""

    prepare: float
    wall: float
    processors: float
    steps: float
    energy_error: float


def initial_states(members: int) -> Array:
    """Angles and velocities of every member, shape (4, members)."""
    noise = np.random.default_rng(1).standard_normal((2, members))
    angles = np.array(PENDULUMS.values.q)[:, None] + SPREAD * noise
    return np.concatenate([angles, np.zeros((2, members))])


def measured(peer: str, options: Mapping[str, Any], members: int) -> Measurement:
    """A peer on all members."""
    made = ensemble(peer, PENDULUMS, **options)
    states = initial_states(members)
    made.follow(states[:, :WARM])
    wall, spent, course = timed_by_both(lambda: made.follow(states))
    start, end = PENDULUMS.energy(states), PENDULUMS.energy(course.states)
    error = float(np.sqrt(np.mean((end / start - 1) ** 2)))
    return Measurement(made.prepare, wall, spent, course.steps, error)


ONE, TWO = "lagrange, 1 thread", "lagrange, 2 threads"
BATCHES = {"form": "by hand", "batch": 8}
CONTENDERS: Mapping[str, tuple[str, Mapping[str, Any]]] = {
    ONE: ("lagrange", {"threads": 1}),
    TWO: ("lagrange", {"threads": 2}),
    "heyoka, batches of 4": ("heyoka", {**BATCHES, "batch": 4}),
    "heyoka, batches of 8": ("heyoka", BATCHES),
    "heyoka, ensemble of batches of 8, 2 threads": ("heyoka", {**BATCHES, "threads": 2}),
}
"""Peers with their options."""


def measure(options: Namespace) -> Report:
    """Every engine with every member."""
    members = FEWER if options.quick else MEMBERS
    tasks = {name: partial(in_own_process, measured, *each, members) for name, each in CONTENDERS.items()}
    results = in_turns(tasks, options.runs)

    def rate(name: str, clock: str) -> float:
        """Members per second of that clock."""
        return float(members / median(getattr(each, clock) for each in results[name]))

    best = max(rate(name, "processors") for name in CONTENDERS if name.startswith("heyoka"))
    rows = [
        (
            name,
            f"{1e3 * median(each.prepare for each in measurements):.0f}",
            f"{rate(name, 'processors'):.0f}",
            f"{rate(name, 'wall'):.0f}",
            f"{measurements[0].steps:.0f}",
            f"{measurements[0].energy_error:.1e}",
        )
        for name, measurements in results.items()
    ]
    head = ("", "prepare, ms", "members/s per core", "members/s", "steps per member", "energy error, rms")
    requirements = (
        Requirement(
            "members/s per core, relative to the best of heyoka",
            rate(ONE, "processors") / best,
            ">=",
            SPEEDUP,
        ),
        Requirement(
            "members/s of lagrange, 2 threads relative to 1",
            rate(TWO, "wall") / rate(ONE, "wall"),
            ">=",
            TWO_CORES,
        ),
    )
    return Report((markdown_table(head, rows),), requirements)


SUITE = Suite(
    "ensemble", measure, packages=("llvmlite", "numpy", "heyoka"), runs=5, quick=f"{FEWER} members only"
)

if __name__ == "__main__":
    sys.exit(SUITE.main())
