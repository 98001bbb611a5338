"""Integrals of systems that do not depend on t in other units of length and time, which change with t.

Let L = mu(t) T - U(q, t), with T of second degree in lengths and in velocities. With q = rho(t) Q for lengths
and dt = mu rho^2 ds, and without a total derivative,

    L' = T(Q, dQ/ds) - mu rho^2 U(rho Q, t) - mu rho^3 (mu rho_dot)_dot T(Q, Q)

(J. R. Ray and J. L. Reid, Phys. Lett. A 71, 317, 1979, for mu = 1). A term g(t) u of U with u of the degree d
does not change with s if rho = (mu g)^(-1/(2 + d)). Where nothing else does, h' and all that L' conserves are
conserved: for Kepler's problem with k/(1 + e t), for the damped oscillator, and for Emden's equation. Drag
-c times the momenta is mu = exp(c t).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, factors_of, reachable
from lagrange_cli.expression.text import text_of
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conservation import Conserved, conservation
from lagrange_cli.mechanics.conserved.ansatz import has_smooth_forces
from lagrange_cli.mechanics.conserved.damped import rate_of
from lagrange_cli.mechanics.conserved.found import Found, Symmetry
from lagrange_cli.mechanics.conserved.residue_states import States
from lagrange_cli.mechanics.conserved.separation import terms_of_sum
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import variables
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass, replace

MOST_RESCALED = 6
"""The largest number of coordinates."""

Factors = Mapping[Node, float]
"""A function of t: powers of such functions."""


def rescaled(found: Found, search: Callable[[Model[Node], Sequence[Conserved]], Iterable[Symmetry]]) -> None:
    """What L' conserves and does not follow from what is known; ``search`` finds what another system
    conserves, besides what is known of it."""
    model = found.model
    if model.constraints or not 0 < len(model.q) <= MOST_RESCALED or not changes_in_time(found):
        return
    if not has_smooth_forces(model, found.noether):
        return
    states = States(model, found.noether)
    for lengths in lengths_of(model):
        units = Units.of(found, states, lengths)
        steady = None if units is None else units.steady()
        if units is not None and steady is not None:
            other, back, text = steady
            energetics, (_, known) = Energetics(other), conservation(other)
            nodes = dict(zip((f"p_{name}" for name in other.coordinates), energetics.momenta))
            nodes["h"] = energetics.energy_function
            given = [(one, nodes[one.quantity]) for one in known]
            given += [(one.conserved, one.node) for one in search(other, known)]
            for each, there in sorted(given, key=lambda one: one[0].quantity != "h"):
                if not there.symbols & model.time.symbols:
                    report(found, states, each, units.in_lengths(there, back), text)
            return


def changes_in_time(found: Found) -> bool:
    """Whether L depends on t, or drag is the only force."""
    applied = not all(map(is_zero, found.noether.energetics.applied))
    return applied or bool(found.noether.energetics.lagrangian.symbols & found.model.time.symbols)


def report(found: Found, states: States, each: Conserved, node: Node, text: str) -> None:
    """Add an integral; all components of a vector or a tensor."""
    part = each.quantity[:2] in ("A_", "F_") and each.quantity not in found.names
    if (not part and not found.is_independent(node)) or not states.conserves(node):
        return
    because = f"{text}; there it is {each.quantity}: {each.because}"
    found.store_integral(text_of(node), because, node, each.quantity if part else "")


def lengths_of(model: Model[Node]) -> Iterator[list[int]]:
    """Sets of coordinates that may be lengths: all, or one, as in polar coordinates."""
    every = [*range(len(model.q))]
    yield every
    yield from ([k] for k in every if len(every) > 1)


@dataclass(frozen=True)
class Units:
    """A system with a kinetic energy ``mu`` times ``kinetic``, its coordinates that are ``lengths``, and the
    terms of its potential: a function of t, one of q, and its degree."""

    found: Found
    lengths: Sequence[int]
    mu: Factors
    kinetic: Node
    terms: Sequence[tuple[Factors, Node, float]]

    @classmethod
    def of(cls, found: Found, states: States, lengths: Sequence[int]) -> Units | None:
        """None where a system is not of this kind."""
        model, graph, energetics = found.model, found.graph, found.noether.energetics
        time, moving = model.time.symbols, variables(model)
        drag = graph.zero
        if not all(map(is_zero, energetics.applied)):
            rate = rate_of(found)
            if rate is None or rate.symbols & moving:
                return None
            left = [f + rate * p for f, p in zip(energetics.applied, energetics.momenta)]
            if not all(map(is_zero, left)):
                return None
            drag = rate
        still = dict.fromkeys(model.v, graph.zero)
        rest, *linear = substituted(graph, [energetics.lagrangian, *energetics.momenta], still)
        entries = [m for row in states.noether.matrix for m in row if not m.is_zero]
        if not all(map(is_zero, linear)) or any(m.symbols & v.symbols for m in entries for v in model.v):
            return None
        mu, _ = in_time(graph, entries[0], time, moving)
        below = product(graph, mu, -1.0)
        matrix = [[below * m for m in row] for row in states.noether.matrix]
        if any(m.symbols & time for row in matrix for m in row) or not homogeneous(found, matrix, lengths):
            return None
        growth = in_time(graph, graph.function("exp", (drag * model.time,)), time, moving)[0]
        terms = []
        for one, c in terms_of_sum(rest, -1.0):
            if one.symbols & moving:
                g, u = in_time(graph, one, time, moving)
                degree = degree_of(found, u, lengths)
                if degree is None or u.symbols & time:
                    return None
                terms.append((times((g, 1.0), (growth, 1.0)), c * u, degree))
        pairs = [(m * v * w, 0.5) for row, v in zip(matrix, model.v) for m, w in zip(row, model.v)]
        return cls(found, lengths, times((mu, 1.0), (growth, 1.0)), graph.sum(pairs), terms)

    def in_lengths(self, node: Node, back: Mapping[Node, Node]) -> Node:
        """A function of Q and dQ/ds as one of the state; of roots of homogeneous functions, rho comes out."""
        graph, known = self.found.graph, dict(back)
        for one in reachable([node]):
            factors = factors_of(one)
            roots = [(a, e) for a, e in factors if a.kind is Kind.SUM and not isinstance(e, int)]
            degrees = [degree_of(self.found, a, self.lengths) for a, _ in roots]
            if roots and None not in degrees:
                power = sum(-d * e for d, (_, e) in zip(degrees, roots) if d is not None)
                (rest,) = substituted(graph, [graph.product(f for f in factors if f not in roots)], known)
                known[one] = graph.product([(rest, 1), *roots]) * product(graph, self.scale, power)
        return substituted(graph, [node], known)[0]

    @cached_property
    def scale(self) -> Factors:
        """rho, by the first term of U that is not of the degree -2; else 1."""
        for g, _, degree in self.terms:
            if degree != -2:
                return times((self.mu, -1 / (2 + degree)), (g, -1 / (2 + degree)))
        return {}

    def steady(self) -> tuple[Model[Node], Mapping[Node, Node], str] | None:
        """The system of L', Q and dQ/ds in terms of the state, and the units in words."""
        found, graph, model, scale = self.found, self.found.graph, self.found.model, self.scale
        if any(times((self.mu, 1.0), (scale, 2 + degree), (g, 1.0)) for g, _, degree in self.terms):
            return None
        growth, pace = (product(graph, times((self.mu, 1.0), (scale, n))) for n in (1.0, 2.0))
        slopes = [(e * graph.diff(one, model.time) / one, 1.0) for one, e in scale.items()]
        bend = graph.diff(graph.sum([(growth * one, 1.0) for one, _ in slopes]), model.time)
        factor = constant(found, product(graph, times((self.mu, 1.0), (scale, 3.0))) * bend)
        if factor is None:
            return None
        stretched = {v: model.q[k] if k in self.lengths else graph.zero for k, v in enumerate(model.v)}
        (spring,) = substituted(graph, [self.kinetic], stretched)
        potential = [(-u, 1.0) for _, u, _ in self.terms]
        other = replace(
            model, lagrangian=graph.sum([(self.kinetic, 1.0), (factor * spring, -1.0), *potential]),
            potential=graph.zero, particles=(), events=(), dissipation=graph.zero,
            generalized_forces=(graph.zero,) * len(model.q),
        )  # fmt: skip
        back = {v: pace * v for v in model.v}
        for k in self.lengths:
            q, v = model.q[k], model.v[k]
            drift = graph.sum([(growth * one * q, -1.0) for one, _ in slopes])
            back |= {q: q * product(graph, scale, -1.0), v: growth * v + drift}
        units = [
            f"{what} divided by {text_of(one)}"
            for what, one in (("lengths are", product(graph, scale)), ("dt is", pace))
            if one is not graph.one
        ]
        return other, back, f"if {' and '.join(units)}, L does not depend on t"


