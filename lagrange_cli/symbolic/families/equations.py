"""``FamilyEquations``: what ``equations`` shows of a system of families, with their indices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy

from lagrange_cli.expression.number_table import NumberTable
from lagrange_cli.records import dataclass
from lagrange_cli.spec.spec import Family
from lagrange_cli.symbolic.equations import Changing, Conserved, Equation
from lagrange_cli.symbolic.families.chains import Path
from lagrange_cli.symbolic.families.linear import Block
from lagrange_cli.symbolic.families.lines import Line
from lagrange_cli.symbolic.families.places import NamedPlace
from lagrange_cli.symbolic.families.reactions import ReactionForm
from lagrange_cli.symbolic.indexed.conditions import Loop
from lagrange_cli.symbolic.order import Order


@dataclass(frozen=True)
class Change:
    """What an event sets: the ``symbol`` gets a ``value``, for all that the ``loops`` run through."""

    symbol: sympy.Symbol
    value: sympy.Expr
    loops: tuple[Loop, ...]


@dataclass(frozen=True)
class EventLine:
    """Events that are alike: the expression of the ``line`` becomes 0, as in ``spec.spec.Event``."""

    line: Line
    direction: int
    stops: bool
    changes: tuple[Change, ...]


@dataclass(frozen=True)
class FamilyEquations:
    """The equations of motion of a system of families. ``T`` and ``U`` are None where the file gives L.
    ``momenta``, ``accelerations``, ``forces`` (those outside L, where there are any) and ``equations`` have a
    line for members that are alike; the ``expression`` of an equation's line is its left side. Where members
    are coupled to others, as along chains and trees, there are no ``accelerations``. ``paths`` are those of
    trees."""

    name: str
    degrees_of_freedom: int
    sizes: Mapping[str, int]
    coordinates: tuple[Family, ...]
    tables: Mapping[str, NumberTable]
    """Those that indices are looked up in."""
    parameters: tuple[Family, ...]
    order: Order
    T: sympy.Expr | None
    U: sympy.Expr | None
    L: sympy.Expr
    h: sympy.Expr
    momenta: tuple[Line, ...]
    forces: tuple[Line, ...]
    equations: tuple[tuple[Line, Equation], ...]
    accelerations: tuple[Line, ...] | None
    blocks: tuple[Block, ...] | None
    """p = M v + b, where M couples members only to those with the same indices."""
    masses: tuple[Line, ...] | None
    """The entries of M in M a = f from the diagonal on: M_x[i,i], M_x_y[i,j]; others are 0. Where members are
    coupled to others, they are there only if they have been asked for (``with_matrix``)."""
    rates: tuple[Line, ...] | None
    """f, the forces but those of constraint, likewise."""
    conserved: tuple[Conserved, ...]
    changing: tuple[Changing, ...]
    paths: tuple[Path, ...]
    constraints: tuple[Line, ...]
    """Expressions that are 0, each with a multiplier."""
    nonholonomic: frozenset[str]
    """The names of the families of those that are on velocities."""
    pulls: tuple[Line, ...]
    """A^T lambda, the forces of constraint on coordinates, likewise."""
    driving: tuple[Line, ...] | None
    """dL/dq + Q + A^T lambda, the rates of momenta; None where they have not been asked for."""
    allowed: tuple[Line, ...]
    """The second derivatives of the constraints, and the first ones of those on velocities, which are 0, too.
    """
    places: tuple[NamedPlace, ...]
    """Where particles are, for places that are written by name, and their velocities and accelerations."""
    events: tuple[EventLine, ...] = ()
    first_order: int = 0
    """The number of coordinates without mass, whose equations of motion give their velocities."""
    reactions: ReactionForm | None = None
    """The forces of constraint on particles, where they have been asked for."""

    @property
    def diagonal(self) -> tuple[Line, ...] | None:
        """The diagonal of M by coordinate, where M is diagonal."""
        if self.blocks is None or any(len(one.families) > 1 for one in self.blocks):
            return None
        return tuple(line for one in self.blocks for line in one.lines(one.matrix[0]))

    @property
    def bound(self) -> Sequence[Family]:
        """The families of constraints."""
        return [*{one.family.name: one.family for one in self.constraints}.values()]
