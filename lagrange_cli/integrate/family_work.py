"""What a step costs in a large system, from its operations, which are counted, and the times that they take.

A Taylor series takes for each convolution the square of its order, for each sum its order, and proofs where
forces may hide. A step by evaluations takes each operation once in each of them, an exponential as well. How
many evaluations of ``ias15`` replace a step by series depends on the order, and on whether forces have poles.
"""

from __future__ import annotations

from typing import cast

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.families.arrays import Chain
from lagrange_cli.families.description import FamilySystem
from lagrange_cli.families.poles import moving, poles
from lagrange_cli.families.system import family_system
from lagrange_cli.integrate.families import narrow
from lagrange_cli.native.families.loops import loops, needed
from lagrange_cli.native.families.series import LoopSeries
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.orders import order_for
from lagrange_cli.records import dataclass
from lagrange_cli.series.program import FREE, UNBOUNDED, Op, Series, SeriesProgram

PRODUCT, FETCHED, SUM = 0.045, 0.4, 0.037
"""Nanoseconds of a product in a convolution, of its coefficients from outside the caches, and of a term of a
sum, for one member (docs/engine.md)."""
PASS, ROW = 19.0, 2.8
"""Those of an order of a loop, and of each of its rows."""
ARITHMETIC, ROOT, POWER, EXPONENTIAL, CIRCULAR = 0.008, 0.20, 14.0, 1.3, 0.38
"""Those of operations in an evaluation: a product or a term of a sum, a root or quotient, another power, exp
and what is made of it, sine or cosine."""
BEGIN, COORDINATE, ROW_ONCE = 60.0, 1.4, 9.3
"""Those of an evaluation of ``ias15``, besides, of each coordinate, and of each row of a loop."""
CACHES = 30e6
"""Bytes of coefficients that stay in the caches."""
PROOF, ENCLOSURE, ENCLOSED_POWER, ENCLOSED_FUNCTION = 2.0, 6000.0, 800.0, 80.0
"""By how much a step takes longer if it has to be proven, and the nanoseconds of enclosing functions, of each
broken power and of each other function besides, whatever the order is."""
AT_ORDER = 18
WITH_POLES, WITHOUT_POLES, PROVEN = (38.0, 1.7), (50.0, 4.5), (16.0, 1.0)
"""Evaluations of ``ias15`` that replace a step of this order, with as small an error, and how many more for
each further order: where poles of forces bound the steps, where series converge further, and where broken
powers or functions that bend are enclosed, which shortens the steps."""
COMPILED, REPAID = 40e6, 5000
"""Nanoseconds that loops take longer to compile than few members that are written out, and the steps in which
they have to save that. A command does not know how many steps its motion will have."""


@dataclass(frozen=True)
class Work:
    """How many operations all members need: for each order, in each convolution, and for each evaluation."""

    convolutions: float
    stored: float
    sums: float
    rows: float
    passes: float
    evaluation: float
    has_poles: bool
    few: bool
    proven: bool
    enclosed: float
    """Nanoseconds of the broken powers and functions in proofs of steps, if these have to be proven."""
    bent: bool
    """Whether some of these are functions of something that is not linear, or broken powers."""

    def step(self, tolerance: float) -> float:
        """Nanoseconds of a step by series."""
        order = order_for(tolerance)
        products = order * order / 2
        bytes_used = 8 * self.stored * (order + 1)
        fetched = max(0.0, 1 - CACHES / bytes_used) * self.stored * FETCHED if bytes_used else 0.0
        each = self.sums * SUM + self.passes * PASS + self.rows * ROW
        taken = products * (self.convolutions * PRODUCT + fetched) + order * each
        return taken * PROOF + self.enclosed + ENCLOSURE * self.bent if self.proven else taken

    def price(self, tolerance: float) -> int:
        """How many evaluations take as long as a step by series."""
        return round(self.step(tolerance) / self.evaluation)

    def worth(self, tolerance: float) -> int:
        """How many evaluations it replaces."""
        first, more = PROVEN if self.bent else WITH_POLES if self.has_poles else WITHOUT_POLES
        return round(first + more * (order_for(tolerance) - AT_ORDER))

    def repays(self, tolerance: float) -> bool:
        """Whether ``ias15`` saves what loops take longer to compile."""
        saved = (self.price(tolerance) - self.worth(tolerance)) * self.evaluation
        return saved * REPAID >= COMPILED


