"""What ``@follow`` and its callers agree on: the queue of members, and the numbers of each lane.

``@follow`` takes the members of an ensemble to their ends, eight at once (see ``ensembles.ensemble``).
"""

from __future__ import annotations

BEYOND = 3
"""Numbers after the state in what ``@follow`` gives for a member: time, steps, samples reached."""
NEXT, LIMIT, HALT = range(3)
"""Places in its queue: the next member, the first one that may not begin yet, whether to stop."""
DIRECTION, PATIENCE = 3, 4
"""Further ones of sections (``ensembles.crossings``)."""
SECTION, STROBE = "where", "every"
"""Kinds of sections: crossings of a surface, states after multiples of a period."""
LANE_NUMBERS = "time", "time_low", "previous", "steps", "usual", "uneven", "reached"
"""The counters of each lane behind its state and the state's low parts, all 0 in a new motion."""
OWN_NUMBERS = {"": (), SECTION: ("side", "since"), STROBE: ("period",)}
"""Its further numbers in each kind of section; ``LANE_COUNTERS`` follow."""
LANE_COUNTERS = "member", "active", "finishing"


def lane_places(width: int, section: str = "") -> dict[str, int]:
    """Where these numbers are in what lanes work on, in vectors; ``width`` is that of the state."""
    names = (*LANE_NUMBERS, *OWN_NUMBERS[section], *LANE_COUNTERS)
    return {name: 3 * width + place for place, name in enumerate(names)}
