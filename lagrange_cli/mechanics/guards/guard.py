"""Guards, which replace the switches in equations, so that these are smooth for a time.

A switch is ``above`` where its argument u(q, q_dot, t) > 0 and ``below`` where u < 0 (see ``Kind.SWITCH``).
Its mode is a constant, +1 or -1, until u changes its sign. Then it is the other one, and the motion goes on
with other equations. Every distinct u has one *guard*.

Where the forces jump at u = 0, both branches may lead back to it: see ``held``."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.switching.cuts import Cut
from lagrange_cli.mechanics.switching.lengths import Vector
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Rooted:
    """Branches that contain roots of the argument: whether they are ``steep`` there, infinitely; and the
    ``side``, the sign of the argument, that alone has some, or 0."""

    steep: bool
    side: int

    def joined(self, other: Rooted | None) -> Rooted:
        """The roots of these branches and of others with the same argument."""
        if other is None:
            return self
        return Rooted(self.steep or other.steep, self.side if self.side == other.side else 0)


@dataclass(frozen=True)
class Guard:
    """What a mode is the sign of: ``argument``, in which other modes may stand.

    ``original`` is the argument as it stands in the system's own equations. ``auxiliary`` is the place, among
    auxiliary coordinates, of the one whose acceleration is the multiplier; None where the motion cannot be
    held. With a ``limit`` the multiplier is a force, which may be that large. A ``cut`` is where an argument
    of another guard may jump; no equation contains its mode."""

    argument: Node
    original: Node
    mode: Node
    auxiliary: int | None = None
    cut: bool = False
    roots: Rooted | None = None
    """Roots of the argument that forces contain, which have no series where it is 0."""
    reverses: bool = False
    """Whether something has its sign, as friction has that of a velocity."""
    limit: Node | None = None
    loud: Node | None = None
    """What is 0, or -1 as the mode of another guard is, while friction is 0 and its mode changes nothing: the
    argument is 1 then (see ``silence``)."""
    broken: Cut | None = None
    """The quantity that jumps where the argument is 0, so that the motion ends there."""
    edge: bool = False
    """Whether the argument is positive within the domain of a function of the file, so that the motion ends
    where it is 0."""
    vector: Vector | None = None
    """What the argument is the length of. It has an auxiliary coordinate for each of its parts then."""

    @property
    def holding(self) -> range:
        """The places of its auxiliary coordinates."""
        count = 1 if self.vector is None else len(self.vector.parts)
        return range(0) if self.auxiliary is None else range(self.auxiliary, self.auxiliary + count)

    def holds(self, graph: Graph) -> Node:
        """What is 0 where it holds the motion: its mode, unless it is silent."""
        return self.mode if self.loud is None else graph.switch(self.loud, self.mode, graph.one, -1)


@dataclass(frozen=True)
class Rest:
    """Whether the motion rests at the ``event`` of that number is said by ``mode``; ``auxiliary`` as of a
    guard."""

    event: int
    mode: Node
    auxiliary: int


@dataclass(frozen=True)
class Guarded:
    """Equations and integrands with modes in place of what moves in switches, and so the arguments of the
    model's ``events``.

    The model of ``residual`` has the ``auxiliary`` coordinates behind its own.
    """

    residual: Residual
    integrands: Mapping[str, Node]
    guards: tuple[Guard, ...] = ()
    auxiliary: int = 0
    events: tuple[Node, ...] = ()
    rests: tuple[Rest, ...] = ()
    limits: tuple[Node, ...] = ()
    """Limit plus force and limit minus force, for each guard with a limit; of vectors, their squares."""
    breaks: tuple[Node, ...] = ()
    """Of each guard where something jumps x, which is negative there, and the squares of a ``Cut``."""
    parts: tuple[Node, ...] = ()
    """Those of each vector."""

    @property
    def silent(self) -> tuple[tuple[int, int], ...]:
        """The guards that may become silent and loud again, each with that which says so."""
        places = {one.mode: j for j, one in enumerate(self.guards)}
        each = ((j, one.loud) for j, one in enumerate(self.guards))
        return tuple((j, places[loud]) for j, loud in each if loud in places)
