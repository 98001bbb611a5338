"""The masses of joints of one kind: J^T m J of what they carry, and its inverse (see ``kinds``)."""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Term, Total
from lagrange_cli.mechanics.matrices import determinant
from lagrange_cli.native.families.joints.kind_symbols import KindSymbols


class KindMasses(KindSymbols):
    """The masses of a kind; what they take is computed ``first``."""

    hangs: bool
    first: list[Total]
    determinant: Total | None
    _inverse: dict[tuple[int, int], Node]
    _gains: dict[tuple[int, int], Node]

    def total(self, node: Node) -> Total:
        """A number of each of the kind's members."""
        return self.balance.total(self.domain.count, [Term(self.domain, node, self.domain.every)])

    def on(self, c: int) -> list[int]:
        """The weights behind component ``c`` of the parent."""
        return [s for s, one in enumerate(self.weights) if one.component == c and self.hangs]

    def weight(self, s: int) -> Node:
        return self.weights[s].mass

    def bent(self, b: int, d: int) -> Node:
        """An entry of J^T m J of the weights; beside a spin what its elimination leaves."""
        every = range(len(self.weights))
        parts = [self.weight(s) * self.swing(s, b) * self.swing(s, d) for s in every]
        free = self.free_mass(b, d)
        if self.spin is not None and (b, d) in self.beside:
            coupled = self.free_mass(b, self.spin) * self.free_mass(d, self.spin)
            held = (1.0 - self.gate(self.spin)) * coupled / self.free_mass(self.spin, self.spin)
            free = self.beside_spin(b, d) + held
        return self.summed([*parts, self.gate(b) * self.gate(d) * free])

    def locked(self, b: int, d: int) -> Node:
        """1 on the diagonal where a coordinate is held."""
        return 1.0 - self.gate(b) if b == d else self.graph.zero

    def meeting(self, c: int, b: int) -> Node:
        """An entry of m J of the weights behind a component."""
        if c in self.balance.turns:
            if not self.is_node:
                return self.graph.zero
            every = range(len(self.weights))
            parts = [self.weight(s) * self.swung(s, c) * self.swing(s, b) for s in every]
            return self.summed([*parts, self.stuck(c, lambda d: self.free_mass(d, b)) * self.gate(b)])
        return self.summed([self.weight(s) * self.swing(s, b) for s in self.on(c)])

    def weighed(self, c: int, e: int) -> list[Term]:
        """Weights that nodes' joints carry behind their parents."""
        if not self.is_node or not self.hangs:
            return []
        if c in self.balance.turns:
            every = range(len(self.weights))
            both = [self.weight(s) * self.swung(s, c) * self.swung(s, e) for s in every]
            both.append(self.stuck(c, lambda b: self.stuck(e, lambda d: self.free_mass(b, d))))
            return [Term(self.domain, self.summed(both), self.at)]
        if e in self.balance.turns:
            one = [self.weight(s) * self.swung(s, e) for s in self.on(c)]
            return [Term(self.domain, self.summed(one), self.at)]
        return [Term(self.domain, self.weight(s), self.at) for s in self.on(c)]

    def met(self, c: int, b: int) -> list[Term]:
        return [Term(self.domain, self.meeting(c, b), self.at)] if self.is_node and b in self.bends else []

    def corner(self, b: int, d: int) -> list[Term]:
        """J^T m J, without what couples a spin to others; 1 where the joint has no such coordinate."""
        if not self.is_node or (b != d and self.spin in (b, d)):
            return []
        if d in self.bends:
            return [Term(self.domain, self.bent(b, d) + self.locked(b, d), self.at)]
        return [Term(self.domain, self.graph.one, self.at)] if b == d else []

    def spinning(self, b: int, d: int) -> list[Term]:
        """What couples the spin ``b`` of a node to another coordinate, divided by its mass."""
        if not self.is_node or b != self.spin or b == d or d not in self.bends:
            return []
        mass = self.bent(b, b) + self.locked(b, b)
        return [Term(self.domain, self.bent(b, d) / mass, self.at)]

    def _eliminate(self) -> None:
        """1 / (J^T m J), and m J / (J^T m J), of joints that carry weights alone."""
        size, entries = len(self.bends), dict[tuple[int, int], Node]()
        for b in self.bends:
            for d in self.bends[b:]:
                entries[b, d] = entries[d, b] = self._kept(self.bent(b, d) + self.locked(b, d))
        spun = {} if self.spin is None else self._without_spin(self.spin, entries)
        matrix = [[entries[b, d] for b in self.bends] for d in self.bends]
        self.determinant = self.total(determinant(self.graph, matrix))
        self.first.append(self.determinant)
        for b in self.bends:
            for d in self.bends[b:]:
                rows = [[entries[i, j] for j in range(size) if j != b] for i in range(size) if i != d]
                sign = -1.0 if (b + d) % 2 else 1.0
                node = sign * determinant(self.graph, [*zip(*rows)]) / self.own(self.determinant)
                self._inverse[b, d] = node if node.is_zero else self._kept(node)
        if self.spin is not None:
            self._with_spin(self.spin, spun)
        for c in self.balance.axes:
            for b in self.bends:
                node = self.summed([self.meeting(c, d) * self.inverse(d, b) for d in self.bends])
                self._gains[c, b] = node if node.is_zero else self._kept(node)

    def _without_spin(self, spin: int, entries: dict[tuple[int, int], Node]) -> dict[int, Node]:
        """Take what couples a spin to the others out of M, divided by its mass."""
        found = dict[int, Node]()
        for d in self.bends:
            if d != spin and not entries[spin, d].is_zero:
                found[d] = self._kept(entries[spin, d] / entries[spin, spin])
                entries[spin, d] = entries[d, spin] = self.graph.zero
        return found

    def _with_spin(self, spin: int, spun: Mapping[int, Node]) -> None:
        """M^-1 of all coordinates, from that beside a spin."""
        for b in self.bends:
            if b != spin:
                node = self.summed([part * self.inverse(d, b) for d, part in spun.items()])
                self._inverse[min(spin, b), max(spin, b)] = self._kept(-node)
        node = self.summed([part * self.inverse(spin, d) for d, part in spun.items()])
        self._inverse[spin, spin] = self._kept(self.inverse(spin, spin) - node)

    def _kept(self, node: Node) -> Node:
        """A number of each member, computed first."""
        self.first.append(self.total(node))
        return self.own(self.first[-1])

    def held(self, c: int, e: int) -> list[Term]:
        """The mass of weights that hang from nodes."""
        if self.is_node or self.joints.parents is None:
            return []
        node = self.summed([self.weight(s) for s in self.on(c)]) if c == e else self.graph.zero
        node = node - self.summed([self.gain(c, b) * self.meeting(e, b) for b in self.bends])
        return [Term(self.domain, node, self.joints.parents)]
