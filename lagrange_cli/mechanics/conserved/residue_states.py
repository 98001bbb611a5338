"""Random states of a system modulo a prime, with their accelerations, without rounding."""

from __future__ import annotations

import random
from collections.abc import Generator, Iterable, Mapping, Sequence
from functools import cached_property
from itertools import chain, islice

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.modular import solved
from lagrange_cli.expression.node import Kind, Node, reachable, union
from lagrange_cli.expression.residues import LARGE, NoValue, Residues, Step, effort
from lagrange_cli.mechanics.conserved.noether import Noether
from lagrange_cli.mechanics.substitution import root_of, substituted
from lagrange_cli.mechanics.variables import OfModel, variables
from lagrange_cli.records import dataclass

TRIES = 40
"""Random states that are tried for each one with values: half of all numbers have a square root."""
PROOFS = 3
"""States at which the rate of change of what is conserved must vanish."""


@dataclass(frozen=True)
class State:
    """Values of nodes, and the accelerations of the coordinates."""

    values: Mapping[Node, int]
    accelerations: Sequence[int]


@dataclass(frozen=True)
class States(OfModel):
    """The states of a ``model``, on which its constraints hold."""

    noether: Noether

    @cached_property
    def forces(self) -> Sequence[Node]:
        """The mass matrix times the accelerations, without forces of constraint."""
        energetics = self.noether.energetics
        return [
            energetics.lagrangian_rate(q) + force - self.noether.rate(p)
            for q, force, p in zip(self.model.q, energetics.applied, energetics.momenta)
        ]

    @cached_property
    def _turning(self) -> Sequence[Node]:
        """The second derivatives of the constraints, without accelerations."""
        return [self.noether.rate(speed) for speed in self.noether.constraints.speeds]

    @cached_property
    def eliminated(self) -> Mapping[Node, Node] | None:
        """Coordinates and velocities in terms of others; None if constraints cannot be solved in this way."""
        graph, model, known = self.graph, self.model, dict[Node, Node]()
        constraints = self.noether.constraints
        for one, slopes, speed in zip(model.constraints, constraints.slopes, constraints.speeds):
            here, there = substituted(graph, [one.expression, speed], known)
            k = min((k for k in slopes if model.v[k] not in known), default=None, key=lambda k: -k)
            if k is None:
                return None
            q, v = model.q[k], model.v[k]
            if one.holonomic:
                root = root_of(graph, here, q)
                if root is None:
                    return None
                known = {**with_values(graph, known, {q: root}), q: root}
                (there,) = substituted(graph, [there], {q: root})
            slope = graph.diff(there, v)
            if slope.is_zero:
                return None
            (rest,) = substituted(graph, [there], {v: graph.zero})
            known = {**with_values(graph, known, {v: -(rest / slope)}), v: -(rest / slope)}
        return known

    @cached_property
    def needed(self) -> Sequence[Node]:
        """The nodes from which accelerations are computed."""
        slopes = [slope for row in self.noether.constraints.slopes for slope in row.values()]
        return [*chain.from_iterable(self.noether.matrix), *self.forces, *self._turning, *slopes]

    def rate(self, node: Node) -> tuple[Node, list[Node]]:
        """df/dt of a function of the state: a part without accelerations, and the factors of these."""
        return self.noether.rate(node), [self.graph.diff(node, v) for v in self.model.v]

    def conserves(self, node: Node) -> bool:
        """Whether a function of the state is constant along every motion: its rate vanishes at random states,
        modulo a large prime."""
        rest, slopes = self.rate(node)
        count = 0
        for state in islice(self.random(LARGE, [rest, *slopes]), PROOFS):
            rate = state.values[rest] + sum(state.values[s] * a for s, a in zip(slopes, state.accelerations))
            if rate % LARGE:
                return False
            count += 1
        return count == PROOFS

    def random(
        self,
        prime: int,
        nodes: Iterable[Node],
        parameters: Mapping[str, int] | None = None,
        *,
        accelerated: bool = True,
    ) -> Generator[State, bool | None, None]:
        """Random ones with values of ``nodes``; parameters are random, too, but for given ones. Functions of
        these have the same values in all states. If True is sent, only the velocities of the next state are
        others. Without ``accelerated`` there are no accelerations."""
        graph, known, free = self.graph, self.eliminated, union(self.model.v)
        if known is None:
            return
        first, inside = reachable(known.values()), reachable([*nodes, *(self.needed if accelerated else ())])
        names = dict.fromkeys(one.data for one in (*first, *inside) if one.kind is Kind.SYMBOL)
        speeds = [one.data for one in self.model.v if one.data in names]
        source, fails = random.Random(len(inside)), 0
        fixed, moving = Residues(prime, source), variables(self.model)
        try:
            before, within = fixed.prepared(first), fixed.prepared(inside)
            if parameters:
                constant = [one for one in (*before, *within) if not one[0].symbols & moving]
                fixed.evaluated(constant, {**dict.fromkeys(names, 1), **parameters})
        except NoValue:
            return
        placed, here = ([one for one in steps if not one[0].symbols & free] for steps in (before, within))
        pushed, there = ([one for one in steps if one[0].symbols & free] for steps in (before, within))
        work_here, work_there = (effort([one[0] for one in steps], prime) for steps in (here, there))
        while fails < TRIES:
            graph.work.charge(work_here)
            residues, stay = fixed.again(), True
            given = {**{name: residues.random() for name in names}, **(parameters or {})}
            try:
                place, values = self._at(residues, (placed, here), given, {}, {})
                while stay:
                    graph.work.charge(work_there)
                    again = residues.again()
                    given |= {name: again.random() for name in speeds}
                    _, every = self._at(again, (pushed, there), given, place, values)
                    accelerations = self._accelerations(every, prime) if accelerated else ()
                    if accelerations is None:
                        return
                    stay = bool((yield State(every, accelerations)) and there)
                    fails = 0
            except NoValue:
                fails += 1

    def _at(
        self,
        residues: Residues,
        steps: tuple[Sequence[Step], Sequence[Step]],
        given: dict[str, int],
        place: Mapping[Node, int],
        values: Mapping[Node, int],
    ) -> tuple[Mapping[Node, int], Mapping[Node, int]]:
        """The values of further nodes, first those that the eliminated ones are expressed by, in addition to
        known ones; in ``given`` those of the eliminated ones are set."""
        solution = residues.evaluated(steps[0], given, place)
        given |= {
            str(one.data): solution[node] for one, node in (self.eliminated or {}).items() if node in solution
        }
        return solution, residues.evaluated(steps[1], given, values)

    def _accelerations(self, values: Mapping[Node, int], prime: int) -> list[int] | None:
        n, rows = len(self.model.q), self.noether.constraints.slopes
        matrix = [[values[m] for m in row] + [0] * len(rows) for row in self.noether.matrix]
        for i, slopes in enumerate(rows):
            for k, slope in slopes.items():
                matrix[k][n + i] = -values[slope]
            matrix.append([values[slopes[k]] if k in slopes else 0 for k in range(n)] + [0] * len(rows))
        right = [values[force] for force in self.forces] + [-values[one] for one in self._turning]
        found = solved(matrix, right, prime)
        return None if found is None else found[:n]


def with_values(graph: Graph, known: Mapping[Node, Node], values: Mapping[Node, Node]) -> dict[Node, Node]:
    """The known nodes in terms of ``values``."""
    return dict(zip(known, substituted(graph, known.values(), values)))
