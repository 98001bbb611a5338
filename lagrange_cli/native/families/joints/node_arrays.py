"""What is computed of the nodes of chains and trees (see ``balance``)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Source, Term, Total, total_of
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.joints.joints import Articulation

Arranged = Callable[..., Total]


def array(count: int) -> Array:
    """Numbers that are computed."""
    return Array(Source.TOTAL, count)


class NodeArrays:
    """What is computed of nodes; ``arranged`` puts arrays in place of what is constant in totals."""

    masses: Mapping[tuple[int, int], Total]
    """M: that of what hangs from a node first, and then its own besides."""
    pull: Sequence[Total]
    """B: first what hangs from nodes and is no node."""
    strain: Sequence[Total]
    """R of nodes."""
    turned: Mapping[tuple[int, int], Total]
    """What accelerations of nodes are of those of the parents' coordinates that they stick to."""

    def __init__(
        self,
        system: FamilySystem,
        arranged: Arranged,
        forces: Total | None = None,
        loads: Sequence[Total] | None = None,
    ) -> None:
        assert system.joints is not None
        self.system, self.found, self.arrange = system, system.joints, arranged
        self.slots, self.graph = system.slots, system.slots.graph
        found: Articulation = self.found
        self.count, locks = found.count, system.modes and system.modes.locks
        relative = found.relative
        self.sums = [arranged(one) for one in relative.chains] if relative else []
        self.speeds = [arranged(one) for one in relative.speeds] if relative else []
        """Sums of coordinates that are those of joints, and their velocities."""
        self.carries = [arranged(one) for one in locks.carries] if locks else []
        """What accelerations of coordinates that stick are of those of the joints before, one by one."""
        self.places = range(len(found.nodes))
        """The components of places."""
        self.turns = range(len(found.nodes), len(found.nodes) + len(self.carries))
        """The accelerations of nodes' coordinates, as further components."""
        self.axes = range(self.turns.stop)
        self.size = max((len(one.rows) for one in found.joints if one.nodes is not None), default=0)
        loads = system.loads if loads is None else loads
        self.forces = self.on_joints(system.forces if forces is None else forces, loads)
        self.loads = self.on_nodes(loads)
        self.inertia = [arranged(one) for one in found.inertia]
        self.gates = arranged(locks.gates) if locks else None
        """0 of coordinates that are held, if any may be."""
        self.pairs = [(c, e) for c in self.axes for e in self.axes if c <= e]
        self.bonds = [(c, b) for c in self.axes for b in range(self.size)]
        self.pivots = [(b, d) for b in range(self.size) for d in range(self.size) if b <= d]
        many = self.count
        self.node_slopes = {one: array(many) for one in self.bonds if one[0] in self.places}
        """J of nodes."""
        self.rest = [array(many) for _ in self.places]
        """c of nodes."""
        self.gains = {one: array(many) for one in self.bonds}
        """M J / (J^T M J)."""
        self.inverse = {one: array(many) for one in self.pivots}
        """1 / (J^T M J)."""
        self.passed = {(c, e): array(many) for c in self.axes for e in self.axes}
        """What part of B goes on to the parent."""
        self.accelerations = [array(many) for _ in self.axes]
        """Those of nodes, behind one of what does not move."""

    def on_joints(self, forces: Total, loads: Sequence[Total]) -> Total:
        """The forces on the joints' coordinates, from those on coordinates and ``loads`` on sums of these."""
        relative = self.found.relative
        if relative is not None:
            sums = loads[len(self.found.nodes) :]
            forces = total_of(forces.count, relative.forces(forces, sums), self.graph)
        return self.arrange(forces, kept=False)

    def on_nodes(self, loads: Sequence[Total]) -> list[Total]:
        """The loads on nodes."""
        return [self.arrange(one, kept=False) for one in loads[: len(self.found.nodes)]]

    def arranged_symbol(self, symbol: Node) -> Node:
        """The symbol of a coordinate of joints, by the arrays that are computed."""
        slot = self.slots.of[symbol]
        if not isinstance(slot.array, Total):
            return symbol
        return self.slots.symbol(slot.domain, self.arrange(slot.array), slot.table)

    def total(self, count: int, terms: Sequence[Term], *, kept: bool = True) -> Total:
        """A total; one that is changed afterwards is not ``kept`` for the whole motion."""
        moving = tuple(one for one in terms if not one.node.is_zero)
        return self.arrange(Total(Source.TOTAL, count, moving), kept=kept)
