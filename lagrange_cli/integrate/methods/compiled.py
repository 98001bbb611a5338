"""``CompiledEquations``: the code that a motion is followed by."""

from __future__ import annotations

from lagrange_cli.integrate.events import Judge, no_energy
from lagrange_cli.integrate.methods.recompilation import Recompilation
from lagrange_cli.native.compilation.machine import Machine
from lagrange_cli.records import dataclass


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
    recompilation: Recompilation | None = None
    """Code for long runs, where that of ``machine`` was compiled in a hurry."""
    beside: Beside | None = None
    """How the motion differs from that of a run, if it is for a companion."""
    jumping: Judge = no_energy
    """The energy that jumps with values of the parameters, which actions set."""
