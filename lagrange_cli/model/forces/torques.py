"""``torques``: a torque on a rigid body, as a vector in space."""

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
    """The torque as it is given."""
    return Action(torques={name: scope.vector(torque) for name, torque in given.items()})


def unit(name: str, known: Quantities) -> Quantity:
    """Energy."""
    return known.energy
