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
from lagrange_cli.integrate.method import CheckpointSink, Observer, Snapshot, Start
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
PRICE = 2.0**28
"""So many numbers of series are computed while other code is compiled: below that, it is not worth changing
to it on the way."""
FIRST, SEEN, APART = 64, 32, 2
"""Steps after which a motion is judged first, by the last ones, one in so many of which is kept."""
SPANS = SEEN, SEEN // 4
"""Steps that differences are taken over. A motion may repeat itself after one of them, not after both."""
MOST, PART, GROWTH = 2048, 8, 1.2
"""A trial takes no more steps than that, and no more than that part of all. It goes on as long as steps of
``Radau`` would grow by the factor while its length doubles."""
DIFFERENCES = 4
DEAR, CHEAP, MATRICES = 16.0, 4.0, 32.0
"""Taylor steps that take longer than one of ``Radau``, those that do not, and how many numbers of its
matrices for each coordinate take as long as a Taylor step (docs/engine.md)."""
SHORTER = 0.25
"""A step of ``Radau`` replaces at least about so many Taylor steps where a motion is not stiff."""
DIGITS = 100.0
"""The coordinates of a family are so many times as large as the absolute tolerance."""


@dataclass(frozen=True)
class Stiffness:
    """A step of ``Radau`` at the ``tolerance`` replaces so many Taylor steps, of about so many ``steps`` that
    are left."""

    tolerance: float
    replaces: float
    steps: float = math.inf

    def repays(self, implicit: Interface) -> bool:
        """Whether such a step takes less time."""
        return self.replaces >= max(DEAR, implicit.work / (MATRICES * implicit.degrees))


