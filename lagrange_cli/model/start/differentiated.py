"""A system's holonomic constraints, differentiated once: at many places, as in the search for closures of
linkages, their values take far less time than with the expressions of rigid bodies built at each place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

from lagrange_cli.expression.arrays import evaluate
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.vocabulary import TIME
from lagrange_cli.model.constraints import built_constraints
from lagrange_cli.model.scope import Scope
from lagrange_cli.spec.spec import Spec


class Differentiated:
    """Those of ``spec``, in doubles; raises ``SpecError`` where they are not well written, ``TooLarge``."""

    def __init__(self, spec: Spec, parameters: Mapping[str, Any], coordinates: Sequence[str]) -> None:
        algebra = GraphAlgebra()
        scope, graph = Scope(spec, algebra), algebra.graph
        places = {symbol: k for k, symbol in enumerate(scope.q)}
        self.parameters, self.coordinates = parameters, coordinates
        self.values = [one.expression for one in built_constraints(scope) if one.holonomic]
        self.slopes = [graph.gradient(one, places) for one in self.values]

    def at(
        self, t: float, q: Sequence[float], chosen: Sequence[int]
    ) -> tuple[dict[int, float], dict[int, dict[int, float]]] | None:
        """The ``chosen`` constraints at a place, and their slopes; None where one has no finite value."""
        names = {**self.parameters, TIME: t, **dict(zip(self.coordinates, q))}
        nodes = [node for i in chosen for node in (self.values[i], *self.slopes[i].values())]
        found = iter([float(value) for value in evaluate(nodes, names)])
        values, rows = dict[int, float](), dict[int, dict[int, float]]()
        for i in chosen:
            values[i] = next(found)
            rows[i] = {k: next(found) for k in self.slopes[i]}
        numbers = (*values.values(), *(slope for row in rows.values() for slope in row.values()))
        return (values, rows) if all(map(isfinite, numbers)) else None
