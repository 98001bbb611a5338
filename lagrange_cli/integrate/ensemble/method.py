"""``EnsembleMethod``: the interface of the methods for many motions, which give the run batch after batch of
members."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Protocol, TypeAlias

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.events import Change, Crossings, HappenedSink
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from numpy.typing import NDArray


Index: TypeAlias = "NDArray[np.int64]"


class MemberLog(HappenedSink):
    """What happened to a member."""

    def __init__(self, names: tuple[str, ...]) -> None:
        super().__init__(names)
        self.crossings: list[Crossings] = []
        self.changes: list[Change] = []

    def crossed(self, crossings: Crossings) -> None:
        super().crossed(crossings)
        self.crossings.append(crossings)

    def changed(self, change: Change) -> None:
        self.changes.append(change)


@dataclass(frozen=True)
class EndedMembers:
    """Some members that have ended, in any order.

    ``index`` (b,) are their numbers, ``t`` (b,) and ``state`` (b, rows) the time and q, v and integrals at
    which each ended, and ``steps`` (b,) the numbers of steps. Of ``samples`` (b, rows, n), the first
    ``reached`` (b,) of each member hold values, the others nan; None if no samples were asked for. Those of a
    section have ``times`` (b, n) of their own. If there are events, ``logs`` (b) tell what happened to
    each."""

    index: Index
    ending: Sequence[Ending]
    t: Array
    state: Array
    steps: Index
    samples: Array | None
    reached: Index
    logs: Sequence[MemberLog] = ()
    times: Array | None = None

    def known(self, count: int) -> NDArray[np.bool_]:
        """Which of so many samples, or ends, hold values (b, count)."""
        ended = np.array([one not in (Ending.INTERRUPTED, Ending.INCONSISTENT) for one in self.ending])
        reached = ended.astype(np.int64) if self.samples is None else self.reached
        return np.arange(count) < reached[:, None]


Accept: TypeAlias = Callable[[EndedMembers], None]
Kept: TypeAlias = Mapping[str, Array]
"""The snapshot from which the only motion of a section is continued, to the same bits: arrays by name. The
``states`` (rows, n) are those of its crossings so far."""


@dataclass(frozen=True)
class Section:
    """The samples of each motion of a section: its first ``count`` crossings of a surface, or its states
    after as many multiples of its own of the ``periods`` (members,).

    A crossing counts where it goes in the ``direction``: +1 rising, -1 falling, 0 either. A motion ends after
    ``patience`` steps without any.
    """

    count: int
    direction: int = 0
    periods: Array | None = None
    patience: int = 0

    def only(self, members: Index | slice) -> Section:
        """The section with some members (b,) only."""
        return self if self.periods is None else replace(self, periods=self.periods[members])


@dataclass(frozen=True)
class Starts:
    """The initial values of members, and the samples asked for: ``parameters`` (members, P), ``states``
    (members, rows) of q, v and zeros for the integrals, and the sample ``times``, if they are ``sampled``; or
    a ``section``, for which ``times`` say when motions start and stop."""

    parameters: Array
    states: Array
    times: Times
    sampled: bool
    section: Section | None = None

    def __len__(self) -> int:
        return len(self.states)

    def only(self, index: Index) -> Starts:
        """Some of them (b,)."""
        section = None if self.section is None else self.section.only(index)
        return replace(self, parameters=self.parameters[index], states=self.states[index], section=section)


class EnsembleMethod(Protocol):
    """A method for many motions."""

    def follow(self, starts: Starts, accept: Accept, interrupt: Callable[[int], bool], threads: int) -> bool:
        """Integrate members from their ``starts``; returns False if stopped.

        ``accept`` is called in this thread and may keep what it is given. ``interrupt`` is called with the
        number of members that have ended, several times a second; if it returns True, all stop. Results do
        not depend on ``threads``."""
        ...
