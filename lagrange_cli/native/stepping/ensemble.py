"""``@follow``: eight motions at once, a lane for each; a lane whose motion has ended takes the next one.

Lanes take their steps together, each with its own length (Jorba and Zou 2005, eq. 3-8), and check them by
the rules of ``stepper``. When one has come to its end, ``lanes.ll`` stores what came of it and loads the next
member.
"""

from __future__ import annotations

from functools import reduce

from lagrange_cli.native.functions.correctly_rounded import power
from lagrange_cli.native.interface import BEYOND, LANES, Stop
from lagrange_cli.native.llvm.template import fill_in
from lagrange_cli.native.numbers.double import literal, operand
from lagrange_cli.native.numbers.lane_body import (
    Lanes,
    define,
    exp2_roughly,
    log2_roughly,
    two_sum,
    upper_half,
)
from lagrange_cli.native.numbers.lanes import BITS, VECTOR, splat
from lagrange_cli.native.numbers.vector import Real
from lagrange_cli.native.stepping.acceptance import DOUBLE
from lagrange_cli.native.stepping.advance import LAG
from lagrange_cli.native.stepping.polynomial import CAREFUL
from lagrange_cli.native.stepping.step_size import LAST_TERM, LOWEST_TERM, offset_of, split_terms
from lagrange_cli.records import dataclass

LARGEST_GUESS = 1e60
ENDLESS = float("inf")
STATE = "ptr noalias %state, ptr noalias %work"


