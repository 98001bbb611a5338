"""Many motions by the Taylor method: compiled code integrates eight at once in each of several threads."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from lagrange_cli.integrate.checkpoint import UNKEPT, Checkpointing
from lagrange_cli.integrate.ensemble.members import MOMENT, PACK, Members
from lagrange_cli.integrate.ensemble.method import Accept, EndedMembers, Kept, Starts
from lagrange_cli.integrate.ensemble.one_by_one import OneByOne
from lagrange_cli.integrate.method import Method
from lagrange_cli.integrate.methods.backward import reversed_state, reversed_time, reversed_times
from lagrange_cli.native.compilation.machine import Machine
from lagrange_cli.native.interface import LANES, Interface
from lagrange_cli.native.members import SECTION
from lagrange_cli.records import dataclass, replace
from lagrange_cli.spec.spec import SURFACE

POLL_SECONDS = 0.02
"""Seconds between two checks which members have ended."""
Seen = TypeVar("Seen", Starts, EndedMembers)


@dataclass(frozen=True)
class LanesMethod:
    """Integrates motions by their Taylor series (``native.ensembles.ensemble``).

    Each is the same whatever runs beside it. Those that lanes do not bring to their ends are followed by the
    method that ``alone`` makes. Code for motions that are followed ``backward`` is of the reversed equations.
    The only motion of a section may have checkpoints, by ``checkpointing``.
    """

    machine: Machine
    alone: Callable[[], Method]
    backward: bool = False
    checkpointing: Checkpointing[Kept] | None = None

    def follow(
        self, starts: Starts, accept: Accept, interrupt: Callable[[float], bool], threads: int
    ) -> bool:
        """See ``EnsembleMethod``."""
        checkpointing = self.checkpointing
        if checkpointing is not None and checkpointing.begin is not None and PACK not in checkpointing.begin:
            return self._alone(np.arange(1), starts, accept, interrupt, threads, checkpointing)
        members = Members(self.machine, self._seen(starts), threads, checkpointing is not None)
        if checkpointing is not None and checkpointing.begin is not None:
            members.restore(checkpointing.begin)
        workers = started(members, min(threads, -(-len(starts) // LANES)))
        stopped, reached = False, 0.0
        try:
            while not stopped and members.done + len(members.left) < len(starts):
                next((w for w in workers if w.is_alive()), workers[0]).join(
                    POLL_SECONDS if members.roomy else MOMENT
                )
                for batch in members.ended():
                    accept(self._seen(batch))
                reached = max(reached, members.done + members.parts())  # some end in the meantime
                stopped = interrupt(reached) and members.done < len(starts)
                if checkpointing is not None and not stopped and checkpointing.due(members.steps):
                    end(members, workers)
                    if members.on_the_way:
                        checkpointing.keep(members.kept(), members.steps)
                        members.go_on()
                    workers = started(members, 1)
        finally:
            end(members, workers)
        if checkpointing is not None and stopped and members.on_the_way:
            checkpointing.keep(members.kept(), members.steps)
        for batch in members.ended():
            accept(self._seen(batch))
        if stopped or not members.left:
            return not stopped
        # The snapshot of the lane is useless for the method that follows the motion from its start.
        afresh = UNKEPT if checkpointing is None else checkpointing.beginning(None)
        return self._alone(np.sort(members.left), starts, accept, interrupt, threads, afresh)

    def _seen(self, one: Seen) -> Seen:
        """Starts as lanes see them, or what they give as it is in t."""
        return reversed_members(self.machine.program, one) if self.backward else one

    def _alone(
        self,
        index: NDArray[np.int64],
        starts: Starts,
        accept: Accept,
        interrupt: Callable[[float], bool],
        threads: int,
        checkpointing: Checkpointing[Kept],
    ) -> bool:
        """Integrate the members ``index`` one by one: lanes cannot handle kinks, singularities and the
        like."""
        before, program = len(starts) - len(index), self.machine.program
        surface = SECTION in program.integrals
        extra = [2 * program.degrees + program.integrals.index(SECTION)] if surface else []

        def one(batch: EndedMembers) -> None:
            """Where single motions have no integral of a surface, 0 stands in for it."""
            state, samples = np.insert(batch.state, extra, 0.0, axis=1), batch.samples
            samples = None if samples is None else np.insert(samples, extra, 0.0, axis=1)
            accept(replace(batch, index=index[batch.index], state=state, samples=samples))

        chosen = starts.only(index)
        chosen = replace(chosen, states=np.delete(chosen.states, extra, axis=1))
        method = OneByOne(self.alone(), True, (SURFACE,) * surface, checkpointing)
        return method.follow(chosen, one, lambda done: interrupt(before + done), threads)


def started(members: Members, count: int) -> list[threading.Thread]:
    """The threads at work, ``count`` of them."""
    workers = [threading.Thread(target=members.work, daemon=True) for _ in range(count)]
    for worker in workers:
        worker.start()
    return workers


def end(members: Members, workers: list[threading.Thread]) -> None:
    """Let them end after their present step."""
    members.halt()
    for worker in workers:
        worker.join()


def reversed_members(program: Interface, one: Seen) -> Seen:
    """Members that start, or have ended, in reversed time."""
    if isinstance(one, Starts):
        states = reversed_state(program, one.states.T).T
        return replace(one, states=states, times=reversed_times(one.times))
    samples = one.samples
    if samples is not None:
        samples = reversed_state(program, samples.transpose(1, 0, 2)).transpose(1, 0, 2)
    times = None if one.times is None else reversed_time(one.times)
    state = reversed_state(program, one.state.T).T
    return replace(one, t=reversed_time(one.t), state=state, samples=samples, times=times)