@dataclass(frozen=True)
class Trial:
    """The beginning of a motion, by Taylor steps; coordinates with the same number among ``families`` are
    measured alike."""

    method: TaylorMethod
    families: Sequence[int]
    start: Start
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
        end = self.method.follow(self.start, observer, self.threads)
        if end.ending is not Ending.INTERRUPTED or end.snapshot is None or end.steps != until:
            return []
        return [*kept, end.snapshot]

    def seen(self, begin: Snapshot, taken: int) -> list[Snapshot]:
        """The last steps until that many are taken; nothing if the motion ends before."""
        skipped = self.on(begin, taken - SEEN, taken - SEEN) if taken - SEEN > begin.steps else [begin]
        return [*skipped, *(self.on(skipped[-1], taken, APART) if skipped else [])]

    def left(self, found: Sequence[Snapshot]) -> float:
        """How many steps are left to the end, if they are as long as the last ones."""
        return SEEN * (self.start.times.stop - found[-1].t) / (found[-1].t - found[0].t)

    def stiffness(self, tolerance: float) -> Stiffness | None:
        """That of the motion at a tolerance; None if it is not stiff, or has few steps."""
        found = self.judgement(tolerance)
        return found if found is not None and found.replaces >= DEAR else None

    def judgement(self, tolerance: float) -> Stiffness | None:
        """The same where it is not stiff, too; None if it has few steps."""
        first = self.on(None, 1, 1)
        if not first or self.start.times.stop - first[-1].t < LONG * (first[-1].t - self.start.times.start):
            return None
        taken, before, begin = FIRST, 0.0, first[-1]
        while True:
            found = self.seen(begin, taken)
            if len(found) <= SEEN // APART:
                return None
            whole = taken + self.left(found)
            if whole < LONG:
                return None
            judged = self.judged(found, tolerance)
            judged = replace(judged, replaces=min(judged.replaces, whole), steps=whole)
            no_more = judged.replaces < GROWTH * before or 2 * taken > min(MOST, whole / PART)
            if judged.replaces >= DEAR or no_more:
                return judged
            taken, before, begin = 2 * taken, judged.replaces, found[-1]

    def later(self, begin: Snapshot, tolerance: float, *, known: bool) -> Stiffness | None:
        """That of the motion at a tolerance from a time on that Taylor steps have reached; None as before, or
        if implicit steps are not ``known`` yet and too few steps are left to compile these."""
        least = LONG if known else max(LONG, PRICE / max(1, self.method.machine.program.work))
        found = self.seen(begin, begin.steps + SEEN)
        if len(found) <= SEEN // APART or self.left(found) < least:
            return None
        judged = self.judged(found, tolerance)
        if judged.replaces < DEAR:
            return None
        left = self.left(found)
        return replace(judged, replaces=min(judged.replaces, left), steps=left)

    def replaced(self, begin: Snapshot, tolerance: float, length: float) -> float:
        """How many Taylor steps a step of ``Radau`` at its ``tolerance`` replaces, from a time on that it has
        reached with steps of such a ``length``: no more than these do. What has decayed appears again as
        Taylor steps begin, and has to decay."""
        found = self.seen(begin, begin.steps + FIRST)
        if len(found) <= SEEN // APART:
            return math.inf
        q, v = self.moved(found)
        sizes = np.concatenate([np.abs(one).max(axis=0) for one in (q, v)])
        possible = replaced_by(found, np.hstack([q, v]), tolerance * (1 + sizes))
        return min(possible, SEEN * length / (found[-1].t - found[-1 - SEEN // APART].t))

    def moved(self, found: Sequence[Snapshot]) -> tuple[Array, Array]:
        """Coordinates and velocities (steps, degrees)."""
        program = self.method.machine.program
        rows, own = program.inner, slice(program.degrees)
        q, v = (np.array([one.memory[part][own] for one in found]) for part in (rows.q, rows.v))
        return q, v

    def judged(self, found: Sequence[Snapshot], tolerance: float) -> Stiffness:
        """What the last steps tell."""
        q, v = self.moved(found)
        sizes = np.zeros(q.shape[1])
        np.maximum.at(sizes, self.families, np.abs([self.start.state[: q.shape[1]], *q]).max(axis=0))
        largest = float(sizes.max(initial=0.0))
        # tolerances of Radau are absolute ones as well: they are to be small beside the coordinates
        decades = max(0, -round(math.log10(largest))) if largest > 0 else math.inf
        fine = float(f"{tolerance / 10.0**decades:.12g}")
        if fine < METHODS[STIFF].tolerances[DOUBLE][0] or np.any((sizes > 0) & (sizes < DIGITS * fine)):
            return Stiffness(fine, 0.0)
        fastest = np.abs(v).max(axis=0)
        allowed = np.concatenate([np.full_like(sizes, tolerance * largest), fine * (1 + fastest)])
        return Stiffness(fine, replaced_by(found, np.hstack([q, v]), allowed))


def replaced_by(found: Sequence[Snapshot], y: Array, allowed: Array) -> float:
    """How many of the last steps one implicit step replaces, from the states y (steps, rows)."""
    t = np.array([one.t for one in found])
    spans = (span // APART + 1 for span in SPANS)
    usual = (t[-1] - t[0]) / SEEN
    return float(min(smooth(t[-n:], y[-n:], allowed) for n in spans) / usual)


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


def trial_of(prepared: Prepared, start: Start, threads: int | None = 1) -> Trial | None:
    """Of a motion that is prepared for Taylor steps; None if it is not one that implicit steps may follow."""
    follower, program = prepared.follower, prepared.machine.program
    if not isinstance(follower, TaylorMethod) or program.parts > 1:
        return None
    method = replace(follower, recompilation=None)
    unsampled = replace(start, times=replace(start.times, count=1, step=0.0))
    return Trial(method, families_of(prepared.recording.coordinates), unsampled, threads)


def stiffness(prepared: Prepared, values: Values, times: Times, threads: int | None = 1) -> Stiffness | None:
    """That of a motion which is prepared for Taylor steps; None if it is not stiff, or has switches."""
    trial = first_trial(prepared, values, times, threads)
    return None if trial is None else trial.stiffness(prepared.compilation.tolerance)


def first_trial(prepared: Prepared, values: Values, times: Times, threads: int | None = 1) -> Trial | None:
    """Where a motion begins; None if it has switches."""
    program = prepared.machine.program
    if program.guards:
        return None
    return trial_of(prepared, Start.of(program, values, times), threads)


def of_many(found: Sequence[Stiffness | None], at_once: int) -> Stiffness | None:
    """That of all members of an ensemble, from those of some of them; None where it takes less time to follow
    all by explicit steps, ``at_once`` so many, than by implicit ones, one by one. A motion with few steps
    does not count. Where one is not stiff, implicit steps may well be shorter than explicit ones."""
    known = [one for one in found if one is not None]
    stiff = [one for one in known if one.replaces >= DEAR]
    if not stiff:
        return None
    explicit = sum(one.steps for one in known)
    implicit = sum(one.steps / (one.replaces if one.replaces >= DEAR else SHORTER) for one in known)
    if explicit < DEAR * at_once * implicit:
        return None
    return Stiffness(min(one.tolerance for one in stiff), explicit / implicit, explicit)
