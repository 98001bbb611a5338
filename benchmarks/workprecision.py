"""Run time against energy error and against the error of q at the end: tables and figures."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from math import nan
from statistics import median

import numpy as np
from numpy.typing import NDArray

from benchmarks.benchmark import Benchmark
from benchmarks.followers import Heyoka, Ours, Rebound, Run, Scipy, energy_of
from benchmarks.motions import SYSTEMS, System
from benchmarks.report import ROOT, Report, markdown_table
from benchmarks.turns import in_turns, timed
from lagrange_cli.work_precision.figure import Curve, Picture, Point, check_picture, write_picture
from lagrange_cli.work_precision.reference import Reference

FIGURES = ROOT / "docs" / "figures"
TAYLOR = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 2.0**-52)
SCIPY = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
EPSILONS = (1e-2, 1e-4, 1e-6, 1e-9)
"""IAS15's control of the step; 1e-9 is its default."""
SHORT = 0.02
"""Seconds up to which a run is repeated within a turn."""
REPEATS = 5
ROUNDING = 2.0**-53
"""Errors below it are not told apart."""


@dataclass(frozen=True)
class Measured:
    """One engine at one tolerance: seconds, relative energy error, and error of q at the end."""

    seconds: float
    energy_error: float
    end_error: float


Results = Mapping[tuple[str, float], Measured]
"""By the engine's name and the tolerance."""


def report(options: Namespace) -> Report:
    """Measure every system, and draw its figure where the document is written."""
    parts = []
    for system in SYSTEMS:
        figure = FIGURES / f"{system.name}.svg"
        if options.write:
            figure.parent.mkdir(exist_ok=True)
            check_picture(str(figure))
        known, floor = measure(replace(system, stop=system.known), options.runs)
        whole = known if system.stop == system.known else measure(system, options.runs, compared=False)[0]
        if options.write:
            write_picture(str(figure), *pictures(system, whole, known, floor))
        parts += [
            f"![{system.title}: run time against error](figures/{figure.name})",
            table(system, whole, known),
        ]
    return Report(tuple(parts))


def engines(system: System, ours: Ours) -> Iterator[tuple[str, Callable[[float], Run], tuple[float, ...]]]:
    """Each engine's name, what makes a run of it for a tolerance, and the tolerances."""
    yield "lagrange", ours.at, TAYLOR
    scipy = Scipy(system, ours.initial)
    yield "scipy DOP853", scipy.dop853, SCIPY
    yield "scipy LSODA", scipy.lsoda, SCIPY
    yield "heyoka", Heyoka(system, ours.initial, by_hand=False).at, TAYLOR
    yield "heyoka, by hand", Heyoka(system, ours.initial, by_hand=True).at, TAYLOR
    if system.name == "figure_eight":
        yield "rebound IAS15", Rebound(system, ours.initial).at, EPSILONS


def measure(system: System, turns: int, *, compared: bool = True) -> tuple[Results, float]:
    """Everything on one system, in turns, and the error of the reference that q is ``compared`` with."""
    ours = Ours(system)
    reference = ours.reference() if compared else None
    runs = {
        (name, tolerance): make(tolerance)
        for name, make, tolerances in engines(system, ours)
        for tolerance in tolerances
    }
    seconds = in_turns({key: partial(time_of, run) for key, run in runs.items()}, turns)
    energy = energy_of(system, len(ours.initial) // 2)
    measured = {}
    for key, run in runs.items():
        course = run()
        energies = energy(course.states)
        measured[key] = Measured(
            median(seconds[key]),
            float(np.max(np.abs(energies - energies[0])) / abs(energies[0])),
            end_error(reference, course.end) if reference else nan,
        )
    return measured, reference.error if reference else nan


def end_error(reference: Reference, end: NDArray[np.float64]) -> float:
    """The error of q (n,) at the end, relative to its size."""
    return float(np.max(np.abs(end - reference.q[-1]) / reference.sizes))


def time_of(run: Run) -> float:
    """The seconds of a run; the median of some, where it is short."""
    seconds = timed(run)[0]
    return median(timed(run)[0] for _ in range(REPEATS)) if seconds < SHORT else seconds


def table(system: System, whole: Results, known: Results) -> str:
    """One line for each engine and tolerance."""
    return markdown_table(
        ("", "tolerance", f"{system.span}, ms", "energy error", f"{system.known_span}, ms", "error of q"),
        [
            (
                *(key[0], f"{key[1]:.2g}"),
                *(f"{1e3 * each.seconds:.2f}", f"{each.energy_error:.1e}"),
                *(f"{1e3 * known[key].seconds:.2f}", f"{known[key].end_error:.1e}"),
            )
            for key, each in whole.items()
        ],
    )


def pictures(system: System, whole: Results, known: Results, floor: float) -> tuple[Picture, Picture]:
    """The two frames of a figure."""

    def curves(results: Results, error: str, least: float) -> tuple[Curve, ...]:
        points: dict[str, list[Point]] = {}
        for (name, _), each in results.items():
            found = getattr(each, error)
            point = Point(max(least, found), each.seconds, bounded=found < least)
            points.setdefault(name, []).append(point)
        return tuple(Curve(name, tuple(each)) for name, each in points.items())

    return (
        Picture(
            f"{system.title}, {system.span}",
            "largest relative energy error",
            curves(whole, "energy_error", ROUNDING),
        ),
        Picture(
            f"{system.title}, {system.known_span}",
            "error of q at the end, relative to its size",
            curves(known, "end_error", floor),
            floor,
        ),
    )


BENCHMARK = Benchmark(
    "workprecision",
    report,
    packages=("llvmlite", "numpy", "scipy", "sympy", "heyoka", "rebound"),
    runs=7,
)

if __name__ == "__main__":
    sys.exit(BENCHMARK.main())
