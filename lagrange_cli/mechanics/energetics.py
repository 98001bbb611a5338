"""T, U, L, the generalized momenta p_k and the energy function h of a model, over any algebra.

For masses with an embedding, T = T2 + T1 + T0 by degree in the velocities, and for U without velocities
h = T2 - T0 + U (Goldstein, 3rd ed., eq. 2.56): written so, nothing cancels that could be left out.
"""

from __future__ import annotations

from functools import cached_property

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.variables import OfModel, contract, numbered
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Energetics(OfModel):
    """Functions of q, q_dot, t over the graph; all scalars but ``momenta`` (one for each coordinate).

    ``power`` is sum_k Q_k q_dot_k with every force outside L, ``torque[k]`` = dL/dq_k + Q_k, and
    ``explicit_rate`` = dL/dt at fixed q, q_dot. ``kinetic`` and ``potential`` are None for a given L.
    """

    @property
    def kinetic(self) -> Node | None:
        """T = sum m v^2/2."""
        model = self.model
        if model.lagrangian is not None:
            return None
        return self.graph.sum([(p.mass * u * u, 0.5) for p in model.particles for u in p.velocity])

    @property
    def potential(self) -> Node | None:
        """U, as given."""
        return None if self.model.lagrangian is not None else self.model.potential

    @property
    def lagrangian(self) -> Node:
        """L = T - U, or as given."""
        kinetic, potential = self.kinetic, self.potential
        if kinetic is None or potential is None:
            assert self.model.lagrangian is not None
            return self.model.lagrangian
        return kinetic - potential

    @cached_property
    def _motion(self) -> tuple[tuple[Node, Node, Node], ...]:
        """(x, dx/dt, m dx/dt) for each component of each particle."""
        return tuple((x, u, p.mass * u) for p in self.model.particles for x, u in zip(p.position, p.velocity))

    @cached_property
    def _places(self) -> dict[Node, list[int]]:
        """The components of ``_motion`` that a symbol occurs in, in position or velocity."""
        found: dict[Node, list[int]] = {}
        for place, (x, u, _) in enumerate(self._motion):
            for symbol in dict.fromkeys((*self.graph.symbols_of(x), *self.graph.symbols_of(u))):
                found.setdefault(symbol, []).append(place)
        return found

    @cached_property
    def momenta(self) -> tuple[Node, ...]:
        """p_k = dL/dq_dot_k."""
        model, graph = self.model, self.graph
        if model.lagrangian is not None:
            return tuple(graph.diff(model.lagrangian, v) for v in model.v)
        found = []
        for q, v in zip(model.q, model.v):
            here = [self._motion[place] for place in self._places.get(q, ())]
            terms = ((graph.diff(x, q), momentum) for x, _, momentum in here)
            found.append(contract(graph, terms, self._moving) - graph.diff(model.potential, v))
        return tuple(found)

    @property
    def energy_function(self) -> Node:
        """h = sum q_dot_k p_k - L."""
        model, graph = self.model, self.graph
        if model.lagrangian is not None:
            pairs = zip(model.v, self.momenta)
            return graph.sum([(v * p, 1.0) for v, p in pairs] + [(model.lagrangian, -1.0)])
        terms = [(model.potential, 1.0)]
        terms += [(v * graph.diff(model.potential, v), -1.0) for v in model.v]
        for particle in model.particles:
            for x, u in zip(particle.position, particle.velocity):
                drift = graph.diff(x, model.time)
                if drift.is_zero:
                    terms.append((particle.mass * u * u, 0.5))
                else:
                    slopes = graph.gradient(x, numbered(model.q))
                    linear = graph.sum([(slope * model.v[k], 1.0) for k, slope in slopes.items()])
                    terms.append((particle.mass * linear * linear, 0.5))
                    terms.append((particle.mass * drift * drift, -0.5))
        return graph.sum(terms)

    @cached_property
    def forces(self) -> tuple[Node, ...]:
        """Q_k of all forces outside L: ``applied`` ones and those of constraint, but for those that are 0."""
        bound = Constraints(self.model).acting
        return tuple(given + force for given, force in zip(self.applied, bound))

    @cached_property
    def applied(self) -> tuple[Node, ...]:
        """Their parts: F_i . dr_i/dq_k, generalized forces, and -dD/dq_dot_k."""
        model, graph = self.model, self.graph
        found = [
            [(given, 1.0), (graph.diff(model.dissipation, v), -1.0)]
            for v, given in zip(model.v, model.generalized_forces)
        ]
        coordinates = numbered(model.q)
        for particle in model.particles:
            for x, force in zip(particle.position, particle.force):
                for k, slope in graph.gradient(x, coordinates).items():
                    found[k].append((slope * force, 1.0))
        return tuple(map(graph.sum, found))

    def lagrangian_rate(self, symbol: Node) -> Node:
        """dL/dsymbol at fixed other arguments, for ``symbol`` a coordinate or t."""
        model, graph = self.model, self.graph
        if model.lagrangian is not None:
            return graph.diff(model.lagrangian, symbol)
        here = [self._motion[place] for place in self._places.get(symbol, ())]
        terms = ((graph.diff(u, symbol), momentum) for _, u, momentum in here)
        return contract(graph, terms, self._moving) - graph.diff(model.potential, symbol)

    def energy_rate(self, time: Node) -> Node:
        """dh/dt = sum_k Q_k q_dot_k - dL/dt, by the equations of motion."""
        rate: Node = self.power - self.lagrangian_rate(time)
        return rate

    @property
    def torques(self) -> tuple[Node, ...]:
        """dL/dq_k + Q_k, which equals dp_k/dt."""
        return tuple(self.lagrangian_rate(q) + force for q, force in zip(self.model.q, self.forces))

    @property
    def power(self) -> Node:
        """sum_k Q_k q_dot_k: the power of the forces outside L, with what constraints say of those of
        constraint."""
        applied = [(force * v, 1.0) for force, v in zip(self.applied, self.model.v)]
        return self.graph.sum([*applied, (Constraints(self.model).power, 1.0)])
