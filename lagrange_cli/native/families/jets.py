"""``@jet`` of a system of families: its accelerations at a state, or its Taylor series there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lagrange_cli.errors import TooLarge
from lagrange_cli.families.arrays import Array, Chain, Slots, Total
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.limits import way_out, whole
from lagrange_cli.native.families.evaluation import Evaluation, added, loops, needed, room
from lagrange_cli.native.families.lasting import Lasting
from lagrange_cli.native.families.series import LoopSeries, SeriesWriter
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.recurrences.layout_batches import Tables
from lagrange_cli.native.state import StateLayout
from lagrange_cli.records import dataclass

MOST_NUMBERS = whole("numbers")
"""Of all series of a system."""
HEAD = "define internal i1 @jet(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work) #0"


@dataclass(frozen=True, eq=False)
class Jet:
    """The text of ``@jet``, its doubles of ``%work``, and its operations."""

    text: str
    work: int
    operations: int


class SeriesJet:
    """The jet with series: coefficient m of the state's row i is at ``m * width + i``. ``places`` has where
    what lasts is, from the beginning of scratch in ``%constants`` on."""

    def __init__(
        self,
        system: FamilySystem,
        lasting: Lasting,
        places: Mapping[Array, int],
        tables: Tables,
        layout: StateLayout,
        order: int,
    ) -> None:
        self.system, self.lasting, self.tables, self.order = system, lasting, tables, order
        self.slots: Slots = system.slots
        self.f, self.emitter = Function(HEAD), LaneEmitter()
        self.width, self.degrees = layout.width, system.q.count
        self.work = room(self.width * (order + 1) + self.degrees)
        base = self.f.place("%constants", self.f.load_integer("@scratch"), "double")
        self.places = {array: self.f.place(base, at, "double") for array, at in places.items()}
        self.time = self.f.splat(Real(self.f, "%t", 1), LANES).name
        self.planes: dict[Array, tuple[int, int]] = {
            system.q: (0, self.width),
            system.v: (self.degrees, self.width),
        }
        """Where coefficient 0 of arrays is, and how far it is from one to the next."""
        self.loops: list[tuple[LoopSeries, int] | Chain] = []

    def take(self, doubles: int) -> int:
        """So many further ones of ``%work``."""
        self.work += doubles
        return self.work - doubles

    def at(self, array: Array, k: int | Integer) -> Pointer:
        """Where coefficient k of an array is."""
        if array not in self.planes:
            return self.places[array]
        first, step = self.planes[array]
        return self.f.place("%work", k * step + first, "double")

    def evaluation(self, k: int | Integer) -> Evaluation:
        """What computes totals of order k."""
        return Evaluation(
            self.f, self.slots, lambda array: self.at(array, k), self.tables,
            {self.system.time: self.time}, self.emitter,
        )  # fmt: skip

    def arrange(self, totals: Sequence[Total]) -> None:
        """Find the series of these totals, and places for all."""
        for total in totals:
            self.planes[total] = self.take(room(total.count)), 0
        moving = self.system.time.symbols
        for symbol, slot in self.slots.of.items():
            moving |= symbol.symbols if slot.array in self.planes else 0
        for one in loops(totals, self.slots):
            if isinstance(one, Chain):
                self.loops.append(one)
                continue
            series = LoopSeries(one, self.slots, moving, self.system.time, self.order)
            self.loops.append((series, self.take(series.doubles)))

    @property
    def series(self) -> list[LoopSeries]:
        """All series."""
        return [one[0] for one in self.loops if not isinstance(one, Chain)]

    @property
    def unrolled(self) -> int:
        """Orders that are written out before the loop over the others: all series have begun by then, and t
        has had its rate."""
        return max((one.begun for one in self.series), default=1)

    def bounded(self) -> None:
        """Raise ``TooLarge`` where the series take too much memory."""
        if self.work > MOST_NUMBERS:
            raise TooLarge(
                f"the Taylor series of this system are {self.work} numbers, more than {MOST_NUMBERS}",
                f"choose --method ias15, which has no series, make the system smaller, {way_out('numbers')}",
            )

    def write(self) -> Jet:
        """The jet."""
        f, degrees, order = self.f, self.degrees, self.order
        self.totals = self.prepared()
        self.bounded()
        with f.loop(0, 2 * degrees, tested=False) as i:
            f.store(f.load("%state", i), "%work", i)
        with f.loop(0, degrees, tested=False) as i:
            f.store(f.load("%state", i + degrees), "%work", i + self.width)
        self.begin()
        last, rolled, operations = order - 2, min(self.unrolled, order - 1), self.emitter.operations
        for k in range(rolled):
            operations += self.counted(k)
        if rolled <= last:
            with f.loop(rolled, last + 1, tested=False) as counter:
                operations += (last + 1 - rolled) * self.counted(counter)
        with f.loop(0, degrees, tested=False) as i:
            f.store(f.constant(0.0), "%work", i + degrees + order * self.width)
        f.give(self.regular())
        return Jet(f.text(), self.work, operations)

    def counted(self, k: int | Integer) -> int:
        """The operations of stage k, which is written."""
        before = self.emitter.operations
        self.stage(k)
        return self.emitter.operations - before

    def stage(self, k: int | Integer) -> None:
        """All of order k."""
        evaluation = self.evaluation(k)
        listed = [one if isinstance(one, Chain) else one[0].loop for one in self.loops]
        evaluation.clear(added(self.totals, listed))
        for one in self.loops:
            if isinstance(one, Chain):
                evaluation.add_up(one)
            else:
                SeriesWriter(evaluation, one[0], k, one[1]).write()
        self.accelerate(evaluation, k)

    def further(self, k: int | Integer) -> tuple[Real, Real]:
        """k + 1 and k + 2."""
        name = str(k) if isinstance(k, int) else k.name
        one, two = (self.emitter.everywhere("@numbers", name, ahead) for ahead in (1, 2))
        return Real(self.f, one, LANES), Real(self.f, two, LANES)

    # what systems have of their own: here M is diagonal and constant

    def prepared(self) -> Sequence[Total]:
        """The totals of every order, whose series are found."""
        self.forces = self.lasting.arranged(self.system.forces, kept=False)
        self.masses = self.lasting.arranged(self.system.masses)
        totals = needed([self.forces], self.slots, self.lasting.fixed)
        self.arrange(totals)
        return totals

    def begin(self) -> None:
        """What is done before order 0."""

    def accelerate(self, evaluation: Evaluation, k: int | Integer) -> None:
        """Coefficients k of the accelerations, from those of the forces."""
        f, degrees = self.f, self.degrees
        force, mass = evaluation.where(self.forces), evaluation.where(self.masses)
        self.emitter.repeated = degrees // LANES + 1
        number, after = self.further(k)
        following, beyond = (k + 1) * self.width, (k + 2) * self.width
        # a whole vector goes beyond the last row: what is there is written afterwards
        with f.loop(0, degrees, LANES, tested=False) as i:
            rate = f.load_row(force, i, LANES) / f.load_row(mass, i, LANES) / number
            f.store_row(rate, "%work", i + degrees + following)
        with f.loop(0, degrees, LANES, tested=False) as i:
            rate = f.load_row("%work", i + degrees + following, LANES)
            f.store_row(rate / after, "%work", i + beyond)

    def regular(self) -> Bit:
        """Whether the masses are."""
        positive = self.system.spec.lagrangian is None
        return regular(self.f, self.at(self.masses, 0), self.degrees, positive=positive)


def regular(f: Function, masses: Pointer, count: int, *, positive: bool) -> Bit:
    """Whether numbers are positive, or at least not 0."""
    found = f.variable(Bit(f, "true", 1))
    with f.loop(0, count, tested=False) as i:
        mass = f.load(masses, i)
        found.set(found.get() & ((mass if positive else f.magnitude(mass)) > 0.0))
    return found.get()
