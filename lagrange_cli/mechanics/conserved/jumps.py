"""What events change, at random states modulo a prime, without rounding.

It is looked at only where an event happens: on the surface on which its argument is 0.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import islice

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.modular import Equations
from lagrange_cli.expression.node import Kind, Node, factors_of, reachable, terms_of
from lagrange_cli.expression.residues import LARGE, NoValue, Residues, effort, quotient
from lagrange_cli.expression.zero import zeros
from lagrange_cli.mechanics.conserved.columns import SPARE
from lagrange_cli.mechanics.conserved.recognition import Recognition
from lagrange_cli.mechanics.conserved.residue_states import PROOFS, TRIES
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import OfModel, state_symbols
from lagrange_cli.model.events import changes_of
from lagrange_cli.model.model import Event
from lagrange_cli.records import dataclass

SMALL = 2**61 - 1
"""A prime modulo which sums are looked for; functions of parameters have random values there."""

BRANCH = " "
"""Names of the numbers that functions with branches stand for begin with this, which no other name does."""


@dataclass(frozen=True)
class Surface:
    """Where a x^2 + b x + c is 0, with the ``coefficients`` a, b, c."""

    x: Node
    coefficients: Sequence[Node]

    def root(self, residues: Residues, values: Mapping[Node, int]) -> int:
        """An x on it; raises ``NoValue``."""
        a, b, c = (values[one] for one in self.coefficients)
        if not a:
            return quotient(-c, b, residues.prime)
        return quotient(residues.root(b * b - 4 * a * c, 2) - b, 2 * a, residues.prime)


@dataclass(frozen=True)
class Jumps(OfModel):
    """What the events of a model change."""

    @cached_property
    def events(self) -> Sequence[Event[Node]]:
        """The events that change the state."""
        return [event for event in self.model.events if event.changes]

    @cached_property
    def _changes(self) -> Mapping[str, Mapping[Node, Node]]:
        return changes_of(self.model)

    def keep(self, node: Node) -> bool:
        """Whether it is proven that no event changes a function of the state."""
        jumps = [jump for event in self.events for jump in self._of([node], event)]
        absent, pairs = zeros(jumps), zip(self.events, jumps)
        return all(jump in absent or self._vanishes(event, jump) for event, jump in pairs)

    def sums(self, nodes: Sequence[Node]) -> Iterator[dict[int, Node]]:
        """Coefficients, by number, of sums that no event may change, short ones first: functions of the
        parameters. What is found has to be proven."""
        moving = state_symbols(self.model)
        below = reachable([*nodes, *(x for event in self.events for x in self._of(nodes, event))])
        symbols = [one for one in below if one.kind is Kind.SYMBOL and not one.symbols & moving]
        parameters = [one for one in symbols if not str(one.data).startswith(BRANCH)]
        recognition = Recognition(self.graph, parameters, LARGE)
        if not recognition.possible:
            return
        source = random.Random(len(nodes))
        squares = {str(one.data): source.randrange(1, SMALL) ** 2 for one in parameters}
        usable = [i for i, node in enumerate(nodes) if has_value(node, moving, recognition)]
        for vector in sorted(self._solutions([nodes[i] for i in usable], SMALL, squares), key=len):
            some = [usable[i] for i in vector]
            exact = self._solutions([nodes[i] for i in some], LARGE, recognition.values)
            if len(exact) == 1:
                factors = recognition.coefficients([exact[0].get(i, 0) for i in range(len(some))])
                if factors is not None:
                    yield dict(zip(some, factors))

    def _solutions(
        self, nodes: Sequence[Node], prime: int, parameters: Mapping[str, int]
    ) -> list[dict[int, int]]:
        equations = Equations(len(nodes), prime)
        for event in self.events:
            idle = 0
            for row in self._at_random(event, self._of(nodes, event), prime, parameters):
                self.graph.work.charge((len(equations) + 1) * len(nodes))
                idle = 0 if equations.add(row) else idle + 1
                if idle == SPARE:
                    break
            if idle < SPARE:
                return []  # too few states have values
        return equations.solutions()

    def _vanishes(self, event: Event[Node], jump: Node) -> bool:
        """Whether a jump is 0 where the event happens."""
        values = [*islice(self._at_random(event, [jump], LARGE, {}), PROOFS)]
        return len(values) == PROOFS and not any(value for (value,) in values)

    def _of(self, nodes: Sequence[Node], event: Event[Node]) -> list[Node]:
        """How far an event changes functions of the state. What has branches there stands for any number."""
        after = substituted(self.graph, nodes, self._changes[event.name])
        jumps = [new - old for new, old in zip(after, nodes)]
        switches = [one for one in reachable(jumps) if one.kind is Kind.SWITCH]
        free = {one: self.graph.symbol(f"{BRANCH}{i}") for i, one in enumerate(switches)}
        return [*substituted(self.graph, jumps, free)]

    @cached_property
    def _surfaces(self) -> Mapping[str, Surface | None]:
        """Where each event happens, by its name."""
        found, symbols = dict[str, Surface | None](), [*self.model.q, *self.model.v]
        for event in self.events:
            argument = without_root(self.graph, event.argument, state_symbols(self.model))
            given = (surface(self.graph, argument, x) for x in symbols if argument.symbols & x.symbols)
            found[event.name] = next((one for one in given if one is not None), None)
        return found

    def _at_random(
        self, event: Event[Node], jumps: Sequence[Node], prime: int, parameters: Mapping[str, int]
    ) -> Iterator[list[int]]:
        """Their values where the event happens, or anywhere if that is not solved for."""
        where, fails = self._surfaces[event.name], 0
        inside, below = reachable(jumps), reachable(where.coefficients if where else ())
        names = {str(one.data) for one in (*inside, *below) if one.kind is Kind.SYMBOL}
        source, work = random.Random(len(inside)), effort([*inside, *below], prime)
        while fails < TRIES:
            self.graph.work.charge(work)
            residues = Residues(prime, source)
            given = {**{name: residues.random() for name in names}, **parameters}
            try:
                if where:
                    given[str(where.x.data)] = where.root(residues, residues.values(below, given))
                values = residues.values(inside, given)
            except NoValue:
                fails += 1
                continue
            fails = 0
            yield [values[one] for one in jumps]


def surface(graph: Graph, argument: Node, x: Node) -> Surface | None:
    """None where the argument is no polynomial of the first or second degree in x."""
    slope = graph.diff(argument, x)
    second = graph.diff(slope, x)
    if slope.is_zero or second.symbols & x.symbols:
        return None
    b, c = substituted(graph, [slope, argument], {x: graph.zero})
    return Surface(x, (0.5 * second, b, c))


def has_value(node: Node, moving: int, recognition: Recognition) -> bool:
    """Whether the roots of parameters in it exist where coefficients are recognized."""
    fixed = [one for one in reachable([node]) if not one.symbols & moving]
    try:
        Residues(LARGE, random.Random(0)).values(fixed, recognition.values)
    except NoValue:
        return False
    return True


def without_root(graph: Graph, node: Node, moving: int) -> Node:
    """s - c**2 for sqrt(s) - c, such as a distance, with a constant c."""
    roots = [(one, c) for one, c in terms_of(node) if one.symbols & moving]
    if len(roots) == 1:
        ((one, c),) = roots
        factors = [(base, e) for base, e in factors_of(one) if base.symbols & moving]
        if len(factors) == 1 and factors[0][1] == 0.5:
            factor = graph.sum([(one, c)]) / graph.product(factors)
            rest = graph.sum([(node, 1.0), (one, -c)]) / factor
            return factors[0][0] - rest * rest
    return node
