"""Forces of constraint on the particles, R_i = m_i a_i - F_i, in components of space.

F_i is what is applied: forces, and those of U and of Rayleigh's D as functions of the positions r_i and the
velocities u_i of the particles (Goldstein, 3rd ed., eqs. 1.46, 1.58 and 1.67),

    F_i = F_i(applied) - dU/dr_i + d/dt dU/du_i - dD/du_i.

An expression that contains coordinates instead, or a force along a coordinate, says only what work is done
when that coordinate changes: sum_i F_i . dr_i/dq_k = e_k. This determines the forces where as many components
of positions depend on these coordinates as there are coordinates, as with Cartesian or polar ones of a
particle in the plane. Otherwise they are not known.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

from lagrange_cli.expression.algebra import Algebra
from lagrange_cli.expression.node import Node
from lagrange_cli.expression.vocabulary import COMPONENTS, VELOCITY_COMPONENTS
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.embedding import MOST_AT_ONCE, Component, Embedding, solution
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import OfModel, rate, variables
from lagrange_cli.model.build import action_of
from lagrange_cli.model.orientation import Turning
from lagrange_cli.model.scope import Scope
from lagrange_cli.records import dataclass
from lagrange_cli.spec.spec import Spec


class InSpace(Scope[Node]):
    """The values of names, where particles' positions and velocities are variables of their own.

    So are orientations and angular velocities of bodies: what depends on these is a torque.
    """

    def __init__(self, spec: Spec, algebra: Algebra[Node]) -> None:
        super().__init__(spec, algebra)
        places, speeds = dict[Component, Node](), dict[Component, Node]()
        for name in spec.embedding:
            for i, _ in enumerate(self.vector_of(name)):
                places[name, i] = algebra.symbol(f"{name}.{COMPONENTS[i]}")
                speeds[name, i] = algebra.symbol(f"{name}.{VELOCITY_COMPONENTS[i]}")
        self.actual = {places[name, i]: self.vector_of(name)[i] for name, i in places}
        self.actual |= {speeds[name, i]: self.velocity(name)[i] for name, i in speeds}
        self.places, self.speeds = places, speeds
        for name in spec.embedding:
            count = len(self.vector_of(name))
            self.values[name] = tuple(places[name, i] for i in range(count))
            self.velocities[name] = tuple(speeds[name, i] for i in range(count))
        for name in spec.bodies:
            real = self.turning(name)
            axes, rates = (
                self._named(f"{name} {what}", rows) for what, rows in enumerate((real.axes, real.rates))
            )
            in_space, in_body = self._named(f"{name} spin", (real.in_space, real.in_body))
            self._turning[name] = Turning(axes, rates, in_space, in_body)

    def _named(self, name: str, rows: Sequence[Sequence[Node]]) -> tuple[tuple[Node, ...], ...]:
        """Symbols in place of values."""
        made = [
            [self.algebra.symbol(f"{name} {i} {j}") for j in range(len(row))] for i, row in enumerate(rows)
        ]
        for symbols, row in zip(made, rows):
            self.actual |= dict(zip(symbols, row))
        return tuple(map(tuple, made))

    def vector_of(self, particle: str) -> tuple[Node, ...]:
        """Its position."""
        position: tuple[Node, ...] = self.values[particle]
        return position


@dataclass(frozen=True)
class Reactions(OfModel):
    """The forces of constraint of a model with particles."""

    @cached_property
    def on_particles(self) -> Mapping[str, tuple[Node, ...]]:
        """R by particle, of those on which the applied force is known, with time derivatives in it."""
        graph, moving, forces = self.graph, variables(self.model), self._forces[0]
        return {
            one.name: tuple(
                (one.mass * rate(graph, u, moving) if u.symbols & moving else graph.zero)
                - forces.get((one.name, i), graph.zero)
                for i, u in enumerate(one.velocity)
            )
            for one in self.model.particles
            if one.name not in self.unknown and not one.body
        }

    @property
    def unknown(self) -> Mapping[str, str]:
        """Why the force on a particle is not known, by its name."""
        return self._forces[1]

    @cached_property
    def _forces(self) -> tuple[Mapping[Component, Node], Mapping[str, str]]:
        """The applied force on each component of each particle, and where it is not known."""
        model, graph = self.model, self.graph
        assert model.spec is not None
        scope, moving = InSpace(model.spec, model.algebra), variables(model)
        potential = scope.total([scope.scalar(term) for term in model.spec.potential.values()])
        action = action_of(scope)
        dissipation = graph.zero if action.dissipation is None else action.dissipation

        def here(node: Node) -> Node:
            return substituted(graph, [node], scope.actual)[0]

        def pull(place: Node, speed: Node) -> Node:
            """The force along a component, or a coordinate, of that speed."""
            momentum = here(graph.diff(potential, speed))
            slopes = graph.sum([(graph.diff(potential, place), -1.0), (graph.diff(dissipation, speed), -1.0)])
            return here(slopes) + rate(graph, momentum, moving)

        known = {one: pull(place, scope.speeds[one]) for one, place in scope.places.items()}
        for name, force in action.on_particles.items():
            for i, part in enumerate(force):
                known[name, i] = known[name, i] + here(part)
        along: dict[int, Node] = {}
        reasons: dict[int, str] = {}
        for k, (name, q, v) in enumerate(zip(model.coordinates, model.q, model.v)):
            given = action.generalized.get(name, graph.zero)
            for what, parts in (
                ("U contains", [graph.diff(potential, q), graph.diff(potential, v)]),
                ("the dissipation contains the velocity of", [graph.diff(dissipation, v)]),
                ("a generalized force is given along", [given]),
            ):
                if not all(is_zero(here(part)) for part in parts):
                    reasons.setdefault(k, f"{what} the coordinate '{name}'")
            if k in reasons:
                along[k] = pull(q, v) + here(given)
        return self._shared_out(known, along, reasons)

    def _shared_out(
        self, known: dict[Component, Node], along: Mapping[int, Node], reasons: Mapping[int, str]
    ) -> tuple[Mapping[Component, Node], Mapping[str, str]]:
        """The forces ``along`` coordinates as forces on components, added to those that are ``known``."""
        if not along:
            return known, {}
        graph, unknown = self.graph, dict[str, str]()
        embedding = Embedding(self.model)
        for moved, components in embedding.blocks:
            here = [k for k in moved if k in along]
            if not here or not components:
                continue
            # the transposed slopes times the forces on components are the forces along coordinates
            found = None
            if len(moved) == len(components) <= MOST_AT_ONCE:
                matrix = [[embedding.slopes[one].get(k, graph.zero) for one in components] for k in moved]
                found = solution(graph, matrix, [along.get(k, graph.zero) for k in moved])
            if found is not None and known.keys() >= {*components}:
                for one, force in zip(components, found):
                    known[one] = known[one] + force
                continue
            for name, i in filter(known.__contains__, components):
                acting = [k for k in here if k in embedding.slopes[name, i]]
                if acting:
                    reason = reasons[acting[0]]
                    unknown.setdefault(
                        name,
                        f"the force on '{name}' is not known, since {reason}; write it in positions, such as "
                        f"{name}.{COMPONENTS[0]}",
                    )
        return known, unknown
