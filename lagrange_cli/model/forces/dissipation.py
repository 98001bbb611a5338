"""``dissipation``: Rayleigh's function D, with Q_k = -dD/dq_dot_k (Goldstein, 3rd ed., sec. 1.5)."""

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
    """D as it is given."""
    (function,) = given.values()
    return Action(dissipation=scope.scalar(function))


def unit(name: str, known: Quantities) -> Quantity:
    """Power."""
    return known.energy / known.time
