"""``Reference``: a motion more accurate than that of any contender, with an estimate of its error.

It is the mean of three motions by the Taylor method, all of the highest order and with steps several times
shorter than for full double precision. Their truncation errors are negligible, and the compensated sums of
the stepping loop make rounding errors smaller with shorter steps. The step sizes differ, and so do the
rounding errors: the largest distance between two of the motions estimates the error. Chaotic motions cannot
be predicted for long. The reference therefore ends where its error exceeds the one required.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.decimals import decimal
from lagrange_cli.errors import MotionError
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import dataclass
from lagrange_cli.work_precision.trajectory import SAMPLES, Trajectory, evenly

if TYPE_CHECKING:
    from numpy.typing import NDArray

TOLERANCES = (1e-44, 1e-47, 1e-50)
"""Tolerances of the three motions: steps from a quarter to a sixth of those for 2^-52."""
ROUNDING = 2.0**-53
"""The rounding error of the doubles in which it is stored: a lower bound for its error."""
BUDGET = "computing the reference further would exceed --budget"
SHORTEST = 1e-9
"""The shortest part of the given time for which a reference is of use."""


@dataclass(frozen=True)
class Reference:
    """The motion at ``times``: ``q`` of shape (samples, coordinates), and ``sizes`` (coordinates,) of each.

    ``error`` is that of q, relative to the sizes. If the times end before ``asked``, ``reason`` says why.
    """

    times: Times
    q: NDArray[np.float64]
    sizes: NDArray[np.float64]
    error: float
    steps: int
    asked: float
    reason: str = ""

    def error_of(self, q: NDArray[np.float64]) -> float:
        """The largest error of a motion (samples, coordinates), relative to the sizes."""
        return float(np.max(relative(np.abs(q - self.q).max(axis=0), self.sizes)))


def find_reference(
    runs: Sequence[Callable[[Times], Trajectory]],
    start: float,
    stop: float,
    good: float,
    groups: Sequence[str],
) -> Reference:
    """The reference from ``start`` to ``stop``, or as long as its relative error is at most ``good``.

    ``runs`` are the integrations of which it is the mean. ``groups`` has a label for each coordinate: the
    errors of coordinates with the same label are relative to the largest of them.

    Raises ``MotionError`` if no useful part of the motion can be computed with this error.
    """
    asked, reason = stop, ""
    while abs(stop - start) > SHORTEST * abs(asked - start):
        times = evenly(start, stop)
        found = followed(runs, times)
        count = min(len(each.q) for each in found)
        motions = np.stack([each.q[:count] for each in found])
        q = motions.mean(axis=0)
        sizes = running_sizes(q, groups)
        apart = np.maximum.accumulate(np.ptp(motions, axis=0), axis=0)
        with np.errstate(invalid="ignore"):
            known = leading(np.all(apart <= good * sizes, axis=1))
        if known == SAMPLES:
            error = max(ROUNDING, float(np.max(relative(apart[-1], sizes[-1]))))
            steps = found[0].outcome.steps
            return Reference(times, q, sizes[-1], error, steps, asked, reason)
        larger = f"the error of the reference exceeds {decimal(good)} beyond this time"
        reason = why(found) if known == count else larger
        passed = reached(found, start)
        further = times.step * (known - 1) if known > 1 else min(times.step / 2, passed, key=abs)
        stop = start + round_down(further) if further else start
    way = "; end the motion earlier with --stop" if reason == BUDGET else ""
    raise MotionError(f"no reference solution to compare with: {reason}{way}")


def followed(runs: Sequence[Callable[[Times], Trajectory]], times: Times) -> list[Trajectory]:
    """The motions of all ``runs``; one that comes to no sample is the last."""
    found = list[Trajectory]()
    for run in runs:
        found.append(run(times))
        if len(found[-1].q) <= 1:
            break
    return found


def reached(found: Sequence[Trajectory], start: float) -> float:
    """The time in which all of them were followed."""
    return min((one.outcome.t - start for one in found), key=abs)


def leading(holds: NDArray[np.bool_]) -> int:
    """The number of leading true values."""
    return len(holds) if holds.all() else int(np.argmin(holds))


def why(found: Sequence[Trajectory]) -> str:
    """The reason why the shortest of the motions ended."""
    outcome = min(found, key=lambda each: len(each.q)).outcome
    if outcome.ending is Ending.INTERRUPTED:
        return BUDGET
    return outcome.message


def round_down(duration: float) -> float:
    """Round to two digits, so that machines with other rounding errors compare the same times; a duration
    backward in time is negative."""
    unit = math.copysign(10.0 ** (math.floor(math.log10(abs(duration))) - 1), duration)
    return math.floor(duration / unit * (1 + 1e-12)) * unit


def running_sizes(q: NDArray[np.float64], groups: Sequence[str]) -> NDArray[np.float64]:
    """The largest absolute value so far of each coordinate and its group, of the shape of ``q``."""
    sizes = np.maximum.accumulate(np.abs(q), axis=0)
    labels = np.array(groups)
    for label in set(groups):
        members = labels == label
        sizes[:, members] = sizes[:, members].max(axis=1, keepdims=True)
    return sizes


def relative(differences: NDArray[np.float64], sizes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Differences divided by sizes; infinite for a difference from a coordinate that stays 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(differences == 0, 0.0, differences / sizes)
