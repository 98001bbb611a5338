"""What holds coordinates where friction acts along vectors (see ``vector_friction``)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Domain, Term, Total, total_of
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.switching.friction import Held
from lagrange_cli.families.switching.vector_friction import DIRECTIONS, Along
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places


ROUNDED = 2.0**-49
"""The error of the direction of a difference of velocities, as part of these."""


@dataclass(frozen=True, eq=False)
class Rubbing:
    """Friction ``along`` vectors: the ``numbers`` of the modes of its members, the ``mode`` that an
    expression of a member has, and what is 0, or less, where friction is: ``loud``."""

    along: Along
    numbers: Places
    mode: Node
    loud: Node


@dataclass(frozen=True, eq=False)
class Acting:
    """All forces, what is ``applied`` of them, and the ``slopes`` of the potential, with modes."""

    forces: Total
    applied: Total
    slopes: Total


def held_along(
    system: FamilySystem,
    listed: Sequence[Rubbing],
    acting: Acting,
    found: Held | None,
    frozen: Callable[[Term], Term],
) -> Held:
    """The forces where friction along vectors may hold coordinates, besides what is ``found`` to hold others.
    Raises ``Unsuited`` where that holds members to one another."""
    if found is not None and (found.sticking is not None or found.locks is not None):
        raise Unsuited(*DIRECTIONS)
    slots, graph, count = system.slots, system.slots.graph, system.q.count
    modes = np.concatenate([one.numbers for one in listed])
    first = 0 if found is None else len(found.modes)
    free = np.setdiff1d(np.arange(count), np.concatenate([row for one in listed for row in one.along.rows]))
    others = Domain(len(free))
    forces, balanced = (
        [Term(others, slots.symbol(others, one, free), free)] for one in (acting.forces, acting.applied)
    )
    limits = [] if found is None else [*found.limits.terms]
    errors = list[Term]()
    beside, (order, begins) = list[Term](), places_of(listed)
    for one in listed:
        domain, along, mode, squares = one.along.domain, one.along, one.mode, graph.zero
        own, sticks = begins[one.numbers], 1.0 - mode * mode
        for i, row in enumerate(along.rows):
            whole, given, slope = (
                slots.symbol(domain, total, row) for total in (acting.forces, acting.applied, acting.slopes)
            )
            taken = slots.symbol(domain, system.masses, row) * along.rates[i]
            forces.append(Term(domain, mode * mode * whole + sticks * taken, row))
            balanced.append(Term(domain, mode * mode * given + sticks * (slope + taken), row))
            force = sticks * (whole - taken) / along.ratios[i]
            squares = squares + along.vector.weights[i] * force * force
            if any(not belt.is_zero for belt in along.belts):
                part = along.ratios[i] * rounded(system, along) / slots.symbol(domain, system.masses, row)
                errors.append(frozen(Term(domain, part, row)))
            part = graph.switch(one.loud, along.vector.parts[i], graph.one, -1)
            beside.append(Term(domain, part, own + i))
            beside.append(Term(domain, force, own + (len(along.rows) + i)))
        most = frozen(Term(domain, along.limit * along.limit, along.rows[0])).node
        for k, sign in enumerate((1.0, -1.0)):
            limits.append(Term(domain, most + sign * squares, 2 * (first + order[one.numbers]) + k))
    pivots = pivots_of(listed)
    return Held(
        modes=np.concatenate([*([] if found is None else [found.modes]), np.sort(modes)]),
        limits=total_of(2 * (first + len(modes)), limits, graph),
        other=acting.forces, forces=total_of(count, forces, graph),
        applied=total_of(count, balanced, graph), before=() if found is None else (found.other,),
        vectors=tuple((number, pivots[number]) for number in sorted(pivots)),
        beside=total_of(2 * sum(map(len, pivots.values())), beside, graph),
        errors=total_of(count, errors, graph) if errors else None,
    )  # fmt: skip


def rounded(system: FamilySystem, along: Along) -> Node:
    """The error of friction whose direction is that of a difference of rounded velocities: the limit times
    the sizes of these, over the length."""
    graph, sizes = system.slots.graph, list[tuple[Node, float]]()
    for pivot, belt in zip(along.vector.pivots, along.belts):
        sizes += [(pivot * pivot, 1.0), (belt * belt, 1.0)]
    most = graph.power(graph.sum(sizes), graph.constant(0.5))
    found: Node = ROUNDED * along.limit * most / along.length
    return found


def places_of(listed: Sequence[Rubbing]) -> tuple[Places, Places]:
    """By modes: how many vectors have smaller ones, and where the numbers of each begin."""
    largest = max(int(one.numbers.max()) for one in listed) + 1
    widths, some = np.zeros(largest, dtype=np.int64), np.zeros(largest, dtype=np.int64)
    for one in listed:
        widths[one.numbers], some[one.numbers] = 2 * len(one.along.rows), 1
    return np.cumsum(some) - some, np.cumsum(widths) - widths


def pivots_of(listed: Sequence[Rubbing]) -> dict[int, tuple[int, ...]]:
    """By modes, the coordinates that each of them holds."""
    return {
        number: tuple(int(row[k]) for row in one.along.rows)
        for one in listed
        for k, number in enumerate(one.numbers.tolist())
    }
