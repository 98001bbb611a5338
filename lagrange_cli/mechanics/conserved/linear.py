"""Integrals of linear systems, M a + G v + K q = f with constant coefficients: the energies of derivatives.

The rate of change of a motion is a motion without f, and so are all further derivatives y_j of the motion. So
y_j' M y_j + y_(j-1)' K y_(j-1) is conserved: the energy of a normal mode, times a power of the square of its
frequency, summed over the modes. The modes' own energies follow from these.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from itertools import combinations_with_replacement

from lagrange_cli.expression.node import Node
from lagrange_cli.expression.text import joined
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conservation import Conserved
from lagrange_cli.mechanics.conserved.found import Found
from lagrange_cli.mechanics.conserved.reasons import term
from lagrange_cli.mechanics.conserved.residue_states import States
from lagrange_cli.mechanics.matrices import determinant
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import state_symbols, variables

LONGEST_INTEGRAL = 600
"""Characters of its formula."""

Row = Sequence[Node]
"""A linear function of the state: the coefficients of the coordinates, the velocities, and 1."""


def of_derivatives(found: Found) -> None:
    """The energies of derivatives of the motion that do not follow from what is known."""
    model = found.model
    if not all(map(is_zero, found.noether.energetics.applied)):
        return
    states = States(model, found.noether)
    system = LinearSystem(found, states)
    if not system.possible or any(f.symbols & variables(model) for f in system.constant):
        return
    for order, node, text in system.energies():
        if found.is_independent(node) and states.conserves(node):
            number = sum(name.startswith("I_") for name in found.names) + 1
            place = "the rate of change" if order == 1 else f"the derivative of order {order}"
            because = f"the system is linear: {place} of a motion is also one, without constant forces; "
            because += "this is twice its energy"
            found.store(Conserved(found.free_name(f"I_{number}"), text, because), node)


class LinearSystem:
    """M a + G v + K q = f."""

    def __init__(self, found: Found, states: States) -> None:
        self.graph, self.model, self.count = found.graph, found.model, len(found.model.q)
        graph, self.masses = found.graph, found.noether.matrix
        self.forces = states.forces
        self.springs = [[-graph.diff(force, q) for q in self.model.q] for force in self.forces]
        self.turning = [[-graph.diff(force, v) for v in self.model.v] for force in self.forces]

    @property
    def possible(self) -> bool:
        """Whether the coefficients are constants; those of M are, and f may depend on t."""
        moving, free = variables(self.model), state_symbols(self.model) & ~self.model.time.symbols
        every = [one for part in (self.springs, self.turning) for row in part for one in row]
        return not any(one.symbols & moving for one in every) and not any(
            f.symbols & free for f in self.constant
        )

    @property
    def matrices(self) -> tuple[Sequence[Row], Sequence[Row], Sequence[Row]]:
        """M, G, K."""
        return self.masses, self.turning, self.springs

    @property
    def coupled(self) -> list[list[int]]:
        """The coordinates that act on each other, in pairs."""
        pairs = [(i, j) for i in range(self.count) for j in range(self.count)]
        return [[i, j] for i, j in pairs if any(not is_zero(rows[i][j]) for rows in self.matrices)]

    @property
    def constant(self) -> Row:
        """f."""
        still = dict.fromkeys((*self.model.q, *self.model.v), self.graph.zero)
        return substituted(self.graph, self.forces, still)

    def energies(self) -> Iterator[tuple[int, Node, str]]:
        """Twice the energy of each derivative, by its order, as an expression and as a formula."""
        graph, n = self.graph, self.count
        unit: Sequence[Row] = [
            [graph.one if i == j else graph.zero for j in range(2 * n + 1)] for i in range(2 * n)
        ]
        places, speeds = unit[:n], unit[n:]
        pushed = [[*(graph.zero,) * (2 * n), f] for f in self.constant]
        for order in range(1, n):
            rates = self._accelerations(places, speeds, pushed)
            places, speeds, pushed = speeds, rates, [[graph.zero] * (2 * n + 1)] * n
            node, text = self._energy(places, speeds)
            if text:
                yield order, node, text

    def _accelerations(
        self, places: Sequence[Row], speeds: Sequence[Row], pushed: Sequence[Row]
    ) -> list[Row]:
        """a of M a = f - K q - G v."""
        graph, n = self.graph, self.count
        pulls = [(self.springs, places), (self.turning, speeds)]
        right = [
            [
                graph.sum(
                    [(pushed[i][c], 1.0)]
                    + [(matrix[i][j] * rows[j][c], -1.0) for matrix, rows in pulls for j in range(n)]
                )
                for c in range(2 * n + 1)
            ]
            for i in range(n)
        ]
        return [
            [graph.sum([(m * right[i][c], 1.0) for i, m in enumerate(row)]) for c in range(2 * n + 1)]
            for row in self._inverse
        ]

    @cached_property
    def _inverse(self) -> list[Row]:
        """That of M, by Cramer's rule."""
        graph, masses, n = self.graph, self.masses, self.count
        whole, found = determinant(graph, masses), list[Row]()
        for k in range(n):
            below = [[*row[:k], *row[k + 1 :]] for row in masses]
            minors = [determinant(graph, [*below[:i], *below[i + 1 :]]) for i in range(n)]
            found.append([(-1.0) ** (i + k) * minor / whole for i, minor in enumerate(minors)])
        return found

    def _energy(self, places: Sequence[Row], speeds: Sequence[Row]) -> tuple[Node, str]:
        """v' M v + q' K q, without a constant; an empty formula stands for 0."""
        graph, n = self.graph, self.count
        names = [*self.model.coordinates, *map(velocity_name, self.model.coordinates), ""]
        symbols = [*self.model.q, *self.model.v, graph.one]
        terms, texts = list[tuple[Node, float]](), list[str]()
        for a, b in combinations_with_replacement(reversed(range(2 * n + 1)), 2):
            parts = [
                (matrix[i][j] * rows[i][a] * rows[j][b], 1.0 if a == b else 2.0)
                for matrix, rows in ((self.masses, speeds), (self.springs, places))
                for i in range(n)
                for j in range(n)
            ]
            factor = graph.sum(parts)
            if (a == b == 2 * n) or is_zero(factor):
                continue
            terms.append((factor * symbols[a] * symbols[b], 1.0))
            name = f"{names[a]}**2" if a == b else "*".join(x for x in (names[b], names[a]) if x)
            texts.append(term(factor, name))
        text = joined(texts) if texts else ""
        return graph.sum(terms), text if len(text) <= LONGEST_INTEGRAL else "a long sum"
