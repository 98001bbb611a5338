"""``Interface``: all that running a compiled program takes to know of it, and what both sides agree on."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import Any

from lagrange_cli.records import dataclass, fields_of

LANES = 8
"""Doubles of a vector: coefficients or samples that are worked on at once."""
CLOCK = 2 * LANES
"""Doubles of the state for what the stepper keeps besides the rows, and of every copy of it."""
STEPPING = 6
"""The lowest order of q's series that can be stepped with."""
HIGHEST_ORDER = 40
"""The highest one that a tolerance asks for."""
BEYOND = 3
"""Numbers after the state in what ``@follow`` gives for a member: time, steps, samples reached."""


def low(name: str) -> str:
    """What the low part of an observed quantity is called."""
    return f"low {name}"


def width_of(rows: int) -> int:
    """Doubles that so many rows of the state take: one vector, or several whole ones."""
    return next((width for width in (2, 4) if width >= rows), LANES * -(-rows // LANES))


class Stop(IntEnum):
    """Why ``@advance`` returned."""

    END = 0
    SAMPLES = 1
    PAUSE = 2
    SINGULAR = 3
    NOT_FINITE = 4
    UNDERFLOW = 5


@dataclass(frozen=True)
class Interface:
    """What a program holds, and the sizes of the arrays that it works on, in doubles.

    ``order`` is that of q's series, ``degrees`` the number of coordinates. ``observed`` names the
    quantities that ``@observe`` computes, in their order; ``integrals`` the quadratures carried along,
    whose values follow q and v in the state, the last ``stored`` of them constants of the motion. ``lanes``
    is what eight motions at once work on; 0 where the
    program has no code for them. A number is the sum of ``parts`` doubles: rows of high parts come first.
    """

    order: int
    degrees: int
    parameters: tuple[str, ...]
    integrals: tuple[str, ...]
    stored: int
    observed: tuple[str, ...]
    constants: int
    work: int
    lanes: int
    parts: int

    @property
    def rows(self) -> int:
        """Rows of the state: q, v and the integrals."""
        return 2 * self.degrees + len(self.integrals)

    @property
    def quantities(self) -> tuple[str, ...]:
        """The rows of what ``@observe`` computes: the names, and where numbers have low parts, theirs."""
        return self.observed + tuple(map(low, self.observed)) * (self.parts - 1)

    @property
    def width(self) -> int:
        """Doubles from the state's rows to their low parts, and from there to t."""
        return width_of(self.rows)

    @property
    def time(self) -> int:
        """Where the state has t."""
        return 2 * self.width

    @property
    def memory(self) -> int:
        """Doubles of the state: the rows, their low parts, what ``stepper`` says of the clock, some room."""
        return 3 * self.width + CLOCK

    @property
    def trial(self) -> int:
        """Doubles of scratch: what ``@advance`` may go back to and expects; a series (double-double)."""
        return 4 * self.width + CLOCK + LANES + self.work

    def as_data(self) -> dict[str, Any]:
        """The fields in terms of JSON."""
        return {name: getattr(self, name) for name in fields_of(Interface)}

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Interface:
        """What ``as_data`` gave, after JSON."""
        fields: dict[str, Any] = {n: tuple(x) if isinstance(x, list) else x for n, x in data.items()}
        return cls(**fields)
