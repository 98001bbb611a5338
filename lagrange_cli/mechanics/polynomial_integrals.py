"""Conserved polynomials in the velocities, of systems with few degrees of freedom.

Unknown numbers stand before the terms of a sum (``ansatz``). Its rate of change vanishes at every state, a
linear equation for them at each of many random ones. All this is done modulo a prime, where nothing is rounded,
with random values of the parameters: what is found holds for all of them, and its coefficients are functions of
the parameters. These are recognized from their values at prime numbers, if they are products of parameters, of
sums of two such as a - b or 4*a - b, and of numbers. What is claimed is proven again, at other random states
modulo a prime of 521 bits (see ``expression.residues``).
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from itertools import chain, combinations, islice

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.modular import Equations, factored, fraction_of
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.residues import LARGE, SMALL, quotient, square_root
from lagrange_cli.expression.text import joined, text_of
from lagrange_cli.mechanics.ansatz import (
    MOST_COLUMNS,
    Material,
    Powers,
    Term,
    Variables,
    has_constant_masses,
    material_of,
    own_variables,
    separable,
    terms,
    variables_in_space,
)
from lagrange_cli.mechanics.noether import Noether
from lagrange_cli.mechanics.reasons import term as term_text
from lagrange_cli.mechanics.residue_states import State, States
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass

SPARE = 4
"""More states than are needed."""
PROOFS = 3
"""States at which the rate of change must vanish."""
PRIMES = (
    8984771,
    19261343,
    5376263,
    13413637,
    16906601,
    3198799,
    1441849,
    16744829,
    9702487,
    19481281,
    8862877,
    7433869,
)
"""Values of parameters, in which their products are recognized."""
LARGEST = 1000
"""Numerators and denominators of coefficients."""
SMOOTH = 2**8 * 3**4 * 5**2 * 7 * 11 * 13 * 17 * 19 * 23
"""What values of sums may have been divided by: a + b is even for odd a and b."""
SQUARES = (1, 2, 3, 5, 6)
"""Numbers whose roots are recognized."""
FACTORS = (1, 2, 3, 4, 8, 9, 16)
"""Numbers before the terms of sums that are recognized."""
PLACES_OF = {1: 1, 2: 2, 3: 1, 4: 0}
"""Degrees in the velocities that are tried, and the highest one of leading coefficients in the places."""
HIGHEST = 4
"""Of these, the one in which the coefficients of two coordinates are tried to one degree more."""
ODD = (1, 2)
"""Those that are tried where forces change with the sign of velocities."""
SURFACE = (2, 2)
"""Those that are tried on a surface."""
SPACE = 3
"""Its dimensions."""
MOST_VARIABLES = 5
PRODUCTS = 8
"""Products modulo a prime that are one step of work."""


@dataclass(frozen=True)
class Integral:
    """A conserved function of the state, its formula, and its ``degree`` in the velocities."""

    node: Node
    text: str
    degree: int


class PolynomialIntegrals:
    """Those of a model, beside the ``known`` conserved functions."""

    def __init__(self, model: Model[Node], noether: Noether, known: Sequence[Node]) -> None:
        self.model, self.noether, self.known = model, noether, [*known]
        self.states = States(model, noether)

    @property
    def graph(self) -> Graph:
        return graph_of(self.model)

    @cached_property
    def freedoms(self) -> int:
        return len(self.model.q) - len(self.model.constraints)

    def found(self) -> Iterator[Integral]:
        """Those that do not follow from what is known."""
        model = self.model
        if self.freedoms < 2 or len(model.q) > MOST_VARIABLES or self.states.solved_for is None:
            return
        self.known += self._uniform()
        rank = self.rank(self.known)
        for given, ansatz in self._tried():
            if rank is None or rank >= 2 * self.freedoms - 1:
                return
            for one in self._solutions(given, ansatz):
                now = self.rank([*self.known, one.node])
                if now is not None and now > rank and self.is_conserved(one.node):
                    rank = now
                    self.known.append(one.node)
                    yield one

    @cached_property
    def _steady(self) -> bool:
        """Whether masses are constant."""
        return has_constant_masses(self.model, self.states.matrix)

    def _uniform(self) -> list[Node]:
        """t p_k - sum_l M_kl q_l, of coordinates that change uniformly: nobody has to be told."""
        if not self._steady:
            return []
        model, graph = self.model, self.graph
        moves = [
            model.time * p - graph.sum([(m * q, 1.0) for m, q in zip(row, model.q)])
            for p, row in zip(self.noether.energetics.momenta, self.states.matrix)
        ]
        return [one for one in moves if self.is_conserved(one)]

    def _tried(self) -> Iterator[tuple[Variables, list[Term]]]:
        """Sums of terms, short ones first."""
        model = self.model
        given = own_variables(model) if self._steady else variables_in_space(model)
        material = None if given is None else material_of(model, self.noether, given)
        if given is not None and material is not None and len(given.places) <= MOST_VARIABLES:
            for ansatz in self._polynomials(given, material):
                yield given, ansatz
        if not self._steady and not model.constraints and not any(one.body for one in model.particles):
            given, ansatz = separable(model, self.noether, self.states.matrix)
            if len(ansatz) <= MOST_COLUMNS:
                yield given, ansatz

    def _polynomials(self, given: Variables, material: Material) -> list[list[Term]]:
        if not given.flat:
            return [terms(given, material, *SURFACE)] if len(given.places) <= SPACE else []
        found = []
        for degree, most in PLACES_OF.items():
            most += degree == HIGHEST and len(given.places) == 2
            if degree in ODD if material.odd else degree > 1:
                found += [terms(given, material, degree, highest) for highest in range(most + 1)]
        mirrors = self._mirrors(given, material)
        parts = [part for one in found for part in sorted_by(one, mirrors)]
        return sorted((one for one in parts if len(one) <= MOST_COLUMNS), key=len)

    def _mirrors(self, given: Variables, material: Material) -> list[int]:
        """Coordinates whose sign may be changed without a change of L and the forces, together with those of
        their velocities and forces: conserved sums are even in these or odd."""
        model, graph = self.model, self.graph
        if given.speeds is not model.v:
            return []
        nodes = [self.noether.energetics.lagrangian, *material.functions]
        forces = self.noether.energetics.applied
        found = []
        for k, (q, v) in enumerate(zip(model.q, model.v)):
            mirrored = substituted(graph, [*nodes, *forces], {q: -q, v: -v})
            expected = [*nodes, *(-force if i == k else force for i, force in enumerate(forces))]
            if all(one is other for one, other in zip(mirrored, expected)):
                found.append(k)
        return found

    # ------------------------------------------------------------------ one ansatz

    def _solutions(self, given: Variables, ansatz: Sequence[Term]) -> Iterator[Integral]:
        if not given.flat:
            ansatz = self._independent(given, ansatz)
        columns = Columns(self, given, ansatz)
        for vector in sorted(columns.solutions(SMALL, {}), key=len):
            found = self._recognized(given, [ansatz[i] for i in vector])
            if found is not None:
                yield found

    def _independent(self, given: Variables, ansatz: Sequence[Term]) -> list[Term]:
        """Terms that are no sums of those before them where the constraints hold."""
        constant = Term((0,) * len(given.speeds), (0,) * len(given.places))
        columns = Columns(self, given, [constant, *ansatz])
        gone = {*columns.equations(SMALL, {}, columns.values).free}
        return [term for i, term in enumerate(columns.ansatz) if i not in gone][1:]

    def _recognized(self, given: Variables, ansatz: Sequence[Term]) -> Integral | None:
        """The sum with coefficients in terms of the parameters."""
        columns = Columns(self, given, ansatz)
        symbols = self._parameters(columns)
        values = {str(one.data): PRIMES[i] for i, one in enumerate(symbols[: len(PRIMES)])}
        solutions = columns.solutions(LARGE, values)
        if len(solutions) != 1 or len(symbols) > len(PRIMES):
            return None
        (vector,) = solutions
        factors = self._factors(symbols, values)
        known = {name: value for name, (value, _) in factors.items()}
        coefficients: list[tuple[Fraction, int, dict[str, int]]] = []
        for i in range(len(ansatz)):
            found = self._product_of(vector.get(i, 0), known)
            if found is None:
                return None
            coefficients.append(found)
        names = {name for _, _, powers in coefficients for name in powers}
        least = {name: min(powers.get(name, 0) for _, _, powers in coefficients) for name in names}
        whole = math.lcm(*(one.denominator for one, _, _ in coefficients))
        whole = whole if coefficients[-1][0] > 0 else -whole
        found, texts = [], []
        for one, (number, square, powers) in reversed([*zip(ansatz, coefficients)]):
            here = [(factors[name][1], powers.get(name, 0) - least[name]) for name in sorted(names)]
            factor = self.graph.product(here) * (float(whole * number) * math.sqrt(square))
            found.append((factor * columns.node(one), 1.0))
            texts.append(term_text(factor, name_of(one, given)).replace("*1/", "/"))
        return Integral(self.graph.sum(found), joined(texts), max(sum(one.speeds) for one in ansatz))

    def _product_of(
        self, value: int, factors: Mapping[str, int]
    ) -> tuple[Fraction, int, dict[str, int]] | None:
        """(x, n, exponents): a number is x*sqrt(n) times powers of factors."""
        for square in SQUARES:
            fraction = fraction_of(quotient(value, square_root(square, LARGE), LARGE), LARGE)
            above, up = factored(fraction.numerator * SMOOTH, factors)
            below, down = factored(fraction.denominator * SMOOTH, factors)
            number = Fraction(above, below)
            if 0 < max(abs(number.numerator), number.denominator) <= LARGEST:
                return number, square, {name: up.get(name, 0) - down.get(name, 0) for name in {**up, **down}}
        return None

    def _parameters(self, columns: Columns) -> list[Node]:
        """Those that accelerations depend on."""
        model = self.model
        moving = {*model.q, *model.v, model.time}
        below = reachable([*columns.nodes, *self.states.needed])
        return [one for one in below if one.kind is Kind.SYMBOL and one not in moving]

    def _factors(self, symbols: Sequence[Node], values: Mapping[str, int]) -> dict[str, tuple[int, Node]]:
        """What coefficients may be products of, with its value: parameters, and sums of two."""
        found = {str(one.data): (values[str(one.data)], one) for one in symbols}
        numbers = {**values, "": 1}
        for one, other in combinations([*symbols, self.graph.one], 2):
            a, b = (numbers["" if u is self.graph.one else str(u.data)] for u in (one, other))
            for k in FACTORS:
                for n in FACTORS:
                    if math.gcd(k, n) == 1:
                        for sign in (1, -1):
                            node = float(k) * one + float(sign * n) * other
                            found[f"{k}*{one.data} {sign * n}*{other.data}"] = k * a + sign * n * b, node
        return found

    # ------------------------------------------------------------------ proofs

    def is_conserved(self, node: Node) -> bool:
        """Whether its rate vanishes at random states."""
        rest, slopes = self.states.rate(node)
        p = LARGE
        found = [
            (state.values[rest] + sum(state.values[s] * a for s, a in zip(slopes, state.accelerations))) % p
            for state in islice(self.states.states(p, [rest, *slopes], {}), PROOFS)
        ]
        return len(found) == PROOFS and not any(found)

    def rank(self, nodes: Sequence[Node]) -> int | None:
        """How many of them are independent on the states that constraints allow."""
        graph, model = self.graph, self.model
        bound = [one.expression for one in model.constraints if one.holonomic]
        bound += self.noether.constraints.speeds
        rows = [[graph.diff(one, x) for x in (*model.q, *model.v)] for one in (*bound, *nodes)]
        state = next(self.states.states(SMALL, chain.from_iterable(rows), {}), None)
        if state is None:
            return None
        equations = Equations(2 * len(model.q), SMALL)
        return sum([equations.add([state.values[x] for x in row]) for row in rows]) - len(bound)


class Columns:
    """The terms of an ansatz and their rates of change at random states."""

    def __init__(self, integrals: PolynomialIntegrals, given: Variables, ansatz: Sequence[Term]) -> None:
        self.integrals, self.given, self.ansatz = integrals, given, ansatz
        noether, h = integrals.noether, integrals.noether.energy
        self.velocities = [noether.rate(x) for x in given.places]
        self.changes = [integrals.states.rate(u) for u in given.speeds]
        functions = dict.fromkeys(one for term in ansatz for one in term.functions)
        zero = integrals.graph.zero
        self.functions = {one: zero if one is h else noether.rate(one) for one in functions}
        self.nodes = [*given.places, *self.velocities, *given.speeds, *(rest for rest, _ in self.changes)]
        self.nodes += [slope for _, slopes in self.changes for slope in slopes]
        self.nodes += [*self.functions, *self.functions.values()]
        self.speed_powers = [*dict.fromkeys(term.speeds for term in ansatz)]
        self.place_powers = [*dict.fromkeys((term.places, term.functions) for term in ansatz)]

    def node(self, term: Term) -> Node:
        factors = [*zip(self.given.places, term.places), *zip(self.given.speeds, term.speeds)]
        return self.integrals.graph.product([*factors, *((one, 1) for one in term.functions)])

    def values(self, state: State, p: int) -> list[int]:
        """The terms at a state."""
        value = state.values
        x, v = [value[one] for one in self.given.places], [value[one] for one in self.given.speeds]
        moving = {one: monomial(v, one, p) for one in self.speed_powers}
        still = {}
        for places, functions in self.place_powers:
            result = monomial(x, places, p)
            for one in functions:
                result = result * value[one] % p
            still[places, functions] = result
        return [moving[term.speeds] * still[term.places, term.functions] % p for term in self.ansatz]

    def rates(self, state: State, p: int) -> list[int]:
        """Their rates of change."""
        value = state.values
        x, v = [value[one] for one in self.given.places], [value[one] for one in self.given.speeds]
        rates = [value[one] for one in self.velocities]
        a = [
            (value[rest] + sum(value[s] * w for s, w in zip(slopes, state.accelerations))) % p
            for rest, slopes in self.changes
        ]
        moving = {one: (monomial(v, one, p), derivative(v, a, one, p)) for one in self.speed_powers}
        still = {}
        for places, functions in self.place_powers:
            result, change = monomial(x, places, p), derivative(x, rates, places, p)
            for one in functions:
                change = (change * value[one] + result * value[self.functions[one]]) % p
                result = result * value[one] % p
            still[places, functions] = result, change
        found = []
        for term in self.ansatz:
            w, w_rate = moving[term.speeds]
            f, f_rate = still[term.places, term.functions]
            found.append((w * f_rate + w_rate * f) % p)
        return found

    def equations(self, prime: int, parameters: Mapping[str, int], row_of) -> Equations:
        count, work = len(self.ansatz), self.integrals.graph.work
        equations, idle = Equations(count, prime), 0
        for state in self.integrals.states.states(prime, self.nodes, parameters or self.fixed(prime)):
            work.charge(len(equations) * count // PRODUCTS)
            idle = 0 if equations.add(row_of(state, prime)) else idle + 1
            if idle == SPARE or len(equations) == count:
                break
        return equations

    def fixed(self, prime: int) -> dict[str, int]:
        """Random values of the parameters, the same at all states."""
        source = random.Random(1)
        symbols = self.integrals._parameters(self)
        return {str(one.data): source.randrange(1, prime) for one in symbols}

    def solutions(self, prime: int, parameters: Mapping[str, int]) -> list[dict[int, int]]:
        return self.equations(prime, parameters, self.rates).solutions()


def name_of(term: Term, given: Variables) -> str:
    """A term in the language of system files."""
    powers = [*zip(given.speed_names, term.speeds), *zip(given.names, term.places)]
    above = [name if n == 1 else f"{name}**{n}" for name, n in powers if n]
    texts = [given.words.get(one) or text_of(one) for one in term.functions]
    above += [text for text in texts if not text.startswith("1/")]
    return ("*".join(above) or "1") + "".join(text[1:] for text in texts if text.startswith("1/"))


def sorted_by(ansatz: Sequence[Term], mirrors: Sequence[int]) -> list[list[Term]]:
    """The terms that are even or odd in the same coordinates."""
    found: dict[Powers, list[Term]] = {}
    for term in ansatz:
        found.setdefault(tuple((term.speeds[k] + term.places[k]) % 2 for k in mirrors), []).append(term)
    return [*found.values()]


def monomial(x: Sequence[int], powers: Powers, p: int) -> int:
    result = 1
    for one, n in zip(x, powers):
        for _ in range(n):
            result = result * one % p
    return result


def derivative(x: Sequence[int], rates: Sequence[int], powers: Powers, p: int) -> int:
    """Of a monomial."""
    total = 0
    for k, n in enumerate(powers):
        if n:
            total += n * monomial(x, (*powers[:k], n - 1, *powers[k + 1 :]), p) * rates[k]
    return total % p