def work_of(system: FamilySystem) -> Work:
    """The work of a system without switches."""
    variables, _ = moving(system)
    totals = needed([system.forces, *system.loads], system.slots)
    convolutions = stored = sums = rows = passes = enclosed = 0.0
    bent, evaluation = False, BEGIN + COORDINATE * system.q.count
    for loop in loops(totals, system.slots):
        if isinstance(loop, Chain):
            continue
        count = LANES * float(loop.rows.blocks[-1])
        series = LoopSeries(loop, system.slots, variables, system.time, AT_ORDER)
        program = series.program
        terms = sum(max(1, len(one.arguments)) for one in program.series if one.op is Op.LINEAR)
        convolutions += count * sum(convolved(program, index) for index in series.lasting)
        stored += count * len(series.stored)
        sums += count * (terms + len(loop.terms))
        rows += len(loop.rows.starts)
        passes += 1
        enclosed += loop.domain.count * sum(map(enclosing, program.series))
        bent = bent or any(bends(program, one) for one in program.series)
        simple = terms + 2 * len(loop.terms) + len(loop.used)
        evaluation += ROW_ONCE * len(loop.rows.starts)
        evaluation += count * (simple * ARITHMETIC + sum(evaluated(one) for one in program.series))
    pole, few = bool(poles(system, totals)), family_system(system.spec) is None
    proven = narrow(system, large=not few)
    return Work(
        convolutions, stored, sums, rows, passes, evaluation, pole, few, proven,
        enclosed if proven else 0.0, bent and proven,
    )  # fmt: skip


def convolved(program: SeriesProgram, index: int) -> float:
    """How many convolutions a series takes: a square half of one, as its products come in pairs."""
    one = program.series[index]
    factors = [program.series[a] for a in one.arguments]
    if one.op is Op.POWER:
        return 1.5
    if one.op is not Op.MULTIPLY or any(a.level == FREE or a.degree != UNBOUNDED for a in factors):
        return 0.0
    return 0.5 if one.arguments[0] == one.arguments[1] else 1.0


def is_whole(times: float, power: Series) -> bool:
    """Whether so many times its exponent is a whole number."""
    exponent = cast("Node", power.data)
    return exponent.kind is Kind.NUMBER and (times * exponent.data) % 1 == 0


def enclosing(one: Series) -> float:
    """Nanoseconds of enclosing it, if it is a power whose exponent is no whole number, or a function."""
    if one.op is Op.POWER:
        return 0.0 if is_whole(1.0, one) else ENCLOSED_POWER
    return ENCLOSED_FUNCTION if one.op is Op.PRIMITIVE else 0.0


def bends(program: SeriesProgram, one: Series) -> bool:
    """Whether it is a broken power, or a function of something that is not linear in coordinates."""
    if one.op is Op.PRIMITIVE:
        return not all(is_straight(program, program.series[source]) for source in one.sources)
    return one.op is Op.POWER and not is_whole(1.0, one)


def is_straight(program: SeriesProgram, one: Series) -> bool:
    """Whether it is linear in coordinates."""
    if one.op is Op.LINEAR:
        return all(is_straight(program, program.series[part]) for part in one.arguments)
    return one.op in (Op.COORDINATE, Op.TIME)


def evaluated(one: Series) -> float:
    """Nanoseconds of its value, if it is no sum."""
    if one.op is Op.MULTIPLY:
        return ARITHMETIC
    if one.op is Op.POWER:
        return ROOT if is_whole(2.0, one) else POWER
    if one.op is Op.PRIMITIVE and one.node is not None:
        return CIRCULAR if one.node.data in ("sin", "cos") else EXPONENTIAL
    return 0.0
