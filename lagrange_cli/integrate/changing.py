"""A motion that changes between explicit and implicit steps, where it becomes stiff or is so no more.

It is looked at after certain numbers of steps. There it stops, and a few explicit steps are tried from its
state (``integrate.stiffness``). What they tell depends on that state and the stop time alone: neither on the
seconds that anything took, nor on where a run was interrupted. So the same command always changes at the same
steps.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.ending import Ending
from lagrange_cli.integrate.method import UNOBSERVED, End, MethodChange, Observer, Snapshot, Start
from lagrange_cli.integrate.methods.table import STIFF
from lagrange_cli.integrate.stiffness import CHEAP, PRICE, trial_of
from lagrange_cli.native.state import CARRIED_COUNT, Clock
from lagrange_cli.records import dataclass, replace

if TYPE_CHECKING:
    from collections.abc import Hashable

    from lagrange_cli.integrate.prepared import Prepared
    from lagrange_cli.native.interface import Interface

OFTEN, LOOKED, RARELY = 1024, PRICE / 16, 8
"""Steps of a method between two looks at the motion: at least so many, those that compute so many numbers,
and such a part of all its steps. Lengths are powers of two, so that looks do not depend on where a run was
interrupted."""

Asked = tuple[str, float]
"""A method and its tolerance."""


@dataclass(frozen=True)
class Changing:
    """Follows a motion by the ``first`` method, and by others from where they are faster. ``prepare`` gives
    what a method is prepared with, None where it cannot be used; the ``explicit`` one, mostly Taylor series,
    has the tolerance that is asked for."""

    first: Asked
    explicit: Asked
    prepare: Callable[[str, float], Prepared | None]

    def follow(self, start: Start, observer: Observer = UNOBSERVED, threads: int | None = 1) -> End:
        """See ``integrate.method.Method``."""
        begin = observer.checkpoints.begin
        while True:
            if begin is not None:
                program = self.prepared(begin.changes).machine.program
                if is_due(program, begin.steps - steps_before(begin.changes)):
                    begin = self._changed(begin, start, threads)
            end, looked = self._until_a_look(begin, start, observer, threads)
            if not looked:
                return end
            begin = end.snapshot

    def prepared(self, changes: Sequence[MethodChange]) -> Prepared:
        """The method in force after some changes; raises ``ValueError`` where it cannot be used."""
        method, tolerance = (changes[-1].method, changes[-1].tolerance) if changes else self.first
        found = self.prepare(method, tolerance)
        if found is None:
            raise ValueError("no such method")
        return found

    def _until_a_look(
        self, begin: Snapshot | None, start: Start, observer: Observer, threads: int | None
    ) -> tuple[End, bool]:
        """Follow the motion until it is to be looked at; and whether that is why it has ended."""
        changes = () if begin is None else begin.changes
        before, taken = steps_before(changes), 0 if begin is None else begin.steps
        prepared, outside = self.prepared(changes), self.prepared(())
        mark = before + next_look(prepared.machine.program, taken - before)
        sink, reached, asked = observer.checkpoints, False, False

        def due(steps: int) -> bool:
            nonlocal reached
            reached = steps >= mark
            return sink.due(steps)

        def interrupt(t: float) -> bool:
            nonlocal asked
            asked = asked or observer.interrupt(t)
            return asked or reached

        def with_changes(accept: Callable[[Snapshot], None], snapshot: Snapshot) -> None:
            accept(replace(snapshot, changes=changes))

        checkpoints = replace(
            sink,
            begin=begin,
            due=due,
            keep=partial(with_changes, sink.keep),
            ends=None if sink.ends is None else partial(with_changes, sink.ends),
            every=mark,
        )
        there, here = outside.machine.program, prepared.machine.program
        samples = observer.samples
        if labels(there) != labels(here):
            samples = partial(handed_over, there, here, observer.samples)
            start = replace(start, state=rows_of(here, there, start.state))
        own = replace(observer, samples=samples, interrupt=interrupt, checkpoints=checkpoints)
        end = prepared.follower.follow(start, own, threads)
        looked = end.ending is Ending.INTERRUPTED and reached and not asked and end.snapshot is not None
        snapshot = None if end.snapshot is None else replace(end.snapshot, changes=changes)
        beyond = changes[-1].beyond if changes else 0
        return replace(end, snapshot=snapshot, changes=changes, evaluations=end.evaluations + beyond), looked

    def _changed(self, snapshot: Snapshot, start: Start, threads: int | None) -> Snapshot:
        """The snapshot from which the motion goes on: that of another method, if one is faster."""
        now, series = self.prepared(snapshot.changes), self.prepare(*self.explicit)
        if series is None:
            return snapshot
        begin = carried_over(snapshot, now.machine.program, series.machine.program)
        begin = replace(begin, samples=0)  # a trial takes none
        first = rows_of(series.machine.program, self.prepared(()).machine.program, start.state)
        trial = trial_of(series, replace(start, state=first), threads)
        if trial is None:
            return snapshot
        if now.compilation.method == STIFF:
            since = snapshot.changes[-1].t if snapshot.changes else start.times.start
            length = (snapshot.t - since) / (snapshot.steps - steps_before(snapshot.changes))
            replaces = trial.replaced(begin, now.compilation.tolerance, length)
            return noted(snapshot, now, series, replaces) if replaces <= CHEAP else snapshot
        known = STIFF in (self.first[0], *(one.method for one in snapshot.changes))
        found = trial.later(begin, self.explicit[1], known=known)
        implicit = None if found is None else self.prepare(STIFF, found.tolerance)
        if found is None or implicit is None:
            return snapshot
        before = max(self._implicit_lengths(snapshot.changes, start.times.start), default=math.inf)
        usual = before * found.steps / (start.times.stop - snapshot.t)
        found = replace(found, replaces=min(found.replaces, usual))
        if not found.repays(implicit.machine.program):
            return snapshot
        return noted(snapshot, now, implicit, found.replaces)

    def _implicit_lengths(self, changes: Sequence[MethodChange], begin: float) -> Iterator[float]:
        """The average lengths of implicit steps, each time that there were any: they tell more than a moment
        of the motion does."""
        method, since, taken = self.first[0], begin, 0
        for one in changes:
            if method == STIFF and one.steps > taken:
                yield (one.t - since) / (one.steps - taken)
            method, since, taken = one.method, one.t, one.steps


def next_look(program: Interface, steps: int) -> int:
    """After how many steps of a method the motion is looked at next, when it has taken some."""
    worth = 1 << int(LOOKED / max(1, program.work)).bit_length()
    apart = max(OFTEN, worth, (1 << steps.bit_length()) // (2 * RARELY))
    return (steps // apart + 1) * apart


def is_due(program: Interface, steps: int) -> bool:
    """Whether the motion is looked at after these steps."""
    return steps > 0 and next_look(program, steps - 1) == steps


def steps_before(changes: Sequence[MethodChange]) -> int:
    """The steps before the last change."""
    return changes[-1].steps if changes else 0


def noted(snapshot: Snapshot, now: Prepared, then: Prepared, replaces: float) -> Snapshot:
    """The snapshot where a motion begins to be followed by what is prepared ``then``, with a note of that."""
    program, asked = now.machine.program, then.compilation
    beyond = snapshot.changes[-1].beyond if snapshot.changes else 0
    beyond += evaluations_beyond(program, snapshot)
    change = MethodChange(snapshot.t, snapshot.steps, asked.method, asked.tolerance, replaces, beyond)
    return replace(carried_over(snapshot, program, then.machine.program), changes=(*snapshot.changes, change))


def evaluations_beyond(program: Interface, snapshot: Snapshot) -> int:
    """How many evaluations a method has carried out besides one for each step."""
    layout = program.inner
    return int(snapshot.memory[layout.carried_at + CARRIED_COUNT]) if layout.carried else 0


def labels(program: Interface) -> list[Hashable]:
    """What the rows of a state are, outside the stepping code."""
    moving = [(kind, i) for kind in ("q", "v") for i in range(program.degrees)]
    return [*moving, *program.integrals]


def inner_labels(program: Interface) -> list[Hashable]:
    """What they are inside: there are also those of guards."""
    moving = [(kind, i) for kind in ("q", "v") for i in range(program.inner.degrees)]
    return [*moving, *(("argument", i) for i in range(program.arguments)), *program.integrals]


def alike(one: Interface, other: Interface) -> bool:
    """Whether the states of two programs without events are the same but for stored momenta."""
    kept = [set(inner_labels(each)[: each.inner.rows - each.stored]) for each in (one, other)]
    guards = [(each.guards, each.limits, each.vectors, each.inner.set) for each in (one, other)]
    plain = not (one.events or other.events) and one.parts == other.parts == 1
    return plain and kept[0] == kept[1] and guards[0] == guards[1]


KEPT = Clock.TIME, Clock.TIME_LOW, Clock.LAST_PASS, Clock.LENGTH, Clock.PROJECTIONS
"""What does not depend on the method."""


def carried_over(snapshot: Snapshot, now: Interface, then: Interface) -> Snapshot:
    """A snapshot of one program as the beginning of a motion by another one."""
    if now is then:
        return snapshot
    before, after = now.inner, then.inner
    known = dict(zip(inner_labels(now), snapshot.memory[before.part(0)]))
    memory = np.zeros(after.memory)
    memory[after.part(0)] = [known.get(label, 0.0) for label in inner_labels(then)]
    memory[after.settings] = snapshot.memory[before.settings]
    for place in KEPT:
        memory[after.at(place)] = snapshot.memory[before.at(place)]
    memory[after.at(Clock.MARK)] = snapshot.t
    return replace(snapshot, memory=memory, marks=())


def rows_of(wanted: Interface, given: Interface, states: Array) -> Array:
    """States (rows, ...) of one program with the rows of another one."""
    rows, nothing = dict(zip(labels(given), states)), np.zeros(states.shape[1:])
    return np.array([rows.get(label, nothing) for label in labels(wanted)])


def handed_over(
    there: Interface, here: Interface, accept: Callable[[Array, Array], None], times: Array, states: Array
) -> None:
    """Hand over samples with the rows that they have ``there``."""
    accept(times, rows_of(there, here, states))
