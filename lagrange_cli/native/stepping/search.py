"""Searches for a place in an interval, written into a function."""

from __future__ import annotations

from collections.abc import Callable

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Real

BISECTIONS = 50
"""To the resolution of doubles, in a sixteenth of a step."""
MAJOR = (5**0.5 - 1) / 2
"""The larger part of the golden section,"""
SECTIONS = 70
"""and how often it is repeated: to the resolution of doubles."""


def crossing(f: Function, negative: Callable[[Real], Bit], start: Real, length: Real) -> Real:
    """The zero of something within ``length`` after ``start``, where its signs differ."""
    place, piece = f.variable(start), f.variable(length)
    begins = negative(start)
    with f.loop(0, BISECTIONS, tested=False):
        piece.set(piece.get() * 0.5)
        middle = place.get() + piece.get()
        place.set(f.select(negative(middle).compared("eq", begins), middle, place.get()))
    return place.get() + piece.get()


def greatest(f: Function, value: Callable[[Real], Real], start: Real, length: Real) -> Real:
    """The place within ``length`` after ``start`` where ``value`` is greatest, if it has one maximum there,
    by golden-section search."""
    low, wide = f.variable(start), f.variable(length)
    x1, x2 = (f.variable(start + length * part) for part in (1 - MAJOR, MAJOR))
    f1, f2 = (f.variable(value(x.get())) for x in (x1, x2))
    with f.loop(0, SECTIONS, tested=False):
        left = f1.get() > f2.get()
        low.set(f.select(left, low.get(), x1.get()))
        wide.set(wide.get() * MAJOR)
        x = low.get() + wide.get() * f.select(left, f.constant(1 - MAJOR), f.constant(MAJOR))
        for one, other, new in ((x1, x2, x), (f1, f2, value(x))):
            a, b = one.get(), other.get()
            one.set(f.select(left, new, b))
            other.set(f.select(left, a, new))
    return f.select(f1.get() > f2.get(), x1.get(), x2.get())