@dataclass(frozen=True)
class Pack:
    """What eight lanes work on, in vectors: places of each part and ``size``, that of all."""

    degrees: int
    rows: int
    width: int
    span: int
    constants: int
    work: int

    @property
    def places(self) -> dict[str, int]:
        """Where each part begins."""
        single = (
            "time",
            "time_low",
            "previous",
            "member",
            "steps",
            "pace",
            "uneven",
            "reached",
            "active",
            "finishing",
        )
        sizes = {
            "state": self.width,
            "low": self.width,
            **dict.fromkeys(single, 1),
            "constants": self.constants,
            "scratch": -(-self.constants // LANES),
            "trial": self.rows,
            "rates": self.degrees,
            "allowed": self.degrees,
            "work": self.work,
            "size": 0,
        }
        found, place = {}, 0
        for name, size in sizes.items():
            found[name] = place
            place += size
        return found


def follow(pack: Pack, order: int, tolerance: float, parameters: int) -> str:
    """IR of ``@follow`` and its helpers."""
    writer = Writer(pack, order, tolerance)
    numbers = {"one": 1.0, "four": 4.0, "largest": LARGEST_GUESS, "infinity": ENDLESS}
    numbers |= {"ulp": 2.0**-51, "least": 2.0**-1022}
    values: dict[str, object] = {
        "lanes": LANES,
        "real": VECTOR,
        "rows": pack.rows,
        "parameters": parameters,
        "constants": pack.constants,
        "numbers": pack.rows + BEYOND,
        "all": 2**LANES - 1,
        "true": splat("i1", "true"),
        **{name: splat("double", operand(literal(value))) for name, value in numbers.items()},
        **{f"at_{name}": place for name, place in pack.places.items()},
        **{one.name.lower(): int(one) for one in Stop},
    }
    return "\n".join([*writer.functions(), fill_in("lanes", values)])


@dataclass(frozen=True)
class Writer:
    """The functions of real arithmetic that ``lanes.ll`` calls."""

    pack: Pack
    order: int
    tolerance: float

    @property
    def top(self) -> int:
        """The order to which velocities are known."""
        return self.order - 1

    @property
    def safety(self) -> float:
        """See ``stepper``."""
        return power(LAST_TERM * self.tolerance, 1.0 / self.top)

    def functions(self) -> list[str]:
        """Their text."""
        return [self.length(), self.cautious(), self.foretold(), self.sample(), self.update()]

    def velocities(self) -> tuple[int, int]:
        """The rows of the state that are velocities."""
        return self.pack.degrees, 2 * self.pack.degrees

    def size(self, body: Lanes, i: str, row: str, h: Real) -> tuple[Real, Real]:
        """The largest of the velocity and the next three terms of its series over a step; 1 / that, or 0."""
        v, a, b, c = (body.magnitude(body.load(*at)) for at in (("%state", i), (row, 1), (row, 2), (row, 3)))
        size = body.larger(v, h * body.larger(a, h * body.larger(b, h * c)))
        return size, body.select(
            body.above(size, body.constant(0.0)), body.constant(1.0) / size, body.constant(0.0)
        )

    def length(self) -> str:
        """The step, and a number that is not finite where coefficients are not (see ``stepper.ll``)."""
        body = Lanes()
        h, zero = Real(body, "%h"), body.constant(0.0)
        reach, blocks = h * (1.0 / self.safety), split_terms(self.top)

        def measure(i: str, carried: list[Real]) -> list[Real]:
            row = body.row(i, self.pack.span)
            size, inverse = self.size(body, i, row, h)
            last = body.magnitude(body.load(row, self.top))
            most = []
            for block, so_far in zip(blocks, carried[1:]):
                total = body.magnitude(body.load(row, block[-1]))
                for m in reversed(block[:-1]):
                    total = body.larger(total * reach, body.magnitude(body.load(row, m)))
                most.append(body.larger(total * inverse, so_far))
            return [carried[0] + (size + last), *most]

        total, *most = body.loop(*self.velocities(), [zero] * (1 + len(blocks)), measure)
        exponents = [
            body.select(
                body.above(one, zero),
                body.fma(upper_half(body, one), 2.0**-20 / block[0], offset_of(block, self.top)),
                body.constant(-1000.0),
            )
            for block, one in zip(blocks, most)
        ]
        step = exp2_roughly(body, -reduce(body.larger, exponents)) * self.safety
        ever = body.above(reduce(body.larger, most), zero)
        step = body.select(ever, step, body.constant(ENDLESS))
        return define(f"{{ {VECTOR}, {VECTOR} }} @lane_length({STATE}, {VECTOR} %h)", body, step, total)

    def cautious(self) -> str:
        """A step bounded by every coefficient from ``LOWEST_TERM`` on: the last two may vanish by chance."""
        body = Lanes()
        guess, zero = Real(body, "%guess"), body.constant(0.0)

        exponents = body.constant(ENDLESS)
        for m in range(LOWEST_TERM, self.top + 1):

            def one_row(i: str, most: list[Real], m: int = m) -> list[Real]:
                row = body.row(i, self.pack.span)
                inverse = self.size(body, i, row, guess)[1]
                return [body.larger(body.magnitude(body.load(row, m)) * inverse, most[0])]

            (most,) = body.loop(*self.velocities(), [zero], one_row)
            exponents = body.smaller(log2_roughly(body, most) * (-1.0 / m), exponents)
        return define(
            f"{VECTOR} @lane_cautious({STATE}, {VECTOR} %guess)",
            body,
            exp2_roughly(body, exponents) * self.safety,
        )

    def horner(self, body: Lanes, row: str, h: Real, lowest: int = 1) -> Real:
        """sum_{m=lowest}^{order} row[m] h^(m - lowest)."""
        total = body.load(row, self.order)
        for m in range(self.order - 1, lowest - 1, -1):
            total = body.fma(total, h, body.load(row, m))
        return total

    def rate(self, body: Lanes, row: str, h: Real) -> Real:
        """sum_{m=1}^{top} m row[m] h^(m - 1): the derivative at the step's end."""
        total = body.load(row, self.top) * float(self.top)
        for m in range(self.top - 1, 0, -1):
            total = body.fma(total, h, body.load(row, m) * float(m))
        return total

    def foretold(self) -> str:
        """Whether the accelerations are those that the step before foretold, as in ``stepper.ll``."""
        body, places, degrees = Lanes(), self.pack.places, self.pack.degrees
        uneven = body.load("%state", places["uneven"])

        def compare(i: str, carried: list[Real]) -> list[Real]:
            row = body.row(body.define(f"add i64 {i}, {degrees}"), self.pack.span)
            found, known, allowed = (
                body.load("%state", body.define(f"add i64 {i}, {places['rates']}")),
                body.load(row, 1),
                body.load("%state", body.define(f"add i64 {i}, {places['allowed']}")) + uneven,
            )
            # not a number counts as beyond all bounds
            within = body.define(f"fcmp ole {body.real} {body.magnitude(found - known).name}, {allowed.name}")
            return [body.select(within, carried[0], body.constant(1.0))]

        (beyond,) = body.loop(0, degrees, [body.constant(0.0)], compare)
        good = body.define(f"fcmp oeq {body.real} {beyond.name}, {body.of(0.0)}")
        body.line(f"  ret {body.bit} {good}")
        return define(f"{BITS} @lane_foretold({STATE})", body)

    def sample(self) -> str:
        """The state %dt into the step, to ``%out``."""
        body = Lanes()
        dt = Real(body, "%dt")

        def one_row(i: str, carried: list[Real]) -> list[Real]:
            change = self.horner(body, body.row(i, self.pack.span), dt) * dt
            low = body.load("%state", body.define(f"add i64 {i}, {self.pack.width}"))
            body.store(body.load("%state", i) + (change + low), "%out", i)
            return []

        body.loop(0, self.pack.rows, [], one_row)
        body.line("  ret void")
        return define(f"void @lane_sample({STATE}, {VECTOR} %dt, ptr noalias %out)", body)

    def update(self) -> str:
        """The state at the end of the step %h where %moving; nothing changes elsewhere."""
        body = Lanes()
        h, rows, degrees = Real(body, "%h"), self.pack.rows, self.pack.degrees

        def one_row(i: str, carried: list[Real]) -> list[Real]:
            change, rest = self.careful(body, body.row(i, self.pack.span), h)
            at = body.define(f"add i64 {i}, {self.pack.width}")
            low = body.load("%state", at)
            # the low part of a velocity moves its coordinate
            isq = body.define(f"icmp ult i64 {i}, {degrees}")
            velocity = body.define(f"add i64 {at}, {degrees}")
            there = body.define(f"select i1 {isq}, i64 {velocity}, i64 {at}")
            scale = body.define(f"select i1 {isq}, {body.real} %h, {body.real} zeroinitializer")
            extra = body.load("%state", there) * Real(body, scale)
            moved(body, i, at, change, (low + extra) + rest)
            return []

        def moved(body: Lanes, i: str, at: str, change: Real, rest: Real) -> None:
            old, low = body.load("%state", i), body.load("%state", at)
            new, error = two_sum(body, old, change + rest)
            body.store(body.select("%moving", new, old), "%state", i)
            body.store(body.select("%moving", error, low), "%state", at)

        self.foretell(body, h)
        body.loop(0, rows, [], one_row)
        time, place = Real(body, "%h"), self.pack.places
        moved(body, str(place["time"]), str(place["time_low"]), time, body.load("%state", place["time_low"]))
        body.line("  ret void")
        return define(f"void @lane_update({STATE}, {VECTOR} %h, {BITS} %moving)", body)

    def foretell(self, body: Lanes, h: Real) -> None:
        """Keep the accelerations at the end of the step, and how far those of the next one may be off."""
        places, degrees, bounds = self.pack.places, self.pack.degrees, DOUBLE.coarser(self.tolerance)
        lagging = body.load("%state", places["pace"]) * LAG
        pace = body.larger(h, lagging)
        body.store(pace, "%state", str(places["pace"]))
        ulps = body.magnitude(body.load("%state", places["time"])) * 2.0**-51
        almost = ulps / pace + bounds.almost
        slow = body.constant(bounds.rounding) / pace
        fast = slow + body.constant(bounds.resolution) / h

        def one_row(i: str, carried: list[Real]) -> list[Real]:
            at = body.define(f"add i64 {i}, {degrees}")
            row = body.row(at, self.pack.span)
            rate = self.rate(body, row, h)
            change = body.magnitude(rate) + body.magnitude(body.load(row, 1))
            speed, place = (body.magnitude(body.load("%state", each)) for each in (at, i))
            body.store(rate, "%state", body.define(f"add i64 {i}, {places['rates']}"))
            allowed = change * almost + speed * fast
            body.store(allowed, "%state", body.define(f"add i64 {i}, {places['allowed']}"))
            return [body.larger(place, carried[0])]

        (most,) = body.loop(0, degrees, [body.constant(0.0)], one_row)
        body.store(most * slow / pace, "%state", str(places["uneven"]))

    def careful(self, body: Lanes, row: str, h: Real) -> tuple[Real, Real]:
        """sum_{m=1}^{order} row[m] h^m as a sum of two, the first terms free of rounding.

        (See ``stepper._careful_horner``.)
        """
        total, rest = self.horner(body, row, h, CAREFUL + 1), body.constant(0.0)
        for m in range(CAREFUL, -1, -1):
            product = total * h
            rest = body.fma(rest, h, body.fma(total, h, -product))
            total = product
            if m:
                total, error = two_sum(body, body.load(row, m), product)
                rest = rest + error
        return total, rest
