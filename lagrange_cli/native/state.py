"""``StateLayout``: where the state of a motion has its parts, by name, for compiled code and its callers.

The rows are what is integrated. In memory they are followed by their low parts, which compensated summation
keeps (W. Kahan, CACM 8, 1965), and by the clock: t and what the stepper remembers from step to step. The
numbers of a double-double motion have a third part each, behind the clock. Rounding errors of rates, where
they are known, are in the place of these in doubles, and behind them in double-double.
"""

from __future__ import annotations

from enum import IntEnum
from functools import cached_property

from lagrange_cli.records import dataclass

LANES = 8
"""Doubles of a vector: coefficients or samples that are worked on at once."""
CARRIED_COUNT = 2
"""The place of the number of evaluations among what a method carries."""
CLOCK = 2 * LANES
"""Doubles of memory for the clock."""


class Clock(IntEnum):
    """The numbers of the clock, by their place.

    After t, its low part and the last step: the distance to a critical point that no step may pass; the usual
    step; when a critical point was last passed, and the number of passes at nearly the same t; whether the
    last steps led away from one; and the number of steps whose prediction failed narrowly. Then, of the step
    from here: whether ever shorter steps were not accepted, whether a step over the critical point was not
    accepted either, and whether the cause is unknown. Where there are guards, the length of the last step,
    unless it is brief (``native.guards.BRIEF``), and how often the state was moved back to its constraints.
    Last, what tells whether steps become shorter without end (see ``integrate.methods.crawling``).
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
    LENGTH = 12
    PROJECTIONS = 13
    MARK = 14
    PROGRESS = 15


BEGINNING = (
    Clock.STEP, Clock.GAP, Clock.USUAL_STEP, Clock.LEAVING, Clock.NARROW_FAILURES,
    Clock.REFUSED, Clock.REFUSED_BEYOND, Clock.UNEXPLAINED,
)  # fmt: skip
"""The parts of the clock that are reset where other equations begin to hold: steps that were not accepted
before tell nothing about these."""


@dataclass(frozen=True)
class StateLayout:
    """The rows of a motion's state: q, v, multipliers, then integrals, the last of which are cyclic momenta.

    ``quadratures`` are the integrals that change; ``cyclic`` the momenta that are constants of the motion.
    ``set`` numbers behind all parts are changed between steps only: the parameters, where these are kept with
    the state, and what goes with them. So many numbers behind these are ``carried`` by a method from step to
    step. Numbers are sums of so many ``parts``."""

    degrees: int
    quadratures: int = 0
    cyclic: int = 0
    multipliers: int = 0
    set: int = 0
    carried: int = 0
    parts: int = 1

    @cached_property
    def q(self) -> slice[int, int, None]:
        """The coordinates."""
        return slice(0, self.degrees)

    @cached_property
    def v(self) -> slice[int, int, None]:
        """The velocities."""
        return slice(self.degrees, 2 * self.degrees)

    @cached_property
    def motion(self) -> slice[int, int, None]:
        """Coordinates and velocities."""
        return slice(0, 2 * self.degrees)

    @property
    def lagrange_multipliers(self) -> slice[int, int, None]:
        """The multipliers of constraints."""
        return slice(self.motion.stop, self.motion.stop + self.multipliers)

    @cached_property
    def integrals(self) -> slice[int, int, None]:
        """Quadratures, and cyclic momenta."""
        return slice(self.lagrange_multipliers.stop, self.rows)

    @cached_property
    def cyclic_momenta(self) -> slice[int, int, None]:
        """The momenta that stand for the velocities of cyclic coordinates."""
        return slice(self.rows - self.cyclic, self.rows)

    @property
    def rates(self) -> slice[int, int, None]:
        """The rows with rates of their own: all but q."""
        return slice(self.degrees, self.rows)

    @cached_property
    def rows(self) -> int:
        """The number of rows."""
        return self.motion.stop + self.multipliers + self.quadratures + self.cyclic

    @cached_property
    def width(self) -> int:
        """Doubles from the rows to their low parts, and from there to the clock."""
        return width_of(self.rows)

    def part(self, number: int) -> slice[int, int, None]:
        """The rows' parts in memory: the high ones are part 0, the low ones part 1."""
        return slice(number * self.width, number * self.width + self.rows)

    @cached_property
    def clock(self) -> slice[int, int, None]:
        """The clock in memory."""
        return slice(2 * self.width, 2 * self.width + CLOCK)

    def at(self, number: Clock) -> int:
        """The place in memory of one of the clock's numbers."""
        return self.clock.start + number

    @cached_property
    def time(self) -> int:
        """The place of t."""
        return self.at(Clock.TIME)

    @property
    def remembered(self) -> slice[int, int, None]:
        """The clock except the time."""
        return slice(self.at(Clock.STEP), self.clock.stop)

    @cached_property
    def third(self) -> int:
        """Where third parts begin."""
        return self.clock.stop

    @cached_property
    def errors(self) -> int:
        """Where rounding errors of rates begin, at the rows of these."""
        return self.third + (self.width if self.parts > 1 else 0)

    @cached_property
    def settings(self) -> slice[int, int, None]:
        """The values that change between steps only."""
        first = self.errors + self.width
        return slice(first, first + self.set)

    @cached_property
    def memory(self) -> int:
        """Doubles of the state with all its parts."""
        return self.carried_at + whole_vectors(self.carried)

    @cached_property
    def carried_at(self) -> int:
        """Where what is carried begins."""
        return self.errors + self.width + whole_vectors(self.set)


def vectors_of(doubles: int) -> int:
    """How many vectors so many doubles take."""
    return -(-doubles // LANES)


def whole_vectors(doubles: int, beyond: int = 0) -> int:
    """The doubles of these vectors, and of some ``beyond``: what is read and written in vectors that may
    begin anywhere goes further."""
    return LANES * (vectors_of(doubles) + beyond)


def width_of(rows: int) -> int:
    """Doubles that so many rows of the state take: one vector, or several whole ones."""
    return next((width for width in (2, 4) if width >= rows), whole_vectors(rows))
