"""Where a step begins, and what all kinds of steps call: functions that clear and copy."""

from __future__ import annotations

from collections.abc import Sequence

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


def copy_function(layout: StateLayout, name: str = "copy", idle: Sequence[slice[int, int, None]] = ()) -> str:
    """``@copy(from, to)``: whole states, but for places that are ``idle``, in order."""
    f = Function(f"define internal void @{name}(ptr noalias %from, ptr noalias %to) #0")
    lanes, first = min(layout.width, LANES), 0
    for one in (*idle, slice(layout.memory, layout.memory)):
        start = one.start + -one.start % lanes
        if start > first:
            f.copy_rows(("%from", first), ("%to", first), start - first, lanes)
        first = max(first, one.stop - one.stop % lanes)
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
