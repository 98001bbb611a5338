"""The contribution of constraints to the equations of motion: forces, power, and further equations.

With f_i(q, t) = 0 and g_j(q, q_dot, t) = 0, linear in the velocities, Lagrange's equations become

    d/dt dL/dq_dot_k - dL/dq_k = Q_k + sum_i lambda_i df_i/dq_k + sum_j lambda_j dg_j/dq_dot_k

(Goldstein, 3rd ed., sec. 2.4, with d'Alembert's principle for the g_j). Along the motion

    sum_k a_ik q_dot_k + b_i = 0

with a_ik = df_i/dq_k and b_i = df_i/dt, or a_jk = dg_j/dq_dot_k and b_j the rest of g_j. So the power of the
forces of constraint is -sum_i lambda_i b_i. The equations for the multipliers are d2f_i/dt2 = 0 and dg_j/dt =
0; they stay time derivatives, which the Taylor series take as they are (N. S. Nedialkov and J. D. Pryce, BIT
45, 2005).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

from lagrange_cli.errors import NotLinear
from lagrange_cli.expression.node import Node, bits
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.rows import Matrix, Row
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import OfModel, contract, nonzero, numbered, rate, variables
from lagrange_cli.model.model import Constraint
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Constraints(OfModel):
    """The constraints of a model: sum_k ``slopes[i][k]`` q_dot_k + ``drifts[i]`` = 0."""

    @cached_property
    def _places(self) -> Mapping[Node, int]:
        return numbered(self.model.q)

    @cached_property
    def _rates(self) -> Mapping[Node, int]:
        return numbered(self.model.v)

    @cached_property
    def multipliers(self) -> tuple[Node, ...]:
        """The symbols of lambda."""
        return tuple(one.multiplier for one in self.model.constraints)

    @cached_property
    def slopes(self) -> tuple[Mapping[int, Node], ...]:
        """a_ik by the index k of the coordinate, as far as they are not 0.

        Raises ``NotLinear`` where a constraint is not linear in the velocities.
        """
        return tuple(map(self._slopes, self.model.constraints))

    def _slopes(self, one: Constraint[Node]) -> Mapping[int, Node]:
        graph, model = self.graph, self.model
        if one.holonomic:
            return graph.gradient(one.expression, self._places)
        slopes = graph.gradient(one.expression, self._rates)
        for k, slope in slopes.items():
            curving = [*graph.gradient(slope, self._rates).values()]
            if not all(map(is_zero, curving)):
                raise NotLinear(one.name)
            if curving:
                (slopes[k],) = substituted(graph, [slope], dict.fromkeys(model.v, graph.zero))
        return slopes

    @cached_property
    def drifts(self) -> tuple[Node, ...]:
        """b_i: the rate of a constraint at rest."""
        graph, model = self.graph, self.model
        at_rest = dict.fromkeys(model.v, graph.zero)
        return tuple(
            graph.diff(one.expression, model.time)
            if one.holonomic
            else substituted(graph, [one.expression], at_rest)[0]
            for one in model.constraints
        )

    @cached_property
    def speeds(self) -> tuple[Node, ...]:
        """df_i/dt along the motion, or g_j: the conditions on velocities, which must be 0."""
        graph, model = self.graph, self.model
        return tuple(
            graph.sum([(drift, 1.0), *((slope * model.v[k], 1.0) for k, slope in slopes.items())])
            for slopes, drift in zip(self.slopes, self.drifts)
        )

    @cached_property
    def forces(self) -> tuple[Node, ...]:
        """sum_i lambda_i a_ik, for each coordinate."""
        return self._forces([one.multiplier for one in self.model.constraints])

    @cached_property
    def acting(self) -> tuple[Node, ...]:
        """The same without multipliers that are 0."""
        multipliers = [self.graph.zero if one.of else one.multiplier for one in self.model.constraints]
        return self._forces(multipliers)

    def _forces(self, multipliers: Sequence[Node]) -> tuple[Node, ...]:
        graph, moving = self.graph, variables(self.model)
        terms: list[list[tuple[Node, Node]]] = [[] for _ in self.model.q]
        for multiplier, slopes in zip(multipliers, self.slopes):
            for k, slope in slopes.items() if not multiplier.is_zero else ():
                terms[k].append((slope, multiplier))
        return tuple(contract(graph, some, moving) for some in terms)

    @property
    def power(self) -> Node:
        """-sum_i lambda_i b_i: the power of the forces of constraint."""
        pairs = zip(self.model.constraints, self.drifts)
        return self.graph.sum([(one.multiplier * drift, -1.0) for one, drift in pairs if not one.of])

    @property
    def equations(self) -> tuple[Node, ...]:
        """-d2f_i/dt2 and -dg_j/dt, which have to be 0; with this sign the matrix is symmetric."""
        return tuple(map(self._equation, self.model.constraints))

    def _equation(self, one: Constraint[Node]) -> Node:
        graph, moving = self.graph, self._moving
        changing = rate(graph, one.expression, moving)
        return -(rate(graph, changing, moving) if one.holonomic else changing)

    def transport(
        self, multipliers: tuple[Node, ...], moves: tuple[Node, ...], momenta: Sequence[Node]
    ) -> tuple[Node, ...]:
        """M dv, one for each coordinate, where coordinates are moved to the constraints by dq = M^-1 A^T mu.

        It makes the move canonical: generated by sum_i mu_i df_i/dt, it changes p_k by the derivative of that
        by q_k at fixed p, with the other sign. Then the energy that was gained as f drifted off is given
        back, and h does not drift. With M dv = dp - sum_j dp/dq_j dq_j that is

            M dv_k = -sum_i mu_i da_ik/dt + sum_j dq_j (dp_j/dq_k - dp_k/dq_j).

        ``multipliers`` mu and ``moves`` dq are symbols, and ``momenta`` p_k functions of the state.
        """
        graph, model = self.graph, self.model
        terms: list[list[tuple[Node, float]]] = [[] for _ in model.q]
        rates = [*zip(model.q, model.v), (model.time, graph.one)]
        places = {symbol.symbols: place for place, (symbol, _) in enumerate(rates)}
        for one, multiplier, slopes in zip(model.constraints, multipliers, self.slopes):
            for k, slope in slopes.items() if one.holonomic else ():
                there = (places.get(1 << bit) for bit in bits(slope.symbols))
                for symbol, speed in (rates[place] for place in sorted(p for p in there if p is not None)):
                    terms[k].append((multiplier * graph.diff(slope, symbol) * speed, -1.0))
        for j, (momentum, move) in enumerate(zip(momenta, moves)):
            for k, slope in graph.gradient(momentum, self._places).items():
                if k != j:
                    terms[k].append((move * slope, 1.0))
                    terms[j].append((moves[k] * slope, -1.0))
        return tuple(map(graph.sum, terms))

    def bordered(self, matrix: Matrix, applied: Sequence[Node]) -> Matrix:
        """The matrix of the equations with multipliers, [[M, -A^T - dQ/dlambda], [-A, 0]], from the
        mass matrix M and the ``applied`` forces Q (empty where these contain no multipliers)."""
        graph, size = self.graph, len(self.model.q)
        if not self.slopes:
            return matrix
        upper: list[dict[int, Node]] = [
            {k: row[k] for k in nonzero(row, graph.zero, j)} for j, row in enumerate(matrix)
        ]
        lower: list[dict[int, Node]] = [{k: -slopes[k] for k in sorted(slopes)} for slopes in self.slopes]
        for i, row in enumerate(lower):
            for k, entry in row.items():
                upper[k][size + i] = entry
        multipliers = numbered(self.multipliers)
        for row, force in zip(upper, applied):
            for i, push in graph.gradient(force, multipliers).items():
                row[size + i] = row.get(size + i, graph.zero) - push
        return tuple(Row(row, size + len(lower), graph.zero) for row in (*upper, *lower))
