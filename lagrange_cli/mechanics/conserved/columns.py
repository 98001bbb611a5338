"""Values and rates of change of the terms of a sum at random states, and the sums whose rates vanish."""

from __future__ import annotations

import random
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import TypeVar

from lagrange_cli.expression.modular import Equations
from lagrange_cli.expression.node import Kind, Node, reachable, union
from lagrange_cli.expression.residues import BITS, LARGE, SMALL
from lagrange_cli.expression.text import text_of
from lagrange_cli.mechanics.conserved.ansatz import Powers, Term, Variables
from lagrange_cli.mechanics.conserved.reasons import without_denominators
from lagrange_cli.mechanics.conserved.residue_states import State, States
from lagrange_cli.mechanics.matrices import determinant
from lagrange_cli.mechanics.relations import Relations
from lagrange_cli.mechanics.variables import state_symbols
from lagrange_cli.records import dataclass

SPARE = 4
"""States beyond those that are needed."""
PRODUCTS = 4
"""Products modulo a prime that count as one step of work."""
MOST_SOLVED, MOST_COORDINATES = 10, 3
"""Terms of a sum whose coefficients are found by elimination, and coordinates of its system."""

VALUE, RATE = 0, 1
Moving = tuple[int, int]
"""A value and its rate of change."""
Factors = tuple[Powers, tuple[Node, ...]]
"""The powers of places and the functions in a term."""
Key = TypeVar("Key")


