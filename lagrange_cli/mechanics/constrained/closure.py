"""Which combinations of constraints on velocities are integrable, although the constraints are not.

The directions that constraints allow span a distribution D. All motions keep a function F(q, t) if its
differential vanishes on D, and so on all brackets [X, Y] = (X.grad) Y - (Y.grad) X of its fields, on the
brackets of D with these, and so on until nothing new comes. The forms that vanish on all of them are the last
system of the derived flag, and by Frobenius' theorem as many functions stay constant (R. L. Bryant et al.,
Exterior Differential Systems, 1991, ch. II).

Solved for the velocities of some coordinates p, the constraints are dx_p + sum_j R_pj dx_j = 0, and D has the
fields X_j = e_j - sum_p R_pj e_p. Their brackets have components along the e_p only. Fields are exact, ranks
are those at random states, modulo a prime.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator, Mapping, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.modular import Equations
from lagrange_cli.expression.node import Kind, Node, reachable, union
from lagrange_cli.expression.residues import SMALL, Residues
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.relations import Relations
from lagrange_cli.records import dataclass

Form = Mapping[int, Node]
"""The coefficients of dq_k, and of dt behind them."""
Field = tuple[Node, ...]


class State:
    """A random state, modulo a prime: what vanishes there vanishes everywhere, and nothing is rounded."""

    def __init__(self, graph: Graph, parameters: Mapping[str, float], seed: int) -> None:
        self.graph, self.residues = graph, Residues(SMALL, random.Random(seed))
        self.given = {name: self.residues.number(value) for name, value in parameters.items()}

    def values(self, nodes: Sequence[Node]) -> list[int]:
        """Values of expressions; raises ``NoValue``."""
        below = reachable(nodes)
        self.graph.work.charge(2 * len(below))
        for one in below:
            if one.kind is Kind.SYMBOL and one.data not in self.given:
                self.given[str(one.data)] = self.residues.random()
        found = self.residues.values(below, self.given)
        return [found[node] % SMALL for node in nodes]


@dataclass(frozen=True)
class Solved:
    """Independent forms, ``rows`` by number, solved for ``pivots``: dx_p + sum_j ``rest[p][j]`` dx_j = 0."""

    graph: Graph
    variables: Sequence[Node]
    rows: tuple[int, ...]
    pivots: tuple[int, ...]
    rest: Mapping[int, Form]

    @property
    def free(self) -> list[int]:
        """The directions j of the fields X_j."""
        return [j for j in range(len(self.variables)) if j not in self.rest]

    def along(self, j: int, node: Node) -> Node:
        """The derivative of a function along X_j."""
        self.graph.work.charge(len(self.pivots))
        terms = [(self.graph.diff(node, self.variables[j]), 1.0)]
        for p in self.pivots:
            slope = self.rest[p].get(j)
            if slope is not None:
                terms.append((slope * self.graph.diff(node, self.variables[p]), -1.0))
        return self.graph.sum(terms)

    def first(self) -> Iterator[list[Field]]:
        """The brackets [X_j, X_k] by their components along the pivots, those of one j after another."""
        zero, free, rows = self.graph.zero, self.free, [self.rest[p] for p in self.pivots]
        for i, j in enumerate(free):
            yield [
                tuple(self.along(k, row.get(j, zero)) - self.along(j, row.get(k, zero)) for row in rows)
                for k in free[i + 1 :]
            ]

    def bracket(self, j: int, field: Field) -> Field:
        """[X_j, Z] of a field along the pivots."""
        graph, zero = self.graph, self.graph.zero
        graph.work.charge(len(field) ** 2)
        found = []
        for p, z in zip(self.pivots, field):
            slope = self.rest[p].get(j, zero)
            terms = [(self.along(j, z), 1.0)]
            terms += [
                (part * graph.diff(slope, self.variables[q]), 1.0) for q, part in zip(self.pivots, field)
            ]
            found.append(graph.sum(terms))
        return tuple(found)

    def on(self, form: Form, field: Field) -> Node:
        """The value of a form on a field along the pivots."""
        return self.graph.sum(
            [(form[p] * z, 1.0) for p, z in zip(self.pivots, field) if p in form and not z.is_zero]
        )


def solved(graph: Graph, variables: Sequence[Node], forms: Sequence[Form], state: State) -> Solved:
    """The forms as far as they are independent at a state; raises ``NoValue``."""
    numbers, rest = reduced(graph, forms, state, union(variables))
    return Solved(graph, variables, numbers, tuple(rest), rest)


def reduced(
    graph: Graph, forms: Iterable[Form], state: State, moving: int
) -> tuple[tuple[int, ...], dict[int, dict[int, Node]]]:
    """Homogeneous linear equations solved for some unknowns p, x_p + sum_j rest[p][j] x_j = 0.

    Returns the numbers of those that are independent of the ones before at a state, and the rest by p. What
    an equation is solved for has a coefficient without ``moving`` symbols, if any. Raises ``NoValue``.
    """
    rest: dict[int, dict[int, Node]] = {}
    numbers = []
    for number, form in enumerate(forms):
        row = dict(form)
        for p, other in rest.items():
            factor = row.pop(p, None)
            if factor is not None:
                _subtract(graph, row, factor, other)
        values = state.values([*row.values()])
        row = {j: node for (j, node), value in zip(row.items(), values) if value}
        if not row:
            continue
        pivot = min(row, key=lambda j: (bool(row[j].symbols & moving), len(reachable([row[j]]))))
        lead = row.pop(pivot)
        row = {j: node / lead for j, node in row.items()}
        for other in rest.values():
            factor = other.pop(pivot, None)
            if factor is not None:
                _subtract(graph, other, factor, row)
        rest[pivot] = row
        numbers.append(number)
    return tuple(numbers), rest


def _subtract(graph: Graph, row: dict[int, Node], factor: Node, other: Form) -> None:
    for j, node in other.items():
        row[j] = row.get(j, graph.zero) - factor * node


def closure(system: Solved, most: int, state: State) -> list[Field]:
    """Fields along the pivots, independent at a state, that span together with D all brackets of D; there are
    at ``most`` so many. Raises ``NoValue``."""
    size = len(system.pivots)
    basis, found = Equations(size, SMALL), list[Field]()
    pending = system.first()
    while True:
        new: list[Field] = []
        for fields in pending:
            if len(found) + len(new) == most:
                return found + new
            values = iter(state.values([z for field in fields for z in field]))
            new += [field for field in fields if basis.add([next(values) for _ in field])]
        found += new
        if not new:
            return found
        pending = ([system.bracket(j, field) for j in system.free] for field in new)


def annihilating(
    system: Solved, forms: Mapping[int, Form], fields: Sequence[Field], state: State
) -> list[tuple[dict[int, Node], bool]]:
    """A basis of the combinations of ``forms`` that vanish on fields along the pivots: factors by the numbers
    of the forms, and whether these are constants. The forms are independent at the state. Raises
    ``NoValue``."""
    graph, numbers = system.graph, [*forms]
    columns = [[system.on(form, field) for field in fields] for form in forms.values()]
    constant = Relations(graph, system.variables).relations(columns)
    proven = [
        {numbers[i]: factor for i, factor in one.items()}
        for one in constant
        if not any(
            not is_zero(graph.sum([(factor * columns[i][k], 1.0) for i, factor in one.items()]))
            for k in range(len(fields))
        )
    ]
    if len(proven) == len(forms) - len(fields):
        return [(one, True) for one in proven]
    moving = union(system.variables)
    equations = [
        {i: column[k] for i, column in enumerate(columns) if not column[k].is_zero}
        for k in range(len(fields))
    ]
    _, rest = reduced(graph, equations, state, moving)
    return [
        ({numbers[j]: graph.one, **{numbers[p]: -row[j] for p, row in rest.items() if j in row}}, False)
        for j in range(len(forms))
        if j not in rest
    ]
