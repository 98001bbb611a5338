"""What rigid bodies do: quantities of each by its name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any, Protocol

from lagrange_cli.expression.node import Node
from lagrange_cli.expression.operations import cross
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model
from lagrange_cli.model.scope import Scope
from lagrange_cli.records import dataclass

Vectors = Mapping[str, Sequence[Any]]
"""Components by the names of bodies."""


class Bodies(Protocol):
    """The interface of what a planner knows of bodies."""

    @property
    def spins(self) -> Vectors:
        """Angular velocities, in space."""

    @property
    def orientations(self) -> Vectors:
        """The entries of R, row by row."""

    @property
    def momenta(self) -> Vectors:
        """Angular momenta about the centre of mass, in space."""

    @property
    def energies(self) -> Vectors:
        """The kinetic energy of the rotation, one component."""


@dataclass(frozen=True)
class BodiesOfModel:
    """Those of a system that is derived member by member."""

    model: Model[Node]

    def _scope(self) -> Scope[Node]:
        assert self.model.spec is not None
        return Scope(self.model.spec, self.model.algebra)

    @property
    def spins(self) -> Vectors:
        """Angular velocities."""
        scope = self._scope()
        return {name: scope.turning(name).in_space for name in scope.spec.bodies}

    @property
    def orientations(self) -> Vectors:
        """R."""
        scope = self._scope()
        rows = {name: zip(*scope.turning(name).axes) for name in scope.spec.bodies}
        return {name: [*chain.from_iterable(one)] for name, one in rows.items()}

    @property
    def momenta(self) -> Vectors:
        """R I R^T omega."""
        parts: dict[str, list[Sequence[Node]]] = {}
        for one in self.model.particles:
            if one.body:
                momentum = cross(one.position, [one.mass * u for u in one.velocity])
                parts.setdefault(one.body, []).append(momentum)
        graph = graph_of(self.model)
        return {
            name: [graph.sum([(x, 1.0) for x in several]) for several in zip(*momenta)]
            for name, momenta in parts.items()
        }

    @property
    def energies(self) -> Vectors:
        """omega . I omega/2."""
        parts: dict[str, list[tuple[Node, float]]] = {}
        for one in self.model.particles:
            if one.body:
                parts.setdefault(one.body, []).extend((one.mass * u * u, 0.5) for u in one.velocity)
        return {name: [graph_of(self.model).sum(terms)] for name, terms in parts.items()}
