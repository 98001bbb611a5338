"""What is conserved because parameters of the file are functions of others, as in b: sqrt(a**2 - c**2).

The equations have a symbol for each parameter, since --set may change any of them. Here those that have a
formula are definitions.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.text import text_of
from lagrange_cli.limits import whole
from lagrange_cli.mechanics.conservation import Conserved, conservation
from lagrange_cli.mechanics.conserved.found import Found, Symmetry
from lagrange_cli.mechanics.conserved.symmetries import symmetries
from lagrange_cli.mechanics.relations import Relations
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.build import build_model
from lagrange_cli.model.model import Model
from lagrange_cli.model.scope import Scope
from lagrange_cli.records import replace
from lagrange_cli.spec.content import by_name, groups_by_name


def related(
    model: Model[Node], known: Sequence[Conserved], found: Sequence[Symmetry]
) -> tuple[Symmetry, ...]:
    """The quantities that do not follow from those ``known`` (h and momenta) and ``found``; none where
    looking for them takes too much work."""
    work = graph_of(model).work
    return work.attempt(whole("work"), partial(_related, model, known, found)) or ()


def _related(
    model: Model[Node], known: Sequence[Conserved], found: Sequence[Symmetry]
) -> tuple[Symmetry, ...]:
    """The same, however much it takes."""
    graph, spec, algebra = graph_of(model), model.spec, model.algebra
    if spec is None or spec.families.get("parameters") or not isinstance(algebra, GraphAlgebra):
        return ()
    scope = Scope(spec, algebra)
    formulas = {one.name: one.value for one in spec.parameters if scope.scalar(one.value).symbols}
    if not formulas:
        return ()
    free = [one for one in spec.parameters if one.name not in formulas]
    definitions = by_name({**formulas, **groups_by_name(spec.definitions)})
    plain = replace(spec, parameters=free, definitions=definitions, order=(*formulas, *spec.order))
    values = Scope(plain, algebra).values
    nodes = {graph.symbol(name): values[name] for name in formulas}
    own = Found(model, known)
    energetics = own.noether.energetics
    given = [energetics.lagrangian, *energetics.applied, *(one.expression for one in model.constraints)]
    given += [one for event in model.events for one in (event.argument, *event.changes.values())]
    inside = {one for one in reachable(given) if one.kind is Kind.SYMBOL and one.data in model.parameters}
    if inside.isdisjoint(nodes) or not are_related(model, [nodes.get(one, one) for one in inside]):
        return ()
    other = build_model(plain, algebra)
    _, kept = conservation(other)
    search = Found(other, kept)
    lasting = [*own.lasting, *(one.node for one in found if not one.conserved.breaks)]
    before = [*substituted(graph, [*own.kept, *(one.node for one in found)], nodes)]
    unbroken = [*substituted(graph, lasting, nodes)]
    taken = {one.quantity for one in (*known, *(one.conserved for one in found))}
    where = ", ".join(f"{one.data} = {text_of(node)}" for one, node in nodes.items() if one in inside)
    new = list[Symmetry]()
    for one in symmetries(other, kept):
        lasts = not one.conserved.breaks
        if search.is_independent(one.node, unbroken if lasts else before):
            before.append(one.node)
            unbroken += [one.node] * lasts
            name = one.conserved.quantity
            while name in taken:
                name += "'"
            taken.add(name)
            because = f"{one.conserved.because}; only where {where}"
            new.append(replace(one, conserved=replace(one.conserved, quantity=name, because=because)))
    return tuple(new)


def are_related(model: Model[Node], nodes: Sequence[Node]) -> bool:
    """Whether functions of parameters obey a relation: their gradients are dependent."""
    graph = graph_of(model)
    base = [one for one in reachable(nodes) if one.kind is Kind.SYMBOL]
    columns = [[graph.diff(node, one) for one in base] for node in nodes]
    relations = Relations(graph, base)
    return any(relations.may_combine(columns[:k], columns[k]) for k in range(1, len(columns)))
