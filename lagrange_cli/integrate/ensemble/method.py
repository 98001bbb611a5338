"""``EnsembleMethod``: the interface of the methods for many motions, which give the run batch after batch of
members."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import islice
from threading import Event
from typing import TYPE_CHECKING, Protocol, TypeAlias

import numpy as np

from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.method import Array, Method
from lagrange_cli.integrate.methods.names import TAYLOR
from lagrange_cli.integrate.times import Times
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lagrange_cli.integrate.prepared import Prepared

Index: TypeAlias = "NDArray[np.int64]"
BREATH = 0.05
"""Seconds between two reports of progress."""


@dataclass(frozen=True)
class Batch:
    """Some members that have ended, in any order.

    ``index`` (b,) are their numbers, ``t`` (b,) and ``state`` (b, rows) the time and q, v and integrals at
    which each ended, and ``steps`` (b,) the numbers of steps. Of ``samples`` (b, rows, n), the first
    ``reached`` (b,) of each member hold values, the others nan; None if no samples were asked for."""

    index: Index
    ending: Sequence[Ending]
    t: Array
    state: Array
    steps: Index
    samples: Array | None
    reached: Index


Accept: TypeAlias = Callable[[Batch], None]


@dataclass(frozen=True)
class Starts:
    """The initial values of members, and the samples asked for: ``parameters`` (members, P), ``states``
    (members, rows) of q, v and zeros for the integrals, and the sample ``times``, if they are ``sampled``."""

    parameters: Array
    states: Array
    times: Times
    sampled: bool

    def __len__(self) -> int:
        return len(self.states)

    def only(self, index: Index) -> Starts:
        """Some of them (b,)."""
        return replace(self, parameters=self.parameters[index], states=self.states[index])


class EnsembleMethod(Protocol):
    """A method for many motions."""

    def follow(self, starts: Starts, accept: Accept, watch: Callable[[int], bool], threads: int) -> bool:
        """Integrate members from their ``starts``; returns False if stopped.

        ``accept`` is called in this thread and may keep what it is given. ``watch`` is called with the number
        of members that have ended, several times a second; if it returns True, all stop. Results do not
        depend on ``threads``."""
        ...


def ensemble_method(prepared: Prepared, alone: Callable[[], Method]) -> EnsembleMethod:
    """The method of ``prepared`` for many motions; ``alone`` makes that of single ones where it is needed."""
    if prepared.machine.follow is not None:
        from lagrange_cli.integrate.ensemble.lanes import LanesMethod

        return LanesMethod(prepared.machine, alone, prepared.backward)
    return OneByOne(prepared.follower, parallel=prepared.method == TAYLOR)


@dataclass(frozen=True)
class OneByOne:
    """Integrates one member after another, or one in each thread, each as it would be alone.

    ``parallel`` tells that the method releases the interpreter's lock while it works.
    """

    method: Method
    parallel: bool = False

    def follow(self, starts: Starts, accept: Accept, watch: Callable[[int], bool], threads: int) -> bool:
        """See ``EnsembleMethod``."""
        if self.parallel and threads > 1:
            return self._side_by_side(starts, accept, watch, threads)
        for member in range(len(starts)):

            def stop(t: float, member: int = member) -> bool:
                return watch(member)

            batch = self._one(member, starts, stop)
            accept(batch)
            if batch.ending[0] is Ending.INTERRUPTED or (watch(member + 1) and member + 1 < len(starts)):
                return False
        return True

    def _side_by_side(
        self, starts: Starts, accept: Accept, watch: Callable[[int], bool], threads: int
    ) -> bool:
        from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait

        halted, done, stopped = Event(), 0, False

        def one(member: int) -> Batch:
            return self._one(member, starts, lambda t: halted.is_set())

        with ThreadPoolExecutor(threads) as pool:
            try:
                members = iter(range(len(starts)))
                pending = {pool.submit(one, member) for member in islice(members, 2 * threads)}
                while pending:
                    ended, pending = wait(pending, BREATH, FIRST_COMPLETED)
                    for future in ended:
                        accept(future.result())
                    done += len(ended)
                    if watch(done) and done < len(starts):
                        stopped = True
                        halted.set()
                    if not stopped:
                        pending |= {pool.submit(one, member) for member in islice(members, len(ended))}
            finally:
                halted.set()
        return not stopped

    def _one(self, member: int, starts: Starts, watch: Callable[[float], bool]) -> Batch:
        state, times = starts.states[member], starts.times
        samples = np.full((len(state), times.count if starts.sampled else 0), np.nan)
        reached = 0

        def keep(when: Array, chunk: Array) -> None:
            nonlocal reached
            if starts.sampled:
                samples[:, reached : reached + len(when)] = chunk
            reached += len(when)

        end = self.method.follow(starts.parameters[member], state, times, keep, watch)
        return Batch(
            index=np.array([member], dtype=np.int64),
            ending=[end.ending],
            t=np.array([end.t]),
            state=end.state[None],
            steps=np.array([end.steps], dtype=np.int64),
            samples=samples[None] if starts.sampled else None,
            reached=np.array([reached], dtype=np.int64),
        )
