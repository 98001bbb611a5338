"""Better code for long runs: compiled in the background, with the same results to the last bit."""

from __future__ import annotations

from collections.abc import Callable

from lagrange_cli.integrate.background import Work
from lagrange_cli.native.compilation.machine import Machine

PATIENCE = 0.1
"""Seconds that a run takes before better code is compiled for it."""


class Recompilation:
    """Code that takes long to compile, for runs that have begun with quickly compiled code."""

    def __init__(self, make: Callable[[], Machine]) -> None:
        self._make = make
        self._work: Work[Machine] | None = None
        self._spent = 0.0

    def after(self, seconds: float) -> Machine | None:
        """The better code as soon as it is ready; each call tells how many more seconds were spent
        running."""
        self._spent += seconds
        if self._work is None and self._spent > PATIENCE:
            self._work = Work(self._make)
        return None if self._work is None or self._work.is_alive() else self._work.result()
