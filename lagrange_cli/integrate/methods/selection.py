"""The methods by name: what follows one motion, or many, on compiled equations."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Protocol

from lagrange_cli.integrate.methods.table import METHODS
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.integrate.ensemble.method import EnsembleMethod
    from lagrange_cli.integrate.method import Method
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.native.compilation.machine import Machine


class MethodModule(Protocol):
    """What a module named in ``METHODS`` offers."""

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
    module: MethodModule = import_module(f"{__package__}.{METHODS[compilation.method].module}")
    return module.follower(machine, compilation, improve)


def ensemble_method(prepared: Prepared, alone: Callable[[], Method]) -> EnsembleMethod:
    """The method of ``prepared`` for many motions; ``alone`` makes that of single ones where it is needed."""
    if prepared.machine.follow is not None:
        from lagrange_cli.integrate.ensemble.lanes import LanesMethod

        return LanesMethod(prepared.machine, alone, prepared.compilation.backward)
    from lagrange_cli.integrate.ensemble.one_by_one import OneByOne

    return OneByOne(prepared.follower, parallel=METHODS[prepared.compilation.method].parallel)