@dataclass(frozen=True)
class Columns:
    """The ``ansatz`` is a sum of terms in the variables ``given``, with unknown coefficients."""

    states: States
    given: Variables
    ansatz: Sequence[Term]

    @cached_property
    def _made_of(self) -> Sequence[Node]:
        """The variables and functions."""
        functions = (one for term in self.ansatz for one in term.functions)
        return [*dict.fromkeys((*self.given.places, *self.given.speeds, *functions))]

    @cached_property
    def _rates(self) -> Mapping[Node, tuple[Node, Sequence[Node]]]:
        """Their rates: a part without accelerations, and the factors of these. That of a momentum is known
        from Lagrange's equations."""
        states, zero = self.states, self.states.graph.zero
        noether, free = states.noether, union(states.model.v)
        known: dict[Node, tuple[Node, Sequence[Node]]] = {noether.energy: (zero, ())}
        if not states.model.constraints:
            pairs = zip(noether.energetics.momenta, noether.torques)
            known |= {p: (torque, ()) for p, torque in pairs if p.symbols & free}
        found = {one: known.get(one) or states.rate(one) for one in self._made_of}
        return {
            one: (rest, slopes if any(not slope.is_zero for slope in slopes) else ())
            for one, (rest, slopes) in found.items()
        }

    @cached_property
    def _accelerated(self) -> bool:
        """Whether accelerations are in the rates."""
        return any(slopes for _, slopes in self._rates.values())

    @cached_property
    def nodes(self) -> Sequence[Node]:
        """The nodes that are evaluated at each state."""
        return [*self._made_of, *(one for rest, slopes in self._rates.values() for one in (rest, *slopes))]

    @cached_property
    def parameters(self) -> Sequence[Node]:
        """The parameters that the terms and their rates depend on."""
        return self._parameters(self.nodes, accelerated=self._accelerated)

    def _parameters(self, nodes: Sequence[Node], *, accelerated: bool) -> Sequence[Node]:
        """Those in ``nodes``, and in constraints and accelerations where these are needed."""
        model = self.states.model
        moving = {*model.q, *model.v, model.time}
        below = reachable([*nodes, *(self.states.needed if accelerated or model.constraints else ())])
        return [one for one in below if one.kind is Kind.SYMBOL and one not in moving]

    def node(self, term: Term) -> Node:
        """A term as an expression."""
        factors = [*zip(self.given.places, term.places), *zip(self.given.speeds, term.speeds)]
        return self.states.graph.product([*factors, *((one, 1) for one in term.functions)])

    def _known(self, state: State, which: int) -> dict[Node, Moving]:
        """The variables and functions at a state, with their rates of change if these are wanted."""
        value = state.values
        if which == VALUE:
            return {one: (value[one], 0) for one in self._made_of}
        return {
            one: (value[one], value[rest] + sum([value[s] * a for s, a in zip(slopes, state.accelerations)]))
            for one, (rest, slopes) in self._rates.items()
        }

    @cached_property
    def _factors(self) -> tuple[Sequence[Powers], Sequence[Factors], Sequence[tuple[int, int]]]:
        """The different monomials in the speeds, the other factors of terms, and of which two of them, by
        number, each term is the product."""
        speeds = numbers_of(term.speeds for term in self.ansatz)
        others = numbers_of((term.places, term.functions) for term in self.ansatz)
        pairs = [(speeds[term.speeds], others[term.places, term.functions]) for term in self.ansatz]
        return [*speeds], [*others], pairs

    def _row(self, state: State, which: int, p: int) -> list[int]:
        """The terms at a state, or their rates of change."""
        known, (speeds, others, pairs) = self._known(state, which), self._factors
        x, v = ([known[one] for one in some] for some in (self.given.places, self.given.speeds))
        first = [monomial(v, powers, p) for powers in speeds]
        second = [
            product([monomial(x, powers, p), *(known[one] for one in functions)], p)
            for powers, functions in others
        ]
        if which == VALUE:
            return [first[i][0] * second[j][0] for i, j in pairs]
        return [first[i][0] * second[j][1] + first[i][1] * second[j][0] for i, j in pairs]

    def solutions(self, prime: int, parameters: Mapping[str, int] | None = None) -> list[dict[int, int]]:
        """Coefficients of sums that are constant, where the parameters have these values, or random ones."""
        equations = self._equations(prime, RATE, parameters)
        return [] if equations is None else equations.solutions()

    def vanishing(self, prime: int) -> list[int]:
        """Terms that are sums of those before them at every state that constraints allow; all, if there are
        no states."""
        equations = self._equations(prime, VALUE, None)
        return [*range(len(self.ansatz))] if equations is None else equations.free

    def constants(self, prime: int, parameters: Mapping[str, int]) -> dict[Node, int]:
        """Functions of parameters, such as sin(alpha), with the values that they have there."""
        state = next(self.states.random(prime, self.nodes, parameters, accelerated=self._accelerated), None)
        moving = state_symbols(self.states.model)
        known = {} if state is None else state.values
        fixed = {one: value for one, value in known.items() if not one.symbols & moving}
        return {one: value for one, value in fixed.items() if one.kind is Kind.FUNCTION}

    def _equations(self, prime: int, which: int, given: Mapping[str, int] | None) -> Equations | None:
        count, work = len(self.ansatz), self.states.graph.work
        equations, idle, source = Equations(count, prime), 0, random.Random(count)
        nodes, accelerated = (self._made_of, False) if which == VALUE else (self.nodes, self._accelerated)
        if given is None:
            parameters = self._parameters(nodes, accelerated=accelerated)
            given = {str(one.data): source.randrange(1, prime) for one in parameters}
        states = self.states.random(prime, nodes, given, accelerated=accelerated)
        state = sent(states, None)
        if state is None:
            return None
        while state is not None and idle < SPARE and len(equations) < count:
            work.charge((len(equations) + 4) * count * (1 + prime.bit_length() // BITS) // PRODUCTS)
            new = equations.add(self._row(state, which, prime))
            idle = 0 if new else idle + 1
            state = sent(states, new)
        return equations


def sent(states: Generator[State, bool | None, None], stay: bool | None) -> State | None:
    """The next of random states, at the same place if told to stay there; None where there are no more."""
    try:
        return states.send(stay)
    except StopIteration:
        return None


def conserved_sums(
    states: States, given: Variables, ansatz: Sequence[Term]
) -> Iterator[tuple[list[Term], list[Node]]]:
    """The terms of sums that are constant, short ones first, with coefficients in terms of the parameters."""
    for vector in sorted(Columns(states, given, ansatz).solutions(SMALL), key=len):
        from lagrange_cli.mechanics.conserved.recognition import Recognition  # most searches find nothing

        some = [ansatz[i] for i in vector]
        columns = Columns(states, given, some)
        recognition = Recognition(states.graph, columns.parameters, LARGE)
        solutions = columns.solutions(LARGE, recognition.values) if recognition.possible else []
        coefficients = None
        if len(solutions) == 1:
            values = [solutions[0].get(i, 0) for i in range(len(some))]
            coefficients = recognition.coefficients(values)
            if coefficients is None:
                coefficients = recognition.coefficients(values, columns.constants(LARGE, recognition.values))
        if coefficients is None and 1 < len(some) <= MOST_SOLVED:
            coefficients = by_elimination(columns)
        if coefficients is not None:
            yield some, coefficients


def by_elimination(columns: Columns) -> list[Node] | None:
    """Coefficients of the only sum that is constant, as any functions of parameters; None where they are not
    found."""
    states, model, graph = columns.states, columns.states.model, columns.states.graph
    n = len(model.q)
    if model.constraints or n > MOST_COORDINATES:
        return None
    below = determinant(graph, states.noether.matrix)
    accelerations = [  # by Cramer's rule, times the determinant
        determinant(
            graph, [[*row[:k], f, *row[k + 1 :]] for row, f in zip(states.noether.matrix, states.forces)]
        )
        for k in range(n)
    ]
    rates = [states.rate(columns.node(term)) for term in columns.ansatz]
    given = [
        [graph.sum([(rest * below, 1.0), *((s * a, 1.0) for s, a in zip(slopes, accelerations))])]
        for rest, slopes in rates
    ]
    relations = Relations(graph, (model.time, *model.q, *model.v))
    found = relations.solved(given, range(len(given)), {})
    return None if found is None else without_denominators(graph, [*found.values()])


def independent(states: States, given: Variables, ansatz: Sequence[Term]) -> list[Term]:
    """Terms that are neither sums of those before them nor constant at the states that constraints allow."""
    constant = Term((0,) * len(given.speeds), (0,) * len(given.places))
    gone = {*Columns(states, given, [constant, *ansatz]).vanishing(SMALL)}
    return [term for i, term in enumerate(ansatz, 1) if i not in gone]


def name_of(term: Term, given: Variables) -> str:
    """A term in the language of system files."""
    powers = [*zip(given.speed_names, term.speeds), *zip(given.names, term.places)]
    above = [name if n == 1 else f"{name}**{n}" for name, n in powers if n]
    texts = [given.words.get(one) or factor_text(one) for one in term.functions]
    above += [text for text in texts if not text.startswith("1/")]
    return ("*".join(above) or "1") + "".join(text[1:] for text in texts if text.startswith("1/"))


def factor_text(node: Node) -> str:
    """An expression as a factor of a product."""
    return f"({text_of(node)})" if node.kind is Kind.SUM else text_of(node)


def numbers_of(keys: Iterable[Key]) -> dict[Key, int]:
    """The different ones, numbered."""
    return {one: number for number, one in enumerate(dict.fromkeys(keys))}


def monomial(x: Sequence[Moving], powers: Powers, p: int) -> Moving:
    """A product of powers."""
    return product((one for one, n in zip(x, powers) for _ in range(n)), p)


def product(factors: Iterable[Moving], p: int) -> Moving:
    """With its rate of change."""
    value, rate = 1, 0
    for x, x_rate in factors:
        value, rate = value * x % p, (rate * x + value * x_rate) % p
    return value, rate
