"""``Reference``: a motion known better than any contender gives it, and how well it is known.

It is the mean of three motions by the Taylor method, all of the highest order and with steps several times as
short as those for full double precision: their truncation is nothing, and the compensated sums of the
stepping loop make the rounding less the shorter the steps are. The step lengths differ, so the roundings do,
and the largest distance between two of them tells the error. Where neighbouring motions part, no motion is
known for long: the reference ends where its error exceeds what is asked of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.contest.following import SAMPLES, Followed, evenly
from lagrange_cli.errors import MotionError
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from numpy.typing import NDArray

TOLERANCES = (1e-44, 1e-47, 1e-50)
"""What they are computed with: steps from a quarter to a sixth of those for 2^-52."""
ROUNDING = 2.0**-53
"""The error of the doubles that it is kept in, whatever else there is."""
SHORTEST = 1e-9
"""Of the time asked for: where less of it can be known, nothing is compared."""


@dataclass(frozen=True)
class Reference:
    """The motion at ``times``: ``q`` of shape (samples, coordinates), and ``sizes`` (coordinates,) of each.

    ``error`` is that of q, relative to the sizes. Where the times end before ``asked``, ``reason`` says why.
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
    runs: Sequence[Callable[[Times], Followed]], start: float, stop: float, good: float, groups: Sequence[str]
) -> Reference:
    """The reference from ``start`` to ``stop``, or as far as it is known to ``good``.

    ``runs`` are the ways to follow it. ``groups`` has a label for each coordinate: those with the same
    one are measured against the largest of them.

    Raises ``MotionError`` where next to nothing of the motion can be known so well.
    """
    asked, reason = stop, ""
    while abs(stop - start) > SHORTEST * abs(asked - start):
        times = evenly(start, stop)
        found = [run(times) for run in runs]
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
        reason = why(found, good) if known == count else f"no further is it known to {good:g}"
        stop = start + round_down(times.step * (known - 1) if known > 1 else times.step / 2)
    raise MotionError(f"the motion has no reference to be held against: {reason}")


def leading(holds: NDArray[np.bool_]) -> int:
    """How many are true before the first that is not."""
    return len(holds) if holds.all() else int(np.argmin(holds))


def why(found: Sequence[Followed], good: float) -> str:
    """What kept the shortest of the motions from going on."""
    outcome = min(found, key=lambda each: len(each.q)).outcome
    if outcome.ending is Ending.INTERRUPTED:
        return "it takes longer than --budget allows to follow it on"
    return outcome.message


def round_down(duration: float) -> float:
    """To two digits, for people, and for machines that round otherwise to compare the same; one backward in
    time is negative."""
    unit = math.copysign(10.0 ** (math.floor(math.log10(abs(duration))) - 1), duration)
    return math.floor(duration / unit * (1 + 1e-12)) * unit


def running_sizes(q: NDArray[np.float64], groups: Sequence[str]) -> NDArray[np.float64]:
    """How large each coordinate has been until each sample, with all of its group: the shape of ``q``."""
    sizes = np.maximum.accumulate(np.abs(q), axis=0)
    labels = np.array(groups)
    for label in set(groups):
        members = labels == label
        sizes[:, members] = sizes[:, members].max(axis=1, keepdims=True)
    return sizes


def relative(differences: NDArray[np.float64], sizes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Differences over sizes; of what stays 0, no difference is small."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(differences == 0, 0.0, differences / sizes)