def in_time(graph: Graph, node: Node, time: int, moving: int) -> tuple[dict[Node, float], Node]:
    """The factors of a product that depend on t alone, and the others."""
    found, others = dict[Node, float](), list[tuple[Node, float]]()
    for one, exponent in factors_of(node):
        if one.symbols & moving != time:
            others.append((one, exponent))
        elif one.kind is Kind.FUNCTION and one.data == "exp":
            number, argument = graph.split_coefficient(one.arguments[0])
            base = graph.function("exp", (argument,))
            found[base] = found.get(base, 0.0) + number * exponent
        else:
            found[one] = found.get(one, 0.0) + exponent
    return found, graph.product(others)


def times(*factors: tuple[Factors, float]) -> dict[Node, float]:
    """The product of functions of t, each to a power."""
    found = dict[Node, float]()
    for one, power in factors:
        for base, exponent in one.items():
            found[base] = found.get(base, 0.0) + power * exponent
    return {base: exponent for base, exponent in found.items() if abs(exponent) > 1e-12}


def product(graph: Graph, factors: Factors, power: float = 1.0) -> Node:
    """A function of t, to a power, as an expression."""
    found = list[tuple[Node, int | float]]()
    for base, exponent in factors.items():
        whole = power * exponent
        if base.kind is Kind.FUNCTION and base.data == "exp":
            found.append((graph.function("exp", (whole * base.arguments[0],)), 1))
        else:
            found.append((base, int(whole) if whole == int(whole) else whole))
    return graph.product(found)


