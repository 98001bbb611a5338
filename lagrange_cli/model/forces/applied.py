"""``forces``: an applied force F(r, q, q_dot, t) on a particle, as a vector."""

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
    """F_i as it is given."""
    return Action(on_particles={name: scope.vector(force) for name, force in given.items()})


def unit(name: str, known: Quantities) -> Quantity:
    """Energy over the unit of the particle's position."""
    return known.energy / known.positions[name]
