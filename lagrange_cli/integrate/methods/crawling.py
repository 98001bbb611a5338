"""Motions whose steps become shorter and shorter, as under the force sin(1/(t - a)) before t = a.

The length of a step follows from the smoothness of the motion. Near a pole it is a fraction of the distance d
from it, and some hundred steps come as near as numbers can. But where a motion oscillates faster and faster
towards a place, steps are like d^2, so that after n of them d is like 1/n: it would never end. Therefore t is
recorded after 2^k steps. Each doubling of the number of steps advances t twice as far as the one before in an
ordinary motion; here half as far.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lagrange_cli.native.state import Clock

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array

FIRST, ENOUGH = 1 << 18, 1 << 21
"""Steps before the first mark, and before a motion crawls at least."""
SHRINKS = 0.75
"""The progress with twice as many steps is at most this part of the one before, twice in a row."""
LITTLE = 2.0**-12
"""The progress is at most this fraction of the whole time so far."""
CLOSE = 2.0**-6
"""If the stop time is so close to the limit, in terms of the progress, reaching it would take very many
steps."""


def steps_to_mark(steps: int) -> int:
    """After how many more steps the next mark is due."""
    return max(FIRST, 1 << steps.bit_length()) - steps


def crawls(clock: Array, steps: int, elapsed: float, stop: float) -> bool:
    """Record how far a motion has come. Returns whether it would not reach ``stop`` with any number of steps.

    ``PROGRESS`` is negative where it is less than the one before.
    """
    now = float(clock[Clock.TIME]) + float(clock[Clock.TIME_LOW])
    progress, before = now - float(clock[Clock.MARK]), float(clock[Clock.PROGRESS])
    shrinks = progress <= SHRINKS * abs(before) and steps > FIRST
    clock[Clock.MARK], clock[Clock.PROGRESS] = now, -progress if shrinks else progress
    if not (shrinks and before < 0.0 and steps >= ENOUGH and progress <= LITTLE * elapsed):
        return False
    ratio = progress / -before
    return bool(now + progress * (ratio / (1.0 - ratio) - CLOSE) <= stop)
