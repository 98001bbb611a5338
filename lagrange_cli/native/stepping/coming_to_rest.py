"""Where a motion comes to rest at a contact after an impact, and nothing else happens then.

The speed and the distance that the impact has left are taken away along its direction, as if no further
impact had left any (``integrate.impacts.resting``). Whether the force of the contact pushes is seen in the
next step. All else, as where others are hit or come to rest at the same time, is left to the caller.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager

from lagrange_cli.native.guards import ENDLESS, ENDS, GuardRows
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.numbers.error_free import two_sum
from lagrange_cli.native.state import StateLayout
from lagrange_cli.native.stepping.at_once import ROUNDING, Speeds
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Bounce:
    """What an impact leaves: a ``speed``, which is ``still`` none but for rounding, and the value ``above`` 0
    of its argument, whose ``rate`` it had before, from its ``side``. If it is the ``last`` of infinitely many
    that are followed, the others take the time that is ``remaining``."""

    side: Real
    above: Real
    rate: Real
    speed: Real
    remaining: Real
    still: Bit
    last: Bit

    @property
    def rests(self) -> Bit:
        """Whether the motion may rest then."""
        return self.still | self.last


@dataclass(frozen=True)
class ComingToRest:
    """Writes the code for it. ``own`` loops over what the action of an event sets, and ``act`` computes
    that. Where series are ``interpolated``, they do not tell how infinitely many impacts end."""

    rows: GuardRows
    layout: StateLayout
    interpolated: bool
    own: Callable[[Function, Integer], AbstractContextManager[Integer]]
    act: Callable[[Function], Pointer]

    @property
    def possible(self) -> bool:
        """Whether compiled code does it: where no friction has to be looked at."""
        return bool(self.rows.joined) and not self.rows.switches and not self.interpolated

    def stop(self, f: Function, j: Integer, before: Pointer, bounce: Bounce, known: Speeds) -> Bit:
        """Take away what the impact at guard ``j`` has left, before which the state was ``before``. Whether
        another impact without any speed would change velocities."""
        layout, state, degrees = self.layout, f.pointer("%state"), self.layout.degrees
        left = bounce.speed * bounce.side
        whole, drags = left - bounce.rate, f.variable(f.never(1))
        with f.loop(degrees, 2 * degrees, tested=False) as place:
            part = (f.load(state, place) - f.load(before, place)) / whole
            with f.when(~part.equals(0.0)):
                for row, lost in ((place, left), (place - degrees, bounce.above)):
                    high, low = f.load(state, row), f.load(state, row + layout.width)
                    taken = part * lost
                    total, error = two_sum(high, -taken)
                    none = f.magnitude(total) <= f.magnitude(taken) * ROUNDING
                    f.store(f.select(none, 0.0, total), state, row)
                    f.store(f.select(none, 0.0, low + error), state, row + layout.width)
        results = self.act(f)
        with self.own(f, j) as i:
            place = f.load_integer("@changed_places", i)
            change = f.magnitude(f.load(results, i) - f.load(state, place))
            velocity = (place >= degrees) & (place < 2 * degrees)
            drags.set(drags.get() | (velocity & (change > known.largest * ROUNDING)))
        return drags.get()

    def hold(self, f: Function, j: Integer, side: Real) -> None:
        """Rest at the contact of guard ``j``."""
        modes = self.rows.mode(self.layout)
        f.store(side, "%state", f.load_integer("@rests_at", j) + modes)
        f.store(f.constant(0.0), "%state", j + modes)

    def note(self, f: Function, record: Pointer, bounce: Bounce, holds: Bit) -> None:
        """Record whether that is the end of infinitely many impacts."""
        ends = f.load(record, self.layout.time) + bounce.remaining
        f.store(ends, record, self.layout.at(ENDS))
        f.store((holds & bounce.last).to_real(), record, self.layout.at(ENDLESS))
