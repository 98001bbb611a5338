"""Run time against energy error and against the error of q at the end: tables and figures."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from math import nan, pi
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.figures import FIGURES
from benchmarks.harness.report import Report, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.harness.turns import in_turns, timed
from benchmarks.motions.motion import DOUBLE_PENDULUM, FIGURE_EIGHT, KEPLER_POLAR, Motion
from benchmarks.peers import Course, engine
from benchmarks.peers.lagrange import compiled
from lagrange_cli.integrate.times import Times
from lagrange_cli.work_precision.figure import Curve, Picture, Point, check_picture, write_picture
from lagrange_cli.work_precision.reference import TOLERANCES, Reference, find_reference
from lagrange_cli.work_precision.trajectory import Trajectory, follow

TAYLOR = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 2.0**-52)
SCIPY = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
EPSILONS = (1e-2, 1e-4, 1e-6, 1e-9)
"""IAS15's control of the step; 1e-9 is its default."""
SHORT = 0.02
"""Seconds up to which a run is repeated within a turn."""
REPEATS = 5
WELL_KNOWN = 1e-10
"""The largest error of the reference."""
ROUNDING = 2.0**-53
"""Errors below it are not told apart."""


@dataclass(frozen=True)
class Shown:
    """A shipped system and a motion of it; q is compared over ``known``, while it is known."""

    title: str
    motion: Motion
    span: str
    known: float
    known_span: str


SHOWN = (
    Shown("Double pendulum", replace(DOUBLE_PENDULUM, stop=100.0), "100 s", 8.0, "8 s"),
    Shown(
        "Kepler, polar, e = 0.6", replace(KEPLER_POLAR, stop=200 * pi), "100 periods", 200 * pi, "100 periods"
    ),
    Shown(
        "Figure eight", replace(FIGURE_EIGHT, stop=30 * 6.32591398), "30 periods", 30 * 6.32591398,
        "30 periods",
    ),
)  # fmt: skip
"""A chaotic motion keeps its energy for long, but nobody knows for long where it is."""
Run = Callable[[], Course]


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
    for shown in SHOWN:
        motion = shown.motion
        figure = FIGURES / f"{motion.system}.svg"
        if options.write:
            figure.parent.mkdir(exist_ok=True)
            check_picture(str(figure))
        known, floor = measure(replace(motion, stop=shown.known), options.runs)
        whole = known if motion.stop == shown.known else measure(motion, options.runs, compared=False)[0]
        if options.write:
            write_picture(str(figure), *pictures(shown, whole, known, floor))
        parts += [
            f"![{shown.title}: run time against error](figures/{figure.name})",
            table(shown, whole, known),
        ]
    return Report(tuple(parts))


def contenders(motion: Motion) -> Iterator[tuple[str, float, Run]]:
    """Each engine's name, a tolerance, and its run."""
    made: list[tuple[str, str, Mapping[str, Any], tuple[float, ...]]] = [
        ("lagrange", "lagrange", {}, TAYLOR),
        ("scipy DOP853", "scipy", {"method": "DOP853"}, SCIPY),
        ("scipy LSODA", "scipy", {"method": "LSODA"}, SCIPY),
        ("heyoka", "heyoka", {"form": "derived", "dense": True}, TAYLOR),
        ("heyoka, by hand", "heyoka", {"form": "by hand", "dense": True}, TAYLOR),
    ]
    for name, peer, options, tolerances in made:
        for tolerance in tolerances:
            run = engine(peer, motion, tolerance=tolerance, **options).follow
            yield name, tolerance, partial(run, motion.initial)
    if motion.system == "figure_eight":
        for epsilon in EPSILONS:
            run = engine("rebound", motion, epsilon=epsilon).follow
            yield "rebound IAS15", epsilon, partial(run, motion.initial)


def measure(motion: Motion, turns: int, *, compared: bool = True) -> tuple[Results, float]:
    """Everything on one motion, in turns, and the error of the reference that q is ``compared`` with."""
    known = reference(motion) if compared else None
    runs = {(name, tolerance): run for name, tolerance, run in contenders(motion)}
    seconds = in_turns({key: partial(time_of, run) for key, run in runs.items()}, turns)
    measured = {}
    for key, run in runs.items():
        states = run().states
        measured[key] = Measured(
            median(seconds[key]),
            float(np.max(np.abs(motion.energy_errors(states)))),
            end_error(known, states[: motion.degrees, -1]) if known else nan,
        )
    return measured, known.error if known else nan


def reference(motion: Motion) -> Reference:
    """The motion with which runs are compared; it must be known to the end.

    Raises ``RuntimeError`` where it is not.
    """

    def runner(tolerance: float) -> Callable[[Times], Trajectory]:
        prepared = compiled(motion, motion.text, tolerance)
        return lambda times: follow(prepared, motion.values, times, 60.0, lambda: False)

    labels = [str(k) for k in range(motion.degrees)]
    found = find_reference([*map(runner, TOLERANCES)], 0.0, motion.stop, WELL_KNOWN, labels)
    if found.reason:
        raise RuntimeError(f"{motion.system}: {found.reason}")
    return found


def end_error(reference: Reference, end: NDArray[np.float64]) -> float:
    """The error of q (n,) at the end, relative to its size."""
    return float(np.max(np.abs(end - reference.q[-1]) / reference.sizes))


def time_of(run: Run) -> float:
    """The seconds of a run; the median of some, where it is short."""
    seconds = timed(run)[0]
    return median(timed(run)[0] for _ in range(REPEATS)) if seconds < SHORT else seconds


def table(shown: Shown, whole: Results, known: Results) -> str:
    """One line for each engine and tolerance."""
    return markdown_table(
        ("", "tolerance", f"{shown.span}, ms", "energy error", f"{shown.known_span}, ms", "error of q"),
        [
            (
                *(key[0], f"{key[1]:.2g}"),
                *(f"{1e3 * each.seconds:.2f}", f"{each.energy_error:.1e}"),
                *(f"{1e3 * known[key].seconds:.2f}", f"{known[key].end_error:.1e}"),
            )
            for key, each in whole.items()
        ],
    )


def pictures(shown: Shown, whole: Results, known: Results, floor: float) -> tuple[Picture, Picture]:
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
            f"{shown.title}, {shown.span}",
            "largest relative energy error",
            curves(whole, "energy_error", ROUNDING),
        ),
        Picture(
            f"{shown.title}, {shown.known_span}",
            "error of q at the end, relative to its size",
            curves(known, "end_error", floor),
            floor,
        ),
    )


SUITE = Suite(
    "workprecision", report, packages=("llvmlite", "numpy", "scipy", "sympy", "heyoka", "rebound"), runs=7
)

if __name__ == "__main__":
    sys.exit(SUITE.main())
