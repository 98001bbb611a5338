"""Where a proof of families has the disks of arrays: of q and v, and of totals.

Centres are side by side, and so are radii, a vector of each. Totals that cancel with others, or in which
something is singular, have series, too, as sums within members do (``stepping.cancelling``): these add up as
the totals themselves do, and so do their disks within larger disks of time, which tell what is beyond.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.node import reachable
from lagrange_cli.families.arrays import Array, Chain, Total
from lagrange_cli.mechanics.cancellation import singular_in
from lagrange_cli.native.families.arrangement import Arrangement
from lagrange_cli.native.families.evaluation import Evaluation, climb, room
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.families.member_series import InUnits
from lagrange_cli.native.families.tables import place_at
from lagrange_cli.native.families.vectors import Divisor
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Index, Integer, Pointer, Real
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.recurrences.disk import Disks
from lagrange_cli.native.recurrences.disk_arithmetic import Disk
from lagrange_cli.native.stepping.cancelling import Tail, rounding
from lagrange_cli.native.stepping.proof import Margins, radii
from lagrange_cli.native.stepping.state_series import combinations

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places as Table


def totals_of(arrangement: Arrangement) -> list[Total]:
    """The forces, and before them what they contain."""
    return needed([arrangement.forces], arrangement.slots, arrangement.lasting.fixed)


def followed(arrangement: Arrangement) -> frozenset[Array]:
    """The totals that have series: in which something is singular, which may cancel with others, or which
    those that have some are made of."""
    system, slots, totals = arrangement.system, arrangement.slots, totals_of(arrangement)
    variables = system.time.symbols | slots.symbols_of(system.q, system.v, *totals)
    nodes = [term.node for total in totals for term in total.terms]
    moving = [symbol for node in nodes for symbol, slot in slots.inside(node) if symbol.symbols & variables]
    asked = singular_in(nodes, variables)
    asked += [
        symbol for one in combinations(reachable(nodes), variables, moving).values() for symbol in one.symbols
    ]
    made = slots.made_of(asked)
    inside = {slot.array for node in made for _, slot in slots.inside(node)}
    return frozenset(total for total in totals if total in inside and total is not arrangement.forces)


class Places:
    """Where the doubles of a proof are, from the beginning of scratch on: those of arrays, and behind them
    series of sums, from ``end`` on."""

    def __init__(self, arrangement: Arrangement, first: int = 0) -> None:
        self.end, system = first, arrangement.system
        self.forces, self.followed = arrangement.forces, followed(arrangement)
        self.numbers, self.radii = dict[Array, int](), dict[Array, int]()
        self.series, self.farther, self.beyond = dict[Array, int](), dict[Array, int](), dict[Array, int]()
        """Of totals that have series: coefficients, order by order, their radii within larger disks of time,
        and those of what is beyond."""
        self.bounds = dict[Array, int]()
        """Lower bounds of the sizes of these."""
        for array in (system.q, system.v, *totals_of(arrangement)):
            if isinstance(array, Total):
                self.numbers[array] = self.take(room(array.count))
            if array is not self.forces:
                self.radii[array] = self.take(LANES * array.count)
            if array in self.followed:
                self.series[array] = self.take(room(array.count) * (arrangement.order + 1))
                for those in (self.farther, self.beyond, self.bounds):
                    those[array] = self.take(LANES * array.count)

    def take(self, doubles: int) -> int:
        """So many further ones."""
        self.end += doubles
        return self.end - doubles


class DiskArrays:
    """The disks of arrays in the function of a proof, whose doubles are at ``places``."""

    def __init__(self, f: Function, arrangement: Arrangement, places: Places, margins: Margins) -> None:
        self.f, self.arrangement, self.lengths, self.low = f, arrangement, margins.lengths, margins.low
        self.vectors, self.system = InUnits(f), arrangement.system
        self.base, self.followed, self.forces = (
            arrangement.scratch(self.vectors),
            places.followed,
            places.forces,
        )
        self.tail, self.time = Tail(f), radii(f, Real(f, "%h"))
        self.orders = arrangement.order - 1
        """Those to which the series of totals are known, as accelerations are."""
        self.numbers = self.pointers({**arrangement.places, **places.numbers})
        """Where the numbers of each array begin."""
        self.radii = self.pointers(places.radii)
        """Where the radii of disks around them do; there are none around constants."""
        self.series, self.far, self.beyond, self.bounds = map(
            self.pointers, (places.series, places.farther, places.beyond, places.bounds)
        )
        self.of_state = dict(zip((self.system.q, self.system.v), (0, self.lengths.degrees)))
        """Rows of the state."""
        self.numbers |= {array: f.place("%state", row, "double") for array, row in self.of_state.items()}

    def pointers(self, places: Mapping[Array, int]) -> dict[Array, Pointer]:
        """Addresses of places."""
        return {array: self.f.place(self.base, at, "double") for array, at in places.items()}

    def new(self) -> Disks:
        """Their arithmetic."""
        return Disks(self.f, Emitter(self.f), LANES)

    def at(self, table: Table, member: Integer) -> Integer:
        """What a table lists for a member."""
        if np.all(table == table[0]):
            return self.f.count(int(table[0]))
        if np.array_equal(table, np.arange(len(table)) + table[0]):
            return member + int(table[0]) if table[0] else member
        first = self.arrangement.tables.of_array(table)
        return place_at(self.f, member + first if first else member)

    def disk(self, array: Array, i: Integer) -> Disk:
        """A number of an array."""
        centre = self.f.load(self.numbers[array], i).name
        if array not in self.radii:
            return Disk(centre)
        bound = partial(self.row, self.bounds, array, i) if array in self.bounds else None
        return Disk(centre, self.row(self.radii, array, i), bound)

    def farther(self, total: Array, i: Integer) -> Disk:
        """A total within larger disks of time."""
        return Disk(self.f.load(self.numbers[total], i).name, self.row(self.far, total, i))

    def row(self, those: Mapping[Array, Pointer], array: Array, i: Integer) -> Real:
        """A vector of a number."""
        return self.f.load_row(those[array], i * LANES, LANES)

    # series

    def speed(self, i: Integer, m: Integer) -> Real:
        """Coefficient ``m`` of a velocity."""
        lengths = self.lengths
        return self.f.load("%work", m * lengths.term + i + (lengths.first + lengths.degrees))

    def place(self, i: Integer, m: Integer) -> Real:
        """Coefficient ``m`` of a coordinate."""
        if self.lengths.followers:
            return self.speed(i, m - 1) / m.to_real()
        return self.f.load("%work", m * self.lengths.term + i + self.lengths.first)

    def coefficient(self, array: Array, i: Integer, m: Integer) -> Real:
        """Coefficient ``m`` of a number."""
        if array in self.of_state:
            return (self.place if array is self.system.q else self.speed)(i, m)
        return self.f.load(self.series[array], m * room(array.count) + i)

    def late(self, array: Array, i: Integer) -> Real:
        """The low part of a coordinate or a velocity."""
        return self.f.load("%state", i + (self.low + self.of_state[array]))

    def of_order(self, k: Index | None) -> Evaluation:
        """What finds coefficients ``k`` of what has series, or low parts if it is None, and what lasts."""
        f, lengths, (q, v) = self.f, self.lengths, self.of_state
        arrays, scales = dict(self.numbers), dict[Array, Divisor]()
        if k is None:
            arrays |= {one: f.place(self.numbers[one], self.low, "double") for one in (q, v)}
        elif k != 0:
            arrays[q] = f.place("%work", k * lengths.term + lengths.first, "double")
            arrays[v] = f.place(arrays[q], lengths.degrees, "double")
            if lengths.followers:
                arrays[q] = f.place(arrays[v], -lengths.term, "double")
                scales = {} if k == 1 else {q: self.vectors.divisor(k, 0)}
        order = self.arrangement.order if k is None else k  # where there is nothing
        for total, series in self.series.items():
            arrays[total] = f.place(series, order * room(total.count), "double")
        time = self.vectors.operand(self.vectors.splat(Real(f, "%t", 1), LANES))
        given = self.arrangement.slots, arrays.__getitem__, self.arrangement.tables
        return Evaluation(self.vectors, *given, {self.system.time: time}, scales)

    # totals

    def clear(self, total: Total) -> None:
        """Begin with 0."""
        f = self.f
        with f.loop(0, total.count, tested=False) as i:
            f.store(f.constant(0.0), self.numbers[total], i)
            for those in (self.radii, self.far, self.bounds):
                if total in those:
                    f.store_row(f.zero(LANES), those[total], i * LANES)
        if total in self.series:
            with f.loop(0, room(total.count) * (self.arrangement.order + 1), LANES, tested=False) as i:
                f.store_row(f.zero(LANES), self.series[total], i)

    def add(self, disks: Disks, value: Disk | None, total: Total, i: Integer) -> None:
        """Add a disk."""
        if value is not None:
            found = disks.add(self.disk(total, i), value) or disks.constant(0)
            self.f.store(Real(self.f, disks.centres.written(found.centre), 1), self.numbers[total], i)
            self.f.store_row(disks.radius(found), self.radii[total], i * LANES)
            if total in self.bounds:
                bound = disks.positive(found.bound() or disks.all(0.0))
                self.f.store_row(bound, self.bounds[total], i * LANES)

    def add_series(
        self, disks: Disks, far: Disk, total: Total, i: Integer, series: Callable[[Integer], Real]
    ) -> None:
        """Add the disk of a term within larger disks of time, before its own, and its series."""
        f = self.f
        reached = disks.add(self.farther(total, i), far) or disks.constant(0)
        f.store_row(disks.radius(reached), self.far[total], i * LANES)
        with f.loop(0, self.orders, tested=False) as m:
            at = m * room(total.count) + i
            f.store(f.load(self.series[total], at) + series(m), self.series[total], at)

    def add_up(self, chain: Chain) -> None:
        """Add the terms of a chain up along it."""
        assert chain.tree is not None
        with climb(self.f, self.arrangement.tables, chain.tree, back=chain.back) as (member, parent, hangs):
            source, target = (member, parent) if chain.back else (parent, member)
            with self.f.when(hangs):
                disks = self.new()
                if chain in self.series:
                    series = partial(self.coefficient, chain, source)
                    self.add_series(disks, self.farther(chain, source), chain, target, series)
                self.add(disks, self.disk(chain, source), chain, target)

    def finish(self, total: Total) -> None:
        """Enclose a total by its series: all terms have been added."""
        f = self.f
        r = self.time * f.splat(1.0 / Real(f, "%unit"), LANES)
        with f.loop(0, total.count, tested=False) as i:
            disks, extent = self.new(), f.variable(f.zero(LANES))
            with f.loop(1, self.orders, tested=False) as passed:
                size = f.magnitude(self.coefficient(total, i, f.count(self.orders) - passed))
                extent.set((extent.get() + f.splat(size, LANES)) * r)
            disk = self.disk(total, i)
            beyond = self.tail.of(self.row(self.far, total, i)) + rounding(disks, disk)
            f.store_row(beyond, self.beyond[total], i * LANES)
            radius = disks.lesser(disks.radius(disk), extent.get() + beyond)
            f.store_row(radius, self.radii[total], i * LANES)
