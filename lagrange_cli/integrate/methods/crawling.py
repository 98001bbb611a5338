"""Motions whose steps become shorter and shorter, as under the force sin(1/(t - a)) before t = a.

The length of a step follows from the smoothness of the motion. Near a pole it is a fraction of the distance d
from it, and some hundred steps come as near as numbers can. But where a motion oscillates faster and faster
towards a place, steps are like d^2, so that after n of them d is like 1/n: it would never end. Therefore t is
recorded after 2^k steps. Each doubling of the number of steps advances t twice as far as the one before in an
ordinary motion; here half as far.

Near the edge of a domain, as of asin(x/l) or sqrt(l - x) in a position, l - x may be known to so few digits
that steps become as short as its rounding errors say. Then fewer steps are enough.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.native.state import Clock

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.integrate.workspace import Workspace

FIRST, SOME, ENOUGH = 1 << 10, 1 << 12, 1 << 21
"""Steps before the first mark, and before a motion crawls: at least so many if half of the digits are lost,
else so many."""
SHRINKS = 0.75
"""The progress with twice as many steps is at most this part of the one before, twice in a row."""
LITTLE = 2.0**-12
"""The progress is at most this fraction of the whole time so far."""
CLOSE = 2.0**-6
"""If the stop time is so close to the limit, in terms of the progress, reaching it would take very many
steps."""

HALF = 2.0**26
"""Half of the digits are lost if relative errors of coordinates are multiplied by so much."""
MOVED, STILL = 2.0**-50, 2.0**-40
"""Relative changes of coordinates by which that is found, and below which nothing moves."""


def steps_to_mark(steps: int) -> int:
    """After how many more steps the next mark is due."""
    return max(FIRST, 1 << steps.bit_length()) - steps


def crawls(
    clock: Array,
    steps: int,
    elapsed: float,
    stop: float,
    lossy: Callable[[bool], bool] = lambda _: False,
    still: Callable[[float], bool] = lambda _: False,
) -> bool:
    """Record how far a motion has come. Returns whether it would not reach ``stop`` with any number of steps.
    ``lossy`` tells whether half of the digits are lost where it is, of any force or of the largest; ``still``
    whether nothing moves in a time.

    ``PROGRESS`` is negative where it is less than the one before.
    """
    now = float(clock[Clock.TIME]) + float(clock[Clock.TIME_LOW])
    progress, before = now - float(clock[Clock.MARK]), float(clock[Clock.PROGRESS])
    shrinks = progress <= SHRINKS * abs(before) and steps > FIRST
    clock[Clock.MARK], clock[Clock.PROGRESS] = now, -progress if shrinks else progress
    if steps < SOME or progress > LITTLE * elapsed:
        return False
    if progress <= LITTLE * (stop - now) and still(progress) and lossy(True):
        return True
    if not (shrinks and before < 0.0):
        return False
    ratio = progress / -before
    endless = now + progress * (ratio / (1.0 - ratio) - CLOSE) <= stop
    return endless and (steps >= ENOUGH or lossy(False))


def loses_digits(space: Workspace, one: bool) -> bool:
    """Whether accelerations are known to half of their digits at most, as coordinates are rounded: the
    largest of them, or any ``one``."""
    return not digits_lost(space, one) <= HALF


def digits_lost(space: Workspace, one: bool = False) -> float:
    """How many times larger relative errors of accelerations are than those of coordinates: of the largest
    acceleration, or of any ``one``."""
    memory, work, q = space.memory.copy(), space.work.copy(), space.layout.q
    known = space.rates()[q]
    space.memory[q] *= 1.0 + MOVED * np.cos(np.arange(q.stop - q.start) * math.e)
    moved = space.rates()[q]
    space.memory[:], space.work[:] = memory, work
    with np.errstate(divide="ignore", invalid="ignore"):  # rates that are not finite lose all digits
        sizes, changes = np.abs(known), np.abs(moved - known)
        if not one:
            sizes = np.full_like(sizes, sizes.max())
        changed = changes != 0.0
        return float(np.max(changes[changed] / sizes[changed], initial=0.0)) / MOVED


def nothing_moves(space: Workspace, time: float) -> bool:
    """Whether hardly any coordinate changes in a time."""
    q, v = (np.abs(space.memory[one]) for one in (space.layout.q, space.layout.v))
    return bool(np.all(v * time <= STILL * q))
