"""Axes in which a file writes its potential, such as X = x*cos(alpha) - y*sin(alpha) with a parameter alpha.

Conserved polynomials have few terms there, with simple coefficients, while in the coordinates of the file
they are long sums of products of sines. T is a sum of squares along axes that are orthogonal in the metric
of the masses: with X_i = a_i q and w_i = M^-1 a_i, T is the sum of (dX_i/dt)^2/(2 a_i w_i), and q that of
w_i X_i/(a_i w_i).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.text import text_of
from lagrange_cli.expression.vocabulary import velocity_name
from lagrange_cli.expression.zero import is_zero
from lagrange_cli.mechanics.conserved.ansatz import degree_of
from lagrange_cli.mechanics.conserved.noether import Noether
from lagrange_cli.mechanics.conserved.polynomial_integrals import Integral, PolynomialIntegrals
from lagrange_cli.mechanics.conserved.reasons import without_denominators
from lagrange_cli.mechanics.conserved.residue_states import States
from lagrange_cli.mechanics.conserved.separation import terms_of_sum
from lagrange_cli.mechanics.embedding import solution
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of, variables
from lagrange_cli.model.model import Model
from lagrange_cli.records import dataclass, replace

NAMES = ("X", "Y", "Z"), ("U", "V", "W"), ("X1", "X2", "X3")
"""What the axes are called, if nothing else is."""


@dataclass(frozen=True)
class Turned:
    """A ``model`` whose coordinates are sums of those of another one, times functions of parameters.
    ``there`` gives those of the other one in terms of its own, ``here`` the reverse; ``text`` says what they
    are."""

    model: Model[Node]
    there: Mapping[Node, Node]
    here: Mapping[Node, Node]
    text: str


def integrals(model: Model[Node], noether: Noether, known: Sequence[Node]) -> Iterator[Integral]:
    """Conserved polynomials in the velocities along other axes, beyond the ``known`` conserved functions."""
    states, graph = States(model, noether), graph_of(model)
    along = turned(model, noether)
    if along is None:
        return
    there = substituted(graph, known, along.there)
    for one in PolynomialIntegrals(along.model, Noether(along.model), there).found():
        (node,) = substituted(graph, [one.node], along.here)
        if states.conserves(node):
            yield replace(one, node=node, note=f"; {along.text}")


def turned(model: Model[Node], noether: Noether) -> Turned | None:
    """The ``model`` along the axes in which its potential is written; its masses are constant. None
    where the potential is written in its own coordinates, apart from polynomials, or where there is more than
    T and a potential."""
    graph, lagrangian = graph_of(model), noether.energetics.lagrangian
    applied = any(not force.is_zero for force in noether.energetics.applied)
    if applied or model.constraints or not 2 <= len(model.q) <= len(NAMES[0]):
        return None
    (still,) = substituted(graph, [lagrangian], dict.fromkeys(model.v, graph.zero))
    if any(not is_zero(graph.diff(lagrangian - still, q)) for q in model.q):
        return None
    forms = [one for one in reachable([still]) if is_form(model, one)]
    axes = orthogonal(model, noether.matrix, [*forms, *model.q]) if forms else []
    taken = {*model.coordinates, *model.parameters}
    free = next((some for some in NAMES if taken.isdisjoint(some)), ())
    if not axes or not free:
        return None
    names = free[: len(axes)]
    q, v = (tuple(map(graph.symbol, some)) for some in (names, map(velocity_name, names)))
    squares = [dot(graph, form, raised) for form, raised in axes]
    forms = [graph.sum([(a * x, 1.0) for a, x in zip(form, model.q)]) for form, _ in axes]
    speeds = [*map(noether.rate, forms)]
    there = dict[Node, Node]()
    for own, other in ((model.q, q), (model.v, v)):
        for k, symbol in enumerate(own):
            parts = zip(other, axes, squares)
            there[symbol] = graph.sum([(x * w[k] / square, 1.0) for x, (_, w), square in parts])
    (still,) = substituted(graph, [still], dict(zip(forms, q)))
    terms, places, moving = terms_of_sum(still, 1.0), {*model.q}, variables(model)
    if any(degree_of(term, places, moving) is None for term, _ in terms if term.symbols & moving):
        return None
    (still,) = substituted(graph, [still], there)
    kinetic = [(speed * speed / square, 0.5) for speed, square in zip(v, squares)]
    zeros = tuple(graph.zero for _ in q)
    along = replace(
        model, coordinates=names, q=q, v=v, lagrangian=graph.sum([*kinetic, (still, 1.0)]), particles=(),
        potential=graph.zero, generalized_forces=zeros, dissipation=graph.zero, events=(), families={},
        observables={}, spec=None,
    )  # fmt: skip
    text = ", ".join(f"{name} = {text_of(form)}" for name, form in zip(names, forms))
    return Turned(along, there, dict(zip((*q, *v), (*forms, *speeds))), text)


def is_form(model: Model[Node], node: Node) -> bool:
    """Whether it is a sum of several coordinates times constants, some of which contain parameters."""
    if node.kind is not Kind.SUM or node.data[0] or degree_of(node, {*model.q}, variables(model)) != 1:
        return False
    slopes = [graph_of(model).diff(node, q) for q in model.q]
    return sum(not one.is_zero for one in slopes) > 1 and any(one.symbols for one in slopes)


def orthogonal(
    model: Model[Node], matrix: Sequence[Sequence[Node]], forms: Sequence[Node]
) -> list[tuple[Sequence[Node], Sequence[Node]]]:
    """As many forms a as there are coordinates, each with M^-1 a, that are orthogonal in this metric; none
    where there are not enough. In the plane the second follows from the first."""
    graph, found = graph_of(model), list[tuple[Sequence[Node], Sequence[Node]]]()
    for form in forms:
        slopes = [graph.diff(form, q) for q in model.q]
        raised = solution(graph, matrix, slopes)
        if raised is None:
            return []
        if all(is_zero(dot(graph, slopes, other)) for _, other in found):
            found.append((slopes, raised))
    if len(found) == 1 and len(model.q) == 2:
        (_, (w, u)) = found[0]
        across = without_denominators(graph, [-u, w])
        found.append((across, solution(graph, matrix, across) or []))
    return found if len(found) == len(model.q) else []


def dot(graph: Graph, one: Sequence[Node], other: Sequence[Node]) -> Node:
    """The sum of products of their components."""
    return graph.sum([(a * b, 1.0) for a, b in zip(one, other)])
