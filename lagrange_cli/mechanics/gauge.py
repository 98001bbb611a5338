"""Total time derivatives in L, which have no effect: L and L + dF/dt(q, t) give the same motion.

(Landau and Lifshitz, Mechanics, 3rd ed., eq. 2.8.) The terms of dF/dt cancel in the equations of motion.
Where F is steep
they are large, and their rounding errors would act as forces. So they are removed beforehand.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain

from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable, terms_of
from lagrange_cli.expression.zero import RANGE, Branches, Doubles, branching, zeros
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.switching.jumps import arguments, sides
from lagrange_cli.mechanics.variables import variables
from lagrange_cli.model.model import Model

MOST_COORDINATES, MOST_TERMS = 30, 60
"""None are looked for in more coordinates, or in more terms."""
POINTS = 3
"""Random states at which terms must cancel before it is proven that they do."""
LEAST = 1e-300
"""The smallest unit of exponents that is tried."""


def acting(model: Model[Node], graph: Graph, lagrangian: Node) -> Node:
    """L without terms that are proven to be a total time derivative dF/dt of a function F(q, t)."""
    velocities = sum(v.symbols for v in model.v)
    if len(model.q) > MOST_COORDINATES or not lagrangian.symbols & velocities:
        return lagrangian
    terms = [graph.sum([term]) for term in terms_of(lagrangian)]
    if len(terms) > MOST_TERMS:
        return lagrangian
    at_rest = dict.fromkeys(model.v, graph.zero)
    forms = {}
    for term in terms:
        slopes = [graph.diff(term, v) for v in model.v]
        if not any(slope.symbols & velocities for slope in slopes) and not ambiguous(term, variables(model)):
            forms[term] = (*slopes, *substituted(graph, [term], at_rest))
    if not any(slope is not graph.zero for form in forms.values() for slope in form[:-1]):
        return lagrangian
    places = (*model.q, model.time)
    idle = {
        term
        for group in groups({term: curl(graph, form, places) for term, form in forms.items()})
        if is_exact(graph, [forms[term] for term in group], places)
        for term in group
    }
    return graph.sum([(term, 1.0) for term in terms if term not in idle]) if idle else lagrangian


def ambiguous(term: Node, moving: int) -> bool:
    """Whether a term has branches, besides those of switches, that depend on what moves."""
    return any(
        inner.symbols & moving
        for node in reachable([term])
        if node.kind is not Kind.SWITCH
        for inner in branching(node)
    )


def curl(graph: Graph, form: Sequence[Node], places: Sequence[Node]) -> list[Node]:
    """The slopes dA_k/dx_j - dA_j/dx_k of A_1 dx_1 + ... + A_n dx_n, j < k: all 0 where this is a dF."""
    slopes = [graph.gradient(node, {x: k for k, x in enumerate(places)}) for node in form]
    return [
        slopes[k].get(j, graph.zero) - slopes[j].get(k, graph.zero)
        for k in range(len(places))
        for j in range(k)
    ]


def is_exact(graph: Graph, forms: Sequence[Sequence[Node]], places: Sequence[Node]) -> bool:
    """Whether it is proven that a sum of terms is dF/dt for an F without jumps."""
    form = [graph.sum([(part, 1.0) for part in parts]) for parts in zip(*forms)]
    left = curl(graph, form, places)
    for u in dict.fromkeys(one for node in form for one in arguments(node)):
        # A jump of A where u changes its sign is the slope of an F with a kink there if it is along du.
        jumps = [above - below for above, below in (sides(graph, node, u) for node in form)]
        slopes = [graph.diff(u, x) for x in places]
        left += [jumps[k] * slopes[j] - jumps[j] * slopes[k] for k in range(len(places)) for j in range(k)]
    return zeros(left) == {*left}


def groups(curls: Mapping[Node, Sequence[Node]]) -> Iterator[list[Node]]:
    """Groups of terms that may be a dF/dt: single ones, and those whose curls cancel at random states."""
    terms = []
    for term, nodes in curls.items():
        if zeros(nodes) == {*nodes}:
            yield [term]
        else:
            terms.append(term)
    states = at_random([node for term in terms for node in curls[term]])
    if len(terms) < 2 or not all(map(math.isfinite, chain.from_iterable(states))):
        return
    from lagrange_cli.mechanics.cancelling import cancelling

    each = len(states[0]) // len(terms)
    rows = [[x for state in states for x in state[k * each : (k + 1) * each]] for k in range(len(terms))]
    yield from ([terms[k] for k in group] for group in cancelling(rows))


def at_random(nodes: Sequence[Node]) -> list[list[float]]:
    """Values of the nodes at random states, or nan where these are too large.

    Exponents are scaled down where they are large (see ``expression.zero``), which changes no identity.
    """
    found: list[list[float]] = []
    source, unit = random.Random(len(nodes)), 1.0
    names = sorted({node.data for node in reachable(nodes) if node.kind is Kind.SYMBOL})
    while len(found) < POINTS:
        branches = Branches(Doubles(), source, unit)
        value, _ = evaluate(nodes, {name: source.uniform(-RANGE, RANGE) for name in names}, branches)
        if not branches.farthest:
            found.append([value[node] for node in nodes])
        elif unit < LEAST:
            return [[math.nan]]
        else:
            found, unit = [], unit * source.uniform(0.5, 1.0) / branches.farthest
    return found
