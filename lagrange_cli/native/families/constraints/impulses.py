"""``@push``: the impulses of the forces of constraint after a simple action (``integrate.impacts.impulses``).

An action sets velocities, which stay, as if these coordinates had infinite masses. The others change as
little as possible in the metric of the masses, so that constraints hold again: with W for 1/M, and 0 of what
was set,

    A W A^T mu = -g,    dv = W A^T mu.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.families.arrays import Array, Source, Term, Total
from lagrange_cli.families.contacts import Coupled
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.constraints.dense import SolvingTables
from lagrange_cli.native.families.constraints.jet import saddle_of, solve
from lagrange_cli.native.families.constraints.moves import Offsets
from lagrange_cli.native.families.constraints.projection import add_to_state, write_residuals
from lagrange_cli.native.families.evaluation import Evaluation
from lagrange_cli.native.families.lasting import Lasting
from lagrange_cli.native.families.tables import place_at
from lagrange_cli.native.guards import DONE, LEFT
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.state import Clock, StateLayout, vectors_of
from lagrange_cli.native.stepping.actions import PUSH
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places

HEAD = f"define i64 @{PUSH}(ptr %constants, ptr %state, ptr %results, ptr %speeds, i64 %event) #0"
PASSES = 2
"""How often impulses are computed: what rounding leaves of the first ones, too."""
EXACT = 2.0**-30
"""The second ones are at most this part of the first ones."""
MOST = 6
"""How often the state is moved back to the constraints at most, until it is there to the last digit."""


class Impulses(Offsets):
    """What is computed of them, as totals."""

    moved: Array

    def __init__(self, system: FamilySystem, lasting: Lasting) -> None:
        super().__init__(system, lasting)
        zeros = dict.fromkeys(range(len(self.bounds)), self.graph.zero)
        self.right = self.of_bounds(zeros, less=self.off_speeds)
        self.speeds = self.on_coordinates(None, self.multipliers)
        self.approaching = self.rates_of_contacts()
        self.kept = Array(Source.TOTAL, 4 * system.q.count)
        """The state before, with its low parts."""

    def rates_of_contacts(self) -> Total:
        """The rates of the arguments of contacts."""
        contact = self.system.contact
        assert isinstance(contact, Coupled)
        bounds = [one for one in contact.bonds.bounds if one.numbers[0] >= contact.fixed]
        terms = [Term(one.domain, self.rate(one.node), one.numbers - contact.fixed) for one in bounds]
        return self.total(contact.count, terms)

    @cached_property
    def inverses(self) -> Array:
        """W."""
        return Array(Source.TOTAL, self.system.q.count)

    @property
    def arrays(self) -> Sequence[Array]:
        found = [self.inverses, self.square, self.right, self.multipliers, self.speeds]
        return [*super().arrays, *found, self.approaching, self.kept]


@dataclass(frozen=True)
class Impulse:
    """Writes the function of the ``evaluation``: it sets what an event sets, and lets the constraints act;
    ``LEFT`` if these are not met then to the last digit, and nothing has changed. Actions set what is
    ``changed``: by event, the place among q and q_dot (2, values). It gives the rates of contacts' arguments
    then, at %speeds."""

    moves: Impulses
    evaluation: Evaluation
    layout: StateLayout
    tabled: SolvingTables
    changed: Places
    scratch: Pointer

    def text(self) -> str:
        """The function's text."""
        f, evaluation, where = self.evaluation.f, self.evaluation, self.evaluation.where
        moves, layout, degrees = self.moves, self.layout, self.layout.degrees
        state, kept = f.pointer("%state"), where(moves.kept)
        self._copy(state, kept, (0, layout.width), (0, 2 * degrees))
        inverses = where(moves.lasting.inverses), where(moves.inverses)
        with f.loop(0, vectors_of(degrees), tested=False) as b:
            f.store_row(f.load_row(inverses[0], b * LANES, LANES), inverses[1], b * LANES)
        self._set()
        sound, sizes = f.variable(Bit(f, "true", 1)), [f.variable(f.constant(0.0)) for _ in range(PASSES)]
        saddle = saddle_of(evaluation.vectors, self.tabled, self.scratch, 0)
        with f.loop(0, PASSES, tested=False) as k:
            write_residuals(moves, evaluation, f.variable(Bit(f, "true", 1)))
            with f.when(k.equals(0)):
                evaluation.write([moves.square])
                saddle.factor(where(moves.square), moves.placed(self.tabled), sound)
            evaluation.write([moves.right])
            solve(saddle, where(moves.right), where(moves.multipliers))
            evaluation.write([moves.speeds])
            sizes[0].set(f.select(k.equals(0), sizes[0].get(), sizes[1].get()))
            sizes[1].set(self._largest(where(moves.speeds)))
            add_to_state(evaluation.vectors, where(moves.speeds), degrees, layout)
        good = sound.get() & (sizes[1].get() <= sizes[0].get() * EXACT)
        with f.when(good):
            sound.set(self._met(f))
        with f.when(~(good & sound.get())):
            self._copy(kept, state, (0, 2 * degrees), (0, layout.width))
            f.give(f.count(LEFT))
        evaluation.write([moves.approaching])
        with f.loop(0, moves.approaching.count, tested=False) as i:
            f.store(f.load(where(moves.approaching), i), f.pointer("%speeds"), i)
        f.give(f.count(DONE))
        return f.text()

    def _copy(self, source: Pointer, to: Pointer, first: tuple[int, int], second: tuple[int, int]) -> None:
        """Copy coordinates and velocities, then their low parts, from and to these places."""
        for origin, target in zip(first, second):
            self.evaluation.f.copy_rows((source, origin), (to, target), 2 * self.layout.degrees, 1)

    def _set(self) -> None:
        """Set what the event sets: W is 0 of these."""
        f, layout, state, tables = self.evaluation.f, self.layout, "%state", self.evaluation.tables
        events, places = self.changed
        order = np.argsort(events, kind="stable")
        starts = np.searchsorted(events[order], np.arange(int(events.max(initial=0)) + 2))
        first = tables.of_array(starts)
        listed, rows = tables.of_array(order), tables.of_array(places[order])
        begin, end = (place_at(f, Integer(f, "%event") + (first + ahead)) for ahead in range(2))
        with f.loop(begin, end) as k:
            row = place_at(f, k + rows)
            f.store(f.load("%results", place_at(f, k + listed)), state, row)
            f.store(f.constant(0.0), state, row + layout.width)
            f.store(f.constant(0.0), self.evaluation.where(self.moves.inverses), row - layout.degrees)

    def _largest(self, changes: Pointer) -> Real:
        """The largest magnitude of changes of velocities; no number if one of them is none."""
        f = self.evaluation.f
        found = f.variable(f.constant(0.0))
        with f.loop(0, self.layout.degrees, tested=False) as i:
            size = f.magnitude(f.load(changes, i))
            found.set(f.select(size <= found.get(), found.get(), size))
        return found.get()

    def _met(self, f: Function) -> Bit:
        """Move the state to the constraints, as far as rounding lets it; whether it is there."""
        place, done = self.layout.at(Clock.PROJECTIONS), f.variable(Bit(f, "false", 1))
        count = f.load("%state", place)
        with f.loop(0, MOST, tested=False), f.when(~done.get()):
            before = f.load("%state", place)
            f.call(None, "project", f.pointer("%constants"), f.pointer("%state"))
            done.set(f.load("%state", place).equals(before))
        f.store(count, "%state", place)
        return done.get()
