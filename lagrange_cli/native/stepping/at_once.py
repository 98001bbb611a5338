"""Impacts of bodies that constraints join, while others touch: which comes first, and what it does to these.

Impulses of constraints move all that is joined. A contact at which the motion rests ends where they give it a
speed; what they drive back is hit next, at the same time, the fastest first. Compiled code decides only where
all speeds are far above rounding: whether bodies rest, and which of them, is left to its caller
(``integrate.impacts.touching``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

from lagrange_cli.native.guards import SMALLEST, GuardRows, Role
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.state import Clock, StateLayout
from lagrange_cli.records import dataclass

TOUCHING = 2.0**-34
"""Up to this part of its terms an argument may be 0 at the same time as another one, but for what rounding
does along a long way."""
ROUNDING = 2.0**-44
"""An argument that is so small beside its terms is a rounding error."""
LEFT = 2.0**-50
"""One that is so small is 0 as far as rounding lets it be: more of it takes time, if the speed is small."""
CLEAR = 2.0**-40
"""Relative speeds that are more than this part of the largest velocity are no rounding errors."""
HIDDEN = 2.0**-36
"""Nor do flights end in no time that take longer than this part of a step (``integrate.impacts.resting``)."""
SOON, SHORT, NEARLY = 2.0**-30, 2.0**-26, 1.25
"""When all further impacts take no time (the same place), as far as the forces before an impact tell."""
ALIKE = 2.0**-40
"""Speeds that differ by this part are the same but for rounding."""
NOTHING = -1
"""In tables, of guards that are no impacts which reduce the speed, or have no contact."""
UNCLEAR, LEAVES = -1, -2
"""What ``@first_impact`` gives where the caller decides, and where bodies have touched and go apart."""


@dataclass(frozen=True)
class Other:
    """A contact, number ``k``, of guard ``j``: the mode in which it is ``held``, at guard ``rest``; its
    ``value`` and its terms' ``size``."""

    k: Integer
    j: Integer
    rest: Integer
    held: Real
    value: Real
    size: Real


@dataclass(frozen=True)
class Speeds:
    """The ``largest`` velocity, and the ``least`` speed that tells that something moves. If all further
    impacts at a contact are over ``soon``, the motion may rest there."""

    largest: Real
    least: Real
    soon: Real


