"""Guards in the state: what ends a step, where its argument is in the state, and what is kept of it.

Compiled code and its callers agree on this, as on all of the state (``native.state``).
"""

from __future__ import annotations

from enum import IntEnum
from functools import cached_property

from lagrange_cli.native.state import LANES, Clock, StateLayout
from lagrange_cli.records import dataclass

SMALL = 2.0**-36
"""An argument that is a larger part of what it may be computed from is not 0 up to rounding."""
AT_REST = 2.0**-80
"""An argument that rests at 0, with no force that holds it, moves again where it has become so large; or as
large as its negative mark, where it is known less well."""
HELD = 1.0 + 2.0**-40
"""Multipliers up to this hold the motion: at the bound itself, rounding does not decide."""
RIDES, RIDDEN = 1.5, 3.0
"""The same as ``mechanics.guards.modes`` has, for those that do not import it: of modes of friction that
constraints bind to what others hold."""
CHANGES, EACH = 64.0, 4.0
"""If so many modes change while t hardly does, or so many for each guard, the motion is held there, or
ends."""
FOUND = 8
"""The order of q's series at single states: of arguments, as many derivatives less two are looked at."""
BRIEF, NOWHERE = 2.0**-38, 2.0**-50
"""A step that is so small a fraction of the one before it, or of t, changes nothing: what was 0 up to
rounding, still is."""
SMALLEST, TRIED = 2.0**-1022, 2.0**-1040
"""The least mark of an argument that is 0, and that of one from which no way across was found."""
INFO, DUE, RECORDED, HALTED = 6, 3, 4, 5
"""Numbers in ``%info``; the places of the guard that is due, of the number of records, and of what asks to
leave a step that is divided very often (if it is not 0)."""
SIMPLE, CUT, BREAK, EXPLICIT, ROOTED, PLACED, STEEP, LOOSE, EDGE = range(-1, -10, -1)
"""Guards without an auxiliary coordinate. ``EXPLICIT``: with limits alone, which do not depend on other
guards that hold the motion; ``PLACED``: the same of an argument that is no velocity, but a place;
``ROOTED``: forces contain a root of the argument; ``STEEP``: one whose slope is infinite at 0; ``LOOSE``: an
impact that reduces the speed, after which nothing rests; ``EDGE``: where the
motion ends."""
SIDES = {0: 0, 1: -16, -1: -32}
"""What is added to ``ROOTED`` and ``STEEP`` where the root is on one side only."""
COSTLY = 256
"""Steps of a state with so many rows take longer than what decides in their place whether fewer will do."""
UNSEEN = 2.0**-47
"""A flight no higher than this part of the argument's terms may be hidden by rounding, for methods that know
values of the argument instead of its series: they would miss the next impact."""
RECORDS, MOST_RECORDS, ROOM = 32, 4096, 2**21
"""Crossings of which compiled code keeps a record before they are taken from it: at least, at most, and in so
many doubles."""
NOTES = Clock.STEP, Clock.GAP, Clock.USUAL_STEP, Clock.LAST_PASS
"""Where a record has the number of the guard, and three coefficients of its argument's series, from its rate
on."""
SAMPLE, AFTER = Clock.LEAVING, -1.0
"""Where it has the number of samples before it; and the number of the record that follows, of the state after
a simple action."""
ENDS, ENDLESS = NOTES[1:3]
"""Where that has when infinitely many impacts end, and whether they do."""
DONE, LEFT = 1, 0
"""The results of functions that do what an event does: it is done, or left to the caller."""
BESIDE = 3
"""Rows that a guard has where something jumps."""


class Role(IntEnum):
    """What a guard is for: a switch, which is simple, or one that may hold the motion; an event of which no
    more than a record is made, one whose action is simple, or one with another action; resting contact; the
    cut of a function in other arguments, which a step goes a little beyond; one where an energy jumps, or
    something has no value beyond; one beyond which something has none."""

    SWITCH = 0
    HOLD = 1
    RECORD = 2
    CHANGE = 3
    ACTION = 4
    REST = 5
    CUT = 6
    BREAK = 7
    EDGE = 8


EVENTS = Role.RECORD, Role.CHANGE, Role.ACTION
"""Those of events."""
ROOTS = {kind + more: (kind == STEEP, side) for kind in (ROOTED, STEEP) for side, more in SIDES.items()}
"""Guards whose forces contain a root: whether it is steep, and the side that has one (0: both)."""
ROLES = {**dict.fromkeys((SIMPLE, *ROOTS), Role.SWITCH), CUT: Role.CUT, BREAK: Role.BREAK, EDGE: Role.EDGE}
"""Those of guards without an auxiliary coordinate."""


def rooted_kind(steep: bool, side: int) -> int:
    """The kind of a guard whose forces contain roots."""
    return (STEEP if steep else ROOTED) + SIDES[side]


