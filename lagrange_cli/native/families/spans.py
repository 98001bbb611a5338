"""Pieces of arrays and of loops, and what is done with their numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Real

Span: TypeAlias = "tuple[Integer, Integer]"
"""From one to before the other."""


def larger(f: Function, a: Integer, b: Integer) -> Integer:
    """The larger one."""
    return f.select(a > b, a, b)


def smaller(f: Function, a: Integer, b: Integer) -> Integer:
    """The smaller one."""
    return f.select(b > a, a, b)


def behind(f: Function, a: Integer, b: Integer) -> Integer:
    """a - b, or 0."""
    return f.select(a > b, a - b, f.count(0))


def in_vectors(f: Function, span: Span | int, write: Callable[[Integer, int], None]) -> None:
    """``write(i, lanes)`` for each i, of a span or of so many, eight together as long as there are eight."""
    first, last = (f.count(0), f.count(span)) if isinstance(span, int) else span
    whole = f.variable(first)
    with f.when(last > first):
        whole.set(first + ((last - first) & -LANES))
    with f.loop(first, whole.get(), LANES) as i:
        write(i, LANES)
    with f.loop(whole.get(), last) as i:
        write(i, 1)


def divided(f: Function, a: Real, inverse: Real, rest: Real) -> Real:
    """a / b, given 1/b in two parts."""
    return f.fused(a, inverse, a * rest)
