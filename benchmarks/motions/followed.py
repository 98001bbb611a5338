"""Curves of processor time and error of every method on one motion: integration alone."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.motions.varied import Varied
from lagrange_cli.errors import LagrangeError
from lagrange_cli.integrate.compilation import Compilation
from lagrange_cli.integrate.outcome import Outcome
from lagrange_cli.integrate.prepare import prepare_system
from lagrange_cli.integrate.prepared import Prepared
from lagrange_cli.integrate.run import integrate
from lagrange_cli.integrate.times import Times
from lagrange_cli.run.derive import derive_system
from lagrange_cli.run.monitor import untimed
from lagrange_cli.run.motion import Motion
from lagrange_cli.run.request import Request
from lagrange_cli.run.settings.settings import resolve_settings
from lagrange_cli.run.start import consistent_values
from lagrange_cli.run.trial import settled
from lagrange_cli.spec.read import read_spec
from lagrange_cli.spec.spec import SolveDefaults
from lagrange_cli.spec.values import resolve_values

DEFAULT = 2.0**-52
ASKED = (DEFAULT, 1e-10, 1e-6)
"""Tolerances that a user asks for."""
TRIED = {
    "taylor": (1e-3, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, DEFAULT),
    "ias15": (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-13, DEFAULT),
    "DOP853": (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 2.3e-14),
    "Radau": (1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12),
}
FINEST = (
    ("taylor", 1e-21), ("taylor", 1e-23), ("ias15", DEFAULT), ("taylor", DEFAULT), ("DOP853", 2.3e-14),
    ("Radau", 1e-12),
)  # fmt: skip
"""Where the true motion is taken from: the first two of these that reach the end."""
BUDGET, FINE_BUDGET = 1.5, 8.0
"""Processor seconds that a run may take."""
SAMPLES = 9
LATEST = 200.0
KNOWN = 1e-8
"""The true motion is followed as long as it is known to this part of its size."""
SMALL = 1e-3
"""Errors are relative to the largest value of a coordinate or velocity, or to this part of that of all."""
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Point:
    """A run of a method: processor seconds of the integration and of preparing it, its error at the samples,
    steps and evaluations."""

    method: str
    tolerance: float
    seconds: float
    prepare: float
    error: float
    steps: int
    evaluations: int


@dataclass(frozen=True)
class Curves:
    """What was found: the methods that auto chooses at the tolerances that are asked for, with their
    tolerances; all runs; and the error of the true motion. If that is not known, ``failed`` says why."""

    chosen: Mapping[float, tuple[str, float]]
    points: Sequence[Point] = ()
    floor: float = math.nan
    failed: str = ""


@dataclass
class Followed:
    """A motion that is followed by several methods, each compiled once."""

    case: Varied
    ready: dict[tuple[str, float], tuple[Prepared, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        spec = read_spec(self.case.text, self.case.kind, self.case.sizes)
        values = resolve_values(spec)
        self.stop = self.case.stop or min(spec.solve.stop or LATEST, LATEST)
        self.spec, self.values, _ = consistent_values(spec, values, 0.0, ())

    def chosen(self, tolerance: float) -> tuple[str, float]:
        """The method that auto chooses at first, and its tolerance."""
        given = SolveDefaults(
            stop=self.stop, tolerance=tolerance, samples=SAMPLES, outputs=("q", "v"), method="auto"
        )
        settings = resolve_settings(self.spec, given, cached=False)
        motion = Motion(self.spec, self.values, settings)
        if motion.may_be_stiff:
            motion, _ = settled(motion, Request(cache=False), untimed)
        return motion.settings.method, motion.settings.tolerance

    def prepared(self, method: str, tolerance: float) -> tuple[Prepared, float]:
        """The compiled system, and the seconds that it took."""
        key = method, tolerance
        if key not in self.ready:
            began = time.process_time()
            asked = Compilation(method, tolerance, frozenset({"q", "v"}))
            made = prepare_system(self.spec, derive_system, None, asked)
            self.ready[key] = made, time.process_time() - began
        return self.ready[key]

    def run(self, method: str, tolerance: float, budget: float) -> tuple[Array, Outcome, float]:
        """The samples (samples, coordinates and velocities), the outcome, and processor seconds.

        Raises ``LagrangeError`` where the method does not reach the end.
        """
        prepared, _ = self.prepared(method, tolerance)
        paths = [one.path for one in prepared.recording.states if one.path.startswith(("q/", "v/"))]
        chunks = list[Array]()

        def emit(chunk: dict[str, Any]) -> None:
            count = len(chunk["t"])
            chunks.append(np.concatenate([chunk[path].reshape(count, -1) for path in paths], axis=1))

        times, began = Times(0.0, self.stop, SAMPLES, self.stop / (SAMPLES - 1)), time.process_time()
        outcome = integrate(prepared, self.values, times, emit, lambda: time.process_time() - began > budget)
        seconds = time.process_time() - began
        if outcome.ending.status != "complete":
            raise LagrangeError(f"{method} at {tolerance:g}: {outcome.message}")
        return np.concatenate(chunks), outcome, seconds

    def point(self, method: str, tolerance: float, true: Array, sizes: Array, floor: float) -> Point:
        """A run, and the least time of several where it is short."""
        samples, outcome, seconds = self.run(method, tolerance, BUDGET)
        again = 7 if seconds < 0.01 else 3 if seconds < 0.1 else 1 if seconds < 0.5 else 0
        least = min([seconds, *(self.run(method, tolerance, BUDGET)[2] for _ in range(again))])
        error = max(floor, float(np.max(np.abs(samples - true) / sizes)))
        prepare = self.prepared(method, tolerance)[1]
        return Point(method, tolerance, least, prepare, error, outcome.steps, outcome.evaluations)

    def true(self) -> tuple[Array, Array]:
        """Two motions that are as accurate as can be.

        Raises ``LagrangeError`` where there are none.
        """
        found, failed = list[Array](), list[str]()
        for method, tolerance in FINEST:
            try:
                found.append(self.run(method, tolerance, FINE_BUDGET)[0])
            except LagrangeError as error:
                failed.append(str(error))
            if len(found) == 2:
                return found[0], found[1]
        raise LagrangeError("; ".join(failed))


def curves(case: Varied) -> Curves:
    """All runs of a motion, and what auto chooses."""
    one = Followed(case)
    chosen = {tolerance: one.chosen(tolerance) for tolerance in ASKED}
    while True:
        try:
            true, other = one.true()
        except LagrangeError as error:
            return Curves(chosen, failed=str(error))
        largest = np.abs(true).max(axis=0)
        sizes = np.maximum(largest, SMALL * max(largest.max(), SMALL))
        apart = float(np.max(np.abs(true - other) / sizes))
        if apart <= KNOWN:
            break
        one.stop /= 2
    floor, points = max(apart, DEFAULT / 2), list[Point]()
    for method, tolerances in TRIED.items():
        asked = {fine for name, fine in chosen.values() if name == method}
        for tolerance in sorted({*tolerances, *asked}, reverse=True):
            try:
                points.append(one.point(method, tolerance, true, sizes, floor))
            except LagrangeError:
                break  # finer ones take longer, or the method refuses the system
    return Curves(chosen, points, floor)
