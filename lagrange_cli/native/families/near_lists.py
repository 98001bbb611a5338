"""Steps that look at guards near one another alone (``nearness``), with lists of these.

A list of candidates lasts for many steps (L. Verlet, Phys. Rev. 159, 1967). It is made with disks that are
larger than a step needs. As long as all coordinates stay in theirs, no other argument becomes 0, whatever
forces act and however velocities change: this takes an operation for each coordinate, and none for each pair.
Of the candidates, those that may become 0 within a step are listed for the step, and have series.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from lagrange_cli.families.arrays import Array, Chain, Slots, Source, Total
from lagrange_cli.native.families.evaluation import room
from lagrange_cli.native.families.jets import Jet
from lagrange_cli.native.families.loops import Loop
from lagrange_cli.native.families.member_lists import ListWriter, MemberList, each_of
from lagrange_cli.native.families.nearness import Enclosure, Watch, WatchedJet, enclosed, write_radii
from lagrange_cli.native.families.stage import SeriesWriter
from lagrange_cli.native.families.tables import before, place_at
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.vector import Bit, Index, Integer, Pointer, Real
from lagrange_cli.native.state import vectors_of
from lagrange_cli.native.stepping.near import NearPlaces
from lagrange_cli.native.stepping.proof import WIDER

FARTHER = 8.0
"""Candidates are found for times that are so much longer than those that are looked at, at first."""
MOST_FAR = 64.0
"""Lists with too many candidates are made anew where they are for so much longer times."""
MOST, FEWEST_STEPS = 8, 16
"""If more than one of so many members is a candidate, the next list is for a shorter time; if a list did not
last for so many steps, for a longer one."""
TIME, LASTS, STEPS, VALID = range(4)
"""Numbers of a list: when it was made, for how long, how often it was used, and whether there is one."""
REST = 2.0**-52
"""Of its size, a coordinate may move by as much as rounding does."""


def suits(arguments: Total, loops: Sequence[Loop | Chain], moving: Sequence[Array], slots: Slots) -> bool:
    """Whether all arguments are in loops of their own, of numbers that no mode changes."""
    own = enclosed(arguments, loops, moving)
    inside = slots.made_of([term.node for term in arguments.terms])
    modes = any(slot.array.source is Source.MODES for node in inside for _, slot in slots.inside(node))
    return len(own) == len(loops) and not modes


class ListEnclosure(ListWriter, Enclosure):
    """The code that lists for a step those candidates of a loop that may become 0 within it."""

    def choose(self, members: MemberList, near: MemberList, watch: Watch, marks: NearPlaces) -> None:
        """Take them from the ``members`` to what is ``near``."""
        f, self.members, layout = self.f, members, watch.layout
        base = (f.place("%state", one(layout), "double") for one in (watch.rows.mode, watch.rows.fresh))
        modes, fresh = base
        with f.loop(0, members.count, LANES) as j:
            values, inside = self.enclosed(self.gathered(j)), self.inside(j)
            wanted = f.never(LANES)
            for value, i in zip(values, members.targets):
                places = members.at(i, j)
                mode, mark = (self.gather(one, places) for one in (modes, fresh))
                wanted = wanted | ~((value * mode > 0.0) & (mark <= 0.0))
            with each_of(f, wanted & inside) as lane:
                near.add_from(members, j + lane)
                marks.mark(f, [members.place(i, j + lane) for i in dict.fromkeys(members.targets)])


class ListSeries(ListWriter, SeriesWriter):
    """Stage ``k`` of the series of the members of a list: coefficients k + 1 of the integrals of arguments go
    to the ``rows``."""

    def put_series(self, members: MemberList, rows: Pointer) -> None:
        """Compute and store them."""
        f, vectors = self.f, self.vectors
        self.members, self.block, divisor = members, f.count(0), vectors.divisor(self.k, 1)
        with f.loop(0, members.count, LANES) as j:
            known = {**self.evaluation.known, **self.gathered(j)}
            values = self.carefully(self.values(known, j), known, lambda one: one.gathered(j))
            for value, i in zip(values, members.targets):
                self._put(vectors.divided(vectors.number(value), divisor), rows, members.at(i, j))

    def _put(self, values: Real, rows: Pointer, places: Pointer) -> None:
        for lane in range(LANES):
            self.f.store(self.f.lane(values, lane), rows, place_at(self.f, lane, places))


class ListJet(WatchedJet):
    """The series of those arguments that may be 0 within ``%h``, by lists of these."""

    def prepared(self) -> Sequence[Total]:
        first = self.work
        totals = super().prepared()
        count, moving = self.integrands.count, (self.system.q, self.system.v)
        loops = [one[0].loop for one in self.loops if not isinstance(one, Chain)]
        sizes = count, vectors_of(count), LANES, LANES, count, count, len(self.parameters)
        marks, blocks, flag, *others = (self.take(room(one)) for one in sizes)
        self.kept = NearPlaces(marks, blocks, flag, first, listed=True)
        self.numbers, self.sure, self.wanted, self.given = others
        f, each = self.f, range(len(moving))
        self.radii, self.reach, self.centres = (
            [f.place("%work", self.take(room(self.degrees)), "double") for _ in each] for _ in range(3)
        )
        self.candidates, self.near = (
            [MemberList(f, self.tables, loop, self._at(self.take(MemberList.room(loop)))) for loop in loops]
            for _ in range(2)
        )
        self._list(loops, Real(f, "%h", 1))
        return totals

    @property
    def parameters(self) -> range:
        """The places of parameters among the settings."""
        return range(self.watch.rows.parameters)

    def _list(self, loops: Sequence[Loop], h: Real) -> None:
        """List those that are near."""
        f = self.f
        for one in self.near:
            with one.each() as j:
                self.kept.mark(f, [one.place(i, j) for i in dict.fromkeys(one.targets)], 0.0)
            one.empty()
        with f.when(h < math.inf):
            write_radii(self, self.watch.layout, h, self.radii)
            with f.when(~self._holds(h)):
                self._make(loops, h)
                self.kept.renew(f)
            with f.when(self.kept.is_stale(f)):
                self._choose()
            self._number(STEPS, self._number(STEPS) + 1.0)
            radii = dict(zip((self.system.q, self.system.v), self.radii))
            for loop, members, near in zip(loops, self.candidates, self.near):
                made = ListEnclosure(self.evaluation(0), loop, self._at(self.sure), radii, h)
                made.choose(members, near, self.watch, self.kept)
        with f.otherwise():
            for loop, near in zip(loops, self.near):
                with f.loop(0, loop.domain.count, tested=False) as member:
                    near.add(member)
                    self.kept.mark(f, near.of(member))
        for near in self.near:
            near.finish()

    def _at(self, place: int) -> Pointer:
        return self.f.place("%work", place, "double")

    def _number(self, which: int, value: Real | None = None) -> Real:
        """A number of the list of candidates, or its new value."""
        if value is None:
            return self.f.load("%work", self.numbers + which)
        self.f.store(value, "%work", self.numbers + which)
        return value

    def _holds(self, h: Real) -> Bit:
        """Whether the list of candidates is good for a step of ``h``."""
        f, wrong = self.f, self.f.variable(self.f.never(1))
        for part, (radius, reach, centre) in enumerate(zip(self.radii, self.reach, self.centres)):
            beyond = f.variable(f.never(LANES))
            with f.loop(0, self.degrees, LANES, tested=False) as i:
                away = f.magnitude(
                    f.load_row("%state", i + part * self.degrees, LANES) - f.load_row(centre, i, LANES)
                )
                inside = (away + f.load_row(radius, i, LANES)) * WIDER <= f.load_row(reach, i, LANES)
                beyond.set(beyond.get() | ~(inside | self._behind(i)))
            wrong.set(wrong.get() | f.any(beyond.get()))
        since = f.magnitude(Real(f, "%t", 1) - self._number(TIME))
        late = ~((since + h) * WIDER <= self._number(LASTS))
        far = self._many() & (self._number(LASTS) > h * MOST_FAR) & (h > 0.0)
        with f.loop(0, len(self.parameters)) as i:
            same = f.load("%state", i + self.watch.layout.settings.start).equals(
                f.load("%work", i + self.given)
            )
            wrong.set(wrong.get() | ~same)
        return ~(wrong.get() | late | far) & (self._number(VALID) > 0.0)

    def _behind(self, i: Integer) -> Bit:
        """Which of eight rows are none of coordinates."""
        return ~before(self.f, i, self.f.count(self.degrees))

    def _many(self) -> Bit:
        """Whether there are too many candidates."""
        count = sum((one.count for one in self.candidates), start=self.f.count(0))
        return count * MOST > sum(one.loop.domain.count for one in self.candidates)

    def _make(self, loops: Sequence[Loop], h: Real) -> None:
        """Find out which arguments are not 0 for a while."""
        f, before = self.f, self._number(LASTS)
        brief = (self._number(STEPS) < float(FEWEST_STEPS)) & (self._number(VALID) > 0.0)
        lasts = f.select(self._many(), before * 0.5, f.select(brief, before + before, before))
        usual = (lasts >= h * 2.0) & ~(self._many() & (lasts > h * MOST_FAR))
        lasts = f.select(usual, lasts, h * FARTHER)
        fastest = f.variable(f.zero(LANES))
        with f.loop(0, self.degrees, LANES, tested=False) as i:
            speed = f.magnitude(f.load_row("%state", i + self.degrees, LANES))
            fastest.set(f.larger(fastest.get(), f.select(self._behind(i), f.zero(LANES), speed)))
        way = f.splat(f.reduce("fmax", fastest.get()) * lasts, LANES)
        for part, (radius, reach, centre) in enumerate(zip(self.radii, self.reach, self.centres)):
            with f.loop(0, self.degrees, LANES, tested=False) as i:
                own, at = f.load_row(radius, i, LANES), f.load_row("%state", i + part * self.degrees, LANES)
                least = f.fused(f.magnitude(at), REST, own + own)
                f.store_row(least if part else f.larger(least, way), reach, i)
                f.store_row(at, centre, i)
        farthest = dict(zip((self.system.q, self.system.v), self.reach))
        for loop in loops:
            Enclosure(self.evaluation(0), loop, self._at(self.sure), farthest, lasts).write()
        with f.loop(0, len(self.parameters)) as i:
            f.store(f.load("%state", i + self.watch.layout.settings.start), "%work", i + self.given)
        one, none = f.constant(1.0), f.constant(0.0)
        for which, value in ((TIME, Real(f, "%t", 1)), (LASTS, lasts), (STEPS, none), (VALID, one)):
            self._number(which, value)

    def _choose(self) -> None:
        """List the candidates: those not known to be away from 0, on the side where the motion is."""
        f, rows, layout = self.f, self.watch.rows, self.watch.layout
        with f.loop(0, room(self.integrands.count), LANES, tested=False) as j:
            mode, mark = (f.load_row("%state", j + one(layout), LANES) for one in (rows.mode, rows.fresh))
            away = (f.load_row(self._at(self.sure), j, LANES) * mode > 0.0) & (mark <= 0.0)
            f.store_row(f.select(away, f.zero(LANES), f.vector([1.0] * LANES)), self._at(self.wanted), j)
        for one in self.candidates:
            one.empty()
            with f.loop(0, one.loop.domain.count, tested=False) as member:
                wanted = f.never(1)
                for guard in one.of(member):
                    wanted = wanted | (f.load(self._at(self.wanted), guard) > 0.0)
                with f.when(wanted):
                    one.add(member)
            one.finish()
        self.kept.renew(f, done=True)

    # the series

    def stage(self, k: Index, phase: int | None, windows: object) -> None:
        rows = self.vectors.place(self.at(self.system.v, k + 1), self.degrees)
        for (series, place), near in zip(self.series, self.near):
            ListSeries(self.evaluation(k), series, place, k, phase).put_series(near, rows)

    def write(self) -> Jet:
        f = self.f
        self.totals = self.prepared()
        self.bounded()
        operations = self.emitter.operations + self.stages()
        last = f.place(self.at(self.system.v, self.order), self.degrees, "double")
        for near in self.near:
            with near.each() as j:
                for i in dict.fromkeys(near.targets):
                    f.store(f.constant(0.0), last, near.place(i, j))
        f.give(self.regular())
        return Jet(f.text(), self.work, operations, self.kept)
