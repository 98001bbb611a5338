"""Where a step begins, and what all kinds of steps call: functions that clear and copy."""

from __future__ import annotations

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Real
from lagrange_cli.native.state import LANES, StateLayout
from lagrange_cli.records import dataclass

STRAIGHT = 4
"""So close to a critical point that the coefficients from here on consist of rounding errors only."""


@dataclass(frozen=True)
class Now:
    """Where a step begins: t and its low part, the length of the step before it, and the unit of time of the
    series' coefficients."""

    t: Real
    low: Real
    previous: Real
    unit: Real


def copy_function(layout: StateLayout) -> str:
    """``@copy(from, to)``: whole states."""
    f = Function("define internal void @copy(ptr noalias %from, ptr noalias %to) #0")
    f.copy_rows(("%from", 0), ("%to", 0), layout.memory, min(layout.width, LANES))
    f.give()
    return f.text()


def clear_function() -> str:
    """``@clear(place, count)``: set vectors to 0. (Infinities and nan would spread: the sums also contain
    unused coefficients, times 0.)"""
    f = Function("define internal void @clear(ptr noalias %place, i64 %count) #0")
    with f.loop(0, Integer(f, "%count"), LANES, tested=False) as i:
        f.store_row(f.zero(LANES), "%place", i)
    f.give()
    return f.text()
