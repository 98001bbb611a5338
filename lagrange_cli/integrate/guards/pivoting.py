"""The choice of modes that depend on one another, and of what leads on from where an argument is 0."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from lagrange_cli.integrate.arrays import Array

PATIENCE = 8
"""How often so many are changed together that there are no fewer wrong ones then."""

OTHERWISE = 16
"""So many rounds hold one thing at a time again, as many others all that should be held."""


class Pivoting:
    """Which of several guards that depend on one another change their modes at a time: all of them, as long
    as this leads to fewer; else the last one, which always ends (K. G. Murty 1974; J. J. Judice and F. M.
    Pires, Computers and Operations Research 21, 1994)."""

    def __init__(self) -> None:
        self._fewest, self._left = np.inf, PATIENCE

    def singly(self, let_go: bool, turn: int | None) -> bool:
        """Whether one thing at a time is held again, which may hold all that constraints bind to it: that
        mostly ends where something is ``let_go``. If all is tried once more, it changes from ``turn`` to
        turn."""
        if turn is not None:
            return let_go == (turn // OTHERWISE % 2 == 0)
        return let_go or self._left == 0

    def chosen(self, wrong: Sequence[int]) -> Sequence[int]:
        """Those of the ``wrong`` ones that change."""
        if len(wrong) < self._fewest:
            self._fewest, self._left = len(wrong), PATIENCE
        elif self._left == 0:
            return [max(wrong)]
        else:
            self._left -= 1
        return wrong


def dip(u: Array) -> float:
    """How far below 0 a series without its first coefficient falls before it rises; 0 if it rises at once, or
    not at all."""
    first = next((m for m, one in enumerate(u.tolist()) if one != 0.0), None)
    if first is None or u[first] > 0.0:
        return 0.0
    rises = first + np.flatnonzero(u[first:] > 0.0)
    if not len(rises):
        return 0.0
    times = (-u[first] / u[rises]) ** (1.0 / (rises - first))
    soon = int(np.argmin(times))
    falls = np.fmax(-u[: rises[soon]], 0.0)
    return float(np.sum(falls * times[soon] ** np.arange(1, len(falls) + 1)))
