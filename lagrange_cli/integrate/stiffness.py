"""Whether a motion is stiff, from a few of its Taylor steps.

Something that decays at a rate s bounds the steps of a series of order n to some n/(e s), even where it has
long decayed. The motion itself is then far smoother than these steps: many of them together are a polynomial
of low degree, to within the tolerance. Otherwise a step of a series is the longest one of all. So the fourth
derivative, by differences over several steps, tells how long a step of ``Radau`` may be (its error estimate
vanishes on polynomials of degree 3). No time is measured: the same motion always gives the same numbers.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.method import CheckpointSink, Observer, Snapshot
from lagrange_cli.integrate.methods.table import METHODS, STIFF
from lagrange_cli.integrate.methods.taylor import TaylorMethod
from lagrange_cli.integrate.precision import DOUBLE
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.native.interface import Interface
    from lagrange_cli.spec.values import Values

LONG = 5000
"""Taylor steps that a motion takes at least: for fewer it is not worth compiling other code."""
FIRST, SEEN, APART = 64, 32, 2
"""Steps after which a motion is judged first, by the last ones, one in so many of which is kept."""
SPANS = SEEN, SEEN // 4
"""Steps that differences are taken over. A motion may repeat itself after one of them, not after both."""
MOST, PART, GROWTH = 2048, 8, 1.2
"""A trial takes no more steps than that, and no more than that part of all. It goes on as long as steps of
``Radau`` would grow by the factor while its length doubles."""
DIFFERENCES = 4
DEAR, MATRICES = 16.0, 32.0
"""Taylor steps that take longer than one of ``Radau``, and how many numbers of its matrices for each
coordinate take as long as a Taylor step (docs/engine.md)."""
DIGITS = 100.0
"""The coordinates of a family are so many times as large as the absolute tolerance."""


@dataclass(frozen=True)
class Stiffness:
    """A step of ``Radau`` at the ``tolerance`` replaces so many Taylor steps."""

    tolerance: float
    replaces: float

    def repays(self, implicit: Interface) -> bool:
        """Whether such a step takes less time."""
        return self.replaces >= max(DEAR, implicit.work / (MATRICES * implicit.degrees))


@dataclass(frozen=True)
class Trial:
    """The beginning of a motion, by Taylor steps; coordinates with the same number among ``families`` are
    measured alike."""

    method: TaylorMethod
    families: Sequence[int]
    parameters: Array
    state: Array
    times: Times
    threads: int | None = 1

    def on(self, begin: Snapshot | None, until: int, every: int) -> list[Snapshot]:
        """The motion at every so many steps from there until it has taken that many; nothing if it ends
        before."""
        kept, taken = list[Snapshot](), 0

        def due(steps: int) -> bool:
            nonlocal taken
            taken = steps
            return steps % every == 0

        checkpoints = CheckpointSink(begin, due, kept.append, None, every)
        observer = Observer(interrupt=lambda t: taken >= until, checkpoints=checkpoints)
        end = self.method.follow(self.parameters, self.state, self.times, observer, self.threads)
        if end.ending is not Ending.INTERRUPTED or end.snapshot is None or end.steps != until:
            return []
        return [*kept, end.snapshot]

    def stiffness(self, tolerance: float) -> Stiffness | None:
        """That of the motion at a tolerance; None if it is not stiff, or has few steps."""
        found = self.on(None, 1, 1)
        if not found or self.times.stop - found[-1].t < LONG * (found[-1].t - self.times.start):
            return None
        taken, before = FIRST, 0.0
        while True:
            skipped = self.on(found[-1], taken - SEEN, taken - SEEN)
            found = [*skipped, *(self.on(skipped[-1], taken, APART) if skipped else [])]
            if len(found) <= SEEN // APART:
                return None
            whole = taken + SEEN * (self.times.stop - found[-1].t) / (found[-1].t - found[0].t)
            if whole < LONG:
                return None
            judged = self.judged(found, tolerance)
            if judged.replaces >= DEAR:
                return replace(judged, replaces=min(judged.replaces, whole))
            if judged.replaces < GROWTH * before or 2 * taken > min(MOST, whole / PART):
                return None
            taken, before = 2 * taken, judged.replaces

    def judged(self, found: list[Snapshot], tolerance: float) -> Stiffness:
        """What the last steps tell."""
        layout = self.method.machine.program.inner
        q, v = (np.array([one.memory[rows] for one in found]) for rows in (layout.q, layout.v))
        sizes = np.zeros(layout.degrees)
        np.maximum.at(sizes, self.families, np.abs([self.state[layout.q], *q]).max(axis=0))
        largest = float(sizes.max(initial=0.0))
        # tolerances of Radau are absolute ones as well: they are to be small beside the coordinates
        decades = max(0, -round(math.log10(largest))) if largest > 0 else math.inf
        fine = float(f"{tolerance / 10.0**decades:.12g}")
        if fine < METHODS[STIFF].tolerances[DOUBLE][0] or np.any((sizes > 0) & (sizes < DIGITS * fine)):
            return Stiffness(fine, 0.0)
        fastest = np.abs(v).max(axis=0)
        allowed = np.concatenate([np.full_like(sizes, tolerance * largest), fine * (1 + fastest)])
        t, y = np.array([one.t for one in found]), np.hstack([q, v])
        usual = (t[-1] - t[0]) / SEEN
        replaces = min(smooth(t[-n:], y[-n:], allowed) for n in (span // APART + 1 for span in SPANS)) / usual
        return Stiffness(fine, replaces)


def smooth(t: Array, y: Array, allowed: Array) -> float:
    """The length within which a motion is a cubic polynomial, as far as differences of the states y (n, rows)
    tell."""
    places = np.linspace(0, len(t) - 1, DIFFERENCES + 1).astype(int)
    t, y = t[places], y[places]
    for k in range(1, DIFFERENCES + 1):
        y = (y[1:] - y[:-1]) / (t[k:] - t[:-k])[:, None]
    error = math.sqrt(float(np.mean((y[0] / allowed) ** 2)))
    return float(error ** (-1 / DIFFERENCES)) if error > 0 else math.inf


def families_of(coordinates: Sequence[str]) -> list[int]:
    """The number of the family of each coordinate."""
    numbers = dict[str, int]()
    return [numbers.setdefault(one.partition("[")[0], len(numbers)) for one in coordinates]


def stiffness(prepared: Prepared, values: Values, times: Times, threads: int | None = 1) -> Stiffness | None:
    """That of a motion which is prepared for Taylor steps; None if it is not stiff."""
    follower, program = prepared.follower, prepared.machine.program
    if not isinstance(follower, TaylorMethod) or program.guarded or program.parts > 1:
        return None
    parameters = np.array([values.parameters[name] for name in program.parameters], np.float64)
    state = np.concatenate([values.q, values.v, np.zeros(len(program.integrals))])
    method, whole = replace(follower, recompilation=None), replace(times, count=1, step=0.0)
    trial = Trial(method, families_of(prepared.recording.coordinates), parameters, state, whole, threads)
    return trial.stiffness(prepared.compilation.tolerance)
