"""Noether's theorem: the quantity conserved if a change of coordinates and time leaves the equations
unchanged.

With q_k -> q_k + e xi_k(q, t) and t -> t + e tau(t),

    d/dt (sum_k xi_k p_k - tau h) = sum_k [xi_k (dL/dq_k + Q_k) + xi_dot_k p_k] - tau_dot h - tau h_dot,

from Lagrange's equations with all forces Q outside L (E. Noether, Goett. Nachr. 1918, 235; D. S. Djukic and
B. D. Vujanovic, Acta Mech. 23, 1975, 17, for forces). Where the right side is dF/dt for some F(q, t), the
*current* sum xi_k p_k - tau h - F is conserved. Forces of constraint drop out where the change is compatible
with the constraints: sum_k xi_k a_ik = 0, for nonholonomic ones as well (d'Alembert).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.zero import branching, deciding, is_zero, zeros
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.relations import Relations
from lagrange_cli.mechanics.variables import OfModel, numbered, state_symbols, variables
from lagrange_cli.records import dataclass, field

if TYPE_CHECKING:
    from lagrange_cli.mechanics.conserved.allowed_states import AllowedStates


@dataclass(frozen=True)
class Change:
    """A change of the coordinates by xi_k(q, t), ``directions`` by k, and of the time by tau(t), ``time``.

    ``gain`` is F(q, t), by whose rate it changes L. None of them stands for 0.
    """

    directions: Mapping[int, Node] = field(default_factory=dict)
    time: Node | None = None
    gain: Node | None = None


Parts = Sequence[tuple[Node, Change]]
"""Changes, each times a function of q and t."""


@dataclass(frozen=True)
class Noether(OfModel):
    """The currents of a model and their rates of change."""

    @cached_property
    def energetics(self) -> Energetics:
        """Its energies, momenta and forces."""
        return Energetics(self.model)

    @cached_property
    def torques(self) -> list[Node]:
        """dL/dq_k and applied forces."""
        rates = map(self.energetics.lagrangian_rate, self.model.q)
        return [rate + force for rate, force in zip(rates, self.energetics.applied)]

    @cached_property
    def matrix(self) -> Sequence[Sequence[Node]]:
        """The mass matrix dp_k/dv_l."""
        return [[self.graph.diff(p, v) for v in self.model.v] for p in self.energetics.momenta]

    @cached_property
    def has_constant_masses(self) -> bool:
        """Whether the mass matrix is constant."""
        moving = variables(self.model)
        return not any(m.symbols & moving for row in self.matrix for m in row)

    @cached_property
    def energy(self) -> Node:
        """h."""
        return self.energetics.energy_function

    @cached_property
    def _energy_rate(self) -> Node:
        pairs = zip(self.energetics.applied, self.model.v)
        power = self.graph.sum([(force * v, 1.0) for force, v in pairs])
        return power - self.energetics.lagrangian_rate(self.model.time)

    @cached_property
    def constraints(self) -> Constraints:
        """The constraints of the model."""
        return Constraints(self.model)

    @cached_property
    def _given(self) -> list[Node]:
        """What decides about the equations of motion."""
        model = self.model
        given = [model.potential, *(u for one in model.particles for u in one.velocity)]
        given = given if model.lagrangian is None else [model.lagrangian]
        return [*given, *self.energetics.applied]

    @cached_property
    def _deciding(self) -> list[Node]:
        """The arguments that decide branches of functions in L and the forces, whose jumps derivatives do not
        show; those of roots last."""
        return sorted(deciding(self._given, self._moving), key=self._roots.__contains__)

    @cached_property
    def _roots(self) -> set[Node]:
        """Those of roots, which are positive wherever there is a motion, and decide nothing else."""
        roots, others = set[Node](), set[Node]()
        for node in reachable(self._given, lambda one: bool(one.symbols & self._moving)):
            (roots if node.kind is Kind.PRODUCT else others).update(branching(node))
        return roots - others

    @cached_property
    def _allowed(self) -> AllowedStates | None:
        """The states that the constraints of the model allow, if it has any."""
        if not self.model.constraints:
            return None
        from lagrange_cli.mechanics.conserved.allowed_states import AllowedStates

        return AllowedStates(self.model, self.constraints)

    @property
    def eliminated(self) -> Mapping[Node, Node]:
        """Velocities by others, as the constraints have it, and coordinates that these are linear in."""
        return self._allowed.eliminated if self._allowed else {}

    def _where_constraints_hold(self, lists: Sequence[Sequence[Node]]) -> Sequence[Sequence[Node]]:
        """Expressions, with what the constraints make of velocities and of coordinates."""
        return self._allowed.where_constraints_hold(lists) if self._allowed else lists

    @cached_property
    def _places(self) -> Mapping[Node, int]:
        return numbered(self.model.q)

    @cached_property
    def _moving(self) -> int:
        return state_symbols(self.model)

    def rate(self, node: Node) -> Node:
        """df/dt of a function of q and t."""
        graph, model = self.graph, self.model
        terms = [(slope * model.v[k], 1.0) for k, slope in graph.gradient(node, self._places).items()]
        return graph.sum([*terms, (graph.diff(node, model.time), 1.0)])

    def current(self, change: Change) -> Node:
        """sum_k xi_k p_k - tau h - F."""
        terms = [(xi * self.energetics.momenta[k], 1.0) for k, xi in change.directions.items()]
        terms += [(change.time * self.energy, -1.0)] if change.time is not None else []
        return self.graph.sum(terms + ([(change.gain, -1.0)] if change.gain is not None else []))

    def conditions(self, changes: Sequence[Change]) -> Sequence[Sequence[Node]]:
        """The expressions that must vanish, for each change: linear in it, and as many for every one.
        Whether roots have arguments that stay positive is left to the proof."""
        plain = 1 + sum(u not in self._roots for u in self._deciding)
        return self._where_constraints_hold(
            [[*self._balance(one)[:plain], *self._along(one)] for one in changes]
        )

    def _along(self, change: Change) -> list[Node]:
        """The rates of the constraints in a change."""
        found = []
        for slopes, drift in zip(self.constraints.slopes, self.constraints.drifts):
            terms = [(a * change.directions[k], 1.0) for k, a in slopes.items() if k in change.directions]
            terms += [(change.time * drift, 1.0)] if change.time is not None else []
            found.append(self.graph.sum(terms))
        return found

    def _balance(self, change: Change) -> list[Node]:
        """The rate of the current, and what must not change because it decides branches."""
        graph, model, energetics = self.graph, self.model, self.energetics
        terms: list[tuple[Node, float]] = []
        rates = {k: self.rate(xi) for k, xi in change.directions.items()}
        for k, xi in change.directions.items():
            terms += [(xi * self.torques[k], 1.0), (rates[k] * energetics.momenta[k], 1.0)]
        stretch = graph.zero if change.time is None else self.rate(change.time)
        if change.time is not None:
            terms += [(stretch * self.energy, -1.0), (change.time * self._energy_rate, -1.0)]
        if change.gain is not None:
            terms.append((self.rate(change.gain), -1.0))
        found = [graph.sum(terms)]
        for u in self._deciding:
            parts = [(graph.diff(u, model.q[k]) * xi, 1.0) for k, xi in change.directions.items()]
            parts += [(graph.diff(u, model.v[k]) * xi_dot, 1.0) for k, xi_dot in rates.items()]
            if change.time is not None:
                parts.append((graph.diff(u, model.time) * change.time, 1.0))
                parts += [(graph.diff(u, v) * v * stretch, -1.0) for v in model.v if u.symbols & v.symbols]
            found.append(graph.sum(parts))
        return found

    def _growth(self, factor: Node, change: Change) -> list[Node]:
        """What ``_balance`` is more than f times as large for f xi_k in place of xi_k, with a function f:
        f_dot sum_k xi_k p_k, and f_dot sum_k xi_k du/dv_k."""
        graph, rate = self.graph, self.rate(factor)
        momenta = [(xi * self.energetics.momenta[k], 1.0) for k, xi in change.directions.items()]
        found = [rate * graph.sum(momenta)]
        for u in self._deciding:
            slopes = [(graph.diff(u, self.model.v[k]) * xi, 1.0) for k, xi in change.directions.items()]
            found.append(rate * graph.sum(slopes))
        return found

    def leaves_everywhere(self, change: Change) -> bool:
        """Whether the rate of the current is 0 and the constraints allow the change at every state, also at
        those that the constraints do not allow."""
        rates = [*self._balance(change), *self._along(change)]
        return zeros(rates) >= {*rates}

    def keeps(self, change: Change) -> bool:
        """Whether it is proven that the current is conserved."""
        if self.kept([[(self.graph.one, change)]]) == [True]:
            return True
        if self.model.constraints or not self._roots:
            return False
        changing = dict(zip([None, *self._deciding], self._balance(change)))
        plain = [rate for u, rate in changing.items() if u not in self._roots]
        return zeros(plain) >= {*plain} and all(
            self._stays_positive(u, rate)
            for u, rate in changing.items()
            if u in self._roots and u is not None
        )

    def _stays_positive(self, u: Node, rate: Node) -> bool:
        """Whether u changes in proportion to u, so that no change lets it pass 0."""
        graph, model = self.graph, self.model
        symbols = (model.time, *model.q, *model.v)
        columns = [[u * factor] for factor in (graph.one, *symbols)]
        found = Relations(graph, symbols).relations([*columns, [rate]])
        for relation in found:
            if len(columns) in relation:
                return is_zero(
                    graph.sum([(factor * [*columns, [rate]][i][0], 1.0) for i, factor in relation.items()])
                )
        return False

    def kept(self, sums: Sequence[Parts]) -> list[bool]:
        """The same for each of several sums of changes times functions; all are proven at once, as they
        have most terms in common. Products are not multiplied out, and what the constraints do not allow goes
        first."""
        along = self._vanish([self._sum([(f, self._along(one)) for f, one in parts]) for parts in sums])
        left = [parts for parts, allowed in zip(sums, along) if allowed]
        one, balances = self.graph.one, []
        for parts in left:
            terms = [(f, self._balance(change)) for f, change in parts]
            grown = [(one, self._growth(f, change)) for f, change in parts if f.symbols & self._moving]
            balances.append(self._sum([*terms, *grown]))
        balanced = iter(self._vanish(balances))
        return [allowed and next(balanced) for allowed in along]

    def _sum(self, parts: Sequence[tuple[Node, Sequence[Node]]]) -> list[Node]:
        """The sums of several lists of expressions, each times a factor."""
        scaled = [[(factor * node, 1.0) for node in nodes] for factor, nodes in parts]
        return [self.graph.sum(terms) for terms in zip(*scaled)]

    def vanishes(self, node: Node) -> bool:
        """Whether it is proven of an expression that it is 0 wherever the constraints hold."""
        return self._vanish([[node]]) == [True]

    def _vanish(self, lists: Sequence[Sequence[Node]]) -> list[bool]:
        """Whether it is proven of all expressions in each list that they are 0."""
        lists = self._where_constraints_hold(lists)
        absent = zeros([node for nodes in lists for node in nodes])
        return [absent >= {*nodes} for nodes in lists]

    def together(self, parts: Sequence[tuple[Node, Change]]) -> Change:
        """A sum of changes with coefficients."""
        graph = self.graph
        directions: dict[int, list[tuple[Node, float]]] = {}
        times: list[tuple[Node, float]] = []
        gains: list[tuple[Node, float]] = []
        for factor, change in parts:
            for k, xi in change.directions.items():
                directions.setdefault(k, []).append((factor * xi, 1.0))
            times += [] if change.time is None else [(factor * change.time, 1.0)]
            gains += [] if change.gain is None else [(factor * change.gain, 1.0)]
        total = {k: graph.sum(terms) for k, terms in directions.items()}
        return Change(
            {k: xi for k, xi in total.items() if not xi.is_zero},
            graph.sum(times) if times else None,
            graph.sum(gains) if gains else None,
        )
