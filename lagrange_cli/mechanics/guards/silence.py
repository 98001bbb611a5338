"""Friction that is 0 for a time, or from the start: the system is that without it then, and its guards are
silent.

Whether the mode of a guard changes anything is seen from the equations with either mode. Their differences
are sums of products; where each of these has a factor that is 0, whatever moves, the mode may be any. Such
factors are made of parameters and of modes, such as that of t < 1 in where(t < 1, F, 0). If another force has
a kink at the same velocity, it is among the differences.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, factors_of, reachable, terms_of, union
from lagrange_cli.mechanics.guards.guard import Guard
from lagrange_cli.mechanics.guards.modes import Modes, three_ways
from lagrange_cli.mechanics.multiplied_out import monomials
from lagrange_cli.mechanics.substitution import rebuilt, rewritten
from lagrange_cli.records import dataclass, replace


@dataclass(frozen=True)
class Silence:
    """What is 0 where nodes do not depend on modes, or vanish: whole numbers from 0 on. They are made of
    symbols that are ``fixed`` (a bit set), and of switches by these or by arguments whose side is
    ``known``."""

    graph: Graph
    fixed: int
    known: Container[Node] = ()

    def differing(self, nodes: Iterable[Node], one: Mapping[Node, Node], other: Mapping[Node, Node]) -> Node:
        """0 only where none of the ``nodes`` changes if others in them have the values ``other``, instead of
        those of ``one``."""
        changed = union(one)
        nodes = [node for node in dict.fromkeys(nodes) if node.symbols & changed]
        inside = reachable(nodes, lambda node: bool(node.symbols & changed))
        sides = [self._with(inside, given) for given in (one, other)]
        found: dict[Node, Node] = {}

        def vanishing(node: Node) -> Node:
            if node not in found:
                return self.vanishing(node)
            return self.graph.sum([(self.vanishing(side[node]), 1.0) for side in sides])

        for node in inside:
            first, second = (side[node] for side in sides)
            if first is second:
                found[node] = self.graph.zero
            elif node in one or node.kind is Kind.SWITCH:
                terms = monomials(self.graph, first - second)
                found[node] = self.vanishing(first - second if terms is None else self.graph.sum(terms))
            elif node.kind is Kind.PRODUCT:
                factors = factors_of(node)
                found[node] = self.graph.sum(
                    (
                        self.graph.product(
                            [(found[a], 1), *((vanishing(b), 1) for b, e in factors if b is not a and e > 0)]
                        ),
                        1.0,
                    )
                    for a, _ in factors
                    if a in found
                )
            else:
                found[node] = self.graph.sum([(found[a], 1.0) for a in node.arguments if a in found])
        return self.graph.sum([(one, 1.0) for one in dict.fromkeys(found[node] for node in nodes)])

    def _with(self, nodes: Iterable[Node], values: Mapping[Node, Node]) -> dict[Node, Node]:
        """Nodes, arguments before their users, with values of symbols that are in all of them."""
        made = dict(values)
        for node in nodes:
            if node not in made:
                arguments = [made.get(a, a) for a in node.arguments]
                if node.kind is not Kind.DDT:
                    made[node] = rebuilt(self.graph, node, arguments)
                elif arguments[0].symbols & ~self.fixed:
                    made[node] = self.graph.ddt(arguments[0])
                else:
                    made[node] = self.graph.zero
        return made

    def vanishing(self, node: Node) -> Node:
        """0 only where a node is 0, and stays so."""
        graph = self.graph
        if not node.symbols & ~self.fixed:
            return three_ways(graph, node, graph.one, graph.one, graph.zero)
        if node.kind is Kind.SUM:
            return graph.sum([(self.vanishing(term), 1.0) for term, _ in terms_of(node)])
        if node.kind is Kind.PRODUCT:
            return graph.product([(self.vanishing(base), 1) for base, e in factors_of(node) if e > 0])
        if node.kind is Kind.DDT:
            return self.vanishing(node.arguments[0])
        if node.kind is Kind.SWITCH:
            u, *sides = node.arguments
            above, below = map(self.vanishing, sides)
            moves = u.symbols & ~self.fixed and u not in self.known
            return above + below if moves else graph.switch(u, above, below, node.data)
        return graph.one


def silence(
    modes: Modes, nodes: Sequence[Node], limits: Callable[[Modes, Guard], Sequence[Node]]
) -> list[Guard]:
    """Let guards that may hold the motion be silent while their modes change none of the ``nodes``, nor the
    arguments of others and their ``limits``. Returns guards that say when that is, if it changes in a
    motion."""
    graph, model, others = modes.graph, modes.residual.model, union(one.mode for one in modes.guards.values())
    known = Silence(graph, others | union(model.parameters.values()))
    watched = {original: [one.argument, *limits(modes, one)] for original, one in modes.guards.items()}
    set_by_events = {name for event in model.events for name in event.changes}
    changes = others | union(one for name, one in model.parameters.items() if name in set_by_events)
    made: dict[Node, Guard] = {}
    for original, guard in [*modes.guards.items()]:
        if guard.auxiliary is None:
            continue
        felt = [*nodes, *(node for one, listed in watched.items() if one is not original for node in listed)]
        loud = known.differing(felt, {guard.mode: graph.one}, {guard.mode: -graph.one})
        if not loud.symbols:
            continue
        if loud.symbols & changes:
            if loud not in made:
                argument = graph.switch(loud, graph.one, -graph.one, -1)
                made[loud] = Guard(argument, argument, graph.symbol(f"loud {len(made)}"))
            loud = made[loud].mode
        modes.guards[original] = replace(guard, loud=loud)
    return [*made.values()]


def without_silent_vectors(modes: Modes) -> Callable[[Sequence[Node]], tuple[Node, ...]]:
    """Nodes without the friction along vectors that is 0, which has no direction where these are 0: they are
    those of the mode -1."""
    graph, made = modes.graph, dict[Node, Node]()
    changed = {
        one.mode: graph.switch(one.loud, one.mode, -graph.one, -1)
        for one in modes.guards.values()
        if one.vector is not None and one.loud is not None
    }

    def change(node: Node, arguments: list[Node]) -> Node | None:
        if node.kind is Kind.DDT and arguments[0] is not node.arguments[0]:
            return graph.ddt(arguments[0])
        return changed.get(node)

    return lambda nodes: rewritten(graph, nodes, change, made) if changed else tuple(nodes)


def hushed(graph: Graph, guard: Guard) -> Guard:
    """A guard whose argument, and the parts of whose vector, are 1 while it is silent."""
    if guard.loud is None:
        return guard
    loud, vector = guard.loud, guard.vector
    if vector is not None:
        vector = replace(vector, parts=tuple(graph.switch(loud, u, graph.one, -1) for u in vector.parts))
    return replace(guard, argument=graph.switch(loud, guard.argument, graph.one, -1), vector=vector)
