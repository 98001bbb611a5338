"""The interface of a key of the system file for forces: how its entries act, and their unit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Generic, Protocol

from lagrange_cli.expression.algebra import E
from lagrange_cli.model.scope import Scope
from lagrange_cli.records import dataclass, field
from lagrange_cli.spec.spec import Expression

if TYPE_CHECKING:
    from lagrange_cli.model.quantity import Quantity


@dataclass(frozen=True)
class Action(Generic[E]):
    """What acts on the system besides its potential: Q_k = sum_i F_i . dr_i/dq_k + (given) - dD/dq_dot_k.

    ``on_particles`` has the components of F_i by particle, ``generalized`` what is given by coordinate,
    ``dissipation`` is Rayleigh's function D, None where there is none, and ``torques`` has the components of
    torques in space by body.
    """

    on_particles: Mapping[str, tuple[E, ...]] = field(default_factory=dict)
    generalized: Mapping[str, E] = field(default_factory=dict)
    dissipation: E | None = None
    torques: Mapping[str, tuple[E, ...]] = field(default_factory=dict)


class Quantities(Protocol):
    """The quantities whose units are known before those of the forces; members of a family have one."""

    @property
    def energy(self) -> Quantity: ...
    @property
    def time(self) -> Quantity: ...
    @property
    def coordinates(self) -> Mapping[str, Quantity]: ...
    @property
    def positions(self) -> Mapping[str, Quantity]: ...


class Law(Protocol):
    """A module of this package: one key of the system file."""

    def act(self, scope: Scope[E], given: Mapping[str, Expression]) -> Action[E]:
        """The action of the entries ``given``, by name."""

    def unit(self, name: str, known: Quantities) -> Quantity:
        """The quantity that the entry of that name, or those of a family, must be."""
