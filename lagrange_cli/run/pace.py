"""Runs that would take years, as where ``stop: 1e300`` is a slip: this is said once, while they run."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from lagrange_cli.decimals import decimal

PATIENCE = 5.0
"""Seconds of a run after which its pace is known well enough."""
YEAR = 365.25 * 86400
MOST = 1e300
"""The most years that are told."""


def in_years(seconds: float) -> str:
    """``3e8 years``."""
    return f"{decimal(min(seconds / YEAR, MOST), 2)} years"


class Pace:
    """Passes on how far a run to ``stop`` has come to ``show``, and tells that it takes years, if it does.

    The ``clock`` gives seconds."""

    def __init__(
        self,
        stop: float,
        show: Callable[[float], None],
        tell: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._stop, self._show, self._tell, self._clock = stop, show, tell, clock
        self._first: tuple[float, float] | None = None
        self._judged = False

    def __call__(self, t: float) -> None:
        """The motion has reached ``t``."""
        if not self._judged:
            self._judge(t, self._clock())
        self._show(t)

    def _judge(self, t: float, now: float) -> None:
        begin, began = self._first = self._first or (t, now)
        passed = now - began
        if passed < PATIENCE:
            return
        self._judged = True
        share = abs(t - begin) / abs(self._stop - begin)
        needed = passed / share if share else math.inf
        if needed >= YEAR:
            self._tell(
                f"t = {decimal(t)} after {passed:.0f} s: at this pace, the run to t = {decimal(self._stop)} "
                f"takes {in_years(needed)}; end it earlier with --stop"
            )
