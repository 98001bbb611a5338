"""``@proven`` of systems of families (see ``stepping.proof``): a loop over the members encloses their terms.

M is diagonal and constant, so that all that is left of the equations is left of the forces. The totals
that these contain are enclosed first: the centres of their disks are side by side, and so are their radii, a
vector of each. The terms of the forces are looked at one by one, and their parts of the defect are added up
for each coordinate.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from lagrange_cli.expression.node import Node, union
from lagrange_cli.families.arrays import Array, Chain, Slot, Total
from lagrange_cli.mechanics.defect import terms
from lagrange_cli.native.families.arrangement import Arrangement
from lagrange_cli.native.families.evaluation import climb, room
from lagrange_cli.native.families.loops import Loop, loops, needed
from lagrange_cli.native.families.tables import place_at
from lagrange_cli.native.families.vectors import DoubleVectors
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer, Pointer, Real
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.recurrences.disk import Disks
from lagrange_cli.native.recurrences.disk_arithmetic import Disk
from lagrange_cli.native.recurrences.evaluation import emit_values
from lagrange_cli.native.stepping.cancelling import StateSeries, Sums
from lagrange_cli.native.stepping.proof import (
    HEAD,
    WIDER,
    Margins,
    Proof,
    exceeded,
    expected,
    least,
    radii,
    weights_of,
)
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.expression.index_arrays import Places


@dataclass(frozen=True)
class FamilyProof(Proof):
    """The proof of a system whose arrays are where ``arrangement`` says. Those of the proof are behind them,
    from ``first`` on: radii of q and v; centres and radii of totals; the defects of the forces."""

    arrangement: Arrangement
    first: int
    margins: Margins

    def function(self) -> Function:
        return _Writer(self).written()


def proof_room(arrangement: Arrangement) -> int:
    """The doubles that a proof takes."""
    return max(end for _, end in places_of(arrangement, 0).values())


def totals_of(arrangement: Arrangement) -> list[Total]:
    """The forces, and before them what they contain."""
    return needed([arrangement.forces], arrangement.slots, arrangement.lasting.fixed)


def places_of(arrangement: Arrangement, at: int) -> dict[Array, tuple[int, int]]:
    """Where the numbers of arrays begin, if there are any, and where their radii end, from ``at`` on."""
    found, system = dict[Array, tuple[int, int]](), arrangement.system
    for array in (system.q, system.v, *totals_of(arrangement)):
        numbers = 0 if array in (system.q, system.v) else room(array.count)
        size = 0 if array is arrangement.forces else LANES * array.count
        found[array] = at, at + numbers + size
        at += numbers + size
    return found


class _Writer:
    """The text of the function."""

    def __init__(self, proof: FamilyProof) -> None:
        self.margins, self.arrangement = proof.margins, proof.arrangement
        self.lengths, self.system = proof.margins.lengths, proof.arrangement.system
        self.f = f = Function(HEAD.format(proof.name))
        base = proof.arrangement.scratch(DoubleVectors(f))
        self.numbers: dict[Array, Pointer] = {
            array: f.place(base, at, "double") for array, at in proof.arrangement.places.items()
        }
        """Where the numbers of each array begin."""
        self.radii: dict[Array, Pointer] = {}
        """Where the radii of disks around them do, a vector of each; there are none around constants."""
        for array, (at, end) in places_of(proof.arrangement, proof.first).items():
            self.numbers[array] = f.place(base, at, "double")
            self.radii[array] = f.place(base, end - LANES * array.count, "double")
        for i, array in enumerate((self.system.q, self.system.v)):
            self.numbers[array] = f.place("%state", i * self.lengths.degrees, "double")
        self.moving = {array for array in self.radii if array is not proof.arrangement.forces}
        disks = Disks(f, Emitter(f), LANES)
        self.weights, self.time = weights_of(disks), radii(f, Real(f, "%h"))

    def written(self) -> Function:
        """The function."""
        f, defects = self.f, self.numbers[self.arrangement.forces]
        self.enclose_state()
        totals = totals_of(self.arrangement)
        for total in totals:
            self.clear(total)
        for one in loops(totals, self.arrangement.slots):
            if isinstance(one, Chain):
                self.add_up(one)
            else:
                self.add(one)
        h, inverse = Real(f, "%h"), 1.0 / Real(f, "%unit")
        scaled, nothing = h * inverse, self.margins.negligible(f, h)
        masses, excess = self.numbers[self.arrangement.lasting.masses], f.variable(f.constant(0.0))
        with f.loop(0, self.lengths.degrees, tested=False) as i:
            change = (self.slope(i, scaled) + f.magnitude(self.speed(i, f.count(1)))) * inverse
            speed = f.magnitude(f.load(self.numbers[self.system.v], i)) / h
            allowed = f.magnitude(f.load(masses, i)) * f.fused(change + speed, self.margins.small, nothing)
            excess.set(exceeded(f, excess.get(), f.load(defects, i) * WIDER, allowed))
        f.give(expected(f, excess.get(), self.lengths.order))
        return f

    # coordinates and velocities

    def speed(self, i: Integer, m: Integer) -> Real:
        """Coefficient ``m`` of a velocity."""
        lengths = self.lengths
        return self.f.load("%work", m * lengths.term + i + (lengths.first + lengths.degrees))

    def place(self, i: Integer, m: Integer) -> Real:
        """Coefficient ``m`` of a coordinate."""
        if self.lengths.followers:
            return self.speed(i, m - 1) / m.to_real()
        return self.f.load("%work", m * self.lengths.term + i + self.lengths.first)

    def slope(self, i: Integer, x: Real) -> Real:
        """sum_{m >= 2} m |v[m]| x^(m - 1)."""
        f, total = self.f, self.f.variable(self.f.constant(0.0))
        with f.loop(0, self.lengths.top - 1, tested=False) as passed:
            m = f.count(self.lengths.top) - passed
            total.set((total.get() + f.magnitude(self.speed(i, m)) * m.to_real()) * x)
        return total.get()

    def enclose_state(self) -> None:
        """The radii of q and v: sum_{m >= 1} |c[m]| r^m, and low parts."""
        f, degrees = self.f, self.lengths.degrees
        r = radii(f, Real(f, "%h") / Real(f, "%unit"))
        with f.loop(0, degrees, tested=False) as i:
            place, speed = (f.variable(f.zero(LANES)) for _ in range(2))
            with f.loop(0, self.lengths.top, tested=False) as passed:
                m = f.count(self.lengths.top) - passed
                place.set((place.get() + f.splat(f.magnitude(self.place(i, m + 1)), LANES)) * r)
                speed.set((speed.get() + f.splat(f.magnitude(self.speed(i, m)), LANES)) * r)
            first = f.splat(f.magnitude(self.place(i, f.count(1))), LANES)
            for array, radius in ((self.system.q, (place.get() + first) * r), (self.system.v, speed.get())):
                shift = self.margins.low + (degrees if array is self.system.v else 0)
                low = f.splat(f.magnitude(f.load("%state", i + shift)), LANES)
                f.store_row(radius + low, self.radii[array], i * LANES)

    # disks

    def at(self, table: Places, member: Integer) -> Integer:
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
        if array not in self.moving:
            return Disk(centre)
        return Disk(centre, self.f.load_row(self.radii[array], i * LANES, LANES))

    def put(self, disks: Disks, value: Disk | None, array: Array, i: Integer) -> None:
        """Keep a disk."""
        if value is not None:
            self.f.store(Real(self.f, disks.centres.written(value.centre), 1), self.numbers[array], i)
            self.f.store_row(disks.radius(value), self.radii[array], i * LANES)

    def clear(self, total: Total) -> None:
        """Begin with 0."""
        f = self.f
        with f.loop(0, total.count, tested=False) as i:
            f.store(f.constant(0.0), self.numbers[total], i)
            if total in self.moving:
                f.store_row(f.zero(LANES), self.radii[total], i * LANES)

    def add_up(self, chain: Chain) -> None:
        """Add the terms of a chain up along it."""
        assert chain.tree is not None
        with climb(self.f, self.arrangement.tables, chain.tree, back=chain.back) as (member, parent, hangs):
            source, target = (member, parent) if chain.back else (parent, member)
            with self.f.when(hangs):
                disks = Disks(self.f, Emitter(self.f), LANES)
                both = self.disk(chain, target), self.disk(chain, source)
                self.put(disks, disks.add(*both), chain, target)

    def add(self, loop: Loop) -> None:
        """Add the terms of a loop's members to what they belong to."""
        f, constants = self.f, self.arrangement.tables.constants
        moving = (symbol for symbol, slot in loop.used.items() if slot.array in self.moving)
        variables = union((self.system.time, *moving))
        parts: list[list[Node]] = [
            terms(term.node, variables, self.system.time.symbols)
            if total is self.arrangement.forces
            else [term.node]
            for term, total in loop.terms
        ]
        nodes = [node for listed in parts for node in listed]
        with f.loop(0, loop.domain.count, tested=False) as member:
            disks = Disks(f, Emitter(f), LANES)
            known = self.known(loop.used, member)
            Sums(disks, nodes, MemberSeries(self, loop.used, member, variables), known, constants).enclose()
            emit_values(disks, nodes, known, constants)
            for (term, total), listed in zip(loop.terms, parts):
                i = self.at(term.targets, member)
                if total is not self.arrangement.forces:
                    self.put(disks, disks.add(self.disk(total, i), known[listed[0]]), total, i)
                elif listed:
                    defect = f.load(self.numbers[total], i)
                    for one in listed:
                        defect = defect + least(disks, known[one], self.weights)
                    f.store(defect, self.numbers[total], i)

    def known(self, used: Mapping[Node, Slot], member: Integer) -> dict[Node, Disk | None]:
        """The disks of a member's slots, and of time."""
        found: dict[Node, Disk | None] = {self.system.time: Disk("%t", self.time)}
        for symbol, slot in used.items():
            found[symbol] = self.disk(slot.array, self.at(slot.table, member))
        return found


class MemberSeries(StateSeries):
    """The series of q and v in the slots of a member."""

    def __init__(self, writer: _Writer, used: Mapping[Node, Slot], member: Integer, variables: int) -> None:
        self.writer, self.lengths, self.variables = writer, writer.lengths, variables
        self.time, self.sums = writer.system.time, dict[Node, int]()
        places, speeds = (
            {symbol: writer.at(slot.table, member) for symbol, slot in used.items() if slot.array is array}
            for array in (writer.system.q, writer.system.v)
        )
        self.places, self.speeds = places, speeds
        self.members = {**places, **speeds}

    def coefficient(self, node: Node, m: Integer) -> Real:
        coefficient = self.writer.place if node in self.places else self.writer.speed
        return coefficient(self.members[node], m)

    def late(self, symbol: Node) -> Real:
        row = self.writer.margins.low + (0 if symbol in self.places else self.lengths.degrees)
        return self.writer.f.load("%state", self.members[symbol] + row)
