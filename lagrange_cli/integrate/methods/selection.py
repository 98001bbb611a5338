"""The methods by name: what follows one motion, or many, on compiled equations."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from lagrange_cli.integrate.methods.names import TAYLOR
from lagrange_cli.records import replace

if TYPE_CHECKING:
    from lagrange_cli.integrate.compilation import Compilation
    from lagrange_cli.integrate.ensemble.method import EnsembleMethod
    from lagrange_cli.integrate.method import Method
    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.native.compilation.machine import Machine


def follower(
    machine: Machine, compilation: Compilation, improve: Callable[[], Machine] | None = None
) -> Method:
    """The method that a ``machine`` is compiled for; ``improve`` makes better code for a long run, if any."""
    if compilation.backward:
        from lagrange_cli.integrate.methods.backward import Backward

        forward = replace(compilation, backward=False)
        return Backward(follower(machine, forward, improve), machine.program)
    if compilation.method == TAYLOR:
        from lagrange_cli.integrate.methods.recompilation import Recompilation
        from lagrange_cli.integrate.methods.taylor import TaylorMethod

        return TaylorMethod(machine, None if improve is None else Recompilation(improve))
    from lagrange_cli.integrate.methods.scipy import ScipyMethod

    return ScipyMethod(machine, compilation.method, compilation.tolerance)


def ensemble_method(prepared: Prepared, alone: Callable[[], Method]) -> EnsembleMethod:
    """The method of ``prepared`` for many motions; ``alone`` makes that of single ones where it is needed."""
    if prepared.machine.follow is not None:
        from lagrange_cli.integrate.ensemble.lanes import LanesMethod

        return LanesMethod(prepared.machine, alone, prepared.compilation.backward)
    from lagrange_cli.integrate.ensemble.one_by_one import OneByOne

    return OneByOne(prepared.follower, parallel=prepared.compilation.method == TAYLOR)
