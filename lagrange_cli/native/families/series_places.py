"""Where the series of ``@jet`` are in memory, and what they are computed with."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

from lagrange_cli.families.arrays import Array, Chain, Total
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.native.families.acting import ActingLists, Spare, Where
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.lasting import Lasting
from lagrange_cli.native.families.loops import Loop, loops
from lagrange_cli.native.families.series import LoopSeries
from lagrange_cli.native.families.tables import Tables
from lagrange_cli.native.families.tiling import Tiling, tiling_of
from lagrange_cli.native.families.vectors import Divisor, Vectors
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Index, Pointer
from lagrange_cli.native.motions import RATES
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.state import StateLayout, whole_vectors
from lagrange_cli.records import dataclass, replace

HEAD = "define internal i1 @{}(ptr noalias %constants, {}, ptr noalias %state, ptr noalias %work) #0"
JET, MOTION, BRIEF, BESIDE, AT_ONCE = "jet", "motion", "accelerations", "beside", "at_once"
"""The names of the functions: all of a step's series, or the motion's alone, if others have a function of
their own; accelerations alone; series beside the motion's; and a few coefficients of all."""


def velocity_planes(rows: int) -> tuple[int, int]:
    """Where coefficient 0 of the velocities is, and how far it is from one to the next, if so many ``rows``
    are beside one another: these, and integrals behind them. Vectors may begin before them or end behind
    them: zeros are between coefficients."""
    return LANES, whole_vectors(rows, 1)


@dataclass(frozen=True, eq=False)
class JetSetting:
    """What the jets of a program have in common. ``places`` has where what lasts is, from the beginning of
    scratch in ``%constants`` on, and ``order`` is that of q's series. There may be ``spare`` room elsewhere
    than in ``%work``."""

    system: FamilySystem
    lasting: Lasting
    places: Mapping[Array, int]
    tables: Tables
    layout: StateLayout
    order: int
    kind: type[Vectors]
    spare: Spare | None = None


class SeriesPlaces:
    """The series of the velocities are at ``velocity_planes``."""

    local = True
    """Whether an order takes nothing but loops and ``accelerate``, and coordinates have no series of their
    own. (Double-double numbers have these: to compute them again and again takes longer.)"""
    tiled = True
    """Whether blocks of members may be taken through all orders one after the other."""
    head = HEAD
    """The head of the function."""
    shared = False
    """Whether several threads may compute them."""

    def __init__(self, setting: JetSetting, name: str = JET) -> None:
        self.setting, system, layout, kind = setting, setting.system, setting.layout, setting.kind
        self.system, self.slots, self.order = system, system.slots, setting.order
        self.lasting, self.tables = setting.lasting, setting.tables
        self.enter(Function(self.head.format(name, kind.times)))
        self.local = self.local and kind.parts == 1
        self.width, self.degrees, self.rates = layout.width, system.q.count, layout.rows - layout.degrees
        self.work = 0
        self.planes: dict[Array, tuple[int, int]] = self.of_state()
        """Where coefficient 0 of arrays is, and how far it is from one to the next."""
        self.loops: list[tuple[LoopSeries, int] | Chain] = []
        self.acting = ActingLists(self.tables, self.degrees, setting.spare or self.in_work)
        self.tiling: Tiling | None = None
        self.short: dict[int, str] = {}
        """The texts of short loops."""
        self.waiting: list[int] = []
        """Where the registers of each loop wait between blocks, for each order."""

    def enter(self, f: Function) -> None:
        """Write into this function from here on."""
        self.f, self.vectors = f, self.setting.kind(f)
        self.emitter: LaneEmitter = self.vectors.kind
        base = self.vectors.place("%constants", f.load_integer("@scratch"))
        self.places = {array: self.vectors.place(base, at) for array, at in self.setting.places.items()}
        self.time = self.vectors.operand(self.vectors.splat(self.vectors.now(), LANES))

    @contextmanager
    def within(self, f: Function) -> Iterator[None]:
        """Write into this function, and then go on in the one before."""
        before = self.f, self.vectors, self.emitter, self.places, self.time
        self.enter(f)
        yield
        self.f, self.vectors, self.emitter, self.places, self.time = before

    def take(self, doubles: int) -> int:
        """So many further ones of ``%work``."""
        self.work += doubles
        return self.work - doubles

    def in_work(self, doubles: int) -> Where:
        """The same, as ``Scratch.spare`` gives it."""
        at = self.take(doubles)
        return lambda vectors: vectors.place("%work", at)

    def at(self, array: Array, k: Index) -> Pointer:
        """Where coefficient k of an array is, or what it follows from (``scales``)."""
        if array not in self.planes:
            return self.places[array]
        if self.local and array is self.system.q and not (isinstance(k, int) and k == 0):
            array, k = self.system.v, k - 1
        first, step = self.planes[array]
        return self.vectors.place("%work", k * step + first)

    def scales(self, k: Index) -> dict[Array, Divisor]:
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

    def evaluation(self, k: Index) -> Evaluation:
        """What computes totals of order k."""
        return Evaluation(
            self.vectors, self.slots, lambda array: self.at(array, k), self.tables,
            {self.system.time: self.time}, self.scales(k),
        )  # fmt: skip

    def arrange(self, totals: Sequence[Total]) -> None:
        """Find the series of these totals, and places for all."""
        for total in totals:
            self.planes[total] = self.take(room(total.count)), 0
        moving = self.system.time.symbols | self.slots.symbols_of(*self.planes)

        def series_of(found: Sequence[Loop | Chain]) -> list[LoopSeries | Chain]:
            given = self.slots, moving, self.system.time, self.order
            return [one if isinstance(one, Chain) else LoopSeries(one, *given) for one in found]

        plain = loops(totals, self.slots)
        listed = series_of(plain)
        found = [one for one in listed if not isinstance(one, Chain)]
        if self.tiled and self.local and self.order > RATES and len(found) == len(listed):
            self.tiling = tiling_of(found, self.planes, self.degrees, self.order, shared=self.shared)
        if self.tiling is None:
            known: dict[Loop | Chain, LoopSeries | Chain] = {one.loop: one for one in found}
            listed = [known.get(one) or series_of([one])[0] for one in self.acting.parted(plain)]
        for i, one in enumerate(listed):
            if isinstance(one, Chain):
                self.loops.append(one)
                continue
            if self.tiling is not None:
                one = replace(one, kept=self.tiling.kept(i))
                self.waiting.append(self.take(LANES * len(one.loop.terms) * self.order))
            self.loops.append((one, 0 if self.acting.hold(one) else self.take(one.doubles)))
        if self.acting.lists:
            self.acting.make(self.evaluation(0))

    @property
    def series(self) -> list[tuple[LoopSeries, int]]:
        """All series, with their places in ``%work``."""
        return [one for one in self.loops if not isinstance(one, Chain)]
