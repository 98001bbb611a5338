"""Many motions one after another, or one in each thread, by a method for single ones."""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice
from threading import Event

from lagrange_cli.integrate.checkpoint import UNKEPT, Checkpointing
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.ensemble.method import Accept, EndedMembers, Kept, MemberLog, SampleRows, Starts
from lagrange_cli.integrate.method import Interrupt, Method, Observer
from lagrange_cli.records import dataclass

POLL_SECONDS = 0.05
"""Seconds between two reports of progress."""


@dataclass(frozen=True)
class OneByOne:
    """Integrates one member after another, or one in each thread, each as it would be alone.

    ``parallel`` tells that the method releases the interpreter's lock while it works. ``events`` are the
    names of what may happen in each; that of a surface is the last one. The only motion of a section may have
    checkpoints, by ``checkpointing``.
    """

    method: Method
    parallel: bool = False
    events: tuple[str, ...] = ()
    checkpointing: Checkpointing[Kept] = UNKEPT

    def follow(
        self, starts: Starts, accept: Accept, interrupt: Callable[[float], bool], threads: int
    ) -> bool:
        """See ``EnsembleMethod``."""
        if self.parallel and threads > 1 and len(starts) > 1:
            return self._side_by_side(starts, accept, interrupt, threads)
        for member in range(len(starts)):

            def stop(t: float, member: int = member) -> bool:
                return interrupt(member + part_of(starts, t))

            batch = self._one(member, starts, stop)
            accept(batch)
            if batch.ending[0] is Ending.INTERRUPTED or (interrupt(member + 1) and member + 1 < len(starts)):
                return False
        return True

    def _side_by_side(
        self, starts: Starts, accept: Accept, interrupt: Callable[[float], bool], threads: int
    ) -> bool:
        from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait

        from lagrange_cli.integrate.hearing import heard

        halted, done, stopped, reached = Event(), 0, False, 0.0
        parts = dict[int, float]()

        def one(member: int) -> EndedMembers:
            def stop(t: float) -> bool:
                parts[member] = part_of(starts, t)
                return halted.is_set()

            ended = self._one(member, starts, stop)
            parts.pop(member, None)
            return ended

        with heard(), ThreadPoolExecutor(threads) as pool:
            try:
                members = iter(range(len(starts)))
                pending = {pool.submit(one, member) for member in islice(members, 2 * threads)}
                while pending:
                    ended, pending = wait(pending, POLL_SECONDS, FIRST_COMPLETED)
                    for future in ended:
                        accept(future.result())
                    done += len(ended)
                    reached = max(reached, done + sum([*parts.values()]))
                    if interrupt(reached) and done < len(starts):
                        stopped = True
                        halted.set()
                    if not stopped:
                        pending |= {pool.submit(one, member) for member in islice(members, len(ended))}
            finally:
                halted.set()
        return not stopped

    def _one(self, member: int, starts: Starts, interrupt: Interrupt) -> EndedMembers:
        if starts.section is not None:
            from lagrange_cli.integrate.ensemble.section import through_section

            given = starts, member, self.checkpointing, interrupt
            return through_section(self.method, self.events, *given)
        start = starts.of(member)
        samples = SampleRows(len(start.state), starts.times.count if starts.sampled else 0)
        log = MemberLog(self.events)
        observer = Observer(samples.take, interrupt, log)
        end = self.method.follow(start, observer)
        rows = samples.rows if starts.sampled else None
        return EndedMembers.one(member, end, samples.reached, rows, [log] if self.events else [])


def part_of(starts: Starts, t: float) -> float:
    """How far a motion has come, unless a number of crossings ends it."""
    return starts.times.part(t) if starts.section is None else 0.0
