"""``Found``: conserved quantities while they are looked for, and whether another one is new."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.conservation import Conserved, broken, surfaces_of_events
from lagrange_cli.mechanics.conserved.noether import Change, Noether
from lagrange_cli.mechanics.embedding import Embedding
from lagrange_cli.mechanics.relations import Relations, dependent
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of, state_symbols
from lagrange_cli.model.events import changes_of
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass, replace

LONGEST_INTEGRAL = 600
"""Characters of a formula."""


@dataclass(frozen=True)
class Symmetry:
    """A conserved quantity and the function of q, q_dot, t that it is."""

    conserved: Conserved
    node: Node


@dataclass(frozen=True)
class Trial:
    """A displacement of all particles: the quantity that it may conserve, as a formula, and a description of
    it, or the reason."""

    name: str
    change: Change
    text: str
    how: str = ""
    because: str = ""


class Found:
    """The ``symmetries`` of a model so far, beyond what is ``known`` of h and of momenta."""

    def __init__(self, model: Model[Node], known: Sequence[Conserved]) -> None:
        self.model, self.noether, self.graph = model, Noether(model), graph_of(model)
        self.embedding = Embedding(model)
        self.symmetries: list[Symmetry] = []
        self.note = ""
        """What is added to each reason."""
        self.place = ""
        """Where the particle is, in words, that the system moves like."""
        self.names = {each.quantity for each in known}
        nodes = {f"p_{name}": p for name, p in zip(model.coordinates, self.noether.energetics.momenta)}
        nodes["h"] = self.noether.energy
        breaks = {each.quantity: each.breaks for each in known}
        self.kept = [node for name, node in nodes.items() if name in self.names]
        self.lasting = [node for name, node in nodes.items() if breaks.get(name) == ()]
        """The quantities that no event changes."""
        self.currents: list[tuple[str, Change]] = []
        """Changes that conserve something, with its name if it is reported; where events change the state,
        others, too."""
        self.trials: list[Trial] = []
        """Displacements of all particles that conserve nothing by themselves."""
        self.relations = Relations(self.graph, (model.time, *model.q, *model.v))

    def add(self, name: str, text: str, because: str, change: Change) -> bool:
        """Add a conserved current, unless it is a combination of those that are known; whether it is new."""
        node = self.noether.current(change)
        if self.is_known(node, change, self.kept) and not self._outlasts(node, change):
            return False
        self.kept.append(node)
        name = self.free_name(name)
        self.currents.append((name, change))
        self.store(Conserved(name, text, because), node)
        return True

    @property
    def kept_linear(self) -> list[Node]:
        """The known functions that are linear in the velocities."""
        return [one for one in self.kept if one is not self.noether.energy]

    @cached_property
    def eventful(self) -> bool:
        """Whether events change the state."""
        return any(event.changes for event in self.model.events)

    @cached_property
    def _jumps(self) -> tuple[Mapping[str, Mapping[Node, Node]], Mapping[str, Mapping[Node, Node]]]:
        """What events set, and where they happen."""
        return changes_of(self.model), surfaces_of_events(self.model)

    def store(self, each: Conserved, node: Node) -> None:
        """Add what is proven to be conserved."""
        each = replace(each, because=each.because + self.note)
        if self.eventful:
            each = broken(self.graph, each, node, *self._jumps)
        self.lasting += [] if each.breaks else [node]
        self.symmetries.append(Symmetry(each, node))

    def store_lasting(self, each: Conserved, node: Node) -> None:
        """Add what is proven to be conserved, and to be changed by no event."""
        self.lasting.append(node)
        self.symmetries.append(Symmetry(each, node))

    def store_integral(self, text: str, because: str, node: Node, name: str = "") -> None:
        """The same, without a name of its own unless one is given, and perhaps with a long formula."""
        text = text if len(text) <= LONGEST_INTEGRAL else "a long sum"
        number = sum(one.startswith("I_") for one in self.names) + 1
        self.store(Conserved(self.free_name(name or f"I_{number}"), text, because), node)

    def _outlasts(self, node: Node, change: Change) -> bool:
        """Whether no event changes a current, although events change its parts: the total momentum in a
        collision."""
        if len(self.lasting) == len(self.kept):
            return False
        breaks = broken(self.graph, Conserved("", "", ""), node, *self._jumps).breaks
        return not breaks and not self.is_known(node, change, self.lasting)

    def is_known(self, node: Node, change: Change, kept: Sequence[Node]) -> bool:
        """Whether a current is a sum of known ones with constant factors, or a constant."""
        others = [one for one in kept if change.time is not None or one is not self.noether.energy]
        known = substituted(self.graph, [*others, node], self.noether.eliminated)
        columns = [[one] for one in (self.graph.one, *known)]
        rows = self.relations.rows(columns, {})
        return not rows or len(known) in dependent(rows, len(columns))

    def is_independent(self, node: Node, known: Sequence[Node] | None = None) -> bool:
        """Whether it is no function of those that are known, and of what constraints keep, by gradients at
        a state."""
        model, graph = self.model, self.graph
        symbols = [*model.q, *model.v]
        known = [*self.kept, *(one.node for one in self.symmetries)] if known is None else known
        given = [*known, *self.plain]
        allowed = substituted(graph, [*given, node], self.noether.eliminated)
        columns = [[graph.diff(one, s) for s in symbols] for one in allowed]
        return not self.relations.may_combine(columns[:-1], columns[-1])

    @cached_property
    def plain(self) -> list[Node]:
        """What need not be reported: constraints, functions of place that constraints on velocities keep, and
        that coordinates with conserved momenta change uniformly."""
        if not self.model.constraints:
            return self._uniform()
        from lagrange_cli.mechanics.constrained.potentials import integrals

        holonomic = [one.expression for one in self.model.constraints if one.holonomic]
        return [*holonomic, *self.noether.constraints.speeds, *(node for _, node in integrals(self.model))]

    def _uniform(self) -> list[Node]:
        """t p_k - sum_l M_kl q_l where p_k and all M_kl are constant."""
        graph, model, found = self.graph, self.model, list[Node]()
        if self.eventful:
            return []
        pairs = zip(model.coordinates, self.noether.energetics.momenta)
        moving = state_symbols(model)
        for k, (name, p) in enumerate(pairs):
            row = [graph.diff(p, v) for v in model.v] if f"p_{name}" in self.names else []
            if row and not any(m.symbols & moving for m in row):
                change = Change({k: model.time}, gain=graph.sum([(m * q, 1.0) for m, q in zip(row, model.q)]))
                if self.noether.keeps(change):
                    found.append(self.noether.current(change))
        return found

    def free_name(self, name: str) -> str:
        """The name, or the next one that nothing else has."""
        while name in self.model.coordinates or name in self.names:
            name += "'"
        self.names.add(name)
        return name

    def is_made(self, node: Node) -> bool:
        """Whether it is a sum of constants, of what is known, and of products of two of these."""
        known = [*self.kept, *(one.node for one in self.symmetries)]
        known += [
            a * b for i, a in enumerate(self.kept) for b in self.kept[i:] if self.noether.energy not in (a, b)
        ]
        columns = [[one] for one in (self.graph.one, *known, node)]
        rows = self.relations.rows(columns, {})
        return not rows or len(columns) - 1 in dependent(rows, len(columns))
