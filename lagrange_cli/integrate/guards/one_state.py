"""What compiled code works on, at a single state."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lagrange_cli.integrate.guards.settling import Settling
from lagrange_cli.integrate.workspace import Workspace

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array
    from lagrange_cli.native.compilation.machine import Machine


def space_at(machine: Machine, parameters: Array, t: float, state: Array) -> Workspace:
    """The memory of the code, with ``parameters`` and a ``state`` (q, v and integrals) at t, where switches
    have their modes."""
    space = Workspace(machine, state, t, 0)
    if machine.program.guards:
        Settling(machine, space.constants, space.memory, space.work).begin(parameters)
    else:
        machine.prepare(parameters.ctypes.data, space.constants.ctypes.data)
    return space
