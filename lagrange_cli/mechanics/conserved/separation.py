"""Separable systems: a part whose coordinates share no term of L with others conserves its own energy."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from functools import reduce
from operator import or_

from lagrange_cli.expression.node import Kind, Node, bits
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conservation import Conserved
from lagrange_cli.mechanics.conserved.found import Found
from lagrange_cli.mechanics.constraints import Constraints
from lagrange_cli.mechanics.energetics import Energetics
from lagrange_cli.mechanics.matrices import united
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model

Term = tuple[Node, float]
MOST = 2000
"""Terms that products are multiplied out to."""
MOST_NAMES = 3
"""Coordinates that are named in one sentence."""


def parts(found: Found) -> None:
    """Energies of parts of the system."""
    for names, node in separate_energies(found.model, found.names):
        found.store(energy_of_part(names), node)


def energy_of_part(names: Sequence[str]) -> Conserved:
    """The energy of the part with these coordinates."""
    listed = ", ".join(names[:MOST_NAMES]) + ", ..." * (len(names) > MOST_NAMES)
    because = f"no other coordinate is in the same terms of L as {listed}, nor is t"
    return Conserved(f"h_{names[0]}", f"the part of h with {listed}", because)


def separate_energies(model: Model[Node], momenta: Collection[str]) -> list[tuple[list[str], Node]]:
    """The coordinates of each part, and its conserved energy sum v_k p_k - L.

    Parts with nothing but coordinates whose ``momenta`` (names) are conserved are left out, and those whose
    forces of constraint do work. A single part gives nothing.
    """
    energetics, graph, constraints = Energetics(model), graph_of(model), Constraints(model)
    own, terms, working = _own(model), _terms_of(model), 0
    for one, drift in zip(model.constraints, constraints.drifts):
        working |= 0 if is_zero(drift) else one.expression.symbols
    parts = [
        part
        for part in _parts(own, _masks(model, terms))
        if not all(f"p_{model.coordinates[k]}" in momenta for k in part)
    ]
    found = []
    for part in parts if len(parts) > 1 else ():
        mine = sum(own[k] for k in part)
        if mine & working:
            continue
        lagrangian = graph.sum([(term, c) for term, c in terms if term.symbols & mine])
        power = graph.sum([(model.v[k] * energetics.applied[k], 1.0) for k in part])
        if is_zero(power - graph.diff(lagrangian, model.time)):
            moving = [(model.v[k] * energetics.momenta[k], 1.0) for k in part]
            found.append(([model.coordinates[k] for k in part], graph.sum([*moving, (lagrangian, -1.0)])))
    return found


def coordinates_together(model: Model[Node]) -> list[list[str]]:
    """The coordinates of each part of a system: no term of L, no force and no constraint has those of two."""
    parts = _parts(_own(model), _masks(model, _terms_of(model)))
    return [[model.coordinates[k] for k in part] for part in parts]


def _own(model: Model[Node]) -> list[int]:
    """The bits of each coordinate and its velocity."""
    return [q.symbols | v.symbols for q, v in zip(model.q, model.v)]


def _masks(model: Model[Node], terms: Sequence[Term]) -> list[int]:
    """The bits of coordinates that occur together: in ``terms`` of L, along with a force, and in
    constraints."""
    masks = [term.symbols for term, _ in terms]
    bound = {one.multiplier.symbols: one.expression.symbols for one in (*model.constraints, *model.redundant)}
    multipliers = reduce(or_, bound, 0)
    for force, mine in zip(Energetics(model).applied, _own(model)):
        if not force.is_zero:
            through = (bound[1 << bit] for bit in bits(force.symbols & multipliers))
            masks.append(reduce(or_, through, force.symbols | mine))
    return [*masks, *bound.values()]


def _terms_of(model: Model[Node]) -> list[Term]:
    """The terms that L is a sum of, with their coefficients."""
    if model.lagrangian is not None:
        return terms_of_sum(model.lagrangian, 1.0)
    kinetic = [(one.mass * u * u, 0.5) for one in model.particles for u in one.velocity]
    return kinetic + terms_of_sum(model.potential, -1.0)


def terms_of_sum(node: Node, sign: float) -> list[Term]:
    """Those of one sum, with products expanded, except a constant: up to ``MOST`` terms. Of more, some
    are left as they are."""
    found: list[Term] = []
    pending, left = [(node, sign)], MOST
    while pending:
        one, factor = pending.pop()
        parts = _summands(one) if left > 0 else []
        if parts:
            left -= len(parts)
            pending += [(term, factor * c) for term, c in reversed(parts) if c]
        else:
            found.append((one, factor))
    return found


def multiplied_out(node: Node) -> Node:
    """The same as a sum of products."""
    constant = node.data[0] if node.kind is Kind.SUM else 0.0
    return node.graph.sum([*terms_of_sum(node, 1.0), (node.graph.one, constant)])


def _summands(node: Node) -> list[Term]:
    """The terms of a sum, or of a product with one as a factor; none of anything else."""
    if node.kind is Kind.SUM:
        return [*zip(node.arguments, node.data[1])]
    if node.kind is Kind.PRODUCT:
        inner = next((a for a, e in zip(node.arguments, node.data) if a.kind is Kind.SUM and e == 1), None)
        if inner is not None:
            rest, (constant, coefficients) = node / inner, inner.data
            terms = [*zip(inner.arguments, coefficients), (node.graph.one, constant)]
            return [(rest * term, c) for term, c in terms]
    return []


def _parts(own: list[int], masks: Iterable[int]) -> tuple[tuple[int, ...], ...]:
    """Coordinates that stand together in expressions; these have the bits ``masks``, coordinates ``own``."""
    places = {bit: k for k, mine in enumerate(own) for bit in bits(mine)}
    every = reduce(or_, own, 0)
    return united(len(own), ([places[bit] for bit in bits(mask & every)] for mask in masks))
