"""Runs that would take years, as where ``stop: 1e300`` is a slip: this is said once, while they run."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from lagrange_cli.decimals import decimal
from lagrange_cli.run.monitor import Progress

PATIENCE = 5.0
"""Seconds of a run after which its pace is known well enough."""
YEAR = 365.25 * 86400
MOST = 1e300
"""The most years that are told."""


def in_years(seconds: float) -> str:
    """``3e8 years``."""
    return f"{decimal(min(seconds / YEAR, MOST), 2)} years"


class Pace:
    """``Progress`` of a run to ``stop`` that is passed on; tells that the run takes years, if it does.

    The ``clock`` gives seconds."""

    def __init__(
        self,
        stop: float,
        progress: Progress,
        tell: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._stop, self._progress, self._tell, self._clock = stop, progress, tell, clock
        self._first: tuple[float, float] | None = None
        self._judged = False

    def show(self, t: float) -> None:
        """The motion has reached ``t``."""
        if not self._judged:
            self._judge(t, self._clock())
        self._progress.show(t)

    def clear(self) -> None:
        """There is nothing more to show."""
        self._progress.clear()

    def _judge(self, t: float, now: float) -> None:
        begin, began = self._first = self._first or (t, now)
        passed = now - began
        if passed < PATIENCE:
            return
        self._judged = True
        share = abs(t - begin) / abs(self._stop - begin)
        needed = passed / share if share else math.inf
        if needed >= YEAR:
            reached, whole = self._words(t, share)
            self._tell(
                f"{reached} after {passed:.0f} s: at this pace, {whole} takes {in_years(needed)}; "
                "end it earlier with --stop"
            )

    def _words(self, t: float, share: float) -> tuple[str, str]:
        """How far it has come, and what the whole is."""
        return f"t = {decimal(t)}", f"the run to t = {decimal(self._stop)}"


class PaceOfMany(Pace):
    """The same of many motions, where ``stop`` is their number: of each one on its way, the part counts that
    it has come."""

    def _words(self, t: float, share: float) -> tuple[str, str]:
        return f"{decimal(100 * share, 2)} % of all motions", "the sweep"
