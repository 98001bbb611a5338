"""Acceptance of a step: the accelerations at its end, from the series that begins there, must agree with
those that its own series predicts.

A series does not show a kink of the potential or a narrow wall that the motion has not reached. The bound is
a fraction of the accelerations, and of those that would change velocities and coordinates within a step:
rounding may cause as much.
"""

from __future__ import annotations

from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Real
from lagrange_cli.native.stepping.lengths import Lengths
from lagrange_cli.records import dataclass, replace

PLACES = "ptr noalias %work, ptr noalias %rates, ptr noalias %allowed"


@dataclass(frozen=True)
class PredictionBounds:
    """How exactly numbers of one kind can be predicted, and where time ends to be resolved.

    A series must predict the accelerations to ``almost`` of their size and their change, to what changes a
    velocity by ``resolution`` of its size within the step, to what changes velocities and coordinates by
    ``rounding`` of their size within the usual step, and to the error that ``ulp``, the resolution of time
    relative to the time, makes. What rests may be moved by ``nothing_much``.

    A critical point is approached to ``grain`` of the usual step, or if shorter steps fail as well, to
    ``doubt`` of the step; the other side of it must lie within ``widest`` of the usual step. If it is passed
    again and again within ``no_time`` of the time, the motion sticks there. Steps below ``shortest`` of the
    time do not move it.
    """

    almost: float
    resolution: float
    rounding: float
    nothing_much: float
    ulp: float
    grain: float
    doubt: float
    widest: float
    no_time: float
    shortest: float
    precision: float

    def nothing(self, f: Function, h: Real) -> Real:
        """An error of accelerations that moves what rests by nothing much within ``h``."""
        return self.nothing_much / (h * f.larger(h, 1.0))

    def coarser(self, tolerance: float) -> PredictionBounds:
        """The bounds for a tolerance, if it is coarser than full precision."""
        coarse = max(1.0, tolerance / self.precision)
        return replace(self, almost=self.almost * coarse, resolution=self.resolution * coarse)

    def timed(self, depends: bool) -> PredictionBounds:
        """The bounds, where an equation ``depends`` on t, which is known to a rounding only. Where
        steps had to be shorter, a pole may lie between t and the next number, as that of tan(t) near pi/2."""
        return replace(self, shortest=self.ulp / 4.0) if depends else self


DOUBLE = PredictionBounds(
    almost=2.0**-40, resolution=2.0**-47, rounding=2.0**-45, nothing_much=2.0**-48, ulp=2.0**-51,
    grain=2.0**-54, doubt=2.0**-24, widest=2.0**-20, no_time=2.0**-36, shortest=2.0**-80, precision=2.0**-52,
)  # fmt: skip
DOUBLE_DOUBLE = PredictionBounds(
    almost=2.0**-88, resolution=2.0**-96, rounding=2.0**-92, nothing_much=2.0**-96, ulp=2.0**-102,
    grain=2.0**-106, doubt=2.0**-40, widest=2.0**-64, no_time=2.0**-72, shortest=2.0**-130,
    precision=2.0**-104,
)  # fmt: skip


@dataclass(frozen=True)
class Allowance:
    """By how much the accelerations at the end of a step may differ from those predicted: parts of their size
    and change, of speeds, and of places (see ``PredictionBounds``)."""

    change: Real
    speed: Real
    place: Real

    def of(self, f: Function, lengths: Lengths, change: Real, speed: Real) -> Real:
        """The step that the ``change`` of accelerations and a ``speed`` allow."""
        part, share = (lengths.wide(f, one) for one in (self.change, self.speed))
        return f.fused(change, part, speed * share)


def allowance(f: Function, bounds: PredictionBounds, t: Real, usual: Real, h: Real) -> Allowance:
    """The allowance of a step of ``h`` that ends at about ``t``, where steps are ``usual`` long."""
    inverse = 1.0 / usual
    slow = inverse * bounds.rounding
    fast = bounds.resolution / h
    return Allowance(t * bounds.ulp * inverse + bounds.almost, slow + fast, inverse * slow)


def accepted(lengths: Lengths, low: int = 0, name: str = "accepted") -> Function:
    """``@accepted(work, rates, allowed, uneven, slack, unexplained, floor, ..)``: whether the accelerations
    agree, or the rates of the rows that are ``Lengths.followed`` but for those at ``%integrals`` that are no
    numbers.

    They may differ by ``allowed`` and ``uneven``, times ``slack``. Where failures are ``unexplained``, they
    and those expected must be at most ``floor`` instead: nothing but rounding of what rests. If low parts are
    ``low`` doubles behind coefficients, the first of these are accelerations times ``inverse``.
    """
    more = ", ptr noalias %low, double %inverse" if low else ""
    more += ", ptr noalias %integrals" if lengths.followed[1] else ""
    given = "REAL %uneven, REAL %slack, BIT %unexplained, REAL %floor"
    f = Function(f"define internal BIT @{name}({PLACES}, {given}{more}) #0", lengths.motions)
    uneven, slack, floor = (lengths.wide(f, one) for one in f.reals("uneven", "slack", "floor"))
    bad = f.variable(f.never(lengths.lanes))
    with lengths.velocities(f) as row:
        found, expected = row.series()[1], row.at("%rates")
        distance = expected - found
        if low:
            rest = row.series()[1 + low]
            found, rest = found * Real(f, "%inverse"), rest * Real(f, "%inverse")
            distance = (expected - found) + (row.at("%low") - rest)
        strictly = f.magnitude(distance).compared("ugt", (row.at("%allowed") + uneven) * slack)
        grossly = f.magnitude(found).compared("ugt", floor) | f.magnitude(expected).compared("ugt", floor)
        apart = f.select(Bit(f, "%unexplained"), grossly, strictly)
        if lengths.followed[1]:
            new = row.at("%integrals")
            apart = apart & new.equals(new)
        bad.set(bad.get() | row.moving(apart))
    f.give(~lengths.of_motions(f, bad.get()))
    return f
