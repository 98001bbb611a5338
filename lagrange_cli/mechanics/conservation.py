"""Which coordinates are cyclic and what every motion conserves, decided without a computer algebra system.

dp_k/dt = dL/dq_k + Q_k and dh/dt = -dL/dt + sum Q_k q_dot_k (Goldstein, 3rd ed., secs. 2.6 and 2.7). Where
such a rate is not 0 by its structure alone (a sum may need an identity to vanish), it is evaluated at
random arguments: an analytic expression that vanishes at several of them is identically 0. What is so narrow
or steep that it may only be small there is evaluated with many more digits.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence

from lagrange_cli.expression.evaluate import SATURATING, evaluate
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass

POINTS = 5
"""Random arguments at which an expression must vanish."""
ROUNDING = 1e-11
"""A value this small beside the terms it is the sum of is rounding."""
COMMON, STEEP = 1e3, 8
"""Numbers up to the one and down to its reciprocal, and powers below the other, hide nothing."""


@dataclass(frozen=True)
class Conserved:
    """A constant of the motion: ``quantity`` ("h" or "p_theta"), what it is, and why it is kept."""

    quantity: str
    expression: str
    because: str


def is_zero(node: Node) -> bool:
    """Whether an expression without ``ddt`` is identically 0 (see the module's first lines)."""
    return node in zeros([node])


def zeros(nodes: Sequence[Node]) -> set[Node]:
    """Those of the expressions that are identically 0; what they have in common is evaluated once."""
    found = {node for node in nodes if node.is_zero}
    unsettled = {node: 0 for node in nodes if not node.is_zero}
    attempt = 0
    source = random.Random(len(unsettled))
    while unsettled and attempt < 4 * POINTS:
        values, sizes = evaluate(list(unsettled), arguments(list(unsettled), source, attempt))
        attempt += 1
        for node in list(unsettled):
            if not (math.isfinite(values[node]) and math.isfinite(sizes[node])):
                continue
            unsettled[node] += 1
            if abs(values[node]) > ROUNDING * sizes[node]:
                del unsettled[node]
            elif unsettled[node] == POINTS:
                del unsettled[node]
                found.add(node)
    doubtful = [node for node in found if any(map(hides, reachable([node])))]
    return found - nonzero(doubtful, source) if doubtful else found


def nonzero(nodes: Sequence[Node], source: random.Random) -> set[Node]:
    """Those that are not 0, or have no value where it would show."""
    from lagrange_cli.expression.many_digits import vanish

    found, unsettled = set(), list(nodes)
    for attempt in range(4 * POINTS):
        vanishing = vanish(unsettled, arguments(unsettled, source, attempt))
        found |= {node for node, nothing in vanishing.items() if nothing is False}
        unsettled = [node for node, nothing in vanishing.items() if nothing is None]
        if not unsettled:
            break
    return found.union(unsettled)


def arguments(nodes: Sequence[Node], source: random.Random, attempt: int) -> dict[str, float]:
    """Random values of all symbols: every other time positive, as some functions need it."""
    low = 0.2 if attempt % 2 else -1.3
    names = [inner.data for inner in reachable(nodes) if inner.kind is Kind.SYMBOL]
    return {name: source.uniform(low, 1.3) for name in names}


def hides(node: Node) -> bool:
    """Whether it may make a value too small to show."""
    if node.kind is Kind.NUMBER:
        return unusual(node.data)
    if node.kind is Kind.SUM:
        return any(map(unusual, (node.data[0], *node.data[1])))
    if node.kind is Kind.PRODUCT:
        return any(abs(exponent) >= STEEP for exponent in node.data)
    return node.kind is Kind.POWER or (node.kind is Kind.FUNCTION and node.data in SATURATING)


def unusual(number: float) -> bool:
    """Whether it is of a scale that calls for care."""
    return number != 0.0 and not 1 / COMMON <= abs(number) <= COMMON


def conservation(model: Model[Node]) -> tuple[tuple[str, ...], tuple[Conserved, ...]]:
    """Names of the cyclic coordinates, and the conserved quantities."""
    energetics = Energetics(model)
    conserved: list[Conserved] = []
    cyclic: list[str] = []
    rates = [energetics.lagrangian_rate(q) for q in model.q]
    absent = zeros([*rates, *energetics.forces])
    for name, rate, force in zip(model.coordinates, rates, energetics.forces):
        if rate not in absent:
            continue
        cyclic.append(name)
        if force in absent:
            because = f"{name} is cyclic (L does not depend on it), and no generalized force acts on it"
            conserved.append(Conserved(f"p_{name}", f"dL/d{velocity_name(name)}", because))
    if is_zero(energetics.lagrangian_rate(model.time)) and is_zero(energetics.power):
        conserved.append(_energy(model, energetics))
    return tuple(cyclic), tuple(conserved)


def _energy(model: Model[Node], energetics: Energetics) -> Conserved:
    because = "L does not depend on t explicitly"
    if not all(map(is_zero, set(energetics.forces))):
        because += ", and the generalized forces do no work"
    if model.lagrangian is None:
        graph = graph_of(model)
        drifts = {graph.diff(x, model.time) for p in model.particles for x in p.position}
        if all(map(is_zero, drifts | {graph.diff(model.potential, v) for v in model.v})):
            return Conserved(
                "h", "T + U", f"{because}; h = T + U, as neither positions depend on t nor U on velocities"
            )
    return Conserved("h", "sum_k q_dot_k p_k - L", because)
