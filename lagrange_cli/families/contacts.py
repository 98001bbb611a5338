"""What is known of impacts and resting contact of families (see ``families.impacts.impacts``)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lagrange_cli.families.arrays import Array, Total
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places
    from lagrange_cli.expression.node import Node
    from lagrange_cli.families.arrays import Domain
    from lagrange_cli.families.bonds import Bonds


@dataclass(frozen=True, eq=False)
class Contacts:
    """Resting contact at the ``events`` of these numbers, in order. ``slopes`` are dg/dq, each of a contact
    by a coordinate that it ``reads`` (2, slopes), ``bends`` what d2g/dt2 is without accelerations.
    ``directions`` are d, each of a contact and a coordinate on which it ``acts`` (2, directions), and
    ``divisors`` grad g d. ``signs`` has the modes, which are 0 but at rest, and ``others`` the contact that
    has the same coordinate and goes before, or ``NONE``. ``multipliers`` are N, once forces are known.
    """

    events: Places
    reads: Places
    slopes: Total
    bends: Total
    acts: Places
    directions: Total
    divisors: Total
    signs: Array
    others: Places
    multipliers: Total

    @property
    def count(self) -> int:
        """The number of contacts."""
        return len(self.events)

    @property
    def single(self) -> bool:
        """Whether each holds one coordinate."""
        return bool(self.reads.shape[1] == self.count)


@dataclass(frozen=True, eq=False)
class Push:
    """What the members of a ``domain`` have of the directions of slow impacts: ``node`` for each one's
    contact, along the coordinates at these ``rows``."""

    domain: Domain
    node: Node
    contacts: Places
    rows: Places


@dataclass(frozen=True, eq=False)
class Reach:
    """What the members of a ``domain`` have of them along the coordinates at these ``rows``, where contacts
    depend on places of nodes that these move: ``node``, times dx/dq of the coordinate's own joint, times
    dg/dx. This is that of a contact's place number ``hold``: of the ``members`` of the bound of this number
    (see ``bonds``)."""

    domain: Domain
    node: Node
    bound: int
    hold: int
    members: Places
    rows: Places


@dataclass(frozen=True, eq=False)
class Coupled:
    """Resting contact at the ``events`` of these numbers whose forces depend on one another, and on those of
    constraints: all are the ``bonds``, so many ``fixed`` ones first. ``signs`` has the modes of contacts, and
    ``multipliers`` their forces, which are the last of all multipliers. On chains and trees, contacts change
    accelerations by their ``pushes`` and ``reaches`` (see ``families.impacts.joint_contacts``)."""

    events: Places
    bonds: Bonds
    fixed: int
    signs: Array
    multipliers: Total
    pushes: tuple[Push, ...] = ()
    reaches: tuple[Reach, ...] = ()
    separate: bool = False
    """Whether no contact pushes what another one is at."""

    @property
    def count(self) -> int:
        """The number of contacts."""
        return len(self.events)


@dataclass(frozen=True, eq=False)
class Impacts:
    """Impacts that reduce the speed, at the ``events`` of these numbers, in order. ``rates`` are dg/dt, where
    no argument is at places of nodes. ``speeds`` are those after
    each one's own action. Members may rest where there are ``contacts``; from others they go apart."""

    events: Places
    speeds: Total
    contacts: Contacts | Coupled | None
    rates: Total | None = None
