"""Singularities so weak that a step may pass over one: those of a coordinate or a distance, which otherwise
affect the series from far away (see ``mechanics.defect``).

A pole k/u^n at the distance d adds to coefficient m of a step of h the part k d^-n (h/d)^m. A step that leads
beyond it, h > d, is refused if this is more than the tolerance of the moving coordinates.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from lagrange_cli.expression.evaluate import evaluate
from lagrange_cli.expression.node import Kind, Node, factors_of, reachable, terms_of, union
from lagrange_cli.expression.signs import Sign, signs
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model

FEEBLE = 1e-14
"""A singular term may hide if it is so small a part of the energy where the motion begins."""
BOUNDED = frozenset({"log", "asin", "acos", "tan", "atan2"})
"""Functions that are singular somewhere."""


def has_weak_singularity(model: Model[Node], state: Mapping[str, float]) -> bool:
    """Whether there is one. The model has numbers for parameters, ``state`` has t, q and v by name.

    Terms with multipliers of constraints are left out: their size follows from the equations.
    """
    moving = variables(model)
    bound = union(one.multiplier for one in model.constraints)
    terms = [term for term in energies(model, state) if not term.symbols & bound]
    values, _ = evaluate(terms, state)
    sizes = [abs(values[term]) for term in terms]
    most = max((size for size in sizes if math.isfinite(size)), default=0.0)
    strongest: dict[Node, float] = {}
    for term, size in zip(terms, sizes):
        for base in singular(term, moving):
            strongest[base] = max(strongest.get(base, 0.0), size)
    return any(0.0 < size < FEEBLE * most for size in strongest.values())


def energies(model: Model[Node], state: Mapping[str, float]) -> Iterator[Node]:
    """The terms of energies, and those of all forces times a length: that of the coordinate, or if this is 0,
    of its velocity."""
    graph = graph_of(model)
    ways = [abs(state[str(q.data)]) or abs(state[str(v.data)]) or 1.0 for q, v in zip(model.q, model.v)]
    given = [model.potential, model.dissipation, *(() if model.lagrangian is None else (model.lagrangian,))]
    for k, (q, v, way) in enumerate(zip(model.q, model.v, ways)):
        slopes = [graph.diff(energy, q) for energy in given]
        forces = [*slopes, graph.diff(model.dissipation, v), model.generalized_forces[k]]
        forces += [f * graph.diff(x, q) for p in model.particles for f, x in zip(p.force, p.position)]
        yield from (term * c for force in forces for term, c in terms_of(force * way))
    given += [particle.mass * v * v * 0.5 for particle in model.particles for v in particle.velocity]
    yield from (term * c for energy in given for term, c in terms_of(energy))


def singular(term: Node, moving: int) -> Iterator[Node]:
    """The arguments in a term that may become 0 or reach the end of a domain."""
    known: dict[Node, Sign] = {}
    for node in reachable([term], lambda one: bool(one.symbols & moving)):
        if node.kind is Kind.FUNCTION and node.data in BOUNDED:
            yield node
        for base, exponent in factors_of(node):
            ends = exponent < 0 or exponent != int(exponent)
            if base.symbols & moving and ends and signs(base, known) is not Sign.POSITIVE:
                yield base