@dataclass(frozen=True)
class AtOnce:
    """Writes the code for them. Of series, ``term`` and ``row`` are doubles from a coefficient to the next
    one, and from an argument to the next one; ``own`` loops over what the action of an event sets. Behind so
    many results of ``@act`` are other numbers (``Interface.trial``)."""

    rows: GuardRows
    layout: StateLayout
    term: int
    row: int
    own: Callable[[Function, Integer], AbstractContextManager[Integer]]
    behind: int

    def mode(self, f: Function, j: Integer) -> Real:
        """The mode of a guard."""
        return f.load("%state", j + self.rows.mode(self.layout))

    def mark(self, f: Function, j: Integer) -> Real:
        """The mark of its argument."""
        return f.load("%state", j + self.rows.fresh(self.layout))

    @contextmanager
    def touching(self, f: Function, j: Integer, results: Pointer, *, moved: bool = True) -> Iterator[Other]:
        """Other contacts that may be at 0 now, or are held: of what the action of ``j`` has ``moved``, or of
        all."""
        rows, row = self.rows, f.pointer("%row")
        count = len({guard for guard, _ in rows.reached})
        places = "@moved" if rows.joined else "@changed_places"
        with f.loop(0, count, tested=False) as k:
            other = f.load_integer("@touching", k)
            rest = f.load_integer("@rests_at", other)
            held = self.mode(f, rest)
            size = f.load(results, (other - rows.first_event) * 2 + len(rows.changed))
            value = self.coefficient(f, row, j, other, 1)
            near = ~held.equals(0.0) | (self.mark(f, other) > 0.0) | ~(f.magnitude(value) > size * TOUCHING)
            with f.when(near & ~other.equals(j)):
                one = Other(k, other, rest, held, value, size)
                if not moved:
                    yield one
                    return
                meets = f.variable(f.never(1))
                first, last = (f.load_integer("@reached_first", each) for each in (k, k + 1))
                with f.loop(first, last) as r:
                    place = f.load_integer("@reached", r)
                    with self.own(f, j) as i:
                        meets.set(meets.get() | f.load_integer(places, i).equals(place))
                with f.when(meets.get()):
                    yield one

    def coefficient(self, f: Function, row: Pointer, j: Integer, other: Integer, m: int) -> Real:
        """One of the argument's series of a guard, where that of ``j`` is at ``row``."""
        apart = f.load_integer("@guard_rows", other) - f.load_integer("@guard_rows", j)
        return f.load(row, apart * self.row + m * self.term) * float(m)

    def largest(self, f: Function) -> Real:
        """The largest velocity; what forces of contact have added up to is none."""
        found, first = f.variable(f.constant(0.0)), self.layout.degrees
        with f.loop(first, first + self.rows.degrees, tested=False) as i:
            found.set(f.larger(f.magnitude(f.load("%state", i)), found.get()))
        return found.get()

    def speeds(self, f: Function, j: Integer, results: Pointer) -> Speeds:
        """The speeds that others are compared with."""
        largest, bend = self.largest(f), f.variable(f.constant(0.0))
        with f.loop(0, len({guard for guard, _ in self.rows.reached}), tested=False) as k:
            other = f.load_integer("@touching", k)
            found = f.magnitude(self.coefficient(f, f.pointer("%row"), j, other, 3))
            bend.set(f.larger(found, bend.get()))
        step, pull = self.length(f, results), f.variable(f.constant(0.0))
        with f.loop(0, self.rows.degrees, tested=False) as i:
            velocity = i + self.layout.degrees - f.load_integer("@guard_rows", j)
            pull.set(f.larger(f.magnitude(f.load("%row", velocity * self.row + self.term)), pull.get()))
        usual = f.select(pull.get() * step > largest, largest / pull.get(), step)
        soon = f.larger(step * SOON, usual * SHORT) * NEARLY
        return Speeds(largest, f.larger(largest * CLEAR, bend.get() * step * HIDDEN), soon)

    def length(self, f: Function, results: Pointer) -> Real:
        """The length of the last step, also where others act now."""
        step = f.load("%state", self.layout.at(Clock.STEP))
        return f.select(step > 0.0, step, f.load(results, self.behind + len(self.rows.bounces)))

    def first(self, act: Callable[[Function], Pointer]) -> Function:
        """``@first_impact(state, constants, j, trial, row)``: of the impacts that happen now, one of which is
        at guard ``j``, the fastest in terms of rounding errors. ``act`` computes what actions set."""
        f = Function(
            "define internal i64 @first_impact(ptr %state, ptr %constants, i64 %j, ptr %trial, ptr %row) #0"
        )
        rows, j, results = self.rows, Integer(f, "%j"), act(f)
        known = self.speeds(f, j, results)

        def speed(one: Integer) -> Real:
            """How fast an argument comes to 0."""
            return -(self.coefficient(f, f.pointer("%row"), j, one, 2) * self.mode(f, one))

        def beside(value: Real, one: Integer) -> Real:
            """In terms of what rounding errors are a part of."""
            size = f.load(results, (one - rows.first_event) * 2 + (len(rows.changed) + 1))
            return value / f.larger(size, known.largest)

        with f.when(self.leaves(f, j, results)):
            f.give(f.count(LEAVES))
        fastest = f.variable(beside(speed(j), j))

        @contextmanager
        def others() -> Iterator[tuple[Other, Real]]:
            """Those that may come first, and how fast they are."""
            with self.touching(f, j, results, moved=False) as one, f.when(one.held.equals(0.0)):
                towards = f.load_integer("@guard_directions", one.j).to_real() * self.mode(f, one.j) <= 0.0
                with f.when(towards):
                    yield one, beside(speed(one.j), one.j)

        with others() as (one, this):
            with f.when(self.unclear(f, one, speed(one.j), results)):
                f.give(f.count(UNCLEAR))
            fastest.set(f.select(self.now(f, one), f.larger(this, fastest.get()), fastest.get()))
        least = fastest.get() - f.magnitude(fastest.get()) * ALIKE
        last = f.count(rows.count)
        chosen = f.variable(f.select(beside(speed(j), j) >= least, j, last))
        with others() as (one, this):
            first = self.now(f, one) & (this >= least) & (one.j < chosen.get())
            chosen.set(f.select(first, one.j, chosen.get()))
        simple = f.load_integer("@guard_roles", chosen.get()).equals(Role.CHANGE)
        f.give(f.select(simple, chosen.get(), f.count(UNCLEAR)))
        return f

    def leaves(self, f: Function, j: Integer, results: Pointer) -> Bit:
        """Whether an argument that was 0, but for rounding, moves away from 0, to the side where it is."""
        row, place = f.pointer("%row"), (j - self.rows.first_event) * 2 + len(self.rows.changed)
        value, rate = (self.coefficient(f, row, j, j, m) * self.mode(f, j) for m in (1, 2))
        size, most = (f.load(results, place + ahead) * ROUNDING for ahead in range(2))
        return ~(self.mark(f, j) > 0.0) & (f.magnitude(value) <= size) & (rate > most)

    def now(self, f: Function, one: Other) -> Bit:
        """Whether something that is not held may be hit now."""
        return (self.mark(f, one.j) > 0.0) | ~(f.magnitude(one.value) > one.size * LEFT)

    def unclear(self, f: Function, one: Other, speed: Real, results: Pointer) -> Bit:
        """Whether something with this ``speed`` may be hit at the same time but for what rounding does along
        the way (``integrate.impacts.touching``), or a little later."""
        start = f.load(results, self.behind + len(self.rows.bounces) + 1)
        reached = (f.magnitude(f.load("%state", self.layout.time)) + start) * speed * (NEARLY * ROUNDING)
        return ~self.now(f, one) & ~(f.magnitude(one.value) > reached) & (speed > 0.0)

    def stands(self, size: Real, known: Speeds) -> Bit:
        """Whether a speed is nothing but a rounding error."""
        return size <= known.largest * ROUNDING

    def frees(self, f: Function, j: Integer, speeds: Pointer, results: Pointer, known: Speeds) -> Bit:
        """Whether an impact ends contacts: gives the motion a speed there, as ``speeds`` tell."""
        found = f.variable(f.never(1))
        with self.touching(f, j, results) as one:
            stands = self.stands(f.magnitude(f.load(speeds, one.k)), known)
            found.set(found.get() | (~one.held.equals(0.0) & ~stands))
        return found.get()

    def release(
        self, f: Function, j: Integer, speeds: Pointer, results: Pointer, known: Speeds, rests: Bit,
        settles: Bit,
    ) -> tuple[Bit, Bit]:  # fmt: skip
        """End the contacts at which an impact has given the motion a speed, and tell whether another impact
        comes next, or it is clear which contacts hold; else change nothing. ``speeds`` are those of all
        contacts' arguments now. Where the motion may come to rest at ``j``, and its speed there has been
        taken away (``settles``), tell, too, whether nothing else happens, so that it ``rests``. A speed that
        does not end a contact, but is more than rounding leaves, would add up: the caller decides on it."""
        rows, layout, state = self.rows, self.layout, f.pointer("%state")
        holds, never = rests & settles, f.never(1)
        clear, due, pressed, freed = (
            f.variable(one) for one in (Bit(f, "true"), never, rests & ~settles, never)
        )
        with self.touching(f, j, results) as one:
            held = ~one.held.equals(0.0)
            speed = f.load(speeds, one.k) * f.select(held, one.held, self.mode(f, one.j))
            stands, moves = self.stands(f.magnitude(speed), known), f.magnitude(speed) > known.least
            clear.set(clear.get() & (stands | moves))
            due.set(due.get() | (moves & (speed < 0.0)))
            pressed.set(pressed.get() | (stands & ~held))
            freed.set(freed.get() | (held & ~stands))
        with self.touching(f, j, results, moved=False) as one:  # another impact now may have left a speed
            speed = f.magnitude(f.load(speeds, one.k))
            drifts = self.stands(speed, known) & (speed > known.largest * LEFT)
            pressed.set(pressed.get() | (~one.held.equals(0.0) & drifts))
        clear.set(due.get() | (clear.get() & ~pressed.get() & ~(holds & freed.get())))
        with f.when(clear.get()):
            mark = f.larger(f.load(state, layout.at(Clock.LENGTH)), f.constant(SMALLEST))
            with self.touching(f, j, results) as one:
                moves = ~self.stands(f.magnitude(f.load(speeds, one.k)), known)
                with f.when(~one.held.equals(0.0) & moves):
                    f.store(one.held, state, one.j + rows.mode(layout))
                    f.store(mark, state, one.j + rows.fresh(layout))
                    f.store(f.constant(0.0), state, one.rest + rows.mode(layout))
        return clear.get(), holds


