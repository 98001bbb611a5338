"""Rounding errors of rates: what no step is short enough to follow.

Where forces cancel, as those on what rests on a hard spring, rates are nothing but rounding. Errors of steps
that are estimated from differences of such rates do not become smaller with the step as they should, and may
stay above what a tolerance allows for ever. So a step that would be taken again, shorter, is first looked at
once more: by how much do its rates change where coordinates, velocities and the time change in their last
digits (``rounding_errors``)? What this alone explains is no error of the step. What rates depend on smoothly
changes half as much by half the change; jumps and poles do not, and stay errors. So do jumps that are nearer
than the changes: a change that is far larger changes no more there. In integrands, a force that holds the
motion is as large as what changes where it is let go.

The changes are in the state's memory at the rows of rates (``StateLayout.errors``), for one step.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer, Real
from lagrange_cli.native.rates.places import HEAD, LONGEST, ROUNDED, wide_of
from lagrange_cli.native.stepping.lengths import Row
from lagrange_cli.native.stepping.noise import keep_larger
from lagrange_cli.native.stepping.related import one_by_one, write_coupled, write_fastest
from lagrange_cli.native.stepping.rounding_errors import round_integrands, set_off
from lagrange_cli.native.stepping.step_size import ENDLESS
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.native.rates.nodes import RatesAtNodes
    from lagrange_cli.native.stepping.guards import GuardCode

SIZE = 2.0**-48
"""By what part coordinates and velocities are changed at most; coordinates near 0 by that part of how far
they go in the longest step: what is computed from them may be rounded by far more than they are."""
WIDER, GROWS = 2.0**12, 2.0**4
"""Where the state changes so many times as much, rates must change at least so many times as much: those that
do not have jumped already, as friction does where a velocity is 0 but for rounding."""
EXPLAINED = 2.0**-2
"""This part of what changes counts: the changes must stand out from the rounding that they are to measure."""
FAMILY = 16.0
"""Coordinates of a family are changed by at least so many times that part of how far the fastest of them
goes: depths of contacts between them are rounded as its place is."""
LATER = 0.5
"""And the time, by this part of that: by whole units of its rounding."""
MIXING, BITS = (2654435769, 2246822519, 3266489917), 2**32
"""Odd numbers of many bits, and the range of products of these that count."""
MOST_LINKS = 16
"""Errors are passed on by so many coordinates at most."""
WAYS = 3
"""They are in so many ways: in one of them rates may change less by chance."""


def scattered(row: Row, way: Integer) -> Real:
    """Numbers from -1 to 1, without a pattern: differences between neighbours, and differences of these, are
    as large as the numbers, so that those on which a chain's forces depend change, too."""
    number = row.beyond(0)
    mixed = number * MIXING[0] + row.f.splat(way * MIXING[1], number.lanes)
    for _ in range(2):
        mixed = (mixed * (mixed ^ MIXING[2])) & (BITS - 1)
    return mixed.to_real() * (2.0 / BITS) - 1.0


