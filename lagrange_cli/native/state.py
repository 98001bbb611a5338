"""``StateLayout``: where the state of a motion has its parts, by name, for compiled code and its callers.

The rows are what is integrated. In memory they are followed by their low parts, which compensated summation
keeps (W. Kahan, CACM 8, 1965), and by the clock: t and what the stepper remembers from step to step. The
numbers of a double-double motion have a third part each, behind the clock.
"""

from __future__ import annotations

from enum import IntEnum

from lagrange_cli.records import dataclass

LANES = 8
"""Doubles of a vector: coefficients or samples that are worked on at once."""
CHANGES = 64.0
"""If so many modes change while t hardly does, the motion is held there, or ends."""
CLOCK = 2 * LANES
"""Doubles of memory for the clock."""


class Clock(IntEnum):
    """The numbers of the clock, by their place.

    After t, its low part and the last step: the distance to a critical point that no step may pass; the usual
    step; when a critical point was last passed, and the number of passes at nearly the same t; whether the
    last steps led away from one; and the number of steps whose prediction failed narrowly. Then, of the step
    from here: whether ever shorter steps were not accepted, whether a step over the critical point was not
    accepted either, and whether the cause is unknown.
    """

    TIME = 0
    TIME_LOW = 1
    STEP = 2
    GAP = 3
    USUAL_STEP = 4
    LAST_PASS = 5
    PASSES = 6
    LEAVING = 7
    NARROW_FAILURES = 8
    REFUSED = 9
    REFUSED_BEYOND = 10
    UNEXPLAINED = 11


@dataclass(frozen=True)
class StateLayout:
    """The rows of a motion's state: q, v, multipliers, then integrals, the last of which are cyclic momenta.

    ``quadratures`` are the integrals that change; ``cyclic`` the momenta that are constants of the motion.
    ``set`` numbers behind all parts are changed between steps only: the parameters, where these are kept with
    the state, and what goes with them."""

    degrees: int
    quadratures: int = 0
    cyclic: int = 0
    multipliers: int = 0
    set: int = 0

    @property
    def q(self) -> slice[int, int, None]:
        """The coordinates."""
        return slice(0, self.degrees)

    @property
    def v(self) -> slice[int, int, None]:
        """The velocities."""
        return slice(self.degrees, 2 * self.degrees)

    @property
    def motion(self) -> slice[int, int, None]:
        """Coordinates and velocities."""
        return slice(0, 2 * self.degrees)

    @property
    def lagrange_multipliers(self) -> slice[int, int, None]:
        """Those of constraints."""
        return slice(self.motion.stop, self.motion.stop + self.multipliers)

    @property
    def integrals(self) -> slice[int, int, None]:
        """Quadratures, and cyclic momenta."""
        return slice(self.lagrange_multipliers.stop, self.rows)

    @property
    def cyclic_momenta(self) -> slice[int, int, None]:
        """Those that stand for the velocities of cyclic coordinates."""
        return slice(self.rows - self.cyclic, self.rows)

    @property
    def rates(self) -> slice[int, int, None]:
        """What has a rate of its own: all but q."""
        return slice(self.degrees, self.rows)

    @property
    def rows(self) -> int:
        """How many there are."""
        return self.motion.stop + self.multipliers + self.quadratures + self.cyclic

    @property
    def width(self) -> int:
        """Doubles from the rows to their low parts, and from there to the clock."""
        return width_of(self.rows)

    def part(self, number: int) -> slice[int, int, None]:
        """The rows' parts in memory: the high ones are part 0, the low ones part 1."""
        return slice(number * self.width, number * self.width + self.rows)

    @property
    def clock(self) -> slice[int, int, None]:
        """The clock in memory."""
        return slice(2 * self.width, 2 * self.width + CLOCK)

    def at(self, number: Clock) -> int:
        """The place in memory of one of the clock's numbers."""
        return self.clock.start + number

    @property
    def time(self) -> int:
        """The place of t."""
        return self.at(Clock.TIME)

    @property
    def remembered(self) -> slice[int, int, None]:
        """The clock but for the time."""
        return slice(self.at(Clock.STEP), self.clock.stop)

    @property
    def third(self) -> int:
        """Where third parts begin."""
        return self.clock.stop

    @property
    def settings(self) -> slice[int, int, None]:
        """What is changed between steps only."""
        return slice(self.third + self.width, self.third + self.width + self.set)

    @property
    def memory(self) -> int:
        """Doubles of the state with all its parts."""
        return self.third + self.width + LANES * -(-self.set // LANES)


@dataclass(frozen=True)
class GuardRows:
    """Where the state has what guards need: the ``first`` row of their arguments' quadratures; for each guard
    the row of its multiplier, or 0 where there is none; their modes, among ``parameters`` of the run before
    them.

    A guard without a multiplier is simple: its mode is changed where its argument changes its sign.
    """

    first: int
    multipliers: tuple[int, ...]
    parameters: int

    @property
    def count(self) -> int:
        """How many guards there are."""
        return len(self.multipliers)

    def settings(self, parts: int) -> int:
        """Doubles that parameters, modes and marks take."""
        return parts * (self.parameters + self.count) + self.count

    def mode(self, layout: StateLayout) -> int:
        """The place of the first mode in memory."""
        return layout.settings.start + self.parameters

    def fresh(self, layout: StateLayout) -> int:
        """The place of the first mark: 1 where a guard's argument is 0 at the beginning of the next step."""
        return layout.settings.stop - self.count


def width_of(rows: int) -> int:
    """Doubles that so many rows of the state take: one vector, or several whole ones."""
    return next((width for width in (2, 4) if width >= rows), LANES * -(-rows // LANES))
