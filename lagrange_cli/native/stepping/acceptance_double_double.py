"""The confirmation of a step: the accelerations at its end that its series predicts are compared with those
that are there.

As in ``stepper``, but simpler: a step that is not confirmed is discarded and halved, until the error of the
prediction changes the velocities no more than rounding does. No other rule is needed near a kink, where the
higher coefficients consist of rounding errors: they are scaled by the step (``in_memory``) and shorten it.
"""

from __future__ import annotations

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.numbers.double import Operand, literal, operand
from lagrange_cli.native.numbers.double_double import TYPE, DoubleDoubleBody, Pair, function
from lagrange_cli.native.recurrences.layout_rows import Rows, velocities
from lagrange_cli.native.stepping.advance import EVIDENCE, LAG, NOISY, PASSES

SHORTEST = 2.0**-130
"""Steps below this part of the time do not move it."""
TIME = 2.0**-102
"""The resolution of time, relative to the time."""
PACE = 2.0**-106
"""The part of the usual step up to which a critical point is approached."""
DOUBT = 2.0**-40
"""The part of a step below which rounding, not a critical point, prevents confirmation."""
ALMOST = 2.0**-88
"""The error, relative to its size, with which a step's series must predict the acceleration at its end.
Tolerances coarser than full precision have a proportionally larger bound."""
RESOLUTION = 2.0**-96
"""The part of a velocity by which the error of the prediction may change it in a step; likewise."""
ROUNDING = 2.0**-92
"""The part of the coordinates by which rounding errors of the accelerations may change them in a step."""
NOTHING_MUCH = 2.0**-96
"""How far these may move a coordinate that rests at 0."""
WIDEST = 2.0**-64
"""The part of the usual step within which the other side of a critical point must lie."""
NO_TIME = 2.0**-72
"""A critical point that is passed ``PASSES`` times within this part of the time is one at which the motion
sticks."""
ROUGHLY, ROUGH = 2.0**-40, 2.0**-80
"""The counterparts of ``ALMOST`` and ``ROUNDING`` for the trial of a long step's end before it is taken."""
WIDE = 2.0**12
"""If a step is this many times longer than the scale of its series, coefficients were lost and are computed
again."""
NARROWER, NARROWEST = 2.0**-32, 2.0**-300
"""The factor for the scale if coefficients overflow, and its lower limit."""
FEW = 4
"""The order up to which a series is used where higher coefficients consist of rounding errors."""


def numbers(tolerance: float) -> dict[str, str]:
    """What the stepping loop holds its steps against."""
    coarse = max(1.0, tolerance * 2.0**104)
    values = {
        "shortest": SHORTEST, "resolved": TIME, "grain": PACE, "doubt": DOUBT, "almost": ALMOST * coarse,
        "resolution": RESOLUTION * coarse, "rounding": ROUNDING, "nothing_much": NOTHING_MUCH,
        "widest": WIDEST, "no_time": NO_TIME, "wide": WIDE, "narrower": NARROWER, "narrowest": NARROWEST,
        "lag": LAG, "passes": PASSES, "evidence": EVIDENCE, "noisy": NOISY,
    }  # fmt: skip
    return {name: operand(literal(value)) for name, value in values.items()}


def confirmation(rows: Rows) -> list[str]:
    """Its functions."""
    return [expect(rows), foretold(rows), straighten(rows), holds(rows)]


def expect(rows: Rows) -> str:
    """``@expect``: what the series lets expect of the accelerations at the end of a step.

    Into ``expected``: these, their low parts, how far off they may be. %state and %before are those at
    both ends; %almost, %speed and %place are the parts of accelerations, velocities and coordinates.
    """
    body, width = DoubleDoubleBody(), rows.width
    degrees = len(rows.program.velocities)

    def lesser(row: int) -> Operand:
        ends = [body.call("llvm.fabs.f64", body.load(end, row)) for end in ("%state", "%before")]
        return body.call("llvm.minnum.f64", *ends)

    farthest: Operand = operand(None)
    for coordinate in range(degrees):
        farthest = body.call("llvm.maxnum.f64", farthest, lesser(coordinate))
    uneven = body.mul(farthest, "%place")
    for i, (velocity, row) in enumerate(velocities(rows, body)):
        made = body.define(f"call {TYPE} @slope(ptr {row}, double %h, double %hl)")
        rate = body.unpacked(made).scaled("%inverse")
        body.put(rate, "%expected", i, width)
        begin = body.mul(body.load(row, 1), "%inverse")
        both = body.add(*(body.call("llvm.fabs.f64", x) for x in (rate.high, begin)))
        allowed = body.fma(both, "%almost", body.fma(lesser(velocity), "%speed", uneven))
        body.store(allowed, "%expected", 2 * width + i)
    body.line("  ret void")
    numbers = ", ".join(f"double %{name}" for name in ("h", "hl", "inverse", "almost", "speed", "place"))
    heads = f"ptr %before, ptr %state, ptr %work, {numbers}, ptr %expected"
    return function(f"void @expect({heads})", body)


