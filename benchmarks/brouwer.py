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

from benchmarks.benchmark import Benchmark
from benchmarks.comparison import Maker
from benchmarks.engines import heyoka, lagrange
from benchmarks.problems import KEPLER_CARTESIAN, Problem
from benchmarks.report import ROOT, Report, Requirement, markdown_table
from benchmarks.turns import in_own_process, timed

Array = NDArray[np.float64]
PERIODS, FEWER = 10**6, 10**4
ORBITS = 8
SAMPLES = 10_001
BINS = 40
EXPONENT = 0.6
FIGURE = ROOT / "docs" / "figures" / "brouwer.svg"
OURS, PEER = "lagrange", "heyoka, high accuracy"
MAKERS: Mapping[str, Maker] = {
    OURS: lagrange,
    PEER: partial(heyoka, equations="kepler_by_hand", high_accuracy=True),
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


def growth_exponent(times: Array, errors: Array) -> float:
    """The slope of the straight line through log error over log time."""
    return float(np.polyfit(np.log(times), np.log(errors), 1)[0])


def binned(times: Array, squares: Array, bins: int) -> tuple[Array, Array]:
    """Times (bins,) and root means of ``squares`` (n,) in bins of equal width in log time; empty ones are
    left out."""
    edges = np.geomspace(times[0], times[-1], bins + 1)
    number = np.clip(np.searchsorted(edges, times, side="right") - 1, 0, bins - 1)
    filled = np.unique(number)
    centres = np.array([np.exp(np.mean(np.log(times[number == k]))) for k in filled])
    roots = np.array([np.sqrt(np.mean(squares[number == k])) for k in filled])
    return centres, roots


def followed(make: Maker, problem: Problem) -> Growth:
    """The growth of an engine's error; samples and errors of the first are left out, as they are 0."""
    engine = make(problem)
    runs = [timed(partial(engine.follow, *start)) for start in problem.starts(ORBITS)]
    squares = np.mean([problem.energy_errors(motion.q, motion.v) ** 2 for _, motion in runs], axis=0)
    periods, errors = binned(problem.grid[1:] / (2 * np.pi), squares[1:], BINS)
    return Growth(periods, errors, min(seconds for seconds, _ in runs))


def measure(options: Namespace) -> Report:
    """Both engines, one after the other: what is compared are errors."""
    count = FEWER if options.quick else PERIODS
    problem = replace(KEPLER_CARTESIAN, stop=2 * np.pi * count, samples=SAMPLES)
    growths = {name: in_own_process(followed, make, problem) for name, make in MAKERS.items()}
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
    """The figure of the document, the same bytes for the same errors."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "brouwer"
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6.4, 4.0), layout="constrained")
    for name, each in growths.items():
        axes.loglog(each.periods, each.errors, ".-", label=f"{name} (exponent {each.exponent:.2f})")
    ours = growths[OURS]
    law = ours.errors[-1] * np.sqrt(ours.periods / ours.periods[-1])
    axes.loglog(ours.periods, law, "k--", linewidth=0.8, label="square root of time")
    axes.set(xlabel="periods", ylabel="relative energy error, r.m.s.", title="Kepler ellipse, e = 0.3")
    axes.legend()
    FIGURE.parent.mkdir(exist_ok=True)
    figure.savefig(FIGURE, metadata={"Date": None})


BENCHMARK = Benchmark(
    "brouwer",
    measure,
    packages=("llvmlite", "numpy", "heyoka"),
    runs=1,
    quick="ten thousand periods only",
)

if __name__ == "__main__":
    sys.exit(BENCHMARK.main())
