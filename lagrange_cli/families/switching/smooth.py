"""Systems of families with modes in place of switches, so that they are smooth for a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.families.arrays import Total
from lagrange_cli.families.contacts import Coupled
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.switching.switches import Switching
from lagrange_cli.records import replace


def with_modes(system: FamilySystem) -> FamilySystem | None:
    """The system with modes in place of the switches in its forces and in the arguments of its events; None
    if there are none.

    Raises ``Unsuited`` where sides differ, so that an energy jumps or a motion may stay where they change in
    another way than coordinates that rub or meet do (``families.switching.friction``); where an argument of
    another switch jumps in time; and for switches in masses, in joints and in constraints.
    """
    found = Switching(system)
    if not found.any:
        return None
    found.refuse()
    return found.smooth()


def smooth_of(system: FamilySystem) -> FamilySystem | None:
    """The system with modes in place of switches, if it has any."""
    smooth, contacts = with_modes(system), system.contacts
    rubbing = smooth is not None and smooth.modes is not None and smooth.modes.limits
    between = contacts is not None and (isinstance(contacts, Coupled) or not contacts.single)
    if rubbing and between:
        raise Unsuited  # friction would have to know the forces between what touches
    return smooth


def passing_where_parameters_jump(system: FamilySystem) -> FamilySystem:
    """The same system, whose motions pass where the signs of parameters say whether forces jump: those that
    would have to be held there end."""
    passing = replace(system, passes=True)
    return replace(passing, smooth=smooth_of(passing))


def with_modes_in(
    system: FamilySystem, listed: Sequence[Total]
) -> tuple[FamilySystem, Mapping[Total, Total]]:
    """The same of a system that has some, and of further totals that are ``listed``: with modes, by those
    without."""
    found = Switching(system, listed)
    return found.smooth(), {one: found.of(one) for one in listed}
