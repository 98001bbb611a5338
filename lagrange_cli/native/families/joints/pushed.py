"""What resting contacts add to accelerations, as the series of joints need it (see ``joint_contacts``)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Term, Total
from lagrange_cli.native.families.corrected import Local
from lagrange_cli.native.families.joints.kinds import JointKind
from lagrange_cli.records import dataclass


@dataclass(frozen=True, eq=False)
class PushedJoints:
    """Contacts add u (``pushed``) to accelerations of the joints' coordinates, which are ``of_joints`` then;
    those of the system's coordinates are the ``rates``, and of sums ``of_sums``. Series give what they have
    of u without what is newest (``gained``), and of J u of nodes (``jolts``); ``series`` are those of the
    contacts. ``of_kind`` has terms of u for a kind of joints with these moves, and the unknown of each."""

    pushed: Total
    of_joints: Total
    rates: Total
    of_sums: Sequence[Total]
    gained: Array
    jolts: Sequence[Array]
    series: Sequence[Local]
    of_kind: Callable[[JointKind, Sequence[Node]], Iterable[tuple[Node, Term]]]