def foretold(rows: Rows) -> str:
    """``@foretold``: whether the accelerations are those expected, to ``slack`` times what is allowed.

    Or, where ``lax``, no larger than ``room``: nothing but rounding of what rests.
    """
    body, width, good = DoubleDoubleBody(), rows.width, "true"
    for i, (_, row) in enumerate(velocities(rows, body)):
        found = body.get(row, 1, rows.beyond).scaled("%inverse")
        expected = body.get("%expected", i, width)
        distance = body.call("llvm.fabs.f64", (found - expected).high)
        allowed = body.mul(body.load("%expected", 2 * width + i), "%slack")
        strictly = body.compare("ole", distance, operand(allowed))
        sizes = [body.call("llvm.fabs.f64", x.high) for x in (found, expected)]
        small = [body.compare("ole", size, "%room") for size in sizes]
        loosely = body.define(f"and i1 {small[0]}, {small[1]}")
        within = body.define(f"select i1 %lax, i1 {loosely}, i1 {strictly}")
        good = body.define(f"and i1 {good}, {within}")
    body.line(f"  ret i1 {good}")
    heads = "ptr %work, ptr %expected, double %inverse, i1 %lax, double %room, double %slack"
    return function(f"i1 @foretold({heads})", body)


def straighten(rows: Rows) -> str:
    """``@straighten(work)``: coefficients of the state beyond the ``FEW``th become 0."""
    body = DoubleDoubleBody()
    places = [body.place("%work", rows.row(i)) for i in rows.state]

    def term(m: str) -> None:
        for row in places:
            body.put(None, row, m, rows.beyond)

    body.loop(FEW + 1, rows.order + 1, term)
    body.line("  ret void")
    return function("void @straighten(ptr %work)", body)


def holds(rows: Rows) -> str:
    """``@holds``: whether the equations hold, roughly, at the end of the step %h."""
    body, width = DoubleDoubleBody(), rows.width
    trial_work = body.place("%trial", LANES * -(-2 * width // LANES))
    inverse = operand(body.div(literal(1.0), "%scale"))
    heads = f"double {body.mul('%h', inverse)}, double {operand(None)}, ptr %trial, i64 1, i64 {width}"
    body.line(f"  call void @sample(ptr %state, ptr %work, {heads})")
    time = body.get("%state", 2 * width, 1) + Pair(body, "%h", operand(None))
    given = f"double {time.high}, double {time.low}, double %scale, ptr %trial, ptr {trial_work}"
    good = body.define(f"call i1 @jet(ptr %constants, {given})")
    degrees = len(rows.program.velocities)
    there = [body.place(trial_work, rows.row(i)) for i in rows.program.velocities]
    for (velocity, row), other in zip(velocities(rows, body), there):
        length = f"double {body.mul('%h', inverse)}, double {operand(None)}"
        made = body.unpacked(body.define(f"call {TYPE} @slope(ptr {row}, {length})"))
        rate, found, begin = (
            body.mul(x, inverse) for x in (made.high, body.load(other, 1), body.load(row, 1))
        )
        distance = body.call("llvm.fabs.f64", body.sub(rate, found))
        v, q = (body.call("llvm.fabs.f64", body.load("%trial", i)) for i in (velocity, velocity - degrees))
        size = body.add(body.div(v, "%h"), body.call("llvm.fabs.f64", found))
        size = body.add(size, body.call("llvm.fabs.f64", begin))
        rounding = body.div(body.div(body.mul(q, literal(ROUGH)), "%h"), "%h")
        allowed = body.fma(size, literal(ROUGHLY), rounding)
        within = body.define(f"fcmp ole double {distance}, {operand(allowed)}")
        good = body.define(f"and i1 {good}, {within}")
    body.line(f"  ret i1 {good}")
    heads = "ptr %constants, ptr %state, ptr %work, double %h, double %scale, ptr %trial"
    return function(f"i1 @holds({heads})", body)
