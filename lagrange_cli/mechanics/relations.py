"""Linear relations between expressions, with constant coefficients: guessed from values at random arguments.

A relation has to be proven by whoever uses it.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import islice

from lagrange_cli.expression.evaluate import Reals, evaluate, evaluated, prepared
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable

NEGLIGIBLE = 1e-8
"""The remainder of a column after elimination, relative to its size, if it is a combination of others."""
LARGEST = 12
"""Numerators and denominators of coefficients are not larger."""
DECIMAL = 1000
"""Nor are those of coefficients that come from numbers in the file, such as 1.37."""
ROUNDING = 1e-12
"""A value that is smaller, relative to the terms of its sum, may be rounding alone."""
SPARE, TRIES = 3, 4
"""More equations than unknowns, and random arguments that are tried for each that has values."""
SCALE = 1.7
"""A parameter is multiplied with this, to see what power of it a coefficient is proportional to."""
ENOUGH = 8
"""The least number of random arguments; the last few of them must have brought nothing new."""
MOST_SUMS = 8
"""Sums of parameters that are tried as factors."""
NEARER, CLOSE = 0.6, 0.05
"""Random arguments are taken nearer to 0 after those at which something has no value, down to this part."""
STATES = 2
"""Random states at which a combination is looked at that has numbers of its own at each."""
VALUES_EACH, PRODUCTS = 2, 16
"""Steps of work of the value of a node; and how many products are one."""

Column = Sequence[Node]
"""Expressions that belong to one unknown, one for each condition."""


class Relations:
    """Relations between functions of the ``symbols``; all others are parameters, on which coefficients may
    depend."""

    def __init__(self, graph: Graph, symbols: Iterable[Node] | None = None) -> None:
        self.graph = graph
        self.variables = None if symbols is None else {str(one.data) for one in symbols}

    def combination(self, columns: Sequence[Column], target: Column) -> list[float] | None:
        """Rational numbers with sum_i number_i * columns_i = target."""
        found = self._dependent([*columns, target], {})
        vector = found.get(len(columns))
        if vector is None:
            return None
        numbers = [rational(-vector.get(i, 0.0)) for i in range(len(columns))]
        return None if None in numbers else [float(one) for one in numbers if one is not None]

    def may_combine(self, columns: Sequence[Column], target: Column) -> bool:
        """Whether ``target`` is a combination of ``columns`` at one random state, with whatever numbers; True
        where none is found that has values."""
        given = [*columns, target]
        for rows in self._states(given, {}):
            self.graph.work.charge(len(rows) * len(given) ** 2 // PRODUCTS)
            return len(columns) in dependent(rows, len(given))
        return True

    def parts(self, columns: Sequence[Column], target: Column) -> list[int] | None:
        """The columns, by number, of which ``target`` consists at random states, each with its own numbers;
        None where it does not. All of them where there are no states at which they have values."""
        given, found, states = [*columns, target], set[int](), 0
        for rows in islice(self._states(given, {}), STATES):
            self.graph.work.charge(len(rows) * len(given) ** 2 // PRODUCTS)
            relation = dependent(rows, len(given)).get(len(columns))
            if relation is None:
                return None
            found, states = found | relation.keys(), states + 1
        return sorted(found - {len(columns)}) if states else [*range(len(columns))]

    def relations(self, columns: Sequence[Column]) -> list[dict[int, Node]]:
        """Vectors c with sum_i c_i columns_i = 0, by the number i; each is rational, or monomials of
        parameters, perhaps times a sum of these."""
        base = self._dependent(columns, {})
        found: list[dict[int, Node]] = []
        changed: dict[str, dict[int, dict[int, float]]] = {}
        for last, vector in base.items():
            numbers = {i: rational(value) for i, value in vector.items()}
            made = None
            if None in numbers.values():
                made = self.solved(columns, vector, self._monomials(columns, last, vector, changed))
                numbers = {i: rational(value, 1e-10, DECIMAL) for i, value in vector.items()}
            if made is None and None not in numbers.values():
                exact = {i: one for i, one in numbers.items() if one is not None}
                whole = math.lcm(*(one.denominator for one in exact.values()))  # no quotient is rounded
                made = {i: self.graph.constant(float(whole * one)) for i, one in exact.items()}
            if made is not None:
                found.append(made)
        return found

    def _monomials(
        self,
        columns: Sequence[Column],
        last: int,
        vector: Mapping[int, float],
        changed: dict[str, dict[int, dict[int, float]]],
    ) -> dict[int, Node]:
        """The coefficients that are rational numbers, perhaps with pi, times powers of parameters, and at
        most one sum of parameters."""
        names = {
            str(one.data): one
            for one in reachable([node for column in columns for node in column])
            if one.kind is Kind.SYMBOL and one.data not in (self.variables or set())
        }
        for name in names:
            if name not in changed:
                changed[name] = self._dependent(columns, {name: SCALE})
        sums = [(self.graph.one, 1), *((one, n) for one in self._sums(columns, names) for n in (1, -1))]
        scalings = [{}, *({name: SCALE} for name in names)]
        sizes = [
            evaluate([one for one, _ in sums], self._parameters(names, scaled))[0] for scaled in scalings
        ]
        sums = [(one, n) for one, n in sums if all(size[one] for size in sizes)]  # R - R is 0
        made: dict[int, Node] = {}
        for i, value in vector.items():
            others = [changed[name].get(last, {}).get(i) for name in names]
            for one, n in sums if None not in others else ():
                each = [x / size[one] ** n for x, size in zip((value, *others), sizes) if x is not None]
                monomial = self._monomial(names, each)
                if monomial is not None:
                    made[i] = monomial * self.graph.product([(one, n)])
                    break
        return made

    def solved(
        self, columns: Sequence[Column], vector: Iterable[int], known: Mapping[int, Node]
    ) -> dict[int, Node] | None:
        """The coefficients of the only relation between the columns in ``vector``. Some are ``known``, and
        others may be any functions of parameters."""
        vector = sorted(vector)
        if known.keys() == {*vector}:
            return {**known}
        own = [columns[i] for i in vector]
        below = reachable([node for column in own for node in column])
        symbols = [one for one in below if one.kind is Kind.SYMBOL]
        names = [str(one.data) for one in symbols if self.variables and one.data not in self.variables]
        if not names:
            return None
        variables = [one for one in symbols if one.data not in names]
        given = {n: known[i] for n, i in enumerate(vector) if i in known}
        given = given if len(given) > 1 else {}
        basis = Basis([1.0] * (len(own) - len(given)))
        from lagrange_cli.mechanics.coefficients import coefficients  # where they are no monomials
        from lagrange_cli.mechanics.laurent import primitive

        found = coefficients(self.graph, own, variables, self._parameters(names, {}), given, basis.extend)
        return None if found is None else dict(zip(vector, primitive(self.graph, found)))

    def _sums(self, columns: Sequence[Column], names: Mapping[str, Node]) -> list[Node]:
        """Sums of parameters alone, such as R - r, that a coefficient may contain as a factor."""
        constant = sum(one.symbols for one in names.values())
        below = reachable([node for column in columns for node in column])
        found = [one for one in below if one.kind is Kind.SUM and not one.symbols & ~constant]
        return [one for one in found if len(one.arguments) > 1 or one.data[0]][:MOST_SUMS]

    def _monomial(self, names: Mapping[str, Node], values: Sequence[float]) -> Node | None:
        """A rational number, perhaps with pi, times powers of parameters: from its value, and those where one
        parameter after the other is scaled."""
        value, *others = values
        graph, node, rest = self.graph, self.graph.one, value
        plain = self._parameters(names, {})
        for other, (name, symbol) in zip(others, names.items()):
            if other / value <= 0:
                return None
            power = rational(2 * math.log(other / value) / math.log(SCALE), 1e-5)
            if power is None or power.denominator != 1:
                return None
            exponent = int(power) // 2 if int(power) % 2 == 0 else float(power) / 2
            node, rest = node * graph.product([(symbol, exponent)]), rest / plain[name] ** float(exponent)
        factor = rational(rest)
        if factor is None:
            factor = rational(rest * math.pi)
            if factor is None:
                return None
            node = node / math.pi
        above, below = (graph.constant(float(x)) for x in (factor.numerator, factor.denominator))
        return node * above / below

    def _parameters(self, names: Iterable[str], scaled: Mapping[str, float]) -> dict[str, float]:
        """Values of parameters, the same at every call."""
        values = {}
        for name in names:
            value = random.Random(name).uniform(0.6, 1.6)
            values[name] = value * scaled.get(name, 1.0)
        return values

    def _dependent(
        self, columns: Sequence[Column], scaled: Mapping[str, float]
    ) -> dict[int, dict[int, float]]:
        """The relation of each column that is a combination of those before it, its own coefficient 1."""
        count, basis, kept = len(columns), Basis([]), list[list[float]]()
        states = idle = 0
        for rows in self._states(columns, scaled):
            if states == 0:
                basis = Basis([max(abs(row[j]) for row in rows) or 1.0 for j in range(count)])
            new = [row for row in rows if basis.extend(row)]
            self.graph.work.charge(len(rows) * len(basis) * count // PRODUCTS)
            kept += new
            states, idle = states + 1, 0 if new else idle + 1
            if len(basis) == count or states == count + SPARE or (idle >= SPARE and states >= ENOUGH):
                return dependent(kept or [[0.0] * count], count)
        return {}

    def rows(self, columns: Sequence[Column], scaled: Mapping[str, float]) -> list[list[float]]:
        """Values of the columns at random arguments, an equation for each condition."""
        states = len(columns) + SPARE
        found = list(islice(self._states(columns, scaled), states))
        return [row for rows in found for row in rows] if len(found) == states else []

    def _states(self, columns: Sequence[Column], scaled: Mapping[str, float]) -> Iterator[list[list[float]]]:
        """The same, the equations of one random state after another, of as many as may be needed."""
        nodes = [node for column in columns for node in column]
        conditions = len(columns[0]) if columns else 0
        below = reachable(nodes)
        symbols = [str(one.data) for one in below if one.kind is Kind.SYMBOL]
        variables = symbols if self.variables is None else [one for one in symbols if one in self.variables]
        fixed = self._parameters((one for one in symbols if one not in variables), scaled)
        source, reach = random.Random(len(columns)), 1.0
        reals = Reals()
        steps = prepared(nodes, reals)
        for _ in range(TRIES * (len(columns) + SPARE) if conditions else 0):
            self.graph.work.charge(VALUES_EACH * len(below))
            drawn = {name: reach * source.choice((-1, 1)) * source.uniform(0.3, 1.4) for name in variables}
            value, size = evaluated(steps, {**fixed, **drawn}, reals)
            known = {one: 0.0 if abs(value[one]) <= ROUNDING * size[one] else value[one] for one in nodes}
            here = [[float(known[column[i]]) for column in columns] for i in range(conditions)]
            if all(math.isfinite(x) for row in here for x in row):
                yield here
            else:  # nearer to 0, as velocities below that of light
                reach = NEARER * reach if reach > CLOSE else 1.0


class Basis:
    """Rows of numbers that are no combinations of each other; the numbers of each column have a size."""

    def __init__(self, sizes: Sequence[float]) -> None:
        self._sizes = sizes
        self._rows: list[tuple[int, list[float]]] = []

    def __len__(self) -> int:
        return len(self._rows)

    def extend(self, row: Sequence[float]) -> bool:
        """Add a row, unless it is a combination of those that are there; whether it is new."""
        rest = [x / size for x, size in zip(row, self._sizes)]
        scale = max(map(abs, rest), default=0.0)
        if len(self) == len(self._sizes) or scale == 0.0:
            return False
        rest = [x / scale for x in rest]
        for column, other in self._rows:
            factor = rest[column]
            if factor != 0.0:
                rest = [x - factor * y for x, y in zip(rest, other)]
        pivot = max(range(len(rest)), key=lambda j: abs(rest[j]))
        lead = rest[pivot]
        if abs(lead) < NEGLIGIBLE:
            return False
        self._rows.append((pivot, [x / lead for x in rest]))
        return True


def dependent(rows: Sequence[Sequence[float]], count: int) -> dict[int, dict[int, float]]:
    """The relation of each of ``count`` columns that is a combination of those before it, by its number; its
    own coefficient is 1. Nothing where there are no rows."""
    if not rows:
        return {}
    scales = [max(abs(row[j]) for row in rows) or 1.0 for j in range(count)]
    matrix = [[x / scale for x, scale in zip(row, scales)] for row in rows if any(row)]
    pivots: list[int] = []
    found: dict[int, dict[int, float]] = {}
    for j in range(count):
        done = len(pivots)
        best = max(range(done, len(matrix)), key=lambda i: abs(matrix[i][j]), default=None)
        if best is None or abs(matrix[best][j]) < NEGLIGIBLE:
            relation = {p: -matrix[i][j] * scales[j] / scales[p] for i, p in enumerate(pivots)}
            sizes = {p: abs(matrix[i][j]) for i, p in enumerate(pivots)}
            found[j] = {p: x for p, x in relation.items() if sizes[p] > NEGLIGIBLE} | {j: 1.0}
            continue
        matrix[done], matrix[best] = matrix[best], matrix[done]
        lead = matrix[done][j]
        matrix[done] = [x / lead for x in matrix[done]]
        for i, row in enumerate(matrix):
            if i != done and row[j] != 0:
                matrix[i] = [x - row[j] * y for x, y in zip(row, matrix[done])]
        pivots.append(j)
    return found


def rational(value: float, accuracy: float = 1e-7, largest: int = LARGEST) -> Fraction | None:
    """The simple fraction that a number is, if it is one."""
    if not math.isfinite(value):
        return None
    near = Fraction(value).limit_denominator(largest)
    if abs(near.numerator) > largest * near.denominator or abs(float(near) - value) > accuracy:
        return None
    return near if near or abs(value) < accuracy else None
