"""Linear constraints: a step with a multiplier for each, without the coordinates that follow, and by hand."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Callable
from functools import partial
from unittest.mock import patch

import numpy as np

from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import medians_in_turns, timed_by_both
from benchmarks.motions.constrained_motion import ConstrainedMotion
from benchmarks.peers.constrained import Followed, Ours

MOTIONS = {
    "gear pair": "gear_pair",
    "train of ten gears": "gear_train",
    "Atwood's machine": "rope",
    "disc rolling on an incline": "disc",
}
MULTIPLIERS, ELIMINATED, BY_HAND = "multipliers", "eliminated", "by hand"
SPAN, REPEATS = 2000.0, 3
LESS, NEAR = 1.0, 2.5
"""Bounds for the time of a step without the coordinates that follow: relative to multipliers, and to the same
system written in one coordinate, which does not give the others."""
SHORT, AGREE = 10.0, 1e-13
"""Seconds after which motions are compared, and by how much they may differ."""


def ways(name: str) -> dict[str, Ours]:
    """A system, compiled in three ways."""
    with patch("lagrange_cli.native.elimination.reduced", lambda residual: None):
        whole = Ours(ConstrainedMotion(name, SPAN))
    hand = ConstrainedMotion(f"{name}_by_hand", SPAN)
    return {MULTIPLIERS: whole, ELIMINATED: Ours(ConstrainedMotion(name, SPAN)), BY_HAND: Ours(hand)}


def measure(options: Namespace) -> Report:
    """The processor time of a step, and by how much the motions differ after ten seconds."""
    runs = {(title, way): one for title, name in MOTIONS.items() for way, one in ways(name).items()}
    steps = {key: one.follow().outcome.steps for key, one in runs.items()}

    def seconds(run: Callable[[], Followed]) -> float:
        return min(timed_by_both(run)[1] for _ in range(REPEATS))

    found = medians_in_turns({key: partial(seconds, one.follow) for key, one in runs.items()}, options.runs)
    each = {key: 1e6 * found[key] / count for key, count in steps.items()}
    rows, requirements = [], []
    for title in MOTIONS:
        whole, less, hand = (each[title, way] for way in (MULTIPLIERS, ELIMINATED, BY_HAND))
        off = difference(runs[title, MULTIPLIERS], runs[title, ELIMINATED])
        rows.append(
            (title, f"{whole:.2f}", f"{less:.2f}", f"{hand:.2f}", f"{whole / less:.1f}", f"{off:.0e}")
        )
        requirements += [
            Requirement(f"{title}: time of a step relative to multipliers", less / whole, "<=", LESS),
            Requirement(f"{title}: time of a step relative to one coordinate", less / hand, "<=", NEAR),
            Requirement(f"{title}: difference of q after {SHORT:g} s", off, "<=", AGREE),
        ]
    heads = "", "multipliers: us per step", "eliminated", "by hand", "gain", "difference of q"
    return Report((markdown_table(heads, rows),), tuple(requirements))


def difference(one: Ours, other: Ours) -> float:
    """The largest difference of a coordinate after a short time."""
    return float(np.abs(one.until(SHORT).end() - other.until(SHORT).end()).max())


SUITE = Suite("elimination", measure, packages=("llvmlite", "numpy"), runs=7)

if __name__ == "__main__":
    sys.exit(SUITE.main())
