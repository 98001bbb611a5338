"""Where steps on rates (``rates.steps``) keep what they work on, and what they hand over."""

from __future__ import annotations

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.state import CARRIED_COUNT, StateLayout, whole_vectors
from lagrange_cli.records import dataclass

HEAD = "(ptr noalias %constants, ptr noalias %state, ptr noalias %work"
"""The first arguments of functions."""
NEXT, LENGTH, HEADER = 0, 1, LANES
EVALUATIONS, STALLED, SPAN, PATH, LONGEST, ROUNDED = range(CARRIED_COUNT, CARRIED_COUNT + 6)
"""What is carried: the length that is asked for, that of the last step, how often rates were computed, and
what tells whether the motion is stuck (``stalling``), and whether rounding errors of rates are known
(``rates.noise``)."""

LATER, TRIED, WITHIN, RISES = range(EVALUATIONS + 1, EVALUATIONS + 5)
"""Beside the length that is chosen: the largest acceleration a little later, of what rests without any; the
length that is tried, where forces may cancel at rest; up to where what guards look at is known; and whether
what begins at 0 rises if it seems to do so farther on (``Roots``)."""

NEARER = 0.5
"""The part by which the square of a distance with a pole may become less in a step, or what tells where
narrow forces act: these are seen at nodes before they matter between them."""
LEAST = 0.8
"""A step is taken again that should have been shorter by this factor."""


def span_of(layout: StateLayout) -> int:
    """Doubles of a number for each rate, in whole vectors that may begin at any of them."""
    return whole_vectors(layout.rows - layout.degrees, 1)


def wide_of(layout: StateLayout) -> int:
    """Doubles of a number for each row, likewise."""
    return whole_vectors(layout.width, 1)


@dataclass(frozen=True)
class Places:
    """Where things are in ``%work``: the series that ``advance`` reads first, then ``doubles`` of the
    method's own; the jet's last."""

    layout: StateLayout
    order: int
    doubles: int
    watched: int = 0
    """Doubles for what guards look at."""

    @property
    def own(self) -> int:
        """What the method has for itself."""
        rows = self.layout.width * (self.order + 1)
        return whole_vectors(rows, 1)  # rows are written in whole vectors

    @property
    def begin(self) -> int:
        """The rates where the step begins."""
        return self.own + self.doubles

    @property
    def state(self) -> int:
        """The state at a node, and its low parts."""
        return self.begin + span_of(self.layout)

    @property
    def low(self) -> int:
        """Its low parts, until it is complete."""
        return self.state + whole_vectors(2 * self.layout.width, 1)

    @property
    def chosen(self) -> int:
        """The length of the step that the polynomials are made for, and the next one."""
        return self.low + wide_of(self.layout)

    @property
    def floor(self) -> int:
        """The least that velocities are measured by, at their rows."""
        return self.chosen + LANES

    @property
    def values(self) -> int:
        """What guards look at, at points of the step."""
        return self.floor + wide_of(self.layout)

    @property
    def spare(self) -> int:
        """Room for three numbers of each row."""
        return self.values + whole_vectors(self.watched)

    @property
    def modes(self) -> int:
        """Room for the modes of guards."""
        return self.spare + 3 * wide_of(self.layout)

    @property
    def jet(self) -> int:
        """What ``@jet`` works on."""
        return self.modes + whole_vectors(self.layout.set)
