"""``@act_alone``: what the action of one event sets, where there are many events. It gives new values, sizes
and speeds as ``@act`` does, at the same places, and nothing of other events.

Of each loop of ``@act`` it takes one member, that of the event, if there is one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.families.arrays import NONE, Chain, Total
from lagrange_cli.native.families.arrangement import Arrangement
from lagrange_cli.native.families.loops import Loop, loops, needed
from lagrange_cli.native.families.tables import place_at
from lagrange_cli.native.families.vectors import DoubleVectors
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Real
from lagrange_cli.native.stepping.actions import ALONE
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places

FEWEST = 256
"""From so many values on it pays."""


@dataclass(frozen=True, eq=False)
class Own:
    """A loop of whose members each belongs to an event: ``members`` has that of each event, or ``NONE``."""

    loop: Loop
    members: Places


class OwnActions:
    """The actions of an ``arrangement``: the place of each total among the results, and the loops, if no
    event has several members of one."""

    def __init__(self, arrangement: Arrangement) -> None:
        self.arrangement, events = arrangement, arrangement.events
        self.first: dict[Total, int] = {}
        for place, (total, i) in enumerate(arrangement.acted):
            self.first.setdefault(arrangement.lasting.changed[total], place - i)
        self.loops: list[Own] = []
        if events is None or len(arrangement.acted) < FEWEST or arrangement.kind is not DoubleVectors:
            return
        owners = [events.changed[0], np.arange(events.sizes.count) // 2]
        if events.impacts is not None:
            owners.append(events.impacts.events)
        by_total = dict(zip(self.first, owners))
        totals = needed([*self.first], arrangement.slots, arrangement.lasting.fixed)
        found = [self._own(one, by_total, events.count) for one in loops(totals, arrangement.slots)]
        if set(totals) == set(self.first) and self._single:
            self.loops = [one for one in found if one is not None] if None not in found else []

    @property
    def _single(self) -> bool:
        """Whether each number has one term."""
        return all(
            np.array_equal(
                np.sort(np.concatenate([one.targets for one in total.terms])), np.arange(total.count)
            )
            for total in self.first
            if total.count
        )

    def _own(self, loop: Loop | Chain, owners: dict[Total, Places], events: int) -> Own | None:
        """A loop, if no event has several of its members."""
        if isinstance(loop, Chain):
            return None
        if not all(isinstance(total, Total) and total in owners for _, total in loop.terms):
            return None
        first, *others = (
            owners[total][term.targets] for term, total in loop.terms if isinstance(total, Total)
        )
        members = np.full(events, NONE)
        members[first] = np.arange(loop.domain.count)
        others += [owners[x.array][x.table] for x in loop.used.values() if x.array in owners]
        whole = all(np.array_equal(one, first) for one in others)
        return Own(loop, members) if whole and np.count_nonzero(members >= 0) == loop.domain.count else None

    def text(self) -> str:
        """The function; nothing if ``@act`` has to do."""
        if not self.loops:
            return ""
        head = "ptr noalias %constants, ptr noalias %time, ptr noalias %state, ptr noalias %results"
        f = Function(f"define internal void @{ALONE}({head}, i64 %event) #0")
        made, vectors, event = self.arrangement, DoubleVectors(f), Integer(f, "%event")
        evaluation = made.evaluation(vectors, made.state(f), f.load("%time"))
        tables = evaluation.tables
        for own in self.loops:
            count = own.loop.domain.count
            member = place_at(f, event + tables.of_array(np.where(own.members < 0, count, own.members)))
            with f.when(member < count):
                listed, numbers = own.loop.numbered
                places = [place_at(f, member + tables.of_array(table)) for table in listed]
                known = dict(evaluation.known)
                for (symbol, slot), i in zip(own.loop.used.items(), numbers):
                    if slot.array in self.first:  # what an earlier loop has computed for this event
                        where = f.place("%results", self.first[slot.array], "double")
                    else:
                        where = evaluation.where(slot.array)
                    given: Real = vectors.load(where, places[i])
                    known[symbol] = vectors.operand(vectors.splat(given, LANES))
                values = evaluation.values([term.node for term, _ in own.loop.terms], known)
                for (_, total), one, i in zip(own.loop.terms, values, numbers[len(own.loop.used) :]):
                    assert isinstance(total, Total)
                    value = vectors.lane(vectors.number(one), 0)
                    vectors.store(value, "%results", places[i] + self.first[total])
        f.give()
        return f.text()
