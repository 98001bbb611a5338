"""``Motion``: what every method gives the run, chunk after chunk of samples."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import dataclass

Interrupt = Callable[[float], bool]
"""Told the time reached, several times a second; True to stop there."""
Accept = Callable[[Array, Array], None]
"""Takes sample times (c,) and states (rows, c) with rows q, v and integrals, which stay as they are until it
has been called again; it must not keep them for longer."""


@dataclass(frozen=True)
class Snapshot:
    """Where a method can go on from, to the same bits: ``memory`` is all that it knows of the motion, at
    time ``t``.

    ``steps`` have been taken, and ``samples`` handed over. Unless they were ``limited``, the steps so far are
    those of every motion that ends later, too.
    """

    memory: Array
    t: float
    steps: int
    samples: int
    limited: bool = False


@dataclass(frozen=True)
class End:
    """Why a method stopped, where (time and state: q, v), what it took, and where it can go on from, if it
    can."""

    ending: Ending
    t: float
    state: Array
    steps: int
    evaluations: int
    detail: str = ""
    snapshot: Snapshot | None = None


@dataclass(frozen=True)
class CheckpointSink:
    """Where a method begins (None: at the start), and whom it gives snapshots.

    ``due`` is asked several times a second, with the steps taken; where it says so, all samples before it
    are handed over, and ``keep`` is given a snapshot. ``ends`` is given the one that a longer motion can go
    on from, if there is one, when the samples up to it are handed over.
    """

    begin: Snapshot | None
    due: Callable[[int], bool]
    keep: Callable[[Snapshot], None]
    ends: Callable[[Snapshot], None] | None = None


NO_CHECKPOINTS = CheckpointSink(None, lambda steps: False, lambda snapshot: None)


class Method(Protocol):
    """A way to follow a motion."""

    def follow(
        self,
        parameters: Array,
        state: Array,
        times: Times,
        accept: Accept,
        interrupt: Interrupt,
        checkpoints: CheckpointSink = NO_CHECKPOINTS,
    ) -> End:
        """Follow the motion from ``state`` (q, v, zeros for the integrals) through ``times``.

        ``accept`` is given full chunks of samples, and what there is when the motion ends, however it
        does. One that makes no snapshots ignores its ``checkpoints``.
        """
        ...
