"""``@proven`` of systems of families (see ``stepping.proof``): a loop over the members encloses their terms.

M is diagonal and constant, so that all that is left of the equations is left of the forces. The totals
that these contain are enclosed first: the centres of their disks are side by side, and so are their radii, a
vector of each. The terms of the forces are looked at one by one, and their parts of the defect are added up
for each coordinate.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import partial

from lagrange_cli.expression.node import Node, reachable, union
from lagrange_cli.families.arrays import Array, Chain, Slot, Total
from lagrange_cli.mechanics.cancellation import singular_sums
from lagrange_cli.mechanics.defect import terms
from lagrange_cli.native.families.arrangement import Arrangement
from lagrange_cli.native.families.loops import Loop, loops
from lagrange_cli.native.families.member_series import SumSeries, SumWriter, sum_series
from lagrange_cli.native.families.proof_arrays import DiskArrays, Places, totals_of
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Index, Integer, Pointer, Real
from lagrange_cli.native.recurrences.disk_arithmetic import Disk
from lagrange_cli.native.recurrences.evaluation import emit_values
from lagrange_cli.native.stepping.cancelling import Sums
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
from lagrange_cli.native.stepping.state_series import StateSeries, combinations
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class FamilyProof(Proof):
    """The proof of a system whose arrays are where ``arrangement`` says. Those of the proof are behind them,
    from ``first`` on (``proof_arrays.Places``): disks, the defects of the forces, and series."""

    arrangement: Arrangement
    first: int
    margins: Margins

    def function(self) -> Function:
        return _Writer(self).written()


def proof_room(arrangement: Arrangement) -> int:
    """The doubles that a proof takes: those of arrays, and behind them series of sums."""
    places, totals = Places(arrangement), totals_of(arrangement)
    found = [one for one in loops(totals, arrangement.slots) if isinstance(one, Loop)]
    series = [sums_of(arrangement, one, places.followed) for one in found]
    return places.end + max((one.room for one in series if one), default=0)


def sums_of(arrangement: Arrangement, loop: Loop, followed: Collection[Array]) -> SumSeries | None:
    """What has series of its own in the terms of a loop: combinations, sums in which terms are singular, and
    the terms of totals that are ``followed``. They follow from q, v, t, such totals, and what lasts."""
    system, slots = arrangement.system, arrangement.slots
    moving = system.time.symbols | slots.symbols_of(system.q, system.v, *totals_of(arrangement))
    known = system.time.symbols | slots.symbols_of(system.q, system.v, *followed)
    nodes = [term.node for term, _ in loop.terms]
    symbols = [symbol for symbol in loop.used if symbol.symbols & known]
    combined = combinations(reachable(nodes), moving, symbols)
    sums = [one for one in singular_sums(nodes, moving, moving & ~known) if one not in combined]
    others = [term.node for term, total in loop.terms if total in followed]
    if not (combined or sums or others):
        return None
    made = loop.domain, slots, known, system.time, arrangement.order
    return sum_series(combined, sums, others, *made)


class _Writer:
    """The text of the function."""

    def __init__(self, proof: FamilyProof) -> None:
        self.margins, self.arrangement = proof.margins, proof.arrangement
        self.lengths, self.system = proof.margins.lengths, proof.arrangement.system
        self.f = f = Function(HEAD.format(proof.name))
        self.places = Places(proof.arrangement, proof.first)
        self.arrays = DiskArrays(f, proof.arrangement, self.places, proof.margins)
        self.own = f.place(self.arrays.base, self.places.end, "double")
        """Where series of sums are."""
        self.weights = weights_of(self.arrays.new())

    def written(self) -> Function:
        """The function."""
        f, arrays, totals = self.f, self.arrays, totals_of(self.arrangement)
        self.enclose_state()
        for total in totals:
            arrays.clear(total)
        pending = [total for total in totals if total in arrays.series]
        for one in loops(totals, self.arrangement.slots):
            if isinstance(one, Chain):
                arrays.add_up(one)
                continue
            used = {slot.array for slot in one.used.values()}
            for total in [total for total in pending if total in used]:
                arrays.finish(total)
                pending.remove(total)
            self.add(one)
        h, inverse = Real(f, "%h"), 1.0 / Real(f, "%unit")
        scaled, nothing = h * inverse, self.margins.negligible(f, h)
        masses, excess = arrays.numbers[self.arrangement.lasting.masses], f.variable(f.constant(0.0))
        defects, speeds = arrays.numbers[self.arrangement.forces], arrays.numbers[self.system.v]
        with f.loop(0, self.lengths.degrees, tested=False) as i:
            change = (self.slope(i, scaled) + f.magnitude(arrays.speed(i, f.count(1)))) * inverse
            speed = f.magnitude(f.load(speeds, i)) / h
            allowed = f.magnitude(f.load(masses, i)) * f.fused(change + speed, self.margins.small, nothing)
            excess.set(exceeded(f, excess.get(), f.load(defects, i) * WIDER, allowed))
        f.give(expected(f, excess.get(), self.lengths.order))
        return f

    def slope(self, i: Integer, x: Real) -> Real:
        """sum_{m >= 2} m |v[m]| x^(m - 1)."""
        f, total = self.f, self.f.variable(self.f.constant(0.0))
        with f.loop(0, self.lengths.top - 1, tested=False) as passed:
            m = f.count(self.lengths.top) - passed
            total.set((total.get() + f.magnitude(self.arrays.speed(i, m)) * m.to_real()) * x)
        return total.get()

    def enclose_state(self) -> None:
        """The radii of q and v: sum_{m >= 1} |c[m]| r^m, and low parts."""
        f, arrays = self.f, self.arrays
        r = radii(f, Real(f, "%h") / Real(f, "%unit"))
        with f.loop(0, self.lengths.degrees, tested=False) as i:
            place, speed = (f.variable(f.zero(LANES)) for _ in range(2))
            with f.loop(0, self.lengths.top, tested=False) as passed:
                m = f.count(self.lengths.top) - passed
                place.set((place.get() + f.splat(f.magnitude(arrays.place(i, m + 1)), LANES)) * r)
                speed.set((speed.get() + f.splat(f.magnitude(arrays.speed(i, m)), LANES)) * r)
            first = f.splat(f.magnitude(arrays.place(i, f.count(1))), LANES)
            for array, radius in ((self.system.q, (place.get() + first) * r), (self.system.v, speed.get())):
                low = f.splat(f.magnitude(arrays.late(array, i)), LANES)
                f.store_row(radius + low, arrays.radii[array], i * LANES)

    def add(self, loop: Loop) -> None:
        """Add the terms of a loop's members to what they belong to."""
        f, arrays = self.f, self.arrays
        moving = (symbol for symbol, slot in loop.used.items() if slot.array in arrays.radii)
        variables = union((self.system.time, *moving))
        parts: list[list[Node]] = [
            terms(term.node, variables, self.system.time.symbols)
            if total is self.arrangement.forces
            else [term.node]
            for term, total in loop.terms
        ]
        found = sums_of(self.arrangement, loop, arrays.series)

        def each(member: Integer, lane: Index) -> None:
            self.add_member(
                loop, parts, MemberSeries(arrays, loop.used, member, variables, found, self.own, lane)
            )

        if found is None:
            with f.loop(0, loop.domain.count, tested=False) as member:
                each(member, 0)
        else:
            SumWriter(arrays.of_order, found, self.own, each).write()

    def add_member(self, loop: Loop, parts: Sequence[Sequence[Node]], series: MemberSeries) -> None:
        """Add the terms of a member, or what they are made of."""
        f, arrays, constants = self.f, self.arrays, self.arrangement.tables.constants
        disks, known = arrays.new(), series.disks()
        nodes = [node for listed in parts for node in listed]
        reaching = [term.node for term, total in loop.terms if total in arrays.series]
        sums = Sums(disks, nodes, series, known, constants, arrays.tail, reaching)
        sums.enclose()
        emit_values(disks, nodes, known, constants)
        bounds = dict[Real, Real]()  # opposite forces have the same radius
        for (term, total), listed in zip(loop.terms, parts):
            i = arrays.at(term.targets, series.member)
            if isinstance(total, Total) and total is not self.arrangement.forces:
                if total in arrays.series:
                    own = partial(series.of_node, term.node)
                    arrays.add_series(disks, sums.farther[term.node], total, i, own)
                arrays.add(disks, known[term.node], total, i)
                continue
            defect = f.load(arrays.numbers[total], i)
            for one in listed:
                radius = disks.radius(known[one] or disks.constant(0))
                if radius not in bounds:
                    bounds[radius] = least(disks, radius, self.weights)
                defect = defect + bounds[radius]
            f.store(defect, arrays.numbers[total], i)


