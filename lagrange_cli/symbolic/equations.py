"""``Equations``: everything that ``lagrange equations`` can show of a system, as sympy expressions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING

import sympy

from lagrange_cli.records import dataclass, field
from lagrange_cli.symbolic.order import Order

if TYPE_CHECKING:
    from lagrange_cli.symbolic.reactions import Reaction


@dataclass(frozen=True)
class Equation:
    """One Euler-Lagrange equation, ``left = right``, in textbook form.

    ``right`` holds the terms without coordinates and velocities. ``factor``, made of parameters, numbers and
    exponentials of t, has been divided out: d/dt dL/dv_k - dL/dq_k - Q_k = factor * (left - right), with
    forces of constraint in Q_k, which stand on the right.
    """

    left: sympy.Expr
    right: sympy.Expr
    factor: sympy.Expr


@dataclass(frozen=True)
class Constraint:
    """``expression`` = 0, a function of q and t where it is ``holonomic``, else of velocities too.

    It says that sum_k ``slopes[k]`` q_dot_k + ``drift`` = 0 and sum_k ``slopes[k]`` q_ddot_k = ``rate``. Its
    generalized forces are ``multiplier``, a symbol, times ``slopes[k]``. (It is 0 where the constraint is the
    equation of motion of a coordinate without mass.) Applied forces that are linear in
    the multiplier, such as friction, are ``multiplier`` times ``pushes[k]`` (empty where there are none).
    Where they are not ``linear`` in all multipliers, they contain these. ``rate``, often the longest of all,
    is what ``derived_rate`` returns, derived when it is first asked for.
    """

    name: str
    expression: sympy.Expr
    holonomic: bool
    multiplier: sympy.Expr
    slopes: tuple[sympy.Expr, ...]
    drift: sympy.Expr
    derived_rate: Callable[[], sympy.Expr] = field(repr=False, compare=False)
    pushes: tuple[sympy.Expr, ...] = ()
    linear: bool = True

    @cached_property
    def rate(self) -> sympy.Expr:
        """What does not depend on accelerations in the second derivative, on the right."""
        return self.derived_rate()

    @property
    def acts(self) -> bool:
        """Whether it has forces."""
        return bool(self.multiplier != 0)

    def column(self, k: int) -> sympy.Expr:
        """The factor of the multiplier in the equation of coordinate k."""
        return self.slopes[k] + self.pushes[k] if self.pushes else self.slopes[k]


@dataclass(frozen=True)
class Conserved:
    """A conserved quantity and the reason in words, with formulas between backticks. It is conserved only
    between events if ``breaks`` are events that may change it."""

    quantity: str
    expression: sympy.Expr
    because: str
    breaks: tuple[str, ...] = ()


@dataclass(frozen=True)
class Changing:
    """A quantity that is often conserved but is not here: its rate of change and the reason, likewise."""

    quantity: str
    rate: sympy.Expr
    because: str


@dataclass(frozen=True)
class Event:
    """An event where ``when`` becomes 0, as in ``model.model.Event``; ``changes`` are by name."""

    name: str
    when: sympy.Expr
    direction: int
    stops: bool
    changes: Mapping[str, sympy.Expr]


@dataclass(frozen=True)
class Equations:
    """The equations of motion of a system with n coordinates.

    ``q``, ``v``, ``a`` are the symbols of coordinates, velocities and accelerations (length n each). ``T``
    and ``U`` are None where the file gives L itself. ``momenta``, ``equations``, ``generalized_forces`` (all
    but those of constraint) and ``force`` have length n, ``mass_matrix`` n rows of n: ``mass_matrix`` a =
    ``force`` + all that is linear in multipliers. ``accelerations`` and ``multipliers`` are the explicit
    solution of this and of the constraints, None where there is none, as ``unsolved`` says.
    """

    name: str
    coordinates: tuple[str, ...]
    parameters: Mapping[str, sympy.Expr]
    order: Order
    time: sympy.Expr
    q: tuple[sympy.Expr, ...]
    v: tuple[sympy.Expr, ...]
    a: tuple[sympy.Expr, ...]
    T: sympy.Expr | None
    U: sympy.Expr | None
    L: sympy.Expr
    momenta: tuple[sympy.Expr, ...]
    generalized_forces: tuple[sympy.Expr, ...]
    equations: tuple[Equation, ...]
    mass_matrix: tuple[tuple[sympy.Expr, ...], ...]
    force: tuple[sympy.Expr, ...]
    accelerations: tuple[sympy.Expr, ...] | None
    h: sympy.Expr
    conserved: tuple[Conserved, ...]
    changing: tuple[Changing, ...]
    events: tuple[Event, ...] = ()
    constraints: tuple[Constraint, ...] = ()
    multipliers: tuple[sympy.Expr, ...] | None = ()
    unsolved: str = ""
    degrees_of_freedom: int = 0
    first_order: int = 0
    reactions: tuple[Reaction, ...] = ()
    redundant: Mapping[str, sympy.Expr] = field(default_factory=dict)
    """Constraints that depend on others: they hold, and the equations go without their multipliers."""
    replaced: Mapping[str, sympy.Expr] = field(default_factory=dict)
    """Coordinates of the file, as functions of those that replace them."""
    unknown_reactions: Mapping[str, str] = field(default_factory=dict)
