"""Which coordinates constraints with constant coefficients give, each as a linear function of others."""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce
from operator import or_

from lagrange_cli.expression.node import Kind, Node, union
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.constrained.pushed import forces_of
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Event, Model
from lagrange_cli.records import dataclass, field, replace

SMALL = 1e-9
"""Numbers up to this size may be rounding errors."""


@dataclass(frozen=True)
class LinearRelation:
    """A coordinate: the sum of ``scales`` times others, ``rest``, and ``weights`` times the values of
    constraints, which are 0; by their numbers. It is one between velocities if it is not ``holonomic``. The
    ``length`` is the number of coordinates in its ``constraint``."""

    constraint: int
    holonomic: bool
    scales: Mapping[int, Node]
    rest: Node
    weights: Mapping[int, Node]
    length: int


@dataclass
class LinearRelations:
    """The relations of a model that some of its constraints give, by coordinate."""

    model: Model[Node]
    light: frozenset[int]
    """Coordinates without inertia, which are eliminated first: nothing else changes."""
    acting: frozenset[int]
    """Those whose values count, and not only their velocities."""
    found: dict[int, LinearRelation] = field(default_factory=dict)

    def add(self, number: int, row: Mapping[int, Node], rest: Node) -> None:
        """Solve constraint ``number``, of which these are the slopes and the rest, for a coordinate."""
        graph, holonomic = graph_of(self.model), self.model.constraints[number].holonomic
        given = LinearRelation(number, holonomic, row, rest, {number: graph.one}, len(row))
        for k in [k for k in row if k in self.found]:
            given = self._put(given, k, self.found[k])
        # what is written has been seen not to be 0 (``Spec.faint``); sums of it may be
        open_ = {k: a for k, a in given.scales.items() if a is row.get(k) or is_firm(a)}
        if not holonomic:
            if given.rest.symbols & variables(self.model):
                return
            places = [one.scales for one in self.found.values() if one.holonomic]
            needed = self.acting.union(*places)  # these would be known but for a constant
            open_ = {k: a for k, a in open_.items() if k not in needed}
        if not open_:
            return

        def cost(k: int) -> tuple[bool, bool, int]:
            return k not in self.light, open_[k].kind is not Kind.NUMBER, -k

        pivot = min(open_, key=cost)
        left = {k: a for k, a in given.scales.items() if k != pivot}
        over = -graph.one / open_[pivot]
        solved = LinearRelation(
            number,
            holonomic,
            {k: a * over for k, a in left.items() if not is_zero(a)},
            given.rest * over,
            {i: w * over for i, w in given.weights.items()},
            len(row),
        )
        for k, one in self.found.items():
            if pivot in one.scales:
                self.found[k] = self._put(one, pivot, solved)
        self.found[pivot] = solved

    def _put(self, one: LinearRelation, k: int, other: LinearRelation) -> LinearRelation:
        """A relation with another one in place of coordinate k."""
        graph, factor = graph_of(self.model), one.scales[k]

        def joined(mine: Mapping[int, Node], others: Mapping[int, Node]) -> dict[int, Node]:
            both = dict.fromkeys((*mine, *others))
            return {i: mine.get(i, graph.zero) + factor * others.get(i, graph.zero) for i in both}

        rest = other.rest
        if other.holonomic and not one.holonomic:
            rest = graph.diff(rest, self.model.time)
        left = {i: a for i, a in one.scales.items() if i != k}
        return replace(
            one,
            scales=joined(left, other.scales),
            rest=one.rest + factor * rest,
            weights=joined(one.weights, other.weights),
        )


def is_firm(node: Node) -> bool:
    """Whether it is a product of what is not 0."""
    if node.kind is Kind.NUMBER:
        return abs(float(node.data)) > SMALL
    if node.kind is Kind.SUM:
        return len(node.arguments) == 1 and node.data[0] == 0 and is_firm(node.arguments[0])
    return node.kind is not Kind.PRODUCT or all(map(is_firm, node.arguments))


def relations_of(
    model: Model[Node], residual: Residual, acting: frozenset[int], most: int
) -> LinearRelations:
    """The relations that constraints with constant coefficients give."""
    graph, constraints, moving = residual.graph, Constraints(model), variables(model)
    nodes = [*forces_of(model), *(event.argument for event in model.events)]
    used = union(nodes)
    light = frozenset(k for k in range(len(model.q)) if residual.mass_matrix[k][k].is_zero)
    found = LinearRelations(model, light, acting)
    at_rest = dict.fromkeys((*model.q, *model.v), graph.zero)
    faint = () if model.spec is None else model.spec.faint
    changed = reduce(or_, (changed_by(model, event) for event in model.events), 0)
    order = sorted(enumerate(model.constraints), key=lambda pair: not pair[1].holonomic)
    for number, one in order:
        row, drift = constraints.slopes[number], constraints.drifts[number]
        if not 0 < len(row) <= most or one.multiplier.symbols & used or one.name in faint:
            continue
        if any(entry.symbols & (moving | changed) for entry in row.values()):
            continue
        if one.holonomic:
            (rest,) = substituted(graph, [one.expression], at_rest)
        elif drift.symbols & moving:
            continue
        else:
            rest = drift
        found.add(number, row, rest)
    return found


def changed_by(model: Model[Node], event: Event[Node]) -> int:
    """The parameters that an event sets, as bits."""
    return reduce(or_, (one.symbols for name, one in model.parameters.items() if name in event.changes), 0)
