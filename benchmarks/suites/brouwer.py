"""A million periods of a Kepler ellipse, e = 0.3: how the energy error grows with time.

Rounding errors add up like the steps of a random walk and grow with the square root of time (D. Brouwer,
Astronomical Journal 46, 1937). The exponent is fitted to the root mean square error of several nearby orbits.
"""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.figures import figure
from benchmarks.harness.growth import binned, growth_exponent
from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import in_own_process, timed
from benchmarks.motions.motion import KEPLER, Motion
from benchmarks.peers import Maker, engine

Array = NDArray[np.float64]
PERIODS, FEWER = 10**6, 10**4
ORBITS = 8
SAMPLES = 10_001
BINS = 40
EXPONENT = 0.6
OURS, PEER = "lagrange", "heyoka, high accuracy"
MAKERS: Mapping[str, Maker] = {
    OURS: partial(engine, "lagrange"),
    PEER: partial(engine, "heyoka", form="by hand", high_accuracy=True),
}


@dataclass(frozen=True)
class Growth:
    """Times in periods and root mean square errors there, both (bins,); and the seconds of one orbit."""

    periods: Array
    errors: Array
    seconds: float

    @property
    def exponent(self) -> float:
        """Of the power of time that fits the errors."""
        return growth_exponent(self.periods, self.errors)


def followed(make: Maker, motion: Motion) -> Growth:
    """The growth of an engine's error; samples and errors of the first are left out, as they are 0."""
    follow = make(motion).follow
    runs = [timed(partial(follow, start)) for start in motion.starts(ORBITS)]
    squares = np.mean([motion.energy_errors(course.states) ** 2 for _, course in runs], axis=0)
    periods, errors = binned(motion.grid[1:] / (2 * np.pi), squares[1:], BINS)
    return Growth(periods, errors, min(seconds for seconds, _ in runs))


def measure(options: Namespace) -> Report:
    """Both engines, one after the other: what is compared are errors."""
    count = FEWER if options.quick else PERIODS
    motion = replace(KEPLER, stop=2 * np.pi * count, settings=(("e", "0.3"),), samples=SAMPLES)
    growths = {name: in_own_process(followed, make, motion) for name, make in MAKERS.items()}
    if options.write:
        draw(growths)
    rows = [
        (name, f"{each.errors[-1]:.1e}", f"{each.exponent:.2f}", f"{each.seconds:.1f}")
        for name, each in growths.items()
    ]
    ours, peer = growths[OURS], growths[PEER]
    return Report(
        (
            markdown_table(
                (f"{count} periods", "energy error at the end", "growth exponent", "s per orbit"), rows
            ),
            "![the growth of the energy error](figures/brouwer.svg)",
        ),
        (
            Requirement(
                "energy error of lagrange relative to heyoka", ours.errors[-1] / peer.errors[-1], "<=", 1
            ),
            Requirement("growth exponent of lagrange", ours.exponent, "<=", EXPONENT),
        ),
    )


def draw(growths: Mapping[str, Growth]) -> None:
    """The figure of the document."""
    with figure("brouwer", 6.4, 4.0) as axes:
        for name, each in growths.items():
            axes.loglog(each.periods, each.errors, ".-", label=f"{name} (exponent {each.exponent:.2f})")
        ours = growths[OURS]
        law = ours.errors[-1] * np.sqrt(ours.periods / ours.periods[-1])
        axes.loglog(ours.periods, law, "k--", linewidth=0.8, label="square root of time")
        axes.set(xlabel="periods", ylabel="relative energy error, r.m.s.", title="Kepler ellipse, e = 0.3")
        axes.legend()


SUITE = Suite(
    "brouwer", measure, packages=("llvmlite", "numpy", "heyoka"), runs=1, quick="ten thousand periods only"
)

if __name__ == "__main__":
    sys.exit(SUITE.main())
