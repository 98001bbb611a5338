"""Structure that a file does not state: combinations of coordinates that are cyclic, and parts that do not
act on each other."""

from __future__ import annotations

from collections.abc import Iterator

from lagrange_cli.expression.node import Node
from lagrange_cli.expression.text import joined
from lagrange_cli.mechanics.conserved.noether import Change, Noether
from lagrange_cli.mechanics.conserved.reasons import LONGEST, current_text, in_lowest_terms, term
from lagrange_cli.mechanics.conserved.separation import coordinates_together
from lagrange_cli.mechanics.omitted_work import in_short
from lagrange_cli.mechanics.relations import Relations
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.variables import graph_of
from lagrange_cli.model.model import Model

MOST = 40
"""Coordinates of the largest systems of which combinations are tried."""
WORTH = 2_500_000
"""Steps of work that they may take."""


def structure(residual: Residual) -> tuple[str, ...]:
    """A sentence for each fact."""
    model, found = residual.independent, list[str]()
    if len(model.q) <= MOST:
        graph_of(model).work.attempt(WORTH, lambda: found.extend(cyclic_combinations(model, residual.cyclic)))
    return (*found, *parts(model))


def cyclic_combinations(model: Model[Node], cyclic: tuple[str, ...]) -> Iterator[str]:
    """Coordinates that may be changed together, in a constant ratio, and the momenta that are conserved so;
    without coordinates that are ``cyclic`` by themselves."""
    graph, noether = graph_of(model), Noether(model)
    single = [k for k, name in enumerate(model.coordinates) if name not in cyclic]
    changes = [Change({k: graph.one}) for k in single]
    relations = Relations(graph, (model.time, *model.q, *model.v))
    for relation in relations.relations(noether.conditions(changes)):
        ratio = in_lowest_terms(graph, [relation[i] for i in sorted(relation)])
        sign = -1.0 if graph.split_coefficient(ratio[0])[0] < 0 else 1.0
        change = Change({single[i]: sign * factor for i, factor in zip(sorted(relation), ratio)})
        if len(change.directions) < 2 or not noether.keeps(change):
            continue
        names = joined([term(xi, model.coordinates[k]) for k, xi in change.directions.items()])
        if len(names) > LONGEST:
            names = f"a combination of {len(change.directions)} coordinates"
        yield f"{names} is cyclic, so that {current_text(model, change)} is conserved"


def parts(model: Model[Node]) -> Iterator[str]:
    """The parts of a system, where it has several."""
    groups = coordinates_together(model)
    if len(groups) > 1:
        sets = in_short([f"{{{in_short(group)}}}" for group in groups])
        yield f"parts that do not act on each other: {sets}"
