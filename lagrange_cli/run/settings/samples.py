"""The samples of a motion: their number and their spacing."""

from __future__ import annotations

import math

from lagrange_cli.decimals import decimal, scientific
from lagrange_cli.errors import UsageError
from lagrange_cli.integrate.precision import FULL_PRECISION
from lagrange_cli.limits import way_out, whole

DEFAULT_SAMPLES = 1001
MOST_SAMPLES = whole("samples")


def sample_times(start: float, stop: float, samples: int | None, step: float | None) -> tuple[int, float]:
    """How many samples there are, and how far apart.

    With ``step`` they are at start + i*step, and at ``stop``: the last interval is shorter where that is not
    a whole number of steps away, up to rounding. Else they divide the time from ``start`` to ``stop`` evenly.
    Where ``stop`` is before ``start``, the step that is returned is negative; the one given may be.
    """
    if not math.isfinite(start) or not math.isfinite(stop):
        raise UsageError(
            f"the motion must start and stop at finite times, not at {decimal(start)} and {decimal(stop)}"
        )
    if stop == start:
        raise UsageError(f"the motion stops where it starts, at t = {decimal(start)}: give another stop time")
    if step is None:
        count = DEFAULT_SAMPLES if samples is None else samples
        if count < 2:
            raise UsageError(f"at least 2 samples are needed, the start and the end, not {count}")
        check_count(count)
        return count, (stop - start) / (count - 1)
    if not math.isfinite(step) or step == 0:
        raise UsageError(f"the step between samples must be a positive number, not {decimal(step)}")
    if step < 0 < stop - start:
        raise UsageError(
            f"a step of {decimal(step)} leads away from stop = {decimal(stop)}, which is after "
            f"start = {decimal(start)}: "
            "give a positive step"
        )
    step = math.copysign(step, stop - start)
    ratio = (stop - start) / step
    check_count(ratio)
    nearest = round(ratio)
    divides = abs(ratio - nearest) <= 1e-9 + 4 * FULL_PRECISION * ratio
    if nearest < 1 or (ratio < 1 and not divides):
        raise UsageError(
            f"the step between samples ({decimal(abs(step))}) is longer than the motion "
            f"({decimal(abs(stop - start))}); "
            "give a shorter step"
        )
    return (nearest if divides else math.ceil(ratio)) + 1, step


def check_count(count: float) -> None:
    """Refuse more samples than a disk holds."""
    if count > MOST_SAMPLES:
        raise UsageError(
            f"{decimal(count, 3)} samples are more than the {scientific(MOST_SAMPLES, 0)} that "
            "can be written; "
            f"ask for fewer, {way_out('samples')}"
        )
