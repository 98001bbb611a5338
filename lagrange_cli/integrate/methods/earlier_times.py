"""Memories of earlier times, from which a motion passes singular configurations (see ``passing``)."""

from __future__ import annotations

from collections.abc import Callable

from lagrange_cli.integrate.arrays import Array
from lagrange_cli.integrate.methods.passing import passed, thinned
from lagrange_cli.integrate.methods.workspace import Workspace

MARK = 256
"""After so many steps the memory is kept: neither a clock nor samples decide from where a singular
configuration is passed."""


class EarlierTimes:
    """The last ``memories`` of a workspace that are kept, since a ``singular`` configuration was passed; and
    the times when that was."""

    def __init__(self, space: Workspace) -> None:
        self.space, self.memories, self.singular = space, tuple[Array, ...](), tuple[float, ...]()

    def keep(self, steps: int) -> None:
        """Keep the memory, if that is due after so many steps."""
        place = self.space.layout.time
        due = steps % MARK == 0 and self.memories[-1:] and self.memories[-1][place] != self.space.t
        if due or not self.memories:
            self.memories = thinned((*self.memories, self.space.memory.copy()), place)

    def steps_to_mark(self, steps: int) -> int:
        """How many steps there are, after ``steps``, until a memory may be due."""
        return MARK - steps % MARK

    def passed(
        self, wanted: Array, stop: float, pause: Callable[[float], int], *, limited: bool
    ) -> tuple[Array | None, bool]:
        """Pass a singular configuration: the samples (rows, n) on the way, or None where that is impossible
        or is not to be done (``pause``, see ``passing.passed``); and whether the stop time has influenced the
        motion, as it has before if it is ``limited``."""
        singular, place = self.space.t, self.space.layout.time
        origins = [one for one in self.memories if one[place] < singular]
        if not origins:
            return None, limited
        way, limited = passed(self.space, origins, stop, pause, limited=limited)
        if way is None:
            return None, limited
        self.singular, self.memories = (*self.singular, singular), ()
        return way.at(wanted[wanted <= way.stop]), limited
