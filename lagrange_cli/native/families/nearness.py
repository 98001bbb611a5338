"""Which arguments of guards may be 0 within a step: only these need series.

The coordinates and velocities of a step from t to t + h are in disks around their values at t, of radii
sum_{m >= 1} |c[m]| h^m, and so an argument is in the disk that its expression has there
(``recurrences.disk``). If this does not contain 0, and the argument is on the side where the motion is,
nothing is due. For two bodies far from each other this takes a few operations instead of a series: of the
80,000 pairs of 400 discs all but a few are too far apart to meet within a step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.families.arrays import Array, Chain, Source, Term, Total
from lagrange_cli.native.families.additions import Additions
from lagrange_cli.native.families.beside import BesideJet
from lagrange_cli.native.families.evaluation import Evaluation, Writer, room
from lagrange_cli.native.families.jets import Jet, SeriesJet
from lagrange_cli.native.families.loops import Loop
from lagrange_cli.native.families.series import LoopSeries
from lagrange_cli.native.families.series_places import HEAD, SeriesPlaces
from lagrange_cli.native.families.stage import SeriesWriter
from lagrange_cli.native.families.tables import before, place_at
from lagrange_cli.native.families.vectors import Numbers, Operands
from lagrange_cli.native.guards import GuardRows
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer, Real
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.recurrences.disk import Disks
from lagrange_cli.native.recurrences.disk_arithmetic import Disk
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.guard_search import MANY
from lagrange_cli.native.stepping.near import NearPlaces
from lagrange_cli.native.stepping.proof import WIDER
from lagrange_cli.records import dataclass, replace

FEWEST = 256
"""From so many guards on it pays to look for those that need no series."""
NEAR_HEAD = HEAD.replace(") #0", ", double %h) #0")
LASTING = Source.PARAMETERS, Source.WHOLE, Source.MODES


class LaneDisks(Disks):
    """Eight disks side by side, each with a centre of its own."""

    several = True
    centres: LaneEmitter

    def everywhere(self, table: str, first: str, index: int) -> Disk:
        """The one double ``table[first + index]`` in every lane."""
        return Disk(self.centres.everywhere(table, first, index))


@dataclass(frozen=True)
class Watch:
    """The guards whose arguments a step looks at, where steps have their state."""

    rows: GuardRows
    layout: StateLayout

    @property
    def pays(self) -> bool:
        """Whether there are enough of them."""
        return self.rows.side_by_side >= max(FEWEST, MANY)

    def whole(self, count: int) -> bool:
        """Whether they are ``count`` guards, all side by side."""
        return self.rows.count == count and count - self.rows.side_by_side < LANES


def enclosed(arguments: Total, listed: Sequence[Loop | Chain], moving: Sequence[Array]) -> list[Loop]:
    """The loops whose terms are arguments, one of each, in numbers that last and in what is ``moving``."""
    counts = np.bincount(np.concatenate([one.targets for one in arguments.terms]), minlength=arguments.count)
    alone = counts == 1

    def suits(term: Term, total: Array, slots: Mapping[Node, Array]) -> bool:
        arrays = slots.values()
        known = all(one in moving or one.source in LASTING for one in arrays)
        simple = all(node.kind not in (Kind.SWITCH, Kind.DDT) for node in reachable([term.node]))
        return total is arguments and known and simple and bool(np.all(alone[term.targets]))

    found = []
    for loop in listed:
        if isinstance(loop, Loop):
            slots = {symbol: slot.array for symbol, slot in loop.used.items()}
            if all(suits(term, total, slots) for term, total in loop.terms):
                found.append(loop)
    return found


class Enclosure(Writer):
    """The code of a loop that puts each argument to ``near``, if it is not 0 in all of the step of ``h``. The
    numbers of some arrays have ``radii``."""

    def __init__(
        self, evaluation: Evaluation, loop: Loop, near: Pointer, radii: Mapping[Array, Pointer], h: Real
    ) -> None:
        super().__init__(evaluation, loop)
        self.near, self.radii, self.h = near, radii, h

    def taken(self, array: Array, take: Callable[[Pointer], Numbers]) -> Operands:
        centre = super().taken(array, take)
        return Disk(centre, take(self.radii[array]) if array in self.radii else None)

    def row(self, bases: Sequence[Integer], length: Integer, r: Integer) -> None:
        f, fixed = self.f, self.fixed(bases)
        with f.loop(0, length, LANES, tested=False) as j:
            inside = before(f, j, length)
            values = self.enclosed({**fixed, **self.changing(bases, j)})
            for value, i in zip(values, self.number[len(self.used) :]):
                self.put(value, inside, i, bases, j)

    def enclosed(self, slots: Mapping[Node, Operands]) -> list[Real]:
        """The arguments of eight members with these numbers, 0 for those that may be 0."""
        f, times = self.f, self.evaluation.known
        known = {**{node: Disk(at, f.splat(self.h, LANES)) for node, at in times.items()}, **slots}
        disks = LaneDisks(f, self.vectors.kind, LANES)
        nodes = [term.node for term, _ in self.loop.terms]
        return [self.sure(disks, one) for one in self.evaluation.values(nodes, known, disks)]

    def sure(self, disks: Disks, value: Disk | None) -> Real:
        """The centres of disks that do not contain 0; 0 for others."""
        disk = disks.constant(0) if value is None else value
        centre: Real = self.vectors.number(disk.centre)
        apart = self.f.magnitude(centre) > disks.radius(disk) * WIDER
        return self.f.select(apart, centre, self.f.zero(LANES))

    def put(self, value: Real, inside: Bit, i: int, bases: Sequence[Integer], j: Integer) -> None:
        """Store those that are ``inside`` a row, at the places of table ``i``."""
        f, stride = self.f, self.rows.strides[i]
        if stride == 1:
            at = bases[i] + j
            f.store_row(f.select(inside, value, f.load_row(self.near, at, LANES)), self.near, at)
            return
        value = f.select(inside, value, f.zero(LANES))
        if stride == 0:
            f.store(f.lane(value, 0), self.near, bases[i])
            return
        places = self.looked_up(i, j)
        for lane in reversed(range(LANES)):  # behind a table's end its last place stands again
            f.store(f.lane(value, lane), self.near, place_at(f, lane, places))


def write_radii(jet: SeriesPlaces, layout: StateLayout, h: Real, radii: Sequence[Pointer]) -> None:
    """Compute by how much coordinates and velocities change at most within ``h``; with their low parts."""
    f, length, order = jet.f, jet.f.splat(h, LANES), jet.order
    with f.loop(0, layout.degrees, LANES, tested=False) as i:
        c = [f.magnitude(f.load_row(jet.at(jet.system.v, m), i, LANES)) for m in range(order)]
        terms = [one * (1.0 / m) for m, one in enumerate(c, 1)], c[1:]
        for part, target, own in zip((layout.q, layout.v), radii, terms):
            total = f.magnitude(f.load_row("%state", i + (layout.width + part.start), LANES))
            power = length
            for one in own:
                total, power = f.fused(one, power, total), power * length
            f.store_row(total, target, i)


def mark_near(f: Function, watch: Watch, near: Pointer, count: int, h: Real) -> None:
    """Put 1 in the place of each of ``count`` arguments at ``near`` that needs a series, and 0 of others:
    those that are on the side of their guard's mode for sure. Whoever asks for all arguments, of a single
    state, gives an infinite ``h``; those that are constant may never be 0, and are needed all the same."""
    rows, layout = watch.rows, watch.layout
    step = f.splat(h, LANES) < math.inf
    with f.loop(0, rows.side_by_side, LANES, tested=False) as j:
        mode, mark = (f.load_row("%state", j + one(layout), LANES) for one in (rows.mode, rows.fresh))
        away = (f.load_row(near, j, LANES) * mode > 0.0) & (mark <= 0.0) & step
        f.store_row(f.select(away, f.zero(LANES), f.vector([1.0] * LANES)), near, j)
    if rows.side_by_side < count:
        with f.loop(rows.side_by_side, count, tested=False) as j:
            f.store(f.constant(1.0), near, j)


def any_near(f: Function, near: Pointer, at: Integer) -> Bit:
    """Whether any of eight arguments side by side needs a series."""
    return f.any(f.load_row(near, at, LANES) > 0.0)


class NearSeries(SeriesWriter):
    """The code of a loop whose terms are arguments, for those that are ``near`` alone."""

    near: Pointer

    def eight(
        self,
        bases: Sequence[Integer],
        length: Integer,
        j: Integer,
        fixed: Mapping[Node, Operands],
        added: Additions,
    ) -> None:
        f, tables = self.f, dict.fromkeys(self.number[len(self.used) :])
        wanted = f.never(1)
        for i in tables:
            stride = self.rows.strides[i]
            at = bases[i] if stride == 0 else bases[i] + j
            wanted = wanted | (Bit(f, "true", 1) if stride is None else any_near(f, self.near, at))
        with f.when(wanted):
            super().eight(bases, length, j, fixed, added)


class WatchedJet(BesideJet):
    """The series of those arguments that may be 0 within ``%h``."""

    head = NEAR_HEAD
    copied = False

    def __init__(self, watch: Watch, integrands: Total, motion: SeriesJet, name: str) -> None:
        self.watch = watch
        super().__init__(integrands, motion, name)


class NearJet(WatchedJet):
    """These series, whose arguments are found anew in each step."""

    def prepared(self) -> Sequence[Total]:
        totals = super().prepared()
        listed = [one if isinstance(one, Chain) else one[0].loop for one in self.loops]
        moving = self.system.q, self.system.v
        self.enclosed = enclosed(self.integrands, listed, (*moving, *self.lasting.fixed))
        self.marked = self.take(room(self.integrands.count))
        own = [self.take(room(self.degrees)) for _ in moving]
        f, h = self.f, Real(self.f, "%h", 1)
        radii = {one: f.place("%work", at, "double") for one, at in zip(moving, own)}
        write_radii(self, self.watch.layout, h, [*radii.values()])
        with f.loop(0, room(self.integrands.count), LANES, tested=False) as i:
            f.store_row(f.zero(LANES), self.near, i)
        for loop in self.enclosed:
            Enclosure(self.evaluation(0), loop, self.near, radii, h).write()
        mark_near(f, self.watch, self.near, self.integrands.count, h)
        return totals

    @property
    def near(self) -> Pointer:
        """Where arguments that need series are marked."""
        return self.f.place("%work", self.marked, "double")

    def write(self) -> Jet:
        return replace(super().write(), near=NearPlaces(self.marked))

    def clear(self, evaluation: Evaluation, totals: Sequence[Array]) -> None:
        super().clear(evaluation, [one for one in totals if one is not self.integrands])
        base = evaluation.where(self.integrands)
        f, count = self.f, room(self.integrands.count)
        with f.loop(0, count, LANES, tested=False) as i, f.when(any_near(f, self.near, i)):
            f.store_row(f.zero(LANES), base, i)

    def apart(self, series: LoopSeries) -> bool:
        return series.loop in self.enclosed

    def write_apart(self, series: LoopSeries, place: int, k: Index, phase: int | None) -> None:
        writer = NearSeries(self.evaluation(k), series, place, k, phase)
        writer.near = self.near
        writer.write()

    def chosen(self, write: Callable[[Integer, int], None]) -> Callable[[Integer, int], None]:
        def write_near(i: Integer, lanes: int) -> None:
            with self.f.when(self.f.any(self.f.load_row(self.near, i, lanes) > 0.0)):
                write(i, lanes)

        return write_near
