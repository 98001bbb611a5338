"""``CompiledEquations``: the code that a motion is followed by."""

from __future__ import annotations

from collections.abc import Callable

from lagrange_cli.integrate.background import Work
from lagrange_cli.integrate.events import Judge, no_energy
from lagrange_cli.native.compilation.machine import Machine
from lagrange_cli.records import dataclass

PATIENCE = 0.1
"""Seconds that a run takes before better code is compiled for it."""


class Recompilation:
    """Code that takes long to compile, for runs that have begun with quickly compiled code: it is compiled in
    the background, and gives the same results to the last bit."""

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


@dataclass(frozen=True)
class Beside:
    """How the ``number``-th companion of a run differs from it (see ``integrate.certify.companion``): its
    first step is shorter, the momenta that it keeps are rounded otherwise (``perturbation``), and it begins
    ``late`` by so little time."""

    number: int
    late: float = 0.0


@dataclass(frozen=True)
class CompiledEquations:
    """The compiled equations of a motion, and what goes with them."""

    machine: Machine
    tolerance: float = 0.0
    """The relative one of its steps."""
    recompilation: Recompilation | None = None
    """Code for long runs, where that of ``machine`` was compiled in a hurry."""
    beside: Beside | None = None
    """How the motion differs from that of a run, if it is for a companion."""
    jumping: Judge = no_energy
    """The energy that jumps with values of the parameters, which actions set."""
