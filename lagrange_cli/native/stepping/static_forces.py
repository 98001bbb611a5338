"""``@allow_static``: accelerations are known to the rounding errors of the forces that cancel in them.

At rest in equilibrium, or where a force has just begun as 1 - cos(t) does, accelerations are differences of
much larger terms, and nothing but their rounding errors, while all that moves is smaller still. No series
agrees with these, however short the step. How large they are is computed from the sizes of the terms (N. J.
Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., sec. 3.1), once a step was not accepted.
"""

from __future__ import annotations

from collections.abc import Callable

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.mechanics.static_forces import rounding_at_rest
from lagrange_cli.native.linear.blocks import all_unrolled
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Real
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.numbers.double_double import DoubleDouble
from lagrange_cli.native.numbers.kind import V, Written
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values
from lagrange_cli.native.recurrences.matrix import factored, solved
from lagrange_cli.native.state import Clock, StateLayout
from lagrange_cli.native.stepping.lengths import Lengths

HEAD = "define internal void @allow_static(ptr %constants, ptr %state, ptr %errors) #0"
FEW = 16
"""Equations of a larger system would take long to compile."""
UNITS = 16.0
"""Errors of so many units of the last place are allowed: there are two accelerations, and series of them."""


def in_doubles(
    residual: Residual, layout: StateLayout, constants: Constants, make: Callable[[Function], Emitter]
) -> str:
    """The text of the function, which adds to the ``%errors`` at the rows of velocities; none where no forces
    cancel."""
    return _text(residual, layout, constants, make, lambda f, value: Real(f, value))


def in_double_doubles(residual: Residual, layout: StateLayout, constants: Constants) -> str:
    """The same in double-double."""
    return _text(residual, layout, constants, DoubleDouble, lambda _, value: value.high)


def _text(
    residual: Residual, layout: StateLayout, constants: Constants, make: Callable[[Function], Written[V]],
    high: Callable[[Function, V], Real],
) -> str:  # fmt: skip
    model, own = residual.model, residual.unpushed
    if len(residual.mass_matrix) > FEW or residual.cyclic_momenta:
        return ""
    sizes = rounding_at_rest(residual)
    if not sizes:
        return ""
    f = Function(HEAD)
    kind, rows, low = make(f), residual.unknown, layout.at(Clock.TIME_LOW) - layout.time
    known: dict[Node, V | None] = {model.time: kind.load("%state", layout.time, low)}
    for first, symbols in ((0, model.q), (layout.degrees, model.v)):
        known |= {one: kind.load("%state", first + k, layout.width) for one, k in zip(symbols, rows)}
    emit_values(kind, [*sizes], known, constants)
    factors, regular = factored(own, all_unrolled(kind), known, constants)
    with f.when(Bit(f, regular)):
        both = []
        for sign in (1.0, -1.0):  # what one choice cancels in the accelerations, the other does not
            errors = [
                kind.mul(kind.number(UNITS * kind.unit * sign**k), known[size])
                for k, size in enumerate(sizes)
            ]
            none = [None] * (len(residual.mass_matrix) - len(sizes))
            both.append(solved(own, factors, [*errors, *none], kind.one))
        for k, *found in zip(rows, *both):
            larger = kind.normalized(kind.larger(*map(kind.magnitude, found)))
            if larger is not None:
                place = layout.degrees + k
                f.store(f.load("%errors", place) + high(f, larger), "%errors", place)
    f.give()
    return f.text()


def creeping(lengths: Lengths, nothing_much: float) -> Function:
    """``@creeps(work, h)``: whether no velocity changes by more than ``nothing_much`` within ``h``. Where a
    force begins, velocities are as small as powers of the time since then, and steps by their series, though
    hardly anything moves in them, would be shorter than time resolves."""
    f = Function("define internal BIT @creeps(ptr %work, REAL %h) #0", lengths.motions)
    h, most = lengths.wide(f, Real(f, "%h", lengths.motions)), f.variable(f.zero(lengths.lanes))
    with lengths.velocities(f) as row:
        change = f.zero(lengths.lanes)
        for one in reversed(row.series().terms(1, lengths.top + 1)):
            change = (change + f.magnitude(one)) * h
        most.set(f.larger(most.get(), row.only_velocities(change)))
    f.give(lengths.gather(f, "fmax", most.get()) <= nothing_much)
    return f
