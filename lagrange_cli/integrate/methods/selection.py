"""The method that follows one motion on compiled equations, by its name."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Protocol

from lagrange_cli.integrate.methods.table import METHODS
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.integrate.method import Method
    from lagrange_cli.native.compilation.machine import Machine


class MethodModule(Protocol):
    """The interface of a module named in ``METHODS``."""

    def follower(
        self, machine: Machine, compilation: Compilation, improve: Callable[[], Machine] | None
    ) -> Method:
        """The method on equations compiled for it; ``improve`` makes better code for a long run, if any."""


def follower(
    machine: Machine, compilation: Compilation, improve: Callable[[], Machine] | None = None
) -> Method:
    """The method that a ``machine`` is compiled for; ``improve`` makes better code for a long run, if any."""
    if compilation.backward:
        from lagrange_cli.integrate.methods.backward import Backward

        forward = replace(compilation, backward=False)
        return Backward(follower(machine, forward, improve), machine.program)
    # The module's name stands in the table: a system file only says which row.
    module: MethodModule = import_module(f"{__package__}.{METHODS[compilation.method].module}")
    return module.follower(machine, compilation, improve)