def homogeneous(found: Found, matrix: Sequence[Sequence[Node]], lengths: Sequence[int]) -> bool:
    """Whether T is of second degree in the lengths and their velocities."""
    graph, model = found.graph, found.model
    return all(
        is_zero(
            graph.sum([(model.q[i] * graph.diff(m, model.q[i]), 1.0) for i in lengths])
            - (2.0 - (k in lengths) - (j in lengths)) * m
        )
        for k, row in enumerate(matrix)
        for j, m in enumerate(row)
    )


def degree_of(found: Found, node: Node, lengths: Sequence[int]) -> float | None:
    """The degree of a function of q in the lengths."""
    graph, places = found.graph, found.model.q
    grown = graph.sum([(places[i] * graph.diff(node, places[i]), 1.0) for i in lengths])
    degree = found.relations.combination([[node]], [grown])
    return None if degree is None or not is_zero(grown - degree[0] * node) else degree[0]


def constant(found: Found, node: Node) -> Node | None:
    """The value of a function of t that is constant."""
    if not node.symbols & found.model.time.symbols:
        return node
    if not is_zero(found.graph.diff(node, found.model.time)):
        return None
    for relation in found.relations.relations([[found.graph.one], [node]]):
        if relation.keys() == {0, 1}:
            return -relation[0] / relation[1]
    return found.graph.zero if is_zero(node) else None
