"""A section: a million crossings of x = 0 by a thousand motions of Henon-Heiles with energy 1/10.

Both programs integrate several members at once in the lanes of a vector and find all roots of x in each step.
heyoka is measured with batches of four and of eight, and an event whose callback in Python stores the time
and the state. Nothing is written to a file.
"""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import in_own_process, in_turns, timed_by_both
from benchmarks.motions.motion import HENON_HEILES
from benchmarks.peers import section

Array = NDArray[np.float64]

ENERGY = 0.1
SPEEDUP = 5.0
PERIOD = 6.25
"""About the time between two crossings."""
CROSSINGS, MEMBERS, FEWER = 1000, 1000, 64
"""Of each member; and members, multiples of 8."""
WARM = 8
"""Members that are followed before the clock starts."""


@dataclass(frozen=True)
class Measurement:
    """Seconds to prepare, of the wall's clock and of all processors; steps of a member; the largest |x| of a
    crossing, the error of the energy there, and the sum of the times of all members' tenth crossings."""

    prepare: float
    wall: float
    processors: float
    steps: float
    distance: float
    energy_error: float
    tenth: float


def initial_states(members: int) -> Array:
    """x, y and their velocities of every member, shape (4, members), on the section."""
    source, found = np.random.default_rng(1), list[tuple[float, ...]]()
    while len(found) < members:
        y, v = source.uniform(-0.5, 0.6), source.uniform(-0.5, 0.5)
        squared = 2 * ENERGY - v**2 - y**2 + 2 * y**3 / 3
        if squared > 0:
            found.append((0.0, y, float(np.sqrt(squared)), v))
    return np.ascontiguousarray(np.array(found, dtype=np.float64).T)


def measured(peer: str, options: Mapping[str, Any], members: int) -> Measurement:
    """A peer on all members."""
    made = section(peer, HENON_HEILES, crossings=CROSSINGS, **options)
    states = initial_states(members)
    made.follow(states[:, :WARM])
    wall, spent, found = timed_by_both(lambda: made.follow(states))
    error = HENON_HEILES.energy(found.states.reshape(4, -1)) / ENERGY - 1
    return Measurement(
        made.prepare,
        wall,
        spent,
        found.steps,
        float(np.abs(found.states[0]).max()),
        float(np.sqrt(np.mean(error**2))),
        float(found.times[:, 9].sum()),
    )


ONE, TWO = "lagrange, 1 thread", "lagrange, 2 threads"
CONTENDERS: Mapping[str, tuple[str, Mapping[str, Any]]] = {
    ONE: ("lagrange", {"threads": 1}),
    TWO: ("lagrange", {"threads": 2}),
    "heyoka, batches of 4": ("heyoka", {"batch": 4, "period": PERIOD}),
    "heyoka, batches of 8": ("heyoka", {"batch": 8, "period": PERIOD}),
    "heyoka, batches of 8, 2 threads": ("heyoka", {"batch": 8, "period": PERIOD, "threads": 2}),
}
"""Peers with their options."""


def measure(options: Namespace) -> Report:
    """Every engine with every member."""
    members = FEWER if options.quick else MEMBERS
    tasks = {name: partial(in_own_process, measured, *each, members) for name, each in CONTENDERS.items()}
    results = in_turns(tasks, options.runs)

    def cost(name: str, clock: str) -> float:
        """Microseconds of that clock for a crossing."""
        return float(median(getattr(each, clock) for each in results[name]) / (members * CROSSINGS) * 1e6)

    others = [name for name in CONTENDERS if name.startswith("heyoka")]
    rows = [
        (
            name,
            f"{1e3 * median(each.prepare for each in found):.0f}",
            f"{cost(name, 'processors'):.2f}",
            f"{cost(name, 'wall'):.2f}",
            f"{found[0].steps / CROSSINGS:.1f}",
            f"{found[0].distance:.1e}",
            f"{found[0].energy_error:.1e}",
        )
        for name, found in results.items()
    ]
    head = (
        "", "prepare, ms", "us of a core per crossing", "us per crossing", "steps per crossing",
        "largest distance", "energy error, rms",
    )  # fmt: skip
    alike = abs(results[ONE][0].tenth / results[others[0]][0].tenth - 1)
    requirements = (
        Requirement(
            "time of the best of heyoka, relative to 1 thread",
            min(cost(name, "processors") for name in others) / cost(ONE, "processors"),
            ">=",
            SPEEDUP,
        ),
        Requirement(
            "the same with 2 threads of both", cost(others[-1], "wall") / cost(TWO, "wall"), ">=", SPEEDUP
        ),
        Requirement(
            "energy error, relative to heyoka",
            results[ONE][0].energy_error / min(results[name][0].energy_error for name in others),
            "<=",
            1.0,
        ),
        Requirement("difference of the times of tenth crossings, relative", alike, "<=", 1e-13),
    )
    return Report((markdown_table(head, rows),), requirements)


SUITE = Suite(
    "section", measure, packages=("llvmlite", "numpy", "heyoka"), runs=3, quick=f"{FEWER} members only"
)

if __name__ == "__main__":
    sys.exit(SUITE.main())
