"""``@round_integrands``: integrands are known to the rounding errors of the terms that cancel in them.

The power of a force across the velocity, or of forces that balance, is a sum of terms that is 0: nothing but
their rounding errors, with which no series agrees, however short the step. Changes of the state do not show
how large these are where the terms cancel in every state. It follows from the sizes of the terms (N. J.
Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., sec. 3.1), once a step was not accepted.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from lagrange_cli.expression.node import Node, union
from lagrange_cli.mechanics.explicit import expanded
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.rounding import has_terms, size_where_moving
from lagrange_cli.mechanics.substitution import substituted
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Index, Real
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.double_double import DDReal, DoubleDouble
from lagrange_cli.native.numbers.kind import V, Written
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.rounding_errors import ROUND_INTEGRANDS
from lagrange_cli.native.stepping.step_size import ENDLESS

UNITS = 16.0
"""Errors of so many units of the last place are allowed: there are two integrands, and series of them."""


def in_doubles(
    residual: Residual, integrands: Mapping[int, Node], layout: StateLayout, constants: Constants,
    make: Callable[[Function], Emitter],
) -> str:  # fmt: skip
    """The text of the function for ``integrands``, by their numbers; none where no terms cancel."""

    def number(high: Real, low: Real | None = None) -> str:
        return (high if low is None else high + low).name

    return _text(residual, integrands, layout, constants, make, number, lambda f, value: Real(f, value))


def in_double_doubles(
    residual: Residual, integrands: Mapping[int, Node], layout: StateLayout, constants: Constants
) -> str:
    """The same in double-double."""
    given = residual, integrands, layout, constants
    return _text(*given, DoubleDouble, DDReal, lambda _, value: value.high)


def _text(
    residual: Residual, integrands: Mapping[int, Node], layout: StateLayout, constants: Constants,
    make: Callable[[Function], Written[V]], number: Callable[..., V],
    high: Callable[[Function, V], Real],
) -> str:  # fmt: skip
    sizes, accelerations = sizes_of(residual, integrands)
    if not sizes:
        return ""
    f = Function(ROUND_INTEGRANDS)
    kind, degrees = make(f), layout.degrees
    known: dict[Node, V | None] = {residual.model.time: number(*f.reals("t", "low"))}
    for first, symbols in ((0, residual.state_q), (degrees, residual.state_v)):
        known |= {one: kind.load("%state", first + k, layout.width) for k, one in enumerate(symbols)}
    for one, k in zip(accelerations, residual.unknown):
        known[one] = number(f.load("%rates", degrees + k))
    emit_values(kind, [*sizes.values()], known, constants)
    for i, size in sizes.items():
        value, row = kind.normalized(known[size]), layout.integrals.start + i
        if value is not None:
            keep(f, high(f, value), kind.unit, row)
    f.give()
    return f.text()


def sizes_of(residual: Residual, integrands: Mapping[int, Node]) -> tuple[dict[int, Node], Sequence[Node]]:
    """The sizes of the rounding errors of integrands in which terms may cancel, by their numbers, in units of
    the last place; and the accelerations in them. Those of forces of constraint are not known."""
    graph = residual.graph
    accelerations, nodes = expanded(residual, [*integrands.values()])
    momenta = {one.symbol: one.momentum for one in residual.cyclic_momenta}
    nodes = substituted(graph, nodes, momenta)
    moving = union((*residual.state_q, *residual.state_v, *accelerations, residual.model.time))
    unknown = union((*residual.multipliers, *(one.multiplier for one in residual.contacts)))
    sizes = {
        i: size_where_moving(graph, node, moving)
        for i, node in zip(integrands, nodes)
        if not node.symbols & unknown and has_terms(node, moving)
    }
    return sizes, accelerations


def keep(f: Function, size: Real, unit: float, row: Index, lanes: int = 1) -> None:
    """Keep errors of this size, of units that are so large, from their row on."""
    error, before = size * (UNITS * unit), f.load_row("%errors", row, lanes)
    larger = (error > before) & (error < ENDLESS)
    f.store_row(f.select(larger, error, before), "%errors", row)
