"""``@jet`` of a system of families: its accelerations at a state, or its Taylor series there."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

from lagrange_cli.errors import TooManyNumbers
from lagrange_cli.families.arrays import Array, Chain, Total
from lagrange_cli.limits import way_out, whole
from lagrange_cli.native.families.evaluation import Evaluation, Piece, added, room
from lagrange_cli.native.families.series import LoopSeries, begin_sums
from lagrange_cli.native.families.series_places import SeriesPlaces
from lagrange_cli.native.families.spans import Span, in_vectors
from lagrange_cli.native.families.stage import SeriesWriter
from lagrange_cli.native.families.tiling import Tiling
from lagrange_cli.native.families.vector_dots import AHEAD
from lagrange_cli.native.families.windows import Windows
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer
from lagrange_cli.native.stepping.near import NearPlaces
from lagrange_cli.records import dataclass

MOST_NUMBERS = whole("numbers")
"""Of all series of a system."""
WITHOUT_SERIES = "choose --method ias15, which has no series, "
"""A way out for motions in doubles without a certificate: all others need series."""
SHORT = (
    "define internal void @short{}(ptr noalias %constants, {}, ptr noalias %state, ptr noalias %work, "
    "i64 %k, i64 %first, i64 %last) #0"
)
"""An order of a short loop: some of its blocks."""
BEGUN = 7
"""From this stage on, dot products are begun for several orders together, where coefficients are many. (The
code is twice as long.)"""


@dataclass(frozen=True, eq=False)
class Jet:
    """The text of ``@jet``, its doubles of ``%work``, and its operations; and where ``%work`` tells which
    guards have series, if others have none (``native.families.nearness``). The function for ``single``
    states, if there is one, takes so many doubles."""

    text: str
    work: int
    operations: int
    near: NearPlaces | None = None
    single: int = 0


@contextmanager
def together(windows: Windows | None, k: Integer) -> Iterator[Windows | None]:
    """What is computed of the orders from ``k`` on of which dot products are begun together."""
    if windows is None:
        yield None
    else:
        with windows.together(k, AHEAD) as piece:
            yield piece


class SeriesJet(SeriesPlaces, ABC):
    """The jet with series of the velocities."""

    beside = ""
    """The name of those beside the motion's (``BesideJet``), which follow from these, if there are any."""
    many = 2**16
    """Coefficients from which on the second copy of the code pays."""
    copied = True
    """Whether there may be one."""

    @property
    def carried(self) -> Sequence[Array]:
        """What has series besides, which are kept."""
        return ()

    def bounded(self) -> None:
        """Raise ``TooManyNumbers`` where the series take too much memory."""
        numbers = self.vectors.parts * (self.work + self.acting.numbers)
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
            f.call(Bit, self.beside, constants, *self.vectors.moment(), state, work)
        f.give(self.regular())
        return Jet("".join([f.text(), *self.short.values()]), self.work, operations)

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
        rounds = max(0, end - max(first, BEGUN)) // AHEAD if many and self.copied else 0
        begun = end - rounds * AHEAD
        operations = sum(self.counted(k, None, windows) for k in range(first))
        if first < begun:
            with f.loop(first, begun, tested=False) as counter:
                operations += (begun - first) * self.counted(counter, None, windows)
        if rounds:
            with f.loop(begun, end, AHEAD, tested=False) as counter, together(windows, counter) as piece:
                for phase in range(AHEAD):
                    operations += rounds * self.counted(counter + phase, phase, piece)
        return operations

    def counted(self, k: Index, phase: int | None, windows: Windows | None) -> int:
        """The operations of stage k, which is written."""
        before = self.emitter.operations
        self.stage(k, phase, windows)
        return self.emitter.operations - before

    def stage(self, k: Index, phase: int | None, windows: Windows | None) -> None:
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
            self.begin_sums(k)
        self.clear(evaluation, totals)
        for one in self.loops:
            if isinstance(one, Chain):
                evaluation.add_up(one)
            elif self.apart(one[0]):
                self.write_apart(*one, k, phase)
            elif not self.acting.write_series(evaluation, one[0], k, phase):
                SeriesWriter(evaluation, *one, k, phase).write()
        self.accelerate(evaluation, k, phase)

    def begin_sums(self, k: Integer) -> None:
        """Begin dot products of several orders, from ``k`` on."""
        self.begin_those(self.series, k)

    def begin_those(self, some: Iterable[tuple[LoopSeries, int] | Chain], k: Integer) -> None:
        """Those of some series, at their places."""
        for one in some:
            if isinstance(one, Chain) or self.apart(one[0]):
                continue
            if not self.acting.begin_sums(self.vectors, one[0], k):
                begin_sums(self.f, one[0], k, one[1], 0, int(one[0].blocks[-1]))

    def clear(self, evaluation: Evaluation, totals: Sequence[Array]) -> None:
        """Begin an order with sums that are 0."""
        evaluation.clear(totals)

    def apart(self, series: LoopSeries) -> bool:
        """Whether a loop is written apart, in a function of its own."""
        return False

    def write_apart(self, series: LoopSeries, place: int, k: Index, phase: int | None) -> None:
        """What such a loop has of order k."""
        raise NotImplementedError

    def stage_between(
        self, evaluation: Evaluation, k: Index, phase: int | None, windows: Windows, totals: Sequence[Array]
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
                if series.short and isinstance(k, Integer):
                    self.write_short(i, k, blocks)
                    continue
                if phase == 0 and isinstance(k, Integer):
                    begin_sums(self.f, series, k, place, *windows.blocks(i, k, part, AHEAD - 1))
                registers = self.vectors.place("%work", k * size + waiting)
                SeriesWriter(evaluation, series, place, k, phase).write(Piece(blocks, registers))
        with windows.parts() as part:
            span = windows.units(k, windows.tiling.stride, part)
            self.accelerate(evaluation, k, phase, windows.positions(span, self.degrees))

    def write_short(self, loop: int, k: Integer, blocks: Span) -> None:
        """What a round has of order k of a short loop: a call of a function, which is written once."""
        outer, (series, place), waiting = self.f, self.series[loop], self.waiting[loop]
        if loop not in self.short:
            f = Function(SHORT.format(loop, self.vectors.times))
            order, first, last = (Integer(f, name, 1) for name in ("%k", "%first", "%last"))
            with self.within(f):
                registers = self.vectors.place("%work", order * (LANES * len(series.loop.terms)) + waiting)
                piece = Piece((first, last), registers)
                SeriesWriter(self.evaluation(order), series, place, order, None).write(piece)
            f.give()
            self.short[loop] = f.text()
        constants, state, work = outer.pointers("constants", "state", "work")
        outer.call(None, f"short{loop}", constants, *self.vectors.moment(), state, work, k, *blocks)

    def start(self) -> None:
        """What is done before order 0: coefficients 0."""
        for shift, array in enumerate((self.system.q, self.system.v)):
            state = self.f.place("%state", shift * self.degrees, "double")
            self.copy(self.vectors.in_state(state, self.width), self.at(array, 0), self.degrees)
        if not self.local:
            self.follow(0, self.at(self.system.v, 0), self.at(self.system.q, 1), self.degrees)

    def follow(self, k: Index, source: Pointer, target: Pointer, count: int) -> None:
        """Coefficients k + 1 of so many numbers, from coefficients k of their rates."""
        f, vectors = self.f, self.vectors
        if vectors.parts == 1:
            assert k == 0
            self.copy(source, target, count)
            return
        divisor = vectors.divisor(k, 1)

        def write(i: Integer, lanes: int) -> None:
            vectors.store_row(vectors.divided(vectors.load_row(source, i, lanes), divisor), target, i)

        in_vectors(f, count, write)

    def copy(self, source: Pointer, target: Pointer, count: int) -> None:
        """Copy so many numbers."""
        vectors = self.vectors
        in_vectors(
            self.f, count, lambda i, lanes: vectors.store_row(vectors.load_row(source, i, lanes), target, i)
        )

    # what each kind of system has of its own

    @abstractmethod
    def prepared(self) -> Sequence[Total]:
        """The totals of every order, whose series are found."""

    @abstractmethod
    def accelerate(
        self, evaluation: Evaluation, k: Index, phase: int | None, span: Span | None = None
    ) -> None:
        """Coefficients k of the accelerations, all or some, from those of the forces."""

    @abstractmethod
    def regular(self) -> Bit:
        """Whether the masses are."""
