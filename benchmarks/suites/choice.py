"""Whether `--method auto` chooses the fastest method: processor time at the same error, integration alone.

The time of auto's method, relative to the least time in which any method has as small an error, is 1 where
the choice is the best one. Times between tolerances are interpolated. Some 150 motions take half an hour.
"""

from __future__ import annotations

import math
import sys
from argparse import Namespace
from collections import defaultdict
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, TimeoutError
from dataclasses import dataclass
from multiprocessing import get_context
from statistics import median

from benchmarks.harness.report import Report, Requirement, markdown_table
from benchmarks.harness.suite import Suite
from benchmarks.motions.followed import ASKED, DEFAULT, Curves, Point, curves
from benchmarks.motions.varied import GROUPS, Varied, varied

PATIENCE = 120.0
"""Seconds of the clock that a motion may take."""
ROUNDING, ALIKE = 3.0, 2.0
"""Errors up to so many times that of the reference are all due to rounding; at full precision errors that
differ by less than the second factor are as small."""
FAIR, LONGER = 1.3, 1e-3
"""Ratios that count as more than noise, and the seconds that a run has to take longer."""
SMALL = 30
"""Members up to which motions are measured by ``--quick``."""


@dataclass(frozen=True)
class Judged:
    """A choice: the ratio of its time to that of the ``best`` method, and how many seconds it is longer."""

    motion: Varied
    tolerance: float
    method: str
    best: str
    ratio: float
    longer: float

    @property
    def fair(self) -> bool:
        """Whether no other method is much faster."""
        return self.ratio <= FAIR or self.longer < LONGER


def least_time(points: Sequence[Point], error: float) -> float:
    """The least time of a method for an error; between two runs it is a power of the error."""
    times = [one.seconds for one in points if one.error <= error]
    for worse in points:
        for better in points:
            if worse.error > error >= better.error and worse.seconds < better.seconds:
                part = math.log(error / worse.error) / math.log(better.error / worse.error)
                times.append(worse.seconds ** (1 - part) * better.seconds**part)
    return min(times, default=math.inf)


def judged(motion: Varied, found: Curves) -> Iterator[Judged]:
    """Every choice of a motion that the chosen method follows."""
    by_method = defaultdict[str, list[Point]](list)
    for point in found.points:
        by_method[point.method].append(point)
    for tolerance, (method, fine) in found.chosen.items():
        mine = [one.error for one in by_method[method] if one.tolerance == fine]
        if not mine:
            continue
        error = max(ALIKE * mine[0], ROUNDING * found.floor) if tolerance == DEFAULT else mine[0]
        times = {name: least_time(points, error) for name, points in by_method.items()}
        best = min(times, key=lambda name: times[name])
        ratio, longer = times[method] / times[best], times[method] - times[best]
        yield Judged(motion, tolerance, method, best, ratio, longer)


def measured(motions: Sequence[Varied]) -> Iterator[Judged]:
    """The choices of all motions, each measured in a process of its own; one that takes too long is left
    out."""
    for motion in motions:
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
            task = pool.submit(curves, motion)
            try:
                found = task.result(PATIENCE)
            except TimeoutError:
                print(f"{motion.name}: left out after {PATIENCE:g} s", file=sys.stderr)
                for process in list(pool._processes.values()):  # no public way to end a call
                    process.kill()
                continue
        if found.failed:
            print(f"{motion.name}: {found.failed}", file=sys.stderr)
        for one in judged(motion, found):
            print(f"{motion.name}, {one.tolerance:.2g}: {one.method}, {one.ratio:.2f}", file=sys.stderr)
            yield one


def measure(options: Namespace) -> Report:
    """A table of all groups, and one of the choices that are not the best."""
    listed = [one for one in varied(options.seed) if options.only in one.group]
    if options.quick:
        listed = [one for one in listed if int(one.sizes.get("N", "1")) <= SMALL]
    found = list(measured(listed))
    rows, slower = list[tuple[str, ...]](), [one for one in found if not one.fair]
    for group in GROUPS:
        for tolerance in ASKED:
            these = [one for one in found if one.motion.group == group and one.tolerance == tolerance]
            if these:
                ratios = [one.ratio if one.longer >= LONGER else min(one.ratio, FAIR) for one in these]
                methods = ", ".join(
                    f"{name} {sum(one.method == name for one in these)}"
                    for name in sorted({one.method for one in these})
                )
                numbers = f"{median(ratios):.2f}", f"{max(ratios):.2f}"
                rows.append((group, f"{tolerance:.2g}", str(len(these)), methods, *numbers))
    table = markdown_table(("group", "tolerance", "motions", "chosen", "median", "largest"), rows)
    worse = markdown_table(
        ("motion", "tolerance", "chosen", "fastest", "ratio", "ms longer"),
        [
            (
                *(one.motion.name, f"{one.tolerance:.2g}", one.method, one.best),
                *(f"{one.ratio:.2f}", f"{1e3 * one.longer:.1f}"),
            )
            for one in slower
        ],
    )
    said = f"Choices with a ratio above {FAIR:g} that take a millisecond longer:"
    part = len(slower) / len(found) if found else math.nan
    return Report(
        (table, said, worse if slower else "none"),
        (Requirement(f"part of choices with a ratio above {FAIR:g}", part, "<=", 0.1),),
    )


SUITE = Suite(
    "choice",
    measure,
    packages=("llvmlite", "numpy"),
    runs=1,
    quick=f"motions of up to {SMALL} members only",
    draws=True,
    parts=GROUPS,
)

if __name__ == "__main__":
    sys.exit(SUITE.main())
