"""An equation in Taylor space: a list of operations on power series.

Every node of the graph becomes one of eight operations on Taylor coefficients x[k] (Jorba and Zou,
Experimental Mathematics 14, 2005, sec. 2). ``lowering`` makes the list, ``offsets`` says at which index
each is evaluated.
"""

from __future__ import annotations

from enum import Enum, auto

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.records import dataclass

FREE = -9
"""``order`` of a series that does not depend on q at all."""
UNBOUNDED = 99
"""``degree`` of a series that is not a short polynomial in t."""
SHORT = 2
"""Polynomials in t up to this degree are treated as such: their higher coefficients are never computed."""


class Op(Enum):
    """The operations on series."""

    COORDINATE = auto()  # data: index of q
    TIME = auto()
    MULTIPLIER = auto()  # unknown, found with the accelerations
    LINEAR = auto()  # data: (constant node, coefficient nodes); constants of the motion
    MULTIPLY = auto()
    POWER = auto()  # data: exponent node, a constant of the motion
    DERIVATIVE = auto()
    SELECT = auto()  # data: (what decides by its sign: a constant, or ``sources`` at first; the side of 0)
    PRIMITIVE = auto()  # argument: its rate; a function of ``sources``, or a quadrature from 0


@dataclass
class Series:
    """One power series: its operation, operands, and what is known of it before any number is."""

    op: Op
    arguments: tuple[int, ...] = ()
    data: object = None
    node: Node | None = None
    sources: tuple[int, ...] = ()
    level: int = FREE
    order: int = FREE
    degree: int = UNBOUNDED

    @property
    def corrected(self) -> bool:
        """Whether its newest coefficient depends on the acceleration of the same stage."""
        return self.order >= 0 and self.level + self.order == 2


@dataclass(frozen=True)
class SeriesProgram:
    """Series in an order in which each may be evaluated; indices refer to ``series``.

    ``coordinates[i]`` and ``velocities[i]`` are the series of q_i and q_dot_i, ``residual[i]`` of R_i,
    ``integrals[j]`` of the j-th quadrature; ``multipliers`` are those of constraints. The last ``stored``
    integrals are constants of the motion. The first series, ``motion`` of them, belong to the motion: the
    others are for integrals alone. The coordinates ``dependent``, by their places, follow from the others.
    """

    series: tuple[Series, ...]
    coordinates: tuple[int, ...]
    velocities: tuple[int, ...]
    residual: tuple[int, ...]
    integrals: tuple[int, ...]
    stored: int = 0
    multipliers: tuple[int, ...] = ()
    motion: int = 0
    dependent: tuple[int, ...] = ()

    @property
    def unknown(self) -> list[tuple[int, int]]:
        """The series of the coordinates that the equations are solved for, and of their velocities."""
        pairs = enumerate(zip(self.coordinates, self.velocities))
        return [pair for place, pair in pairs if place not in self.dependent]

    @property
    def state(self) -> tuple[int, ...]:
        """The series of the state's rows: q, v and the integrals."""
        return (*self.coordinates, *self.velocities, *self.integrals)

    @property
    def convolutions(self) -> int:
        """How many convolutions one order of the motion costs: the measure of a formulation.

        A product takes one, a reciprocal too, any other power takes two.
        """
        costly = [one for one in self.series[: self.motion] if one.op in (Op.MULTIPLY, Op.POWER)]
        lasting = [one for one in costly if all(self.series[a].degree == UNBOUNDED for a in one.arguments)]
        return sum(2 if one.op is Op.POWER and not reciprocal(one.data) else 1 for one in lasting)


def reciprocal(exponent: object) -> bool:
    """Whether a power is 1/x."""
    assert isinstance(exponent, Node)
    return bool(exponent.kind is Kind.NUMBER and exponent.data == -1.0)


def needs(one: Series) -> list[tuple[int, int]]:
    """(operand, how far ahead of this series' index the operand is needed)."""
    if one.op is Op.DERIVATIVE:
        return [(one.arguments[0], 1)]
    if one.op is Op.PRIMITIVE:
        return [(one.arguments[0], -1), *((source, 0) for source in one.sources)]
    return [(a, 0) for a in (*one.arguments, *one.sources)]
