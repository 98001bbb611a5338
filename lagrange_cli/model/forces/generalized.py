"""``generalized_forces``: Q_k(r, q, q_dot, t) of a coordinate."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from lagrange_cli.expression.algebra import E
from lagrange_cli.model.forces.law import Action, Quantities
from lagrange_cli.model.scope import Scope
from lagrange_cli.spec.spec import Expression

if TYPE_CHECKING:
    from lagrange_cli.model.quantity import Quantity


def act(scope: Scope[E], given: Mapping[str, Expression]) -> Action[E]:
    """Q_k as it is given."""
    return Action(generalized={name: scope.scalar(force) for name, force in given.items()})


def unit(name: str, known: Quantities) -> Quantity:
    """Energy over the unit of the coordinate."""
    return known.energy / known.coordinates[name]
