"""``@follow`` for stroboscopic sections: of each motion its states after multiples of a period are samples.

What it has in common with that for ``crossings`` is here, too.
"""

from __future__ import annotations

from lagrange_cli.native.ensembles.ensemble import Follower
from lagrange_cli.native.ensembles.pack import Pack, each_lane
from lagrange_cli.native.interface import Stop
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Pointer, Real
from lagrange_cli.native.members import STROBE
from lagrange_cli.native.state import LANES
from lagrange_cli.records import replace


class Returns(Follower):
    """The common base of both kinds: a sample has its time, and members end with their last one."""

    kind = ""

    def __init__(self, pack: Pack, order: int, tolerance: float, parameters: int) -> None:
        pack = replace(pack, section=self.kind, sampled=1, scratch=2 * (order - 1))
        super().__init__(pack, order, tolerance, parameters)

    def complete(self, f: Function, dt: Real, trial: Pointer) -> None:
        """Write the time of a sample."""
        f.store(self.get(f, "time") + (self.get(f, "time_low") + dt), trial, self.pack.rows)

    def halt(self, f: Function) -> None:
        """Give what members have so far."""
        active = f.load_integer(self.part(f, "active"))
        with f.when(~active.equals(0)), each_lane(f, active) as lane:
            places = f.pointer("%results"), f.pointer("%ended")
            f.call(None, "retire", f.pointer("%state"), lane, f.count(Stop.SAMPLES), *places)

    def complete_lanes(self, f: Function, count: Integer) -> Bit:
        """The lanes that have all their samples."""
        return self.get(f, "reached").bits() >= f.splat(count, LANES)


class Periods(Returns):
    """Samples after multiples of a member's period."""

    kind = STROBE

    def __init__(self, pack: Pack, order: int, tolerance: float, parameters: int) -> None:
        super().__init__(pack, order, tolerance, parameters + 1)

    def begin(self, f: Function, n: Integer, lane: Integer) -> None:
        period = f.load_row("%parameters", n * self.parameters + (self.parameters - 1), 1)
        f.store(period, self.number(f, "period", lane))

    def ahead(self) -> Function:
        """``@ahead``: the time from each lane's step to its next sample."""
        f = Function("define internal REAL @ahead(ptr %state, double %start, i64 %count) #0", LANES)
        number = (self.get(f, "reached").bits() + 1).to_real()
        due = number * self.get(f, "period") + f.splat(Real(f, "%start", 1), LANES)
        f.give((due - self.get(f, "time")) - self.get(f, "time_low"))
        return f

    def bounded(self, f: Function, h: Real, left: Real, live: Bit) -> Real:
        """No step goes beyond the last sample."""
        number = f.splat(Integer(f, "%count", 1), LANES).to_real()
        end = number * self.get(f, "period") + f.splat(Real(f, "%start", 1), LANES)
        return f.smaller(h, (end - self.get(f, "time")) - self.get(f, "time_low"))

    def sample(self, f: Function, step: Real, moving: Bit, count: Integer) -> Integer:
        with f.forever() as sampling:
            dt = f.call(Real, "ahead", f.pointer("%state"), Real(f, "%start", 1), count)
            due = ((dt <= step) & moving & ~self.complete_lanes(f, count)).mask()
            with f.when(due.equals(0)):
                sampling.leave()
            self.take(f, dt, due, count)
        return (self.complete_lanes(f, count) & moving).mask()
