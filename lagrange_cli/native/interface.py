"""``Interface``: everything that the callers of a compiled program must know, and what both sides agree
on."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from functools import cached_property
from typing import Any

from lagrange_cli.native.guards import (
    BESIDE,
    BREAK,
    EXPLICIT,
    LOOSE,
    PLACED,
    ROLES,
    ROOTS,
    SIMPLE,
    GuardRow,
    GuardRows,
    Role,
)
from lagrange_cli.native.state import LANES as LANES
from lagrange_cli.native.state import StateLayout
from lagrange_cli.records import dataclass, fields_of, replace

STEPPING = 6
"""The lowest order of q's series that can be stepped with."""
HIGHEST_ORDER = 40
"""The highest one that a tolerance asks for."""
CONSTANTS = 4
"""In a companion's program (see ``numbers.beside``), how much larger the rounding errors of constants are
that are computed from parameters and numbers before the motion begins."""


def low(name: str) -> str:
    """The name of the low part of an observed quantity."""
    return f"low {name}"


class Stop(IntEnum):
    """Why ``@advance`` returned."""

    END = 0
    SAMPLES = 1
    PAUSE = 2
    SINGULAR = 3
    NOT_FINITE = 4
    UNDERFLOW = 5
    GUARD = 6
    CRAWL = 7  # told by the caller of ``@advance``
    STUCK = 8
    ROOT = 9  # a force has no series here


ARRAYS = 8
"""Numbers of each row that the parts of a step take (``stepping.quadratures``)."""


def records_at(layout: StateLayout, work: int, parts: int) -> int:
    """Where records are in scratch; ``parts`` of integrals (0 if there are none)."""
    arrays = (ARRAYS + 2) * layout.width if parts else 0
    return layout.memory + layout.width + LANES + work + arrays


