"""Vectors that friction acts along, and that turn round within a step of rates at several states.

Friction along a vector u has the direction of u. Where u passes 0, or turns round close to 0, friction
reverses within a time |u|/|u'|, and the error that a step estimates may not show it, as where this is soon
after the step begins. Such a step is taken again, shorter, so that it ends before. What is left of the way to
where u is 0 becomes shorter from step to step, until it is so short that rates hardly change on it
(``stepping.stopping``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from lagrange_cli.native.guards import GuardRow, GuardRows
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import table
from lagrange_cli.native.llvm.vector import Integer, Real
from lagrange_cli.native.rates.places import HEAD
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.stopping import sliding
from lagrange_cli.records import dataclass

CLOSE = 0.25
"""A vector that turns round has come close to 0 if no more than this part of it is left then."""
LEAST = 0.125
"""A step in which u becomes shorter than this part of what it was may as well lead beyond 0: implicit steps
may end at 0 though they are too long, with friction in a direction that nothing has there."""
BEFORE = 0.75
"""The step ends at this part of the time until it has turned round."""
NUMBERS = 4
"""Numbers of each vector in the table."""


def parts_of(guard: GuardRow) -> range:
    """The rows whose rates are the parts of a vector."""
    return range(guard.beside, guard.beside + guard.parts)


@dataclass(frozen=True)
class Reversals:
    """Writes ``@reversed(constants, state, work, h)``, which looks at the vectors in a step of ``h``, whose
    values at ``points`` of it are in ``%work`` from ``values`` on, for all watched ``rows``: up to where
    the step is known."""

    guards: GuardRows
    layout: StateLayout
    values: int
    rows: Sequence[int]
    points: Sequence[float]

    @property
    def any(self) -> bool:
        """Whether there are such vectors."""
        return bool(sliding(self.guards))

    def tables(self) -> list[str]:
        """Of each vector its guard, its length and its first part among the rows, and the number of parts."""
        numbers, found = {row: k for k, row in enumerate(self.rows)}, list[int]()
        for j in sliding(self.guards):
            guard = self.guards.guards[j]
            found += [j, numbers[guard.row], numbers[guard.beside], guard.parts]
        return [table("watched_vectors", found)] if found else []

    def call(self, f: Function, h: Real) -> Real:
        """A call of it."""
        if not self.any:
            return h
        return f.call(Real, "reversed", *f.pointers("constants", "state", "work"), h)

    def functions(self) -> list[Function]:
        """The function, if there are such vectors."""
        if not self.any:
            return []
        f = Function(f"define internal double @reversed{HEAD}, double %h) #0")
        known = f.variable(Real(f, "%h"))
        with f.loop(0, len(sliding(self.guards)), tested=False) as i:
            numbers = [f.load_integer("@watched_vectors", i * NUMBERS + n) for n in range(NUMBERS)]
            mode = f.load("%state", numbers[0] + self.guards.mode(self.layout))
            with f.when(mode > 0.0):
                known.set(f.smaller(known.get(), self._turned(f, *numbers[1:])))
        f.give(known.get())
        return [f]

    def _value(self, f: Function, n: Integer | int, k: Integer) -> Real:
        place = (f.count(n) if isinstance(n, int) else n) * len(self.rows) + self.values
        return f.load("%work", place + k)

    def _turned(self, f: Function, length: Integer, first: Integer, count: Integer) -> Real:
        """Up to where a step is known that a vector turns round in."""

        def total(term: Callable[[Integer], Real]) -> Real:
            found = f.variable(f.constant(0.0))
            with f.loop(0, count) as k:
                found.set(found.get() + term(first + k))
            return found.get()

        h, zero, unit = Real(f, "%h"), f.constant(0.0), f.constant(1.0)
        size, known, time = self._value(f, 0, length), f.variable(h), f.variable(zero)
        own = total(lambda k: self._value(f, 0, k) * self._value(f, 0, k))
        before, aside = f.variable(unit), f.variable(zero)
        with f.section() as turned, f.loop(1, len(self.points), tested=False) as n:
            part = total(lambda k: self._value(f, n, k) * self._value(f, 0, k)) / own
            rest, t = f.variable(zero), f.load("@points", n) * h
            with f.loop(0, count) as k:
                one = self._value(f, n, first + k) - self._value(f, 0, first + k) * part
                rest.set(f.larger(rest.get(), f.magnitude(one)))
            with f.when(part <= LEAST):
                share = before.get() / (before.get() - part)
                left = f.fused(rest.get() - aside.get(), share, aside.get())
                crossed = f.fused(t - time.get(), share, time.get())
                known.set(f.select(left <= size * CLOSE, crossed * BEFORE, h))
                turned.leave()
            for kept, value in ((before, part), (aside, rest.get()), (time, t)):
                kept.set(value)
        return known.get()