@dataclass(frozen=True)
class GuardRow:
    """A guard: the ``row`` of the state whose rate is its argument; the row of its ``multiplier``, or 0 (of
    limits alone, the first of them); the ``direction`` in which an argument's sign must change for an event
    (0: any); the first of two rows whose rates are a ``limit`` plus the multiplier, and minus it, or 0 where
    the limit is 1; and of those ``beside`` a break, whose rates tell whether there is one (see
    ``mechanics.switching.cuts``)."""

    role: Role
    row: int
    multiplier: int = 0
    direction: int = 0
    limit: int = 0
    beside: int = 0
    rooted: bool = False
    """Whether forces contain a root of the argument: they have no series where it is 0."""
    steep: bool = False
    """Whether they are infinitely steep there."""
    side: int = 0
    """The sign of the argument on the only side with roots; 0 if both sides have some."""
    placed: bool = False
    """Whether the argument is a place: the motion may pass through 0 whatever its multiplier is."""

    jumps: bool = False
    """Whether the argument of an event may come to its other side without being 0."""
    event: int = -1
    """Of resting contact, the guard of its event."""
    pivots: tuple[int, ...] = ()
    """Of the length of a vector, a coordinate for each of its parts, whose velocity it is but for others: the
    rows of parts are ``beside``, and as many multipliers follow one another."""

    @property
    def parts(self) -> int:
        """How many parts a vector has whose length it is."""
        return len(self.pivots)

    @property
    def alone(self) -> bool:
        """Whether the force that holds a vector follows from other forces alone."""
        return bool(self.pivots) and self.multiplier == self.beside + self.parts

    @property
    def limited(self) -> bool:
        """Whether what holds the motion follows from other forces alone: it has limits and no row of its
        own."""
        return bool(self.limit) and self.multiplier == self.limit

    @property
    def explicit(self) -> bool:
        """Whether it is held then whenever its argument, a velocity, is 0 and its limits allow it."""
        return self.limited and not self.placed


@dataclass(frozen=True)
class GuardRows:
    """The guards in the state: their modes are kept among ``settings``, behind the ``parameters`` of the run.

    The arguments' quadratures are the ``arguments`` rows from the ``first`` integral on.
    """

    first: int
    arguments: int
    guards: tuple[GuardRow, ...]
    parameters: int
    changed: tuple[tuple[int, int], ...] = ()
    """The new values that simple actions give: the guard, and the place among q, q_dot and the parameters."""
    affected: tuple[tuple[int, int], ...] = ()
    """Guards with such an action, each with those whose arguments it changes."""
    bounces: tuple[tuple[int, int], ...] = ()
    """Guards of impacts that reduce the speed, each with that of its contact, or -1 where it has none; if the
    actions of any of these are simple."""
    reached: tuple[tuple[int, int], ...] = ()
    """Guards of impacts that act on one another, each with the coordinates on which it depends: an action is
    simple only while no other one touches that depends on what it sets."""
    joined: tuple[int, ...] = ()
    """If compiled code follows impacts at one time: for each coordinate one of those that constraints couple
    with it, the same of all of these, if constraints have impulses after simple actions; else itself."""
    degrees: int = 0
    """How many coordinates are not auxiliary."""
    constrained: bool = False
    """Whether there are constraints."""

    @property
    def count(self) -> int:
        """The number of guards."""
        return len(self.guards)

    @property
    def changes(self) -> float:
        """So many modes may change while t hardly does."""
        return max(CHANGES, EACH * self.count)

    @property
    def bound(self) -> bool:
        """Whether what holds the motion has limits of its own, and may hold it together by constraints."""
        return self.constrained and any(one.explicit for one in self.guards)

    @property
    def events(self) -> int:
        """The number of guards that are for events."""
        return sum(one.role in EVENTS for one in self.guards)

    @property
    def switches(self) -> int:
        """The number of those before them: of switches."""
        return next((j for j, one in enumerate(self.guards) if one.role in EVENTS), self.count)

    @property
    def first_event(self) -> int:
        """The guard of the first event."""
        return next(j for j, one in enumerate(self.guards) if one.role in EVENTS)

    @property
    def standing(self) -> list[int]:
        """The guards of events whose arguments may be 0 for as long as a switch holds the motion: that of
        resting contact is 0 whatever switches do."""
        contacts = {one.event for one in self.guards}
        return [j for j, one in enumerate(self.guards) if one.role in EVENTS and j not in contacts]

    @cached_property
    def side_by_side(self) -> int:
        """How many guards, the first ones, have arguments side by side, in whole vectors."""
        first = self.guards[0].row
        beside = next((j for j, one in enumerate(self.guards) if one.row != first + j), self.count)
        return beside - beside % LANES

    @cached_property
    def vectors(self) -> tuple[int, ...]:
        """The guards of lengths of vectors."""
        return tuple(j for j, one in enumerate(self.guards) if one.pivots)

    def settings(self, parts: int) -> int:
        """Doubles that parameters, modes, times of events and marks take."""
        return parts * (self.parameters + self.count) + 2 * self.events + self.count

    def records(self, layout: StateLayout) -> int:
        """Crossings of which a record may be kept. Where steps are on rates, it is the caller that finds out
        that a motion rests, whose velocities are rounding errors."""
        many = self.bounces or not layout.carried
        return max(RECORDS, min(MOST_RECORDS, ROOM // layout.memory)) if many else RECORDS

    def mode(self, layout: StateLayout) -> int:
        """The place of the first mode in memory."""
        return layout.settings.start + self.parameters

    def times(self, layout: StateLayout) -> slice[int, int, None]:
        """The places of the times, with low parts, at which events have acted last; nan where they have
        not."""
        return slice(self.fresh(layout) - 2 * self.events, self.fresh(layout))

    def fresh(self, layout: StateLayout) -> int:
        """The place of the first mark: where a guard's argument is 0 at the beginning of the next step, the
        length of the step before; else 0."""
        return layout.settings.stop - self.count
