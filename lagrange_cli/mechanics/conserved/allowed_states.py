"""What constraints make of velocities and of coordinates, where expressions are to hold for all states that
they allow."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from itertools import islice

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Node, factors_of, terms_of
from lagrange_cli.expression.zero import zeros
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import OfModel, state_symbols
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class AllowedStates(OfModel):
    """The states of a model that its ``constraints`` allow."""

    constraints: Constraints

    @cached_property
    def _moving(self) -> int:
        return state_symbols(self.model)

    @cached_property
    def eliminated(self) -> Mapping[Node, Node]:
        """Velocities by others, as the constraints have it, and coordinates that these are linear in."""
        graph, model = self.graph, self.model
        known: dict[Node, Node] = {}
        solved = 0
        for one, slopes, speed in zip(model.constraints, self.constraints.slopes, self.constraints.speeds):
            by_others = resolved(graph, known, solved, [one.expression, speed])
            here = dict(zip(slopes, substituted(graph, slopes.values(), by_others)))
            (speed,) = substituted(graph, [speed], by_others)
            free = {k: a for k, a in here.items() if model.v[k] not in known and not a.is_zero}
            if not free:
                continue
            k = min(free, key=lambda one: bool(free[one].symbols & self._moving))
            slope = graph.diff(speed, model.v[k])
            if slope.is_zero:
                continue
            (rest,) = substituted(graph, [speed], {model.v[k]: graph.zero})
            known[model.v[k]] = -rest / slope
            solved |= model.v[k].symbols
            if one.holonomic and not slope.symbols & self._moving:
                (expression,) = substituted(graph, [one.expression], by_others)
                rest = slope * model.q[k] - expression
                if not rest.symbols & model.q[k].symbols:
                    known[model.q[k]] = rest / slope
                    solved |= model.q[k].symbols
        return resolved(graph, known, solved, known)

    @cached_property
    def normalized(self) -> Mapping[Node, Node]:
        """Coordinates on spheres (``on_sphere``): constraints keep them at a constant distance from 0, as
        those of a quaternion."""
        graph, model = self.graph, self.model
        known: dict[Node, Node] = {}
        for one, slopes in zip(model.constraints, self.constraints.slopes):
            if not one.holonomic or len(slopes) < 2 or any(model.q[k] in known for k in slopes):
                continue
            factors = {slope / model.q[k] for k, slope in slopes.items()}
            square = graph.sum([(model.q[k] * model.q[k], 0.5) for k in slopes])
            for factor in factors if len(factors) == 1 else ():
                rest = one.expression - factor * square
                if not factor.symbols & self._moving and not rest.symbols & self._moving:
                    known |= on_sphere([model.q[k] for k in slopes], either_root(-2.0 * rest / factor))
        return known

    def where_constraints_hold(self, lists: Sequence[Sequence[Node]]) -> list[tuple[Node, ...]]:
        """Expressions, with what the constraints make of velocities and of coordinates."""
        graph, every = self.graph, [node for nodes in lists for node in nodes]
        if self.eliminated:
            every = [*substituted(graph, every, self.eliminated)]
        if self.normalized:
            absent = zeros(every)
            every = [
                graph.zero if node in absent else one
                for node, one in zip(every, substituted(graph, every, self.normalized))
            ]
        left = iter(every)
        return [tuple(islice(left, len(nodes))) for nodes in lists]


def on_sphere(symbols: Sequence[Node], radius: Node) -> dict[Node, Node]:
    """Symbols whose squares add up to that of ``radius``: by stereographic projection, all but the first one
    stand for any numbers. It has no root, whose branches would have to be told apart."""
    first, *others = symbols
    plane = first.graph.sum([(one * one, 1.0) for one in others])
    known = {one: 2.0 * radius * one / (1.0 + plane) for one in others}
    return {first: radius * (1.0 - plane) / (1.0 + plane), **known}


def either_root(square: Node) -> Node:
    """A number with this square, of either sign: b of b**2, and not its absolute value."""
    ((term, c), *others) = terms_of(square)
    factors = factors_of(term)
    if others or c < 0.0 or any(n % 2 for _, n in factors):
        return square.graph.product([(square, 0.5)])
    return math.sqrt(c) * square.graph.product([(base, n / 2) for base, n in factors])


def resolved(
    graph: Graph, known: Mapping[Node, Node], solved: int, nodes: Iterable[Node]
) -> dict[Node, Node]:
    """The symbols in ``nodes`` that are ``known``, with the bits ``solved``, by those that are not. Values
    contain none that were known before them; those that ``nodes`` do not lead to are not looked at."""
    found: dict[Node, Node] = {}
    pending = [x for node in nodes for x in graph.symbols_of(node, solved)]
    while pending:
        symbol = pending[-1]
        inner = graph.symbols_of(known[symbol], solved)
        missing = [x for x in inner if x not in found]
        if missing:
            pending += missing
            continue
        pending.pop()
        if symbol not in found:
            (found[symbol],) = substituted(graph, [known[symbol]], {x: found[x] for x in inner})
    return found
