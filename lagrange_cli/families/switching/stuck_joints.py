"""Joints whose coordinates stick to those of the joints before them: their accelerations follow from these.

Where u = s v + s' v' stays 0, with v of a joint and v' of the one that it hangs from, a = r a', r = -s'/s. So
a joint that sticks is no joint of its own meanwhile: what would move it, H = Q - J^T R (see ``locked``),
moves the one before it as r H besides. The force of friction is f = -H/s.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.index_arrays import distinct
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import NONE, Array, Domain, Source, Term, Total, placed, total_of
from lagrange_cli.families.bonds import Bound
from lagrange_cli.families.description import FamilySystem, Locks
from lagrange_cli.families.joints.joints import Articulation
from lagrange_cli.families.switching.friction import gate
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places


PAIR = 2
"""The coordinates that stick to one another."""


@dataclass(frozen=True, eq=False)
class Hinges:
    """Of each coordinate: its number ``among`` those of its joint, the ``node`` of the joint, and the
    ``parent`` of that; ``NONE`` where there is none."""

    among: Places
    node: Places
    parent: Places

    @classmethod
    def of(cls, found: Articulation, count: int) -> Hinges:
        """Those of so many coordinates."""
        among, node, parent = (np.full(count, NONE, dtype=np.int64) for _ in range(3))
        for kind in found.joints:
            for b, rows in enumerate(kind.rows):
                among[rows] = b
                if kind.nodes is not None:
                    node[rows] = kind.nodes
                if kind.parents is not None:
                    parent[rows] = np.where(kind.parents == found.count, NONE, kind.parents)
        return cls(among, node, parent)

    def behind(self, one: Places, other: Places) -> Places:
        """Whether joints of coordinates hang from those of others."""
        found: Places = (self.parent[one] != NONE) & (self.parent[one] == self.node[other])
        return found


def sticking_joints(
    system: FamilySystem, bounds: Sequence[Bound], modes: tuple[Array, Places], loose: Total
) -> tuple[Locks, Total] | None:
    """What sticks to the joint before it, or to what does not move, and the forces that hold; None where one
    sticks to another joint. ``modes`` are the array of all, and the numbers of those of ``bounds``; ``loose``
    has the other forces."""
    assert system.joints is not None
    slots, graph, count = system.slots, system.slots.graph, system.q.count
    hinges = Hinges.of(system.joints, count)
    left = Total(Source.TOTAL, count)
    gates, forces = list[Term](), list[Term]()
    held: list[Places] = []
    carries: dict[int, list[Term]] = {}
    for bound in bounds:
        if len(bound.rows) > PAIR:
            return None
        for own in range(len(bound.rows)):
            rows, others = bound.rows[own], [*bound.rows[:own], *bound.rows[own + 1 :]]
            mine = hinges.behind(rows, others[0]) if others else np.ones(len(rows), dtype=bool)
            members = np.flatnonzero(mine)
            if not len(members):
                continue
            domain, numbers, targets = Domain(len(members)), bound.numbers[members], rows[members]
            slopes = [placed(slots, one, domain, members) for one in bound.slopes]
            moves = gate(slots, domain, modes[0], modes[1][numbers])
            gates.append(Term(domain, moves, targets))
            force: Node = -slots.symbol(domain, left, targets) / slopes[own]
            forces.append(Term(domain, force, numbers))
            held.append(targets)
            for one in others:
                ratio = -slopes[1 - own] / slopes[own]
                among = hinges.among[one[members]]
                for b in distinct(among).tolist():
                    some = np.flatnonzero(among == b)
                    part = Domain(len(some))
                    node = placed(slots, (1.0 - moves) * ratio, part, some)
                    carries.setdefault(b, []).append(Term(part, node, targets[some]))
    every = np.concatenate([np.zeros(0, dtype=np.int64), *held])
    total = sum(bound.domain.count for bound in bounds)
    if len(every) != total or len(distinct(every)) != total or np.any(hinges.node[every] == NONE):
        return None
    free = np.setdiff1d(np.arange(count), every)
    gates.append(Term(Domain(len(free)), graph.one, free))
    turned = [total_of(count, carries.get(b, []), graph) for b in range(1 + max(carries, default=NONE))]
    locks = Locks(total_of(count, gates, graph), loose, left, turned)
    return locks, total_of(total, forces, graph)