@dataclass(frozen=True)
class RateNoise:
    """Measures rounding errors in ``steps``. The rates where the step begins are in ``%work`` from ``begin``
    on, there is room for three numbers of each row from ``spare`` on, and for the modes of guards; the state
    at a node, which is left as it was, is at ``node``, and the length of the step that is
    tried, where forces or terms of integrands may cancel, at ``tried``."""

    steps: RatesAtNodes
    begin: int
    spare: int
    modes: int
    node: int
    tried: int

    @property
    def place(self) -> int:
        """How far behind velocities it is written how much of their rates is rounding."""
        return self.steps.state.errors

    @property
    def _ways(self) -> int:
        """Where it is written how far each coordinate is moved."""
        return self.spare + 2 * wide_of(self.steps.state)

    def functions(self) -> list[Function]:
        """What measures, and what that calls."""
        return [self._set_off(), self._rounding()]

    def _rounding(self) -> Function:
        """``@rounding(constants, state, work)``: measure."""
        f = Function(f"define internal void @rounding{HEAD}) #0")
        steps, lengths = self.steps, self.steps.lengths
        width, lanes, degrees = steps.state.width, lengths.lanes, lengths.degrees
        half, kept = (f.place("%work", self.spare + part * wide_of(steps.state), "double") for part in (0, 1))
        node = f.place("%work", self.node, "double")
        longest = f.load("%state", steps.state.carried_at + LONGEST)
        with lengths.each(f) as row:
            row.put(f.zero(lanes), "%work", self._ways)
        write_fastest(f, lengths, steps.related, self._ways, longest * FAMILY)
        f.copy_rows((node, 0), (kept, 0), width, lanes)
        with f.loop(0, WAYS, tested=False) as way:
            for size in (WIDER * SIZE, 0.5 * SIZE, SIZE):
                f.call(None, "set_off", *f.pointers("constants", "state", "work"), way, f.constant(size))
                rates = steps.rates(f)
                with lengths.velocities(f) as row:
                    change = row.at(rates, -degrees) - row.at("%work", self.begin - degrees)
                    if size > SIZE:
                        row.put(change, half)
                    elif size < SIZE:
                        grows = f.magnitude(row.at(half)) >= f.magnitude(change) * (2.0 * GROWS)
                        row.put(f.select(grows, change, f.splat(f.constant(ENDLESS), lanes)), half)
                    else:
                        parts = row.at(half) * EXPLAINED, change * EXPLAINED
                        keep_larger(row, self.place, *parts, partial(self._counts, row))
        for first, count in one_by_one(f, steps.related):
            self._where_none(f, first + degrees, count)
        places = ("%work", self.begin - degrees), ("%state", self.place)
        write_coupled(f, lengths, steps.given.coupled, *places, steps.bounds.rounding)
        if steps.given.cancelling:
            self._keep_terms(f, kept)
        if steps.given.static:
            f.call(None, "allow_static", *f.pointers("constants", "state"), f.place("%state", self.place))
            self._pass_on(f, half)
        if steps.guards and steps.guards.holding and steps.state.quadratures:
            self._let_go(f, steps.guards)
        f.copy_rows((kept, 0), (node, 0), width, lanes)
        steps.spend(f, f.constant(3.0 * WAYS))
        f.store(f.constant(1.0), "%state", steps.state.carried_at + ROUNDED)
        f.give()
        return f

    def _set_off(self) -> Function:
        """``@set_off(constants, state, work, way, size)``: rates at a state that differs by rounding errors
        of this size, relative to what moves."""
        f = Function(f"define internal void @set_off{HEAD}, i64 %way, double %size) #0")
        steps, lengths, now = self.steps, self.steps.lengths, self.steps.now(f)
        lanes, degrees = lengths.lanes, lengths.degrees
        way, size = Integer(f, "%way"), Real(f, "%size", 1)
        longest = lengths.wide(f, f.load("%state", steps.state.carried_at + LONGEST))
        with f.loop(0, steps.state.width, lanes, tested=False) as i:
            row = Row(lengths, f, i)
            moved = f.magnitude(row.at("%state", degrees)) * longest
            moved = f.larger(moved, row.at("%work", self._ways + degrees))
            own = row.at("%state")
            most = f.select(row.among(0, degrees), f.larger(f.magnitude(own), moved), own)
            change = most * scattered(row, way) * lengths.wide(f, size)
            change = f.select(row.among(0, 2 * degrees), change, f.zero(lanes))
            steps.put_state(f, i, change, row.at("%state", steps.state.width))
        steps.node(f, f.fused(size, now * LATER, now))
        f.give()
        return f

    def _keep_terms(self, f: Function, node: Pointer) -> None:
        """Keep the rounding errors of terms that cancel in integrands, at the beginning and at a node."""
        now, rates = self.steps.now(f), f.place("%work", self.begin - self.steps.lengths.degrees, "double")
        errors, later = f.place("%state", self.place, "double"), now + f.load("%work", self.tried)
        for state, t in ((f.pointer("%state"), now), (node, later)):
            round_integrands(f, (t, f.constant(0.0)), state, rates, errors)

    def _pass_on(self, f: Function, half: Pointer) -> None:
        """Let errors of rates move coordinates and velocities for the length of the step, and so change other
        rates, link by link: what follows something that moves by rounding errors moves by them, too. Where
        steps are short enough for what oscillates, no acceleration changes by more than the largest error."""
        steps, lengths, place = self.steps, self.steps.lengths, self.place
        width, lanes, degrees = steps.state.width, lengths.lanes, lengths.degrees
        h = lengths.wide(f, f.load("%work", self.tried))
        largest, endless = f.variable(f.zero(lanes)), f.splat(f.constant(ENDLESS), lanes)
        with lengths.velocities(f) as row:
            error = row.only(row.among(degrees, degrees), row.at("%state", place))
            largest.set(f.larger(error, largest.get()))
        most = lengths.wide(f, f.reduce("fmax", largest.get()))
        links = f.variable(f.count(0))
        with f.forever() as passing:
            grown = f.variable(f.never(lanes))
            for size in (0.5, 1.0):
                with f.loop(0, width, lanes, tested=False) as i:
                    row = Row(lengths, f, i)
                    speed = row.at("%state", place) * h
                    moved = f.select(row.among(0, degrees), row.at("%state", place + degrees) * h * h, speed)
                    change = row.only(row.among(0, 2 * degrees), moved * scattered(row, links.get()) * size)
                    steps.put_state(f, i, change, row.at("%state", width))
                rates, _ = steps.node(f, steps.now(f))
                with lengths.velocities(f) as row:
                    change = row.at(rates, -degrees) - row.at("%work", self.begin - degrees)
                    if size < 1.0:
                        row.put(change, half)
                        continue
                    before = row.at("%state", place)
                    bound = f.select(row.among(degrees, degrees), most, endless)
                    keep_larger(row, place, row.at(half), change, partial(self._counts, row), bound)
                    grown.set(grown.get() | (row.at("%state", place) > before * 2.0))
            steps.spend(f, f.constant(2.0))
            links.set(links.get() + 1)
            passing.repeat(f.any(grown.get()) & (links.get() < min(degrees, MOST_LINKS)))

    def _where_none(self, f: Function, first: Index, count: int) -> None:
        """Let the errors of so many velocities, where none was found, be the mean of the others: by chance no
        change may have been smooth."""
        lengths = self.steps.lengths
        start, last, zero = lengths.vector(first), first + count, f.zero(lengths.lanes)
        total, found = f.variable(zero), f.variable(zero)
        with lengths.each(f, start, last) as row:
            error = row.only(row.among(first, count), row.at("%state", self.place))
            total.set(total.get() + error)
            found.set(found.get() + (error > zero).to_real())
        size, known = (f.reduce("fadd", one.get(), f.constant(0.0)) for one in (total, found))
        mean = lengths.wide(f, size / f.larger(known, f.constant(1.0)))
        with lengths.each(f, start, last) as row:
            error = row.at("%state", self.place)
            none = row.among(first, count) & error.equals(0.0)
            row.put(f.select(none, mean, error), "%state", self.place)

    def _let_go(self, f: Function, guards: GuardCode) -> None:
        """The same of integrands, where nothing holds the motion."""
        steps, lengths, state = self.steps, self.steps.lengths, f.pointer("%state")
        first, lanes = steps.state.integrals.start, lengths.lanes
        kept = f.place("%work", self.modes, "double")
        with f.loop(0, guards.rows.count, tested=False) as j:
            f.store(f.load(guards.modes(f, state), j), kept, j)
        with f.loop(0, steps.state.width, lanes, tested=False) as i:
            row = Row(lengths, f, i)
            change = f.select(row.among(0, first), set_off(f, row, row.at("%state")), f.zero(lanes))
            steps.put_state(f, i, change, f.load_row(state, i + steps.state.width, lanes))
        for side in (1.0, -1.0):
            guards.let_go(f, state, f.constant(side))
            rates, _ = steps.node(f, steps.now(f))
            guards.hold(f, state, kept)
            with lengths.velocities(f) as row:
                change = f.magnitude(
                    row.at(rates, -lengths.degrees) - row.at("%work", self.begin - lengths.degrees)
                )
                before = row.at("%state", self.place)
                larger = row.among(first, steps.state.quadratures) & (change < ENDLESS)
                row.put(
                    f.select(larger, f.larger(change * (SIZE * EXPLAINED), before), before),
                    "%state",
                    self.place,
                )
        steps.spend(f, f.constant(2.0))

    def _counts(self, row: Row, steady: Bit) -> Bit:
        state = self.steps.state
        return steady & row.among(state.degrees, state.rows - state.degrees)

    def known(self, f: Function) -> Bit:
        """Whether it has been measured in this step."""
        return f.load("%state", self.steps.state.carried_at + ROUNDED) > 0.0

    def of(self, f: Function, i: Integer) -> Real:
        """How much of the rates from the ``i``-th on is rounding."""
        lengths, state = self.steps.lengths, self.steps.state
        numbers = Row(lengths, f, i).beyond(0)
        errors = f.load_row("%state", i + (self.place + state.degrees), lengths.lanes)
        return f.select(numbers < state.rows - state.degrees, errors, f.zero(lengths.lanes))

    def measure(self, f: Function) -> None:
        """A call of ``@rounding``."""
        f.call(None, "rounding", *f.pointers("constants", "state", "work"))

    def forget(self, f: Function) -> None:
        """Where the next step begins."""
        lengths, flag = self.steps.lengths, self.steps.state.carried_at + ROUNDED
        with f.when(self.known(f)):
            with lengths.each(f) as row:
                row.put(f.zero(lengths.lanes), "%state", self.place)
            f.store(f.constant(0.0), "%state", flag)
