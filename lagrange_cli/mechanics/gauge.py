"""Total time derivatives in L, which act on nothing: L and L + dF/dt(q, t) give the same motion.

(Landau and Lifshitz, Mechanics, 3rd ed., eq. 2.8.) The terms of dF/dt cancel in the equations of motion.
Where F is steep they are large, and what rounding leaves of them would act. So they are left out before.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.zero import RANGE, Branches, Doubles, branching, zeros
from lagrange_cli.mechanics.jumps import arguments, sides, terms_of
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import variables
from lagrange_cli.model.model import Model

MOST_COORDINATES, MOST_TERMS = 30, 60
"""In more coordinates, or in more terms, none are looked for."""
POINTS = 3
"""Random states at which terms must cancel before it is proven that they do."""
ROUNDING = 1e-9
"""Coefficients this near to 0 or 1 are so but for rounding."""
LEAST = 1e-300
"""The smallest unit of exponents that is tried."""
Array = npt.NDArray[np.float64]


def acting(model: Model[Node], graph: Graph, lagrangian: Node) -> Node:
    """L without terms that are proven to be a total time derivative dF/dt of a function F(q, t)."""
    velocities = sum(v.symbols for v in model.v)
    if len(model.q) > MOST_COORDINATES or not lagrangian.symbols & velocities:
        return lagrangian
    terms = [graph.sum([term]) for term in terms_of(graph, lagrangian)]
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
        for group in groups(graph, {term: curl(graph, form, places) for term, form in forms.items()})
        if is_exact(graph, group, [forms[term] for term in group], places)
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


def is_exact(
    graph: Graph, group: Sequence[Node], forms: Sequence[Sequence[Node]], places: Sequence[Node]
) -> bool:
    """Whether it is proven that a sum of terms is dF/dt for an F without jumps."""
    form = [graph.sum([(part, 1.0) for part in parts]) for parts in zip(*forms)]
    left = curl(graph, form, places)
    for u in dict.fromkeys(one for node in form for one in arguments(node)):
        # A jump of A where u changes its sign is the slope of an F with a kink there if it is along du.
        jumps = [above - below for above, below in (sides(graph, node, u) for node in form)]
        slopes = [graph.diff(u, x) for x in places]
        left += [jumps[k] * slopes[j] - jumps[j] * slopes[k] for k in range(len(places)) for j in range(k)]
    return zeros(left) == {*left}


def groups(graph: Graph, curls: Mapping[Node, Sequence[Node]]) -> Iterator[list[Node]]:
    """Groups of terms that may be a dF/dt: single ones, and those whose curls cancel at random states.

    A vector of coefficients with which all curls cancel is in the null space of their values. Where that
    has a basis of vectors which share no terms, each with equal coefficients, these are the groups.
    """
    closed = {term for term, nodes in curls.items() if zeros(nodes) == {*nodes}}
    yield from ([term] for term in closed)
    terms = [term for term in curls if term not in closed]
    values = at_random([node for term in terms for node in curls[term]])
    if not values.size or not np.all(np.isfinite(values)):
        return
    rows = values.reshape(POINTS, len(terms), -1).swapaxes(0, 1).reshape(len(terms), -1)
    for vector in reduced(null_space(rows)):
        members = np.abs(vector) > ROUNDING
        if np.allclose(vector[members], 1.0, rtol=0, atol=ROUNDING):
            yield [term for term, within in zip(terms, members) if within]


def at_random(nodes: Sequence[Node]) -> Array:
    """Values of the nodes at random states, of shape (states, nodes).

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
            break
        else:
            found, unit = [], unit * source.uniform(0.5, 1.0) / branches.farthest
    return np.array(found if len(found) == POINTS else [])


def null_space(rows: Array) -> Array:
    """A basis of the vectors c with c @ rows = 0, as rows."""
    largest = np.max(np.abs(rows), axis=0)
    left, sizes, _ = np.linalg.svd(rows[:, largest > 0] / largest[largest > 0])
    rank = int(np.sum(sizes > ROUNDING * sizes[:1]))
    return np.asarray(left[:, rank:].T)


def reduced(rows: Array) -> Array:
    """The reduced row echelon form (by Gauss and Jordan, with pivots)."""
    rows, done = rows.copy(), 0
    for column in range(rows.shape[1]):
        if done == len(rows):
            break
        pivot = done + int(np.argmax(np.abs(rows[done:, column])))
        if abs(rows[pivot, column]) > ROUNDING:
            rows[[done, pivot]] = rows[[pivot, done]]
            rows[done] /= rows[done, column]
            others = np.arange(len(rows)) != done
            rows[others] -= np.outer(rows[others, column], rows[done])
            done += 1
    return rows
