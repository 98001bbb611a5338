"""Vectors that friction acts along, and that turn round within a step of rates at several states.

The length |u| of such a vector u is no polynomial in time where u passes 0, nor close to there: friction
reverses, and the error that a step estimates may not show it, as where u is 0 soon after the step begins. If
u turns round without turning aside, what a guard looks at is therefore the signed length s = u.e instead,
with the direction e in which u begins: s passes 0 where u does. If u turns aside on the way, friction turns
with it within a time |u|/|u'|, and the step is made shorter, so that it ends before.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from lagrange_cli.native.guards import GuardRow, GuardRows
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import table
from lagrange_cli.native.llvm.vector import Integer, Real
from lagrange_cli.native.rates.places import HEAD, LONGEST
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.native.rates.watching import Trials

ASIDE, ALLOWED = 2.0**-48, 0.25
"""What is left of u where it turns round is nothing up to this part of the velocities that it is made of, or
of what u loses in the longest step, or up to this part of the tolerance."""
RESOLVED = 2.0**-50
"""And up to this part of what it would lose in all the time, which is rounded."""
TURNS = 0.25
"""If what is left is a larger part of that in the beginning, u has just turned, as anything may."""
BEFORE = 0.75
"""The step ends at this part of the time until u has turned round."""
REST = 2.0**-16
"""This part is left of the time until u is 0, where its direction, and so what friction is, is not defined."""


def sliding(guards: GuardRows) -> list[int]:
    """The guards of vectors that friction acts along."""
    return [j for j in guards.vectors if guards.guards[j].multiplier]


def parts_of(guard: GuardRow) -> range:
    """The rows whose rates are the parts of a vector."""
    return range(guard.beside, guard.beside + guard.parts)


@dataclass(frozen=True)
class Reversals:
    """Writes ``@reversed(constants, state, work, h)``, which looks at the vectors in a step of ``h``, whose
    values at ``points`` of it are in ``%work`` from ``values`` on, for all watched ``rows``; it writes signed
    lengths in place of lengths, and returns up to where the step is known. There is ``room`` for values."""

    steps: Trials
    values: int
    room: int
    rows: Sequence[int]
    points: Sequence[float]

    @property
    def guards(self) -> GuardRows:
        """All guards."""
        assert self.steps.guards
        return self.steps.guards.rows

    @property
    def any(self) -> bool:
        """Whether there are such vectors."""
        return bool(sliding(self.guards))

    def tables(self) -> list[str]:
        """Of each vector its guard, its length and its first part among the rows, and the number of parts,
        and of all of these the coordinates."""
        if not self.any:
            return []
        numbers, found, pivots = {row: k for k, row in enumerate(self.rows)}, list[int](), list[int]()
        for j in sliding(self.guards):
            guard = self.guards.guards[j]
            found += [j, numbers[guard.row], numbers[guard.beside], guard.parts, len(pivots)]
            pivots += guard.pivots
        every = [int(bool(one.pivots)) for one in self.guards.guards]
        return [table("sliding", found), table("sliding_pivots", pivots), table("guard_vectors", every)]

    def until(self, f: Function, root: Real, which: Integer) -> Real:
        """Up to where a step may go that comes to the ``root`` of a guard."""
        if not self.any:
            return root
        mode = f.load("%state", which + self.guards.mode(self.steps.state))
        slides = f.load_integer("@guard_vectors", which).equals(1) & (mode > 0.0)
        return f.select(slides, root * (1.0 - REST), root)

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
            which, length, first, count, pivot = (f.load_integer("@sliding", i * 5 + n) for n in range(5))
            mode = f.load("%state", which + self.guards.mode(self.steps.state))
            own = self._sum(f, count, lambda k: self._value(f, 0, first + k) * self._value(f, 0, first + k))
            with f.when((mode > 0.0) & (own > 0.0)):
                known.set(f.smaller(known.get(), self._look(f, length, first, count, pivot, own)))
        f.give(known.get())
        return [f]

    def _value(self, f: Function, n: Integer | int, k: Integer) -> Real:
        return f.load("%work", self._place(f, n) + k)

    def _place(self, f: Function, n: Integer | int) -> Integer:
        return (f.count(n) if isinstance(n, int) else n) * len(self.rows) + self.values

    def _sum(self, f: Function, count: Integer, term: Callable[[Integer], Real]) -> Real:
        total = f.variable(f.constant(0.0))
        with f.loop(0, count) as k:
            total.set(total.get() + term(k))
        return total.get()

    def _look(
        self, f: Function, length: Integer, first: Integer, count: Integer, pivot: Integer, own: Real
    ) -> Real:
        """Up to where a step is known that a vector turns round in."""
        h, zero, unit, last = Real(f, "%h"), f.constant(0.0), f.constant(1.0), len(self.points)
        size = self._value(f, 0, length)
        before, aside, time = f.variable(unit), f.variable(zero), f.variable(zero)
        crossed, left, known = f.variable(h), f.variable(size), f.variable(h)
        with f.loop(1, last, tested=False) as n:
            dot = self._sum(f, count, lambda k: self._value(f, n, first + k) * self._value(f, 0, first + k))
            part, rest, t = dot / own, f.variable(zero), f.load("@points", n) * h
            with f.loop(0, count) as k:
                one = self._value(f, n, first + k) - self._value(f, 0, first + k) * part
                rest.set(f.larger(rest.get(), f.magnitude(one)))
            f.store(size * part, "%work", n + self.room)
            with f.when((part <= 0.0) & (before.get() > 0.0) & crossed.get().equals(h)):
                share = before.get() / (before.get() - part)
                crossed.set(f.fused(t - time.get(), share, time.get()))
                left.set(f.fused(rest.get() - aside.get(), share, aside.get()))
            for one, value in ((before, part), (aside, rest.get()), (time, t)):
                one.set(value)
        with f.when(left.get() <= size * TURNS):
            state, rate = self.steps.state, size / crossed.get()
            longest, t = f.load("%state", state.carried_at + LONGEST), f.load("%state", state.time)
            scale = f.variable(rate * longest)
            with f.loop(0, count) as k:
                row = f.load_integer("@sliding_pivots", pivot + k)
                speed = f.magnitude(f.load("%state", row + state.degrees))
                scale.set(f.larger(scale.get(), speed))
            part = max(ASIDE, self.steps.given.tolerance * ALLOWED)
            nothing = f.larger(scale.get() * part, f.magnitude(rate * t) * RESOLVED)
            with f.when(left.get() <= nothing), f.loop(1, last, tested=False) as n:
                f.store(f.load("%work", n + self.room), "%work", self._place(f, n) + length)
            with f.otherwise():
                known.set(crossed.get() * BEFORE)
        return known.get()
