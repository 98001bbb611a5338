"""Programs that integrate a motion, each adapted once, in a module of its own name.

A module has some of these functions, and is imported only when it is asked for. Its imports are not timed.

- ``engine(motion, **options)`` prepares it for one of ``benchmarks.motions``;
- ``printed(equations, times, **options)`` for equations that ``lagrange equations`` has printed;
- ``ensemble(motion, **options)`` for many motions at once;
- ``section(motion, **options)`` for where the first coordinate of many motions rises through 0.

Each returns an ``Engine``, the last one a ``Cutter``. All numbers in equations are constants, and factors of
1 are omitted: other programs run faster this way.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from benchmarks.motions.motion import Motion
    from benchmarks.motions.printed import Printed

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Course:
    """States q and v, one above the other, (2 n, k): at k times, or the ends of k motions; and the steps.

    Where a motion ended early, the rest is nan. Several motions at once have a mean number of steps.
    """

    states: Array
    steps: float


@dataclass(frozen=True)
class Engine:
    """Seconds it took to prepare; what follows the motion from its initial state (2 n,); and the bytes that
    it works on for each coordinate and order, if they are known.

    An engine for ensembles follows the motions from initial states (2 n, members) to their ends.
    """

    prepare: float
    follow: Callable[[Array], Course]
    bytes: float = math.nan


@dataclass(frozen=True)
class Crossings:
    """Crossings of motions: their times (members, k), the states there (2 n, members, k), and the mean number
    of steps of a member."""

    times: Array
    states: Array
    steps: float


@dataclass(frozen=True)
class Cutter:
    """Seconds it took to prepare; and what finds crossings from initial states (2 n, members)."""

    prepare: float
    follow: Callable[[Array], Crossings]


Maker = Callable[["Motion"], Engine]


def engine(peer: str, motion: Motion, **options: Any) -> Engine:
    """Prepare a peer for a motion, in this process: call it in a process of its own, without warm caches."""
    made: Engine = import_module(f"{__name__}.{peer}").engine(motion, **options)
    return made


def ensemble(peer: str, motion: Motion, **options: Any) -> Engine:
    """Prepare a peer for many motions that differ in their initial states."""
    made: Engine = import_module(f"{__name__}.{peer}").ensemble(motion, **options)
    return made


def section(peer: str, motion: Motion, **options: Any) -> Cutter:
    """Prepare a peer for the crossings of many motions that differ in their initial states."""
    made: Cutter = import_module(f"{__name__}.{peer}").section(motion, **options)
    return made


def printed(peer: str, equations: Printed, times: Array, **options: Any) -> Engine:
    """Prepare a peer for printed equations and samples at ``times`` (k,), the first of which is the start."""
    made: Engine = import_module(f"{__name__}.{peer}").printed(equations, times, **options)
    return made
