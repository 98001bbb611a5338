"""``Equations``: everything that ``lagrange equations`` can show of a system, as sympy expressions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy

from lagrange_cli.symbolic.order import Order


@dataclass(frozen=True)
class Equation:
    """One Euler-Lagrange equation, ``left = right``, in textbook form.

    ``right`` holds the terms without coordinates and velocities. ``factor``, made of parameters and
    numbers, has been divided out: d/dt dL/dv_k - dL/dq_k - Q_k = factor * (left - right).
    """

    left: sympy.Expr
    right: sympy.Expr
    factor: sympy.Expr


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
    """What happens where ``when`` becomes 0, as in ``model.model.Event``; ``changes`` are by name."""

    name: str
    when: sympy.Expr
    direction: int
    stops: bool
    changes: Mapping[str, sympy.Expr]


@dataclass(frozen=True)
class Equations:
    """The equations of motion of a system with n coordinates.

    ``q``, ``v``, ``a`` are the symbols of coordinates, velocities and accelerations (length n each).
    ``T`` and ``U`` are None where the file gives L itself. ``momenta``, ``equations``,
    ``generalized_forces`` and ``force`` have length n, ``mass_matrix`` n rows of n: ``mass_matrix`` a =
    ``force``. ``accelerations`` is None where the explicit solution is too long to print.
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
