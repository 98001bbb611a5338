"""Better code for runs that turn out to be long: compiled beside them, and giving the same bits."""

from __future__ import annotations

from collections.abc import Callable

from lagrange_cli.integrate.alongside import Work
from lagrange_cli.native.machine import Machine

PATIENCE = 0.1
"""Seconds that a run takes before better code for it is thought of."""


class Better:
    """Code that takes long to compile, for runs that are under way with code made quickly."""

    def __init__(self, make: Callable[[], Machine]) -> None:
        self._make = make
        self._work: Work[Machine] | None = None
        self._spent = 0.0

    def after(self, seconds: float) -> Machine | None:
        """The better code as soon as it is there, told each time how many seconds more were spent running."""
        self._spent += seconds
        if self._work is None and self._spent > PATIENCE:
            self._work = Work(self._make)
        return None if self._work is None or self._work.is_alive() else self._work.result()
