"""``@jet`` of a system of families: its accelerations at a state, or its Taylor series there."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence

from lagrange_cli.errors import TooManyNumbers
from lagrange_cli.families.arrays import Array, Chain, Slots, Total
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.limits import way_out, whole
from lagrange_cli.native.families.evaluation import Evaluation, Piece, added, room
from lagrange_cli.native.families.lasting import Lasting
from lagrange_cli.native.families.loops import loops
from lagrange_cli.native.families.series import LoopSeries, begin_sums
from lagrange_cli.native.families.spans import Span, in_vectors
from lagrange_cli.native.families.stage import SeriesWriter
from lagrange_cli.native.families.tiling import Tiling, tiling_of
from lagrange_cli.native.families.vectors import Divisor, DoubleVectors, Vectors
from lagrange_cli.native.families.windows import Windows
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer
from lagrange_cli.native.motions import RATES
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.recurrences.batches.tables import Tables
from lagrange_cli.native.recurrences.vector_dots import AHEAD
from lagrange_cli.native.state import StateLayout
from lagrange_cli.records import dataclass, replace

MOST_NUMBERS = whole("numbers")
"""Of all series of a system."""
WITHOUT_SERIES = "choose --method ias15, which has no series, "
"""A way out for motions in doubles without a certificate: all others need series."""
BEGUN = 7
"""From this stage on, dot products are begun for several orders together, where coefficients are many. (The
code is twice as long.)"""
HEAD = "define internal i1 @{}(ptr noalias %constants, {}, ptr noalias %state, ptr noalias %work) #0"
JET, BRIEF, BESIDE = "jet", "accelerations", "beside"
"""The names of the functions: all of a step's series, accelerations alone, and series beside the motion's."""


@dataclass(frozen=True, eq=False)
class Jet:
    """The text of ``@jet``, its doubles of ``%work``, and its operations."""

    text: str
    work: int
    operations: int


def velocity_planes(rows: int) -> tuple[int, int]:
    """Where coefficient 0 of the velocities is, and how far it is from one to the next, if so many ``rows``
    are beside one another: these, and integrals behind them. Vectors may begin before them or end behind
    them: zeros are between coefficients."""
    return LANES, LANES * (-(-rows // LANES) + 1)


class SeriesJet(ABC):
    """The jet with series of the velocities, at ``velocity_planes``. ``places`` has where what lasts is, from
    the beginning of scratch in ``%constants`` on."""

    local = True
    """Whether an order takes nothing but loops and ``accelerate``, and coordinates have no series of their
    own. (Double-double numbers have these: to compute them again and again takes longer.)"""
    tiled = True
    """Whether blocks of members may be taken through all orders one after the other."""
    shared = False
    """Whether several threads may compute them."""
    beside = False
    """Whether there are series beside the motion's (``BesideJet``), which follow from these."""
    many = 2**16
    """Coefficients from which on the second copy of the code pays."""

    def __init__(
        self,
        system: FamilySystem,
        lasting: Lasting,
        places: Mapping[Array, int],
        tables: Tables,
        layout: StateLayout,
        order: int,
        kind: type[Vectors] = DoubleVectors,
        name: str = JET,
    ) -> None:
        self.system, self.lasting, self.tables, self.order = system, lasting, tables, order
        self.slots: Slots = system.slots
        self.kind, self.lasts = kind, places
        self.enter(Function(HEAD.format(name, kind.times)))
        self.local = self.local and kind.parts == 1
        self.width, self.degrees, self.rates = layout.width, system.q.count, layout.rows - layout.degrees
        self.work = 0
        self.planes: dict[Array, tuple[int, int]] = self.of_state()
        """Where coefficient 0 of arrays is, and how far it is from one to the next."""
        self.loops: list[tuple[LoopSeries, int] | Chain] = []
        self.tiling: Tiling | None = None
        self.waiting: list[int] = []
        """Where the registers of each loop wait between blocks, for each order."""

    def enter(self, f: Function) -> None:
        """Write into this function from here on."""
        self.f, self.vectors = f, self.kind(f)
        self.emitter: LaneEmitter = self.vectors.kind
        base = self.vectors.place("%constants", f.load_integer("@scratch"))
        self.places = {array: self.vectors.place(base, at) for array, at in self.lasts.items()}
        self.time = self.vectors.operand(self.vectors.splat(self.vectors.now(), LANES))

    def take(self, doubles: int) -> int:
        """So many further ones of ``%work``."""
        self.work += doubles
        return self.work - doubles

    def at(self, array: Array, k: int | Integer) -> Pointer:
        """Where coefficient k of an array is, or what it follows from (``scales``)."""
        if array not in self.planes:
            return self.places[array]
        if self.local and array is self.system.q and not (isinstance(k, int) and k == 0):
            array, k = self.system.v, k - 1
        first, step = self.planes[array]
        return self.vectors.place("%work", k * step + first)

    def scales(self, k: int | Integer) -> dict[Array, Divisor]:
        """What numbers of these arrays are divided by: q[k] = v[k - 1] / k."""
        first = isinstance(k, int) and k <= 1
        return {self.system.q: self.vectors.divisor(k, 0)} if self.local and not first else {}

    def of_state(self) -> dict[Array, tuple[int, int]]:
        """The places of q and v."""
        if not self.local:
            return self.of_rows()
        first, step = velocity_planes(self.rates)
        self.take(step * (self.order + 1) + LANES)
        return {self.system.q: (self.take(room(self.degrees)), 0), self.system.v: (first, step)}

    def of_rows(self) -> dict[Array, tuple[int, int]]:
        """The same where both have series: coefficient m of the state's row i is at ``m * width + i``."""
        self.take(room(self.width * (self.order + 1) + self.degrees))
        return {self.system.q: (0, self.width), self.system.v: (self.degrees, self.width)}

    def evaluation(self, k: int | Integer) -> Evaluation:
        """What computes totals of order k."""
        return Evaluation(
            self.vectors, self.slots, lambda array: self.at(array, k), self.tables,
            {self.system.time: self.time}, self.scales(k),
        )  # fmt: skip

    def arrange(self, totals: Sequence[Total]) -> None:
        """Find the series of these totals, and places for all."""
        for total in totals:
            self.planes[total] = self.take(room(total.count)), 0
        moving = self.system.time.symbols
        for symbol, slot in self.slots.of.items():
            moving |= symbol.symbols if slot.array in self.planes else 0
        listed = [
            one
            if isinstance(one, Chain)
            else LoopSeries(one, self.slots, moving, self.system.time, self.order)
            for one in loops(totals, self.slots)
        ]
        found = [one for one in listed if not isinstance(one, Chain)]
        if self.tiled and self.local and self.order > RATES and len(found) == len(listed):
            self.tiling = tiling_of(found, self.planes, self.degrees, self.order, shared=self.shared)
        for i, one in enumerate(listed):
            if isinstance(one, Chain):
                self.loops.append(one)
                continue
            if self.tiling is not None:
                one = replace(one, kept=self.tiling.kept(i))
                self.waiting.append(self.take(LANES * len(one.loop.terms) * self.order))
            self.loops.append((one, self.take(one.doubles)))

    @property
    def series(self) -> list[tuple[LoopSeries, int]]:
        """All series, with their places in ``%work``."""
        return [one for one in self.loops if not isinstance(one, Chain)]

    def bounded(self) -> None:
        """Raise ``TooManyNumbers`` where the series take too much memory."""
        numbers = self.vectors.parts * self.work
        if numbers > MOST_NUMBERS:
            raise TooManyNumbers(
                f"the Taylor series of this system are {numbers} numbers, more than {MOST_NUMBERS}",
                f"{WITHOUT_SERIES}make the system smaller, {way_out('numbers')}",
            )

    def write(self) -> Jet:
        """The jet."""
        f, degrees, order = self.f, self.degrees, self.order
        self.totals = self.prepared()
        self.bounded()
        self.start()
        operations = self.emitter.operations
        if self.tiling is None:
            operations += self.stages()
        else:
            operations += self.rounds(self.tiling)
        last = self.at(self.system.v, order)
        with f.loop(0, degrees, tested=False) as i:
            self.vectors.store(self.vectors.zero(1), last, i)
        if self.beside:
            constants, state, work = (f.pointer(f"%{one}") for one in ("constants", "state", "work"))
            f.call(Bit, BESIDE, constants, *self.vectors.moment(), state, work)
        f.give(self.regular())
        return Jet(f.text(), self.work, operations)

    def rounds(self, tiling: Tiling) -> int:
        """All rounds of a tiling; their operations."""
        with self.f.loop(0, tiling.rounds + tiling.ring, tested=False) as turn:
            return self.stages(Windows(self.f, self.tables, tiling, turn))

    def stages(self, windows: Windows | None = None) -> int:
        """All orders: the first ones by themselves, then a loop, and one in which dot products are begun for
        several orders together. The operations of all of them."""
        f, end = self.f, self.order - 1
        first = min(max((one.unrolled for one, _ in self.series), default=1), end)
        many = self.vectors.parts == 1 and sum(one.doubles for one, _ in self.series) >= self.many
        rounds = max(0, end - max(first, BEGUN)) // AHEAD if many else 0
        begun = end - rounds * AHEAD
        operations = sum(self.counted(k, None, windows) for k in range(first))
        if first < begun:
            with f.loop(first, begun, tested=False) as counter:
                operations += (begun - first) * self.counted(counter, None, windows)
        if rounds:
            with f.loop(begun, end, AHEAD, tested=False) as counter:
                for phase in range(AHEAD):
                    operations += rounds * self.counted(counter + phase, phase, windows)
        return operations

    def counted(self, k: int | Integer, phase: int | None, windows: Windows | None) -> int:
        """The operations of stage k, which is written."""
        before = self.emitter.operations
        self.stage(k, phase, windows)
        return self.emitter.operations - before

    def stage(self, k: int | Integer, phase: int | None, windows: Windows | None) -> None:
        """All of order k, or what a round has of it; ``phase``: how many stages there were since sums were
        begun, if they were."""
        evaluation = self.evaluation(k)
        listed = [one if isinstance(one, Chain) else one[0].loop for one in self.loops]
        totals = added(self.totals, listed)
        if windows is not None:
            with windows.order(k):
                self.stage_between(evaluation, k, phase, windows, totals)
            return
        if phase == 0 and isinstance(k, Integer):
            for series, place in self.series:
                if not self.apart(series):
                    begin_sums(self.f, series, k, place, 0, int(series.blocks[-1]))
        evaluation.clear(totals)
        for one in self.loops:
            if isinstance(one, Chain):
                evaluation.add_up(one)
            elif self.apart(one[0]):
                self.write_apart(*one, k, phase)
            else:
                SeriesWriter(evaluation, *one, k, phase).write()
        self.accelerate(evaluation, k, phase)

    def apart(self, series: LoopSeries) -> bool:
        """Whether a loop is written apart, in a function of its own."""
        return False

    def write_apart(self, series: LoopSeries, place: int, k: int | Integer, phase: int | None) -> None:
        """What such a loop has of order k."""
        raise NotImplementedError

    def stage_between(
        self,
        evaluation: Evaluation,
        k: int | Integer,
        phase: int | None,
        windows: Windows,
        totals: Sequence[Array],
    ) -> None:
        """What a round has of order k."""
        with windows.parts() as part:
            span = windows.units(k, 0, part)
            for total in totals:
                evaluation.clear_between(total, windows.positions(span, room(total.count)))
        for i, ((series, place), waiting) in enumerate(zip(self.series, self.waiting)):
            size = LANES * len(series.loop.terms)
            with windows.parts() as part:
                blocks = windows.blocks(i, k, part)
                if phase == 0 and isinstance(k, Integer):
                    begin_sums(self.f, series, k, place, *windows.blocks(i, k, part, AHEAD - 1))
                registers = self.vectors.place("%work", k * size + waiting)
                SeriesWriter(evaluation, series, place, k, phase).write(Piece(blocks, registers))
        with windows.parts() as part:
            span = windows.units(k, windows.tiling.stride, part)
            self.accelerate(evaluation, k, phase, windows.positions(span, self.degrees))

    def start(self) -> None:
        """What is done before order 0: coefficients 0."""
        for shift, array in enumerate((self.system.q, self.system.v)):
            state = self.f.place("%state", shift * self.degrees, "double")
            self.copy(self.vectors.in_state(state, self.width), self.at(array, 0), self.degrees)
        if not self.local:
            self.follow(0, self.at(self.system.v, 0), self.at(self.system.q, 1), self.degrees)

    def follow(self, k: int | Integer, source: Pointer, target: Pointer, count: int) -> None:
        """Coefficients k + 1 of so many numbers, from coefficients k of their rates."""
        f, vectors = self.f, self.vectors
        if vectors.parts == 1:
            assert k == 0
            self.copy(source, target, count)
            return
        divisor = vectors.divisor(k, 1)

        def write(i: Integer, lanes: int) -> None:
            vectors.store_row(vectors.divided(vectors.load_row(source, i, lanes), divisor), target, i)

        in_vectors(f, (f.count(0), f.count(count)), write)

    def copy(self, source: Pointer, target: Pointer, count: int) -> None:
        """Copy so many numbers."""
        f, vectors = self.f, self.vectors
        in_vectors(
            f,
            (f.count(0), f.count(count)),
            lambda i, lanes: vectors.store_row(vectors.load_row(source, i, lanes), target, i),
        )

    # what each kind of system has of its own

    @abstractmethod
    def prepared(self) -> Sequence[Total]:
        """The totals of every order, whose series are found."""

    @abstractmethod
    def accelerate(
        self, evaluation: Evaluation, k: int | Integer, phase: int | None, span: Span | None = None
    ) -> None:
        """Coefficients k of the accelerations, all or some, from those of the forces."""

    @abstractmethod
    def regular(self) -> Bit:
        """Whether the masses are."""
