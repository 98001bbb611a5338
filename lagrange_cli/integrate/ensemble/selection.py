"""The method that follows many motions on compiled equations."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from lagrange_cli.integrate.methods.table import METHODS

if TYPE_CHECKING:
    from lagrange_cli.integrate.ensemble.method import EnsembleMethod
    from lagrange_cli.integrate.method import Method
    from lagrange_cli.integrate.prepared import Prepared


def ensemble_method(prepared: Prepared, alone: Callable[[], Method]) -> EnsembleMethod:
    """The method of ``prepared`` for many motions; ``alone`` makes that of single ones where it is needed."""
    if prepared.machine.follow is not None:
        from lagrange_cli.integrate.ensemble.lanes import LanesMethod

        return LanesMethod(prepared.machine, alone, prepared.compilation.backward)
    from lagrange_cli.integrate.ensemble.one_by_one import OneByOne

    names = tuple(name for group in prepared.recording.events for name in group.members)
    return OneByOne(prepared.follower, METHODS[prepared.compilation.method].parallel, names)
