"""What members that stick are held by: of each force of friction one coordinate, whose velocity follows from
those of the others, its anchors, or is that of the ground.

Members never hold each other in a circle (``relative_friction.refuse_circles``). So all forces can be put in
an order in which the velocities of anchors are known.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.families.arrays import NONE
from lagrange_cli.families.bonds import Bonds
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places


@dataclass(frozen=True, eq=False)
class Anchors:
    """``numbers`` has the forces in this order. ``held`` has the coordinate that each of them holds, and
    ``others`` (forces, most) its anchors, ``NONE`` where there are fewer."""

    numbers: Places
    held: Places
    others: Places

    @property
    def places(self) -> Places:
        """The place of each force in the order."""
        found = np.empty_like(self.numbers)
        found[self.numbers] = np.arange(len(self.numbers))
        return found


def anchors_of(sticking: Bonds, count: int) -> Anchors:
    """Those of ``count`` coordinates, from the ground on, or else from the first one that is left."""
    rows: list[list[int]] = [[] for _ in range(sticking.count)]
    for bound in sticking.bounds:
        for number, *members in zip(bound.numbers.tolist(), *(one.tolist() for one in bound.rows)):
            rows[number] = members
    touching: list[list[int]] = [[] for _ in range(count)]
    for number, members in enumerate(rows):
        for i in members:
            touching[i].append(number)
    reached, held = [False] * count, dict[int, int]()

    def reach(forces: list[int]) -> None:
        for number in forces:
            if number not in held:
                new = [i for i in rows[number] if not reached[i]]
                held[number] = new[0]
                for i in new:
                    reached[i] = True
                    forces += touching[i]

    reach([number for number, members in enumerate(rows) if len(members) == 1])
    for i in range(count):
        if not reached[i]:
            reached[i] = True
            reach([*touching[i]])
    width = max(1, max(len(members) - 1 for members in rows))
    others = np.full((len(rows), width), NONE)
    for place, (number, one) in enumerate(held.items()):
        listed = [i for i in rows[number] if i != one]
        others[place, : len(listed)] = listed
    numbers, own = (np.array([*one], dtype=np.int64) for one in (held, held.values()))
    return Anchors(numbers, own, others)
