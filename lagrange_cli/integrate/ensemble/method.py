"""``EnsembleMethod``: the interface of the methods for many motions, which give the run batch after batch of
members."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.events import Change, Crossings, HappenedSink
from lagrange_cli.integrate.method import End, Start
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


class SampleRows:
    """The samples of a motion (rows, count) as far as they are ``reached``, nan behind."""

    def __init__(self, rows: int, count: int) -> None:
        self.rows, self.reached = np.full((rows, count), np.nan), 0

    def take(self, times: Array, states: Array) -> None:
        """The next ones; where there is no room for any, they are counted only."""
        if self.rows.size:
            self.rows[:, self.reached : self.reached + len(times)] = states
        self.reached += len(times)


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

    @classmethod
    def one(
        cls, member: int, end: End, reached: int, samples: Array | None, logs: Sequence[MemberLog] = ()
    ) -> EndedMembers:
        """A single one with its ``samples`` (rows, n)."""
        index, steps, count = (np.array([number], dtype=np.int64) for number in (member, end.steps, reached))
        samples = None if samples is None else samples[None]
        return cls(index, [end.ending], np.array([end.t]), end.state[None], steps, samples, count, logs)

    @classmethod
    def unfinished(
        cls, index: Index, ending: Ending, width: int, samples: int | None, section: bool
    ) -> EndedMembers:
        """Members that did not end: nan throughout."""

        def none(*shape: int) -> Array:
            return np.full((len(index), *shape), np.nan)

        zeros, made, times = np.zeros(len(index), dtype=np.int64), None, None
        if samples is not None:
            made, times = none(width, samples), none(samples) if section else None
        endings = [ending] * len(index)
        return cls(index, endings, none(), none(width), zeros, made, zeros, times=times)

    @classmethod
    def joined(cls, batches: Sequence[EndedMembers], interrupted: bool = False) -> EndedMembers:
        """One batch of several, without members that were interrupted on the way, unless these are kept."""
        endings = [ending for batch in batches for ending in batch.ending]
        ended = np.array([interrupted or ending is not Ending.INTERRUPTED for ending in endings])

        def gathered(name: str) -> Any:
            parts = [part for batch in batches if (part := getattr(batch, name)) is not None]
            return np.concatenate(parts)[ended] if parts else None

        names = "index", "t", "state", "steps", "samples", "reached", "times"
        logs = [log for batch in batches for log in batch.logs]
        return cls(
            ending=[ending for ending, here in zip(endings, ended) if here],
            logs=[log for log, here in zip(logs, ended) if here],
            **{name: gathered(name) for name in names},
        )

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

    def of(self, member: int) -> Start:
        """That of one member."""
        return Start(self.parameters[member], self.states[member], self.times)

    def only(self, index: Index) -> Starts:
        """Some of them (b,)."""
        section = None if self.section is None else self.section.only(index)
        return replace(self, parameters=self.parameters[index], states=self.states[index], section=section)


class EnsembleMethod(Protocol):
    """A method for many motions."""

    def follow(
        self, starts: Starts, accept: Accept, interrupt: Callable[[float], bool], threads: int
    ) -> bool:
        """Integrate members from their ``starts``; returns False if stopped.

        ``accept`` is called in this thread and may keep what it is given. ``interrupt`` is called with the
        number of members that have ended, and the parts of those on their way, several times a second; if it
        returns True, all stop. Results do not depend on ``threads``."""
        ...