@dataclass(frozen=True)
class Interface:
    """What a program holds, and the sizes of the arrays that it works on, in doubles.

    ``order`` is that of q's series, ``degrees`` the number of coordinates. ``observed`` names the
    quantities that ``@observe`` computes, in their order; ``integrals`` the quadratures carried along,
    whose values follow q and v in the state, the last ``stored`` of them constants of the motion. (Where
    there are guards, steps have integrals of their arguments before these, whose values nobody needs.)
    The rates of a ``single`` state take so much of what steps ``work`` on, from its beginning.
    ``lanes`` is what eight motions at once work on; 0 where the program has no code for them. A number is the
    sum of ``parts`` doubles: rows of high parts come first; parameters are ``given`` in so many.
    ``guards`` has for each switch's guard (see ``mechanics.guards``) the number of its auxiliary
    coordinate, or ``SIMPLE``, ``ROOTED``, ``STEEP``, ``CUT``, ``BREAK``, ``EDGE``, ``EXPLICIT`` or
    ``PLACED``; ``silent`` are pairs of one that may hold the motion, and one whose mode is -1 while that of
    the first changes nothing;
    ``limits`` are those whose multipliers are forces up to a limit, ``vectors`` those of lengths, with a
    coordinate for each of their parts, whose velocity it is but for others; ``events`` for each event its
    direction, its role, and that number for resting contact, ``EXPLICIT`` where its force follows from other
    forces alone, ``LOOSE`` for an impact without contact, or ``SIMPLE``. ``changed`` are the new values that
    actions give: the event, and the place among q, q_dot and the parameters. ``affected`` are pairs of
    events: a simple action, and what it changes the argument of. The arguments of ``jumping`` events may come
    to their other side without being 0. ``reached`` are the coordinates on which impacts depend that act on
    one another (pairs of an event and a coordinate), if compiled code does these.
    If it does so while others touch, ``joined`` has for each coordinate itself or, where constraints have
    impulses then, one of those that they couple with it, and ``reached`` these. ``@act`` computes new values,
    two sizes of each event's argument, and the ``masses`` that actions change, of these particles.
    ``@speeds`` gives the rates of the arguments of impacts, if there may be contact. ``@constrain`` computes
    so many ``constraints``, their rates, and the entries of the matrix of the equations that ``pattern``
    names; only where an action may leave the constraints.
    ``series_at`` tells where series are in what steps work on: coefficient m of row i at the first number, i
    times the second and m times the third. Steps hand over so many numbers that are ``carried`` with the
    state. Several threads can share an evaluation in so many ``strips``; their ``board`` is in the constants.
    """

    order: int
    degrees: int
    parameters: tuple[str, ...]
    integrals: tuple[str, ...]
    stored: int
    observed: tuple[str, ...]
    constants: int
    work: int
    single: int
    lanes: int
    parts: int
    given: int
    guards: tuple[int, ...]
    silent: tuple[tuple[int, int], ...]
    events: tuple[tuple[int, int, int], ...]
    limits: tuple[int, ...]
    vectors: tuple[tuple[int, tuple[int, ...]], ...]
    changed: tuple[tuple[int, int], ...]
    affected: tuple[tuple[int, int], ...]
    jumping: tuple[int, ...]
    reached: tuple[tuple[int, int], ...]
    joined: tuple[int, ...]
    masses: tuple[str, ...]
    constraints: int
    pattern: tuple[tuple[int, int], ...]
    series_at: tuple[int, int, int]
    carried: int
    strips: int
    board: int

    @cached_property
    def state(self) -> StateLayout:
        """The places of the parts of a state, outside the stepping code."""
        return StateLayout(self.degrees, len(self.integrals) - self.stored, self.stored)

    @cached_property
    def auxiliary(self) -> int:
        """How many auxiliary coordinates there are, behind the others."""
        one_each = sum(one >= 0 for one in (*self.guards, *(event[2] for event in self.events)))
        return one_each + sum(len(pivots) - 1 for j, pivots in self.vectors if self.guards[j] >= 0)

    @cached_property
    def inner(self) -> StateLayout:
        """Where steps have the state's parts: with auxiliary coordinates and, where there are guards, with
        integrals of their arguments and settings."""
        settings = self.rows_of_guards.settings(self.given) if self.guarded else 0
        degrees = self.degrees + self.auxiliary
        quadratures = self.arguments + len(self.integrals) - self.stored
        return StateLayout(
            degrees, quadratures, self.stored, set=settings, carried=self.carried, parts=self.parts
        )

    @property
    def guarded(self) -> bool:
        """Whether steps end at something."""
        return bool(self.guards or self.events)

    @property
    def arguments(self) -> int:
        """How many integrals of guards' arguments steps have before others."""
        return self.rows_of_guards.arguments if self.guarded else 0

    @cached_property
    def rows_of_guards(self) -> GuardRows:
        """The places of the data of guards in that state: of switches, events and contacts."""
        degrees = self.degrees + self.auxiliary

        def multiplier(auxiliary: int) -> int:
            return 0 if auxiliary < 0 else degrees + self.degrees + auxiliary

        first, made = 2 * degrees, list[GuardRow]()
        for one in self.guards:
            role = ROLES.get(one, Role.HOLD)
            steep, side = ROOTS.get(one, (False, 0))
            alone = GuardRow(role, first + len(made), multiplier(one))
            made.append(replace(alone, rooted=one in ROOTS, steep=steep, side=side))
        jumping = set(self.jumping)
        for event, (direction, kind, _) in enumerate(self.events):
            made.append(GuardRow(Role(kind), first + len(made), 0, direction, jumps=event in jumping))
        for i, limited in enumerate(self.limits):
            limit = first + len(made) + 2 * i
            kind = self.guards[limited]
            row = limit if kind in (EXPLICIT, PLACED) else made[limited].multiplier
            made[limited] = replace(made[limited], multiplier=row, limit=limit, placed=kind == PLACED)
        arguments, switches = len(made) + 2 * len(self.limits), len(self.guards)
        for j, one in enumerate(self.guards):
            if one == BREAK:
                made[j] = replace(made[j], beside=first + arguments)
                arguments += BESIDE
        for j, pivots in self.vectors:
            made[j] = replace(made[j], beside=first + arguments, pivots=pivots)
            arguments += len(pivots)
            if self.guards[j] == EXPLICIT:
                made[j] = replace(made[j], multiplier=first + arguments)
                arguments += len(pivots)
        for event, (_, _, one) in enumerate(self.events, switches):
            if one == EXPLICIT:
                made.append(GuardRow(Role.REST, first + arguments, event=event))
                arguments += 1
            elif one >= 0:
                made.append(GuardRow(Role.REST, multiplier(one), event=event))
        changed = tuple((switches + event, self._inside(place)) for event, place in self.changed)
        affected = tuple((switches + a, switches + b) for a, b in self.affected)
        rests = (j for j, one in enumerate(made) if one.role is Role.REST)
        held = [(e, next(rests) if kind != LOOSE else -1) for e, (*_, kind) in self.slowing.items()]
        bounces = tuple((switches + e, rest) for e, rest in held) if self.bounces else ()
        reached = tuple((switches + e, place) for e, place in self.reached)
        return GuardRows(
            first, arguments, tuple(made), len(self.parameters), changed, affected, bounces, reached,
            self.joined, self.degrees, bool(self.constraints),
        )  # fmt: skip

    def _inside(self, place: int) -> int:
        """A place among q, q_dot and the parameters, where auxiliary coordinates are among these."""
        return place + self.auxiliary * (place >= self.degrees) + self.auxiliary * (place >= 2 * self.degrees)

    @cached_property
    def places(self) -> Any:
        """The rows and the columns of the ``pattern``."""
        import numpy as np

        return np.array(self.pattern, dtype=np.int64).reshape(-1, 2).T

    @property
    def rows(self) -> int:
        """Rows of the state: q, v and the integrals."""
        return self.state.rows

    @property
    def quantities(self) -> tuple[str, ...]:
        """The rows of what ``@observe`` computes: the names, and where numbers have low parts, theirs."""
        return self.observed + tuple(map(low, self.observed)) * (self.parts - 1)

    @property
    def trial(self) -> int:
        """Doubles of scratch: a copy of the state, what ``@advance`` expects of its rates, the next clock; a
        series ahead, and what parts of steps need; records of events, a state without auxiliary coordinates,
        if there are any, what ``@act`` gives, and rates of contacts' arguments. Where impacts at one time are
        followed, the last two are the length of a step, and the size of the time when the motion began."""
        return (
            self.records
            + (self.rows_of_guards.records(self.inner) * self.inner.memory + self.acted if self.events else 0)
            + (len(self.bounces) + 2 if self.joined else 0)
            + (2 * self.degrees if self.auxiliary else 0)
        )

    @property
    def acted(self) -> int:
        """How many numbers ``@act`` computes."""
        return len(self.changed) + 2 * len(self.events) + len(self.bounces) + len(self.masses)

    @cached_property
    def slowing(self) -> dict[int, tuple[int, int, int]]:
        """The events that are impacts which reduce the speed."""
        return {e: one for e, one in enumerate(self.events) if one[2] != SIMPLE}

    @cached_property
    def bounces(self) -> tuple[int, ...]:
        """Those, if compiled code does the actions of any of these: ``@act`` computes the rates of their
        arguments after them, too."""
        return tuple(self.slowing) if any(role == Role.CHANGE for _, role, _ in self.slowing.values()) else ()

    @property
    def records(self) -> int:
        """Where records of crossings are behind it, each the state's memory."""
        followed = self.inner.quadratures + self.inner.cyclic
        return records_at(self.inner, self.work, self.parts if followed else 0)

    def as_data(self) -> dict[str, Any]:
        """The fields in terms of JSON."""
        return {name: getattr(self, name) for name in fields_of(Interface)}

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Interface:
        """What ``as_data`` gave, after JSON."""
        return cls(**{name: _tuples(value) for name, value in data.items()})


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, list) else value
