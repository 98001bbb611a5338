"""Chains and trees of particles: which coordinates move what, member by member of a kind.

Each *node* of a tree is its parent's place and what a *joint* adds to it, a function of the few coordinates
of that joint. Particles are at nodes, or where a joint that carries no further one puts them. So the
equations of motion couple a joint to its parent and its children only (see
``native.families.joints.articulated``).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from lagrange_cli.expression.index_arrays import Places
from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Chain, Domain, Total
from lagrange_cli.families.joints.relative import Relative
from lagrange_cli.families.tables import in_groups
from lagrange_cli.records import dataclass


@dataclass(frozen=True, eq=False)
class Weight:
    """A mass at a place along one axis: ``move`` behind component number ``component`` of the joint's
    parent, or behind nothing (None)."""

    component: int | None
    move: Node
    mass: Node


@dataclass(frozen=True, eq=False)
class FreeEnergy:
    """The ``kinetic`` energy of weights that hang from nothing, by a joint's coordinates and their
    ``velocities`` (symbols): the ``momenta`` dT/dq_dot, the ``slopes`` dT/dq, and the ``masses``, which are
    d2T/dq_dot2. If there is a ``spin``, the number of a coordinate that T does not depend on and of which no
    other weight does, with a constant mass I, ``beside`` are the masses M_bd - M_bs M_sd/I of the others."""

    kinetic: Node
    velocities: tuple[Node, ...]
    momenta: tuple[Node, ...]
    slopes: tuple[Node, ...]
    masses: tuple[tuple[Node, ...], ...]
    spin: int | None = None
    beside: tuple[tuple[Node, ...], ...] = ()


@dataclass(frozen=True, eq=False)
class Joints:
    """Joints of one kind, the members of a domain: their ``coordinates`` (rows, and symbols), the nodes that
    are their ``parents`` (None: they hang from what does not move; so do those without weights that have the
    number behind the last node), their own ``nodes`` if they have any and the
    ``moves`` that these add to their parents, and the ``weights`` that they carry besides. Those that hang
    from nothing may have their energy (``free``) in their place."""

    domain: Domain
    rows: tuple[Places, ...]
    coordinates: tuple[Node, ...]
    parents: Places | None
    nodes: Places | None
    moves: tuple[Node, ...]
    weights: tuple[Weight, ...]
    free: FreeEnergy | None = None

    @property
    def hung(self) -> Sequence[Weight]:
        """The weights that have no ``free`` energy in their place."""
        if self.free is None:
            return self.weights
        return [one for one in self.weights if self.parents is not None and one.component is not None]


@dataclass(frozen=True, eq=False)
class Articulation:
    """``nodes`` has their places, and ``rates`` their velocities, and ``inertia`` the masses at them, one
    array for each component. The joints' coordinates may be sums of those of the system (``relative``)."""

    nodes: tuple[Chain, ...]
    rates: tuple[Total | None, ...]
    inertia: tuple[Total, ...]
    joints: tuple[Joints, ...]
    relative: Relative | None = None

    @property
    def parents(self) -> Places:
        """The parent of each node."""
        return (
            self.nodes[0].tree.parents if self.nodes and self.nodes[0].tree else np.zeros(0, dtype=np.int64)
        )

    @property
    def followed(self) -> Iterator[tuple[Total, Total | None]]:
        """The places of nodes, and sums of coordinates that joints have, with their velocities."""
        yield from zip(self.places, self.speeds)

    @property
    def places(self) -> Sequence[Chain]:
        """The places of nodes, and sums of coordinates that joints have, behind these."""
        return (*self.nodes, *(self.relative.chains if self.relative else ()))

    @property
    def speeds(self) -> Sequence[Total | None]:
        """The velocities of both."""
        return (*self.rates, *(self.relative.speeds if self.relative else ()))

    @property
    def moved(self) -> list[Node]:
        """What coordinates move."""
        return [
            node for one in self.joints for node in (*one.moves, *(weight.move for weight in one.weights))
        ]

    @property
    def count(self) -> int:
        """How many nodes there are."""
        return len(self.parents)

    def movers(self, places: Places) -> tuple[Places, Places]:
        """The members that have nodes at these ``places``, if there are such nodes, and the coordinates that
        move these: all pairs."""
        kinds = [(one.nodes, rows) for one in self.joints if one.nodes is not None for rows in one.rows]
        empty = np.zeros(0, dtype=np.int64)
        nodes, rows = (np.concatenate([empty, *some]) for some in zip(*kinds)) if kinds else (empty, empty)
        order = np.argsort(nodes, kind="stable")
        nodes, rows = nodes[order], rows[order]
        members, found, here, at = [empty], [empty], np.arange(len(places)), places
        while True:
            which = (at >= 0) & (at < self.count)
            here, at = here[which], at[which]
            if not len(here):
                return np.concatenate(members), np.concatenate(found)
            left, right = (np.searchsorted(nodes, at, side) for side in ("left", "right"))
            each, within = in_groups(right - left)
            members.append(here[each])
            found.append(rows[left[each] + within])
            at = self.parents[at]


@dataclass(frozen=True, eq=False)
class Part:
    """Something of some members that joints carry: a component of a node (``nodes``: theirs), or a weight
    that hangs from some ``component`` of ``nodes``. ``members`` of the domain, by the joint."""

    domain: Domain
    node: Node
    mass: Node | None
    component: int | None
    nodes: Places | None
    tables: tuple[Places, ...]