def hits(f: Function, j: Integer) -> Bit:
    """Whether the guard ``j`` is that of an impact at which the motion may rest, with a simple action."""
    simple = f.load_integer("@guard_roles", j).equals(Role.CHANGE)
    return simple & ~f.load_integer("@rests_at", j).equals(NOTHING)


def without_auxiliary(f: Function, rows: GuardRows, layout: StateLayout, place: Pointer) -> Pointer:
    """The coordinates and velocities of a state alone: copied to a ``place``, if there are others."""
    state, degrees = f.pointer("%state"), rows.degrees
    if degrees == layout.degrees:
        return state
    for part in range(2):
        f.copy_rows((state, part * layout.degrees), (place, part * degrees), degrees, 1)
    return place


def write_speeds(f: Function, rows: GuardRows, layout: StateLayout, results: Pointer, to: Pointer) -> None:
    """Compute the rates of contacts' arguments in a state; in front of ``results`` there is room."""
    room = f.place(results, -2 * rows.degrees, "double") if rows.degrees < layout.degrees else results
    moving, time, one = without_auxiliary(f, rows, layout, room), f.place("%state", layout.time), f.count(1)
    f.call(None, "speeds", f.pointer("%constants"), time, moving, to, one, one)
    contacts = {guard for guard, _ in rows.reached}
    numbers = [n for n, (guard, _) in enumerate(rows.bounces) if guard in contacts]
    for k, n in enumerate(numbers):
        if n != k:  # others have no contact
            f.store(f.load(to, n), to, k)
