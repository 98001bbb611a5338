"""The energy of a system of families at a state, by arrays: every expression once for all members alike."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from lagrange_cli.errors import TooLarge
from lagrange_cli.expression.graph_algebra import GraphAlgebra
from lagrange_cli.expression.index_arrays import Differ
from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.families.chains import ChainBuilder
from lagrange_cli.families.values import FamilyValues
from lagrange_cli.spec.content import names_of
from lagrange_cli.spec.spec import Spec


def energy(
    spec: Spec, parameters: Mapping[str, float], state: np.ndarray[Any, Any], t: float
) -> float | None:
    """The potential, or the Lagrangian where that is given, at a ``state`` q, v (2 n,); None where members do
    not have enough in common. It is nan where a function has no value."""
    try:
        builder = ChainBuilder(spec, GraphAlgebra())
        energies = [*spec.potential.values()] if spec.lagrangian is None else [spec.lagrangian]
        total = builder.graph.sum([(builder.of_root(one.tree, one.indices), 1.0) for one in energies])
        given = np.array([parameters[name] for name in names_of(spec.parameters)], dtype=np.float64)
        q, v = state.reshape(2, -1)
        with np.errstate(all="ignore"):
            return float(np.asarray(FamilyValues(builder, t, q, v, given).node(total)).reshape(-1)[0])
    except (Unsuited, Differ, ExpressionError, TooLarge, ArithmeticError):
        return None
