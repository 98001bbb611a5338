"""The switches of a system of families, and which of them have no modes (see ``switches``)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.node import Node, factors_of, reachable
from lagrange_cli.families.arrays import Domain, Term, Total
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.jumps import (
    depends_on_parameters,
    is_root,
    jumps,
    jumps_by_a_constant,
    partial,
    pole,
    refuse_angles,
)
from lagrange_cli.families.switching.friction import Friction, holds, passing, yields
from lagrange_cli.families.switching.vector_friction import Along, along_vectors, refuse_elsewhere
from lagrange_cli.mechanics.switching.switches import Merging, switches
from lagrange_cli.records import replace

JUMPS = (
    "forces that jump other than with a coordinate, a velocity or a difference of these",
    "write friction as -F*sign(x_dot[i]) on x[i], or as dissipation: F*abs(x_dot[i] - x_dot[j]), "
    "and let other forces not jump, or only where they vanish with the relative velocity or where they "
    "never push back from both sides",
)
"""What members are written out for, and how to do without."""
ON_JOINTS = (
    "forces that jump on chains and trees, other than with a coordinate, a velocity or a difference of these",
    "write friction as dissipation: F*abs(a_dot[i] - a_dot[j]), or a steep function such as tanh(9*u)",
)
SMOOTH = "write a steep function that does not jump, such as tanh(100*u) for sign(u)"


def written_out(system: FamilySystem) -> Unsuited:
    """Why members are written out for forces that jump."""
    if system.joints is not None:
        return Unsuited(*ON_JOINTS)
    if system.bonds is not None:
        return Unsuited("forces that jump in systems with constraints", SMOOTH)
    return Unsuited(*JUMPS)


class Switched:
    """The switches of a system, in totals with one for each argument; further totals may be ``listed``."""

    def __init__(self, system: FamilySystem, listed: Sequence[Total] = ()) -> None:
        self.system, self.slots, self.graph = system, system.slots, system.slots.graph
        self.places = self.slots.symbols_of(system.q, system.v, totals=True)
        """What moves, but t."""
        self.moving = self.places | system.time.symbols
        events = [] if system.events is None else [system.events.arguments]
        used = *system.energies, *system.acting, system.slopes, system.gradient, system.applied, *events
        used += *listed, *([] if system.vector is None else [system.vector])
        self.totals = [*dict.fromkeys(used)]
        self._others = [system.kinetic, *(one.node for one in system.masses.terms)]
        """What may have no switches."""
        if system.bonds is not None:
            self._others += system.bonds.nodes
        if system.joints is not None:
            fixed = *system.joints.nodes, *system.joints.inertia
            self._others += [*system.joints.moved, *(term.node for one in fixed for term in one.terms)]
        self._merging = Merging(self.graph, self.moving)
        self._merged: dict[Total, tuple[Term, ...]] = {}

    def merged(self, total: Total) -> tuple[Term, ...]:
        """The terms of a total with one switch for each argument."""
        if total not in self._merged:
            nodes = self._merging.merged([one.node for one in total.terms])
            terms = tuple(replace(one, node=node) for one, node in zip(total.terms, nodes))
            self._merged[total] = terms if switches(nodes, self.moving) else total.terms
        return self._merged[total]

    @property
    def any(self) -> bool:
        """Whether there are switches that matter."""
        others = switches(self.slots.made_of(self._others), self.moving)
        return bool(others or self.along) or any(map(self.switched, (self.system.potential, *self._nodes)))

    @property
    def _nodes(self) -> list[Node]:
        """The expressions of all totals with one switch for each argument."""
        return [term.node for total in self.totals for term in self.merged(total)]

    @cached_property
    def _barred(self) -> set[Node]:
        """The arguments whose zeros no motion passes, as energies are infinite there on both sides: those of
        1/|u| and log|u|, or of forces from 1/u on."""
        found = set[Node]()
        for total in self.totals:
            least = 0 if total in self.system.energies else 1
            inside = switches([term.node for term in self.merged(total)], self.moving)
            found.update(one.arguments[0] for one in inside if pole(self.graph, one) >= least)
        return found

    def followed(self, nodes: Iterable[Node]) -> list[Node]:
        """The switches in these that a motion may pass."""
        found = switches(nodes, self.moving)
        return [one for one in found if one.arguments[0] not in self._barred or pole(self.graph, one) < 0]

    def within(self, total: Total) -> bool:
        """Whether there are switches in it that a motion may pass, or in what it is made of."""
        return any(self.switched(term.node) for term in self.merged(total))

    def switched(self, node: Node) -> bool:
        """Whether there are such switches in an expression, or in what it is made of."""
        if self.followed(self._merging.merged([node])) or self._directed(node):
            return True
        arrays = (slot.array for _, slot in self.slots.inside(node))
        return any(isinstance(array, Total) and self.within(array) for array in arrays)

    def _directed(self, node: Node) -> bool:
        """Whether it contains the length of a vector along which friction acts."""
        squares = {square for _, square in self.along}
        return bool(squares) and any(
            exponent % 1.0 == 0.5 and base in squares
            for one in reachable([node])
            for base, exponent in factors_of(one)
        )

    @cached_property
    def along(self) -> Mapping[tuple[Domain, Node], Along]:
        """Dry friction along vectors, by the domains and squares of these."""
        return along_vectors(self.system, self.merged(self.system.forces), self.moving)

    def refuse(self) -> None:
        """Raise ``Unsuited`` for switches that have no modes here."""
        if switches(self.slots.made_of(self._others), self.moving):
            raise Unsuited
        acting = self.system.forces, self.system.applied, self.system.slopes, self.system.gradient
        used = [one for one in self.totals if one not in self._idle]
        others = [term.node for one in used if one not in acting for term in self.merged(one)]
        others += self._merging.merged([self.system.potential])
        terms = (term for total in acting for term in self.merged(total))
        refuse_elsewhere(self.system, self.along, terms, others)
        inside = {*switches(others, self.moving)}
        nodes = [*others, *(term.node for one in acting for term in self.merged(one))]
        rubbing = {friction.argument for friction in self.friction} | self.passed
        decisive = switches(nodes, self.moving)
        refuse_angles(self.slots, [one.arguments[0] for one in decisive])
        for one in decisive:
            argument, above, below = one.arguments
            followed = argument in rubbing and one not in inside
            known = one in inside and jumps_by_a_constant(self.graph, one, self.moving)
            jumping = argument.symbols & self.places and not (followed or known) and jumps(self.graph, one)
            if jumping and self.system.first_order is None:
                raise written_out(self.system)
            if any(jumps(self.graph, inner) for inner in self._within(argument)):
                raise Unsuited
            inner = [a for a in switches([above, below], self.moving) if partial(a.arguments[0], self.moving)]
            if inner:
                raise Unsuited  # they may have no value on the other side, and are followed there, too
            if self.speedy(argument) and any(is_root(x, self.moving) for x in reachable([above, below])):
                raise Unsuited  # what has no series where a velocity is 0 may come to rest there

    @cached_property
    def _jumping(self) -> list[tuple[Friction, Friction]]:
        """The terms of the forces that jump, for each argument with places or velocities by itself; and each
        in the domain of the first that has the same numbers in this. Where velocities follow from places, no
        force jumps but their rates, which hold nothing (``families.first_order``)."""
        if self.system.first_order is not None:
            return []
        found, known = list[tuple[Friction, Friction]](), list[Friction]()
        for term in self.merged(self.system.forces):
            jumping: dict[Node, list[Node]] = {}
            for one in switches([term.node], self.moving):
                if one.arguments[0].symbols & self.places and jumps(self.graph, one):
                    jumping.setdefault(one.arguments[0], []).append(one)
            for argument, listed in jumping.items():
                own = Friction(term, argument, listed)
                first = next((moved for one in known if (moved := own.like(one, self.slots))), own)
                known += [own] if first is own else []
                found.append((own, first))
        return found

    @cached_property
    def friction(self) -> list[Friction]:
        """The forces that can hold coordinates. Raises ``Unsuited`` where one that jumps cannot, unless it
        does not jump while another one holds."""
        found = [pair for pair in self._jumping if pair[0].argument not in self.passed]
        holding = [pair for pair in found if holds(self.system, pair[0], self.moving)]
        held = {one.place for _, one in holding}
        for pair in found:
            if pair not in holding and not (pair[1].place in held and yields(self.system, pair[1])):
                raise written_out(self.system)
        return [one for one, _ in holding]

    @property
    def _idle(self) -> set[Total]:
        """Totals that no force contains, such as the whole power of the dissipation."""
        needed = {*self.system.needed}
        roots = [term.node for one in self.totals if one not in needed for term in one.terms]
        made = self.slots.made_of([self.system.potential, *roots])
        return needed - {slot.array for node in made for _, slot in self.slots.inside(node)}

    @cached_property
    def passed(self) -> set[Node]:
        """The arguments at which forces jump that cannot hold them (``passing``)."""
        acting: dict[tuple[Domain, Node], list[tuple[Friction, Friction]]] = {}
        for own, one in self._jumping:
            acting.setdefault(one.place, []).append((own, one))
        return {
            own.argument
            for given in acting.values()
            if self._by_parameters(given) or passing(self.system, [one for _, one in given])
            for own, _ in given
        }

    def _by_parameters(self, given: Iterable[tuple[Friction, Friction]]) -> bool:
        """Whether forces jump where the signs of parameters say so, and motions are to pass there."""
        inside = (one for own, _ in given for one in own.switches)
        return self.system.passes and all(
            depends_on_parameters(self.graph, one, self.moving) for one in inside
        )

    def _within(self, node: Node) -> Iterator[Node]:
        """The switches in an expression, and in what it is made of."""
        yield from switches([node], self.moving)
        for array in {slot.array for _, slot in self.slots.inside(node)}:
            if isinstance(array, Total):
                for term in self.merged(array):
                    yield from self._within(term.node)

    def speedy(self, node: Node) -> bool:
        """Whether velocities are in an expression, or in what it is made of."""
        arrays = {slot.array for _, slot in self.slots.inside(node)}
        inner = (term.node for one in arrays if isinstance(one, Total) for term in one.terms)
        return self.system.v in arrays or any(map(self.speedy, inner))
