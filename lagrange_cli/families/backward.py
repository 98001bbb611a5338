"""The system of families in reversed time, with which a motion is followed backward (see
``mechanics.backward``): v and t have the other sign in forces and in what is followed beside the motion."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Domain, Total
from lagrange_cli.families.description import FamilySystem, Modes
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.records import replace


class Reversal:
    """Totals of a system as functions of x, dx/ds and s = -t."""

    def __init__(self, system: FamilySystem) -> None:
        self.system, self._known = system, dict[Total, Total]()
        if system.bonds is not None:
            self._known[system.bonds.multipliers] = system.bonds.multipliers
        if system.modes is not None and system.modes.sticking is not None:
            multipliers = system.modes.sticking.multipliers
            self._known[multipliers] = multipliers
        if system.modes is not None and system.modes.locks is not None:
            self._known[system.modes.locks.left] = system.modes.locks.left
        joints = system.joints
        self._places = {place for place, _ in joints.followed} if joints else set[Total]()
        self._speeds = (
            {speed for _, speed in joints.followed if speed is not None} if joints else set[Total]()
        )

    def of(self, total: Total, sign: float = 1.0) -> Total:
        """A total, or its opposite."""
        if total not in self._known:
            terms = [replace(one, node=self._node(one.node, one.domain)) for one in total.terms]
            self._known[total] = replace(total, terms=tuple(terms))
        found = self._known[total]
        if sign == 1.0:
            return found
        return replace(found, terms=tuple(replace(one, node=sign * one.node) for one in found.terms))

    def _node(self, node: Node, domain: Domain) -> Node:
        slots, time = self.system.slots, self.system.time
        others = {time: -time} if node.symbols & time.symbols else {}
        for symbol, slot in slots.inside(node):
            if slot.array is self.system.v or slot.array in self._speeds:
                others[symbol] = -symbol
            elif isinstance(slot.array, Total) and slot.array not in self._places:
                others[symbol] = slots.symbol(domain, self.of(slot.array), slot.table)
        return substituted(slots.graph, [node], others)[0] if others else node

    def equations(self) -> FamilySystem:
        """The system, with the forces and events of reversed time."""
        system, events = self.system, self.system.events
        if events is not None:
            arguments, sizes = self.of(events.arguments), self.of(events.sizes)
            events = replace(events, directions=-events.directions, arguments=arguments, sizes=sizes)
        modes = system.modes
        if modes is not None:
            limits = None if modes.limits is None else self.of(modes.limits)
            loose = None if modes.loose is None else self.of(modes.loose)
            locks = modes.locks and replace(modes.locks, other=self.of(modes.locks.other))
            halts = modes.halts and replace(modes.halts, other=self.of(modes.halts.other))
            modes = replace(
                modes, arguments=self.of(modes.arguments), limits=limits, loose=loose, locks=locks,
                halts=halts, beside=self._beside(modes),
                errors=None if modes.errors is None else self.of(modes.errors),
            )  # fmt: skip
        first_order = system.first_order
        if first_order is not None:
            first_order = replace(first_order, velocities=self.of(first_order.velocities, -1.0))
        return replace(
            system, modes=modes, first_order=first_order, forces=self.of(system.forces),
            needed=[*map(self.of, system.needed)], loads=[*map(self.of, system.loads)], events=events,
        )  # fmt: skip

    def _beside(self, modes: Modes) -> Total | None:
        """The components of vectors along which friction acts, which are dx/ds less those of belts, and the
        forces that hold them."""
        if modes.beside is None:
            return None
        total, components = self.of(modes.beside), np.zeros(modes.beside.count, dtype=bool)
        first = 0
        for _, pivots in modes.vectors:
            components[first : first + len(pivots)] = True
            first += 2 * len(pivots)
        terms = (replace(one, node=-one.node) if components[one.targets[0]] else one for one in total.terms)
        return replace(total, terms=tuple(terms))

    def integrands(self, given: Mapping[str, tuple[Total, int]]) -> dict[str, tuple[Total, int]]:
        """The integrands over s that give integrals over t."""
        opposite: dict[Total, Total] = {}
        for total, _ in given.values():
            opposite.setdefault(total, self.of(total, -1.0))
        return {name: (opposite[total], index) for name, (total, index) in given.items()}