class MemberSeries(StateSeries):
    """The series in the slots of a ``member``, and of its sums, which are in a ``lane`` at ``own``."""

    def __init__(
        self,
        arrays: DiskArrays,
        used: Mapping[Node, Slot],
        member: Integer,
        variables: int,
        found: SumSeries | None,
        own: Pointer,
        lane: Index,
    ) -> None:
        self.arrays, self.lengths, self.member, self.variables = arrays, arrays.lengths, member, variables
        self.found, self.own, self.lane, self.time = found, own, lane, arrays.system.time
        self.sums, self.combined = (found.sums, found.combined) if found else ((), ())
        self.slots = {symbol: (slot.array, arrays.at(slot.table, member)) for symbol, slot in used.items()}
        q, v = arrays.of_state
        self.places, self.speeds, self.totals = (
            [symbol for symbol, (array, _) in self.slots.items() if array in listed]
            for listed in ([q], [v], arrays.series)
        )

    def disks(self) -> dict[Node, Disk | None]:
        """The disks of the slots, and of time."""
        known: dict[Node, Disk | None] = {self.time: Disk("%t", self.arrays.time)}
        return known | {symbol: self.arrays.disk(*place) for symbol, place in self.slots.items()}

    def coefficient(self, node: Node, m: Integer) -> Real:
        if self.found is not None and node in self.combined:
            return self._in_lane(self.found.combination(node), m)
        return self.of_node(node, m) if node in self.sums else self.arrays.coefficient(*self.slots[node], m)

    def of_node(self, node: Node, m: Integer) -> Real:
        """Coefficient ``m`` of a sum, or of the term of a total."""
        assert self.found is not None
        return self._in_lane(self.found.other(node), m)

    def _in_lane(self, at: int, m: Integer) -> Real:
        assert self.found is not None
        place = m * self.found.width
        return self.arrays.f.load(
            self.own, place + (self.lane + at if isinstance(self.lane, Integer) else at)
        )

    def late(self, symbol: Node) -> Real:
        return self.arrays.late(*self.slots[symbol])

    def beyond(self, total: Node) -> Real:
        return self.arrays.row(self.arrays.beyond, *self.slots[total])

    def farther(self, total: Node) -> Real:
        return self.arrays.row(self.arrays.far, *self.slots[total])
