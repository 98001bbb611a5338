"""The stepping loop as machine code: step size, check, dense output at the sample times, compensated update.

``@advance`` takes steps until its sample times are used up, the end is reached, or something stops it. Its
state is an array of doubles: the rows' values (q, v, integrals), the low parts that compensated summation
keeps for each (Kahan, CACM 8, 1965), then t, its low part, and the last step's length.

The step follows Jorba and Zou (2005), eq. 3-8: the radius of convergence is estimated from the last two
coefficients, and h = radius / e^2 at the order that fits the tolerance. Each velocity is measured against its
own size or its change within a step (by its first three terms), whichever is largest, so that units and mixed
scales do not matter.

A series does not show a kink of the potential or a narrow wall that the motion has not reached. So every step
is confirmed by the next one's series, whose accelerations must agree with those that its own series predicts;
until then its samples may be discarded. Such a critical point is approached by halving the distance, and
passed if the accelerations stay finite. The error is their change times the resolution of time."""

from __future__ import annotations

from collections.abc import Sequence

from lagrange_cli.native.functions.correctly_rounded import power
from lagrange_cli.native.interface import STEPPING, Stop
from lagrange_cli.native.llvm.template import fill_in
from lagrange_cli.native.numbers.double import literal, operand
from lagrange_cli.native.recurrences.layout import Layout
from lagrange_cli.native.state import CLOCK, LANES
from lagrange_cli.native.stepping.detection import Detection

CAREFUL = 4
"""Terms of the series that are summed with twice the precision."""
CHAINS = 4
"""Partial sums of the other terms, which can be added in parallel."""
LAST_TERM = 0.01
"""Far enough below the tolerance that truncation, which adds up, stays below rounding, which does not."""
BLOCKS = 8
"""Blocks, one for each lane of a vector, in which the coefficients that determine the step are compared."""
ALMOST = 2.0**-40
"""The error, relative to its size and its change, with which a step's series must predict the acceleration at
its end. Tolerances coarser than full precision have a proportionally larger bound."""
RESOLUTION = 2.0**-47
"""The part of a velocity by which the error of the prediction may change it in a step; likewise."""
ROUNDING = 2.0**-45
"""The part of the coordinates by which rounding errors of the accelerations may change them in a step."""
EVIDENCE, NOISY = 2.0, 2.0**16
"""After this many steps whose prediction failed narrowly, rounding is the cause: the bound is raised by this
factor."""
NOTHING_MUCH = 2.0**-48
"""How far rounding errors of the accelerations may move a coordinate that rests at 0."""
NOTHING, BLIND, MOVED = -3, -2, -1
"""What a step's series must confirm about the step before: nothing; only that it passed a kink; everything
(and for the last step, what ``Stop`` says)."""
LAG = 0.7
"""The factor by which the pace may shrink per step, as steps do in front of a singularity."""
PASSES = 8.0
"""If so many kinks are passed while t hardly changes, the motion sticks at one."""
CLOCK_NUMBERS = 12
"""Numbers of the state after the rows: t, its low part, the last step, the distance to a critical point that
no step may pass, the pace, the time when a critical point was last passed, the number of passes at nearly the
same t, whether the last steps led away from one, and the number of steps whose prediction failed narrowly.
Then, for the step from here: whether ever shorter steps were not confirmed, whether a step over the critical
point was not confirmed either, and whether the cause is unknown."""
MINUS_ZERO = "0x8000000000000000"
AT_REST = 2.0**-900
"""Where forces may hide, velocities below this do not limit the step."""
LOWEST_TERM = 4
"""The first coefficient that tells the range of the series rather than the present speed of the motion."""
FAINT = 2.0**-900
"""If the last coefficient other than 0 is below this, further ones may have underflowed."""
SLACK = 4
"""Binary orders by which the lower coefficients may exceed what the radius of convergence allows.

They serve to find series with gaps, and are often larger than the last coefficients suggest.
"""
FEW_TERMS = 8
"""From this order of the velocities on, the last coefficient is not used, so that the step is known early."""


def stepper(layout: Layout, degrees: int, work: int, tolerance: float, hidden: Sequence[float] = ()) -> str:
    """IR of ``@advance`` and its helpers for ``degrees`` coordinates and ``work`` doubles of ``%work``.

    The last term of a velocity's series is kept below ``LAST_TERM * tolerance`` of the velocity's size.
    ``hidden`` are the powers of what hides forces, whose quadratures are the first (see ``detection``).
    """
    order, width = layout.order, layout.width
    top = order - 1  # velocities are known to this order
    lanes = min(width, LANES)
    vector = f"<{lanes} x double>"
    safety = power(LAST_TERM * tolerance, 1.0 / top)
    coarse = coarseness(tolerance)
    blocks, rest = split_terms(top), AT_REST if hidden else 0.0
    values: dict[str, object] = {
        "degrees": degrees,
        "two_degrees": 2 * degrees,
        "rows": len(layout.state),
        "width": width,
        "low": width,
        "time": 2 * width,
        "top": top,
        "all_but_two": top - 2,
        "lowest": LOWEST_TERM,
        "slot_1": width,
        "slot_2": 2 * width,
        "slot_3": 3 * width,
        "slot_4": 4 * width,
        "above_4": work - 4 * width,
        "safety": operand(literal(safety)),
        "farther": operand(literal(1.0 / safety)),
        "greatest": "\n".join(
            f"  %most{i} = phi {vector} [ zeroinitializer, %entry ], [ %more{i}, %loop ]"
            for i in range(BLOCKS)
        ),
        "size": _size(vector, lanes, width),
        "compare": _compare(vector, lanes, width, blocks, top),
        "gather": _gather(vector, lanes),
        "slopes": _constant([operand(literal(2.0**-20 / block[0])) for block in blocks], "double"),
        "none": _constant([literal(-1000.0)] * BLOCKS, "double"),
        "offsets": _constant([operand(literal(offset_of(block, top))) for block in blocks], "double"),
        "ones": _constant([literal(1.0)] * lanes, "double"),
        "from_degrees": _constant([lane - degrees for lane in range(lanes)], "i64"),
        "all_degrees": _constant([degrees] * lanes, "i64"),
        "counted": _constant(list(range(lanes)), "i64"),
        "is_watching": "true" if hidden else "false",
        "rest": operand(literal(rest)),
        "at_rest": _constant([operand(literal(rest))] * lanes, "double"),
        "splat_h": _splat("%h", lanes),
        "splat_reach": _splat("%reach", lanes),
        "splat_hs": _splat("%hs", lanes),
        "splat_speed_noise": _splat("%speed_noise", lanes),
        "splat_nothing": _splat("%nothing", lanes),
        "splat_almost": _splat("%almost", lanes),
        "splat_room": _splat("%room", lanes),
        "splat_slack": _splat("%slack", lanes),
        "evidence": operand(literal(EVIDENCE)),
        "noisy": operand(literal(NOISY)),
        "splat_uneven": _splat("%uneven", lanes),
        "splat_i": _splat("%i", lanes, "i64"),
        "splat_ui": _splat("%ui", lanes, "i64"),
        **{f"splat8_{name}": _splat(f"%{name}", LANES) for name in ("t", "tl", "hl", "dy", "dl")},
        "rate": _rate(top, vector),
        "horner_update": _careful_horner(order, width, vector, "%hs_v", "%row"),
        "clock_end": 2 * width + CLOCK_NUMBERS,
        "at_rates": 2 * width + CLOCK,
        "at_allowed": 3 * width + CLOCK,
        "at_next": 4 * width + CLOCK,
        "at_series": 4 * width + CLOCK + LANES,
        "at_first": 5 * width + CLOCK + LANES,
        "almost": operand(literal(ALMOST * coarse)),
        "resolution": operand(literal(RESOLUTION * coarse)),
        "lag": operand(literal(LAG)),
        "passes": operand(literal(PASSES)),
        "nothing_much": operand(literal(NOTHING_MUCH)),
        "rounding": operand(literal(ROUNDING)),
        "work_size": work,
        "order": order,
        "fewest": STEPPING,
        "faint": operand(literal(FAINT)),
        "most": 2 * top // 3,
        "inverse_top": operand(literal(1.0 / top)),
        "last_term": operand(literal(LAST_TERM * tolerance)),
        "horner_vector": _horner(order, width, "%dt", "%srow"),
        "lanes": lanes,
        "vector": vector,
        "tag": f"v{lanes}f64",
        "nothing": NOTHING,
        "moved": MOVED,
        "blind": BLIND,
        "end": int(Stop.END),
        "samples": int(Stop.SAMPLES),
        "pause": int(Stop.PAUSE),
        "singular": int(Stop.SINGULAR),
        "not_finite": int(Stop.NOT_FINITE),
        "underflow": int(Stop.UNDERFLOW),
    }
    detection = Detection(
        order, width, len(layout.state), degrees, tuple(hidden), 4 * width + CLOCK + LANES, work, NOTHING_MUCH
    )
    return fill_in("stepper", values) + detection.text()


def coarseness(tolerance: float) -> float:
    """How much coarser than full precision a tolerance is; 1 where it is finer."""
    return max(1.0, tolerance * 2.0**52)


def _constant(values: Sequence[object], kind: str) -> str:
    """A constant vector."""
    return "<" + ", ".join(f"{kind} {value}" for value in values) + ">"


def _splat(name: str, lanes: int, kind: str = "double") -> str:
    """``%name_v``: a vector with %name in every lane."""
    zeros = f"<{lanes} x i32> zeroinitializer"
    return (
        f"  {name}_1 = insertelement <{lanes} x {kind}> poison, {kind} {name}, i64 0\n"
        f"  {name}_v = shufflevector <{lanes} x {kind}> {name}_1, <{lanes} x {kind}> poison, {zeros}"
    )


def _fabs(vector: str, lanes: int, value: str) -> str:
    return f"call {vector} @llvm.fabs.v{lanes}f64({vector} {value})"


def _maximum(vector: str, lanes: int, a: str, b: str) -> str:
    return f"call nnan {vector} @llvm.maxnum.v{lanes}f64({vector} {a}, {vector} {b})"


def _size(vector: str, lanes: int, width: int) -> str:
    """``%size``: the largest of %y0 and of the next three terms, over a step of %h_v."""
    lines, total = [], ""
    for m in (3, 2, 1):
        lines += [
            f"  %a{m} = getelementptr inbounds double, ptr %row, i64 {m * width}",
            f"  %c{m} = load {vector}, ptr %a{m}, align 8",
            f"  %s{m} = {_fabs(vector, lanes, f'%c{m}')}",
        ]
        if total:
            lines.append(f"  %x{m} = {_maximum(vector, lanes, total, f'%s{m}')}")
        total = f"%t{m}"
        lines.append(f"  {total} = fmul {vector} {f'%x{m}' if m < 3 else '%s3'}, %h_v")
    lines.append(f"  %size = {_maximum(vector, lanes, '%y0', total)}")
    return "\n".join(lines)


def split_terms(top: int) -> list[list[int]]:
    """The coefficients that determine the step, in ``BLOCKS`` blocks (the last ones may repeat)."""
    terms = list(range(LOWEST_TERM, top if top >= FEW_TERMS else top + 1))
    size = -(-len(terms) // BLOCKS)
    blocks = [terms[start : start + size] for start in range(0, len(terms), size)]
    return blocks + [blocks[-1]] * (BLOCKS - len(blocks))


def offset_of(block: list[int], top: int) -> float:
    """What is added to 1/m of a coefficient's logarithm, m the first of its block: its bits count from
    2^-1023."""
    return (-1023.0 - (SLACK if block[-1] < 0.75 * top else 0)) / block[0]


def _compare(vector: str, lanes: int, width: int, blocks: list[list[int]], top: int) -> str:
    """``%moreI``: the largest coefficient of block I against %size, all brought to its first index by the
    radius of convergence %reach; ``%sum_next``: %sum and what shows whether all are finite."""
    lines: list[str] = []

    def load(m: int) -> str:
        lines.append(f"  %ta{m} = getelementptr inbounds double, ptr %row, i64 {width * m}")
        lines.append(f"  %tc{m} = load {vector}, ptr %ta{m}, align 8")
        lines.append(f"  %ts{m} = {_fabs(vector, lanes, f'%tc{m}')}")
        return f"%ts{m}"

    for i, block in enumerate(blocks):
        if i and block == blocks[i - 1]:
            lines.append(f"  %more{i} = fadd {vector} %most{i}, zeroinitializer")
            continue
        total = load(block[-1])
        for m in reversed(block[:-1]):
            lines.append(f"  %tm{m} = fmul {vector} {total}, %reach_v")
            lines.append(f"  %tx{m} = {_maximum(vector, lanes, f'%tm{m}', load(m))}")
            total = f"%tx{m}"
        lines.append(f"  %tr{i} = fmul {vector} {total}, %inverse")
        lines.append(f"  %more{i} = {_maximum(vector, lanes, f'%most{i}', f'%tr{i}')}")
    last = load(top) if top not in blocks[-1] else f"%ts{top}"
    lines.append(f"  %sum0 = fadd {vector} %size, {last}")
    lines.append(f"  %sum_next = fadd {vector} %sum, %sum0")
    return "\n".join(lines)


def _gather(vector: str, lanes: int) -> str:
    """``%greatest``: the largest lane of each."""
    lines, whole = [], "poison"
    for i in range(BLOCKS):
        lines.append(f"  %g{i} = call nnan double @llvm.vector.reduce.fmax.v{lanes}f64({vector} %more{i})")
        name = "%greatest" if i + 1 == BLOCKS else f"%gathered{i}"
        lines.append(f"  {name} = insertelement <{BLOCKS} x double> {whole}, double %g{i}, i64 {i}")
        whole = name
    return "\n".join(lines)


def _horner(order: int, width: int, step: str, row: str) -> str:
    """``%row.poly`` = sum_{m=1}^{order} c[m] step^m by Horner's rule at ``LANES`` times; c[m] are doubles
    ``width`` apart."""
    kind, tag = f"<{LANES} x double>", row[1:]
    lines, total = [], ""
    for m in range(order, 0, -1):
        value = f"%{tag}.l{m}"
        lines.append(f"  %{tag}.a{m} = getelementptr inbounds double, ptr {row}, i64 {width * m}")
        lines.append(f"  {value} = load double, ptr %{tag}.a{m}, align 8")
        lines.append(_splat(value, LANES))
        if total:
            given = f"{kind} {total}, {kind} {step}, {kind} {value}_v"
            lines.append(f"  %{tag}.s{m} = call {kind} @llvm.fmuladd.v{LANES}f64({given})")
        total = f"%{tag}.s{m}" if total else f"{value}_v"
    return "\n".join([*lines, f"  %{tag}.poly = fmul {kind} {total}, {step}"])


def _careful_horner(order: int, width: int, vector: str, step: str, row: str) -> str:
    """``%row.poly + %row.rest`` = sum_{m=1}^{order} c[m] step^m for a vector of rows, the first terms free of
    rounding.

    (Compensated Horner scheme: Graillat, Langlois and Louvet 2005. It is what keeps the error of a step below
    that of its coefficients.) The other terms, whose last ones are known last, do not hold it up: they are
    summed in ``CHAINS`` chains, and go into the rest.
    """
    tag = vector.replace("<", "v").replace(" x double>", "f64")
    lines = [
        line
        for m in range(1, order + 1)
        for line in (
            f"  %c{m}.a = getelementptr inbounds double, ptr {row}, i64 {width * m}",
            f"  %c{m}.c = load {vector}, ptr %c{m}.a, align 8",
        )
    ]

    def fused(name: str, a: str, b: str, c: str, kind: str = "fma") -> str:
        lines.append(f"  {name} = call {vector} @llvm.{kind}.{tag}({vector} {a}, {vector} {b}, {vector} {c})")
        return name

    powers = {1: step}
    for n in (2, 4):
        powers[n] = f"%power{n}"
        lines.append(f"  %power{n} = fmul {vector} {powers[n // 2]}, {powers[n // 2]}")
    chains: dict[int, str] = {}
    for m in range(order, CAREFUL, -1):
        above = chains.get(m + CHAINS)
        chains[m] = fused(f"%c{m}.t", above, powers[CHAINS], f"%c{m}.c", "fmuladd") if above else f"%c{m}.c"
    sums = [chains[m] for m in range(CAREFUL + 1, min(CAREFUL + CHAINS, order) + 1)]
    for n in (1, 2):
        pairs = [sums[i : i + 2] for i in range(0, len(sums), 2)]
        sums = [
            fused(f"%tail{n}{i}", pair[1], powers[n], pair[0], "fmuladd") if len(pair) > 1 else pair[0]
            for i, pair in enumerate(pairs)
        ]
    total, rest = f"%c{CAREFUL}.c", "zeroinitializer"
    for m in range(CAREFUL - 1, -1, -1):
        name = f"%c{m}."
        product = f"{name}p"
        lines.append(f"  {product} = fmul {vector} {total}, {step}")
        lines.append(f"  {name}n = fneg {vector} {product}")
        rest = fused(f"{name}r", rest, step, fused(f"{name}e", total, step, f"{name}n"))
        total = product
        if m:
            lines += [
                f"  {name}s = fadd {vector} {name}c, {product}",
                f"  {name}b = fsub {vector} {name}s, {name}c",
                f"  {name}x = fsub {vector} {name}s, {name}b",
                f"  {name}y = fsub {vector} {name}c, {name}x",
                f"  {name}z = fsub {vector} {product}, {name}b",
                f"  {name}w = fadd {vector} {name}y, {name}z",
                f"  {name}q = fadd {vector} {rest}, {name}w",
            ]
            total, rest = f"{name}s", f"{name}q"
    lines.append(f"  %power5 = fmul {vector} {powers[4]}, {step}")
    lines.append(f"  %row.poly = fadd {vector} {total}, {_constant([MINUS_ZERO] * int(vector[1]), 'double')}")
    fused("%row.rest", sums[0], "%power5", rest, "fmuladd")
    return "\n".join(lines)


def _rate(top: int, vector: str) -> str:
    """``%rate`` = sum_{m=1}^{top} m c[m] step^(m-1), the derivative at the step's end, in two chains."""
    tag = vector.replace("<", "v").replace(" x double>", "f64")
    lines = []
    for m in range(1, top + 1):
        number = _constant([operand(literal(m))] * int(vector[1]), "double")
        lines.append(f"  %d{m} = fmul {vector} %c{m}.c, {number}")
    chains = []
    for start in (top, top - 1):
        chain = f"%d{start}"
        for m in range(start - 2, 0, -2):
            given = f"{vector} {chain}, {vector} %power2, {vector} %d{m}"
            lines.append(f"  %d{m}.t = call {vector} @llvm.fmuladd.{tag}({given})")
            chain = f"%d{m}.t"
        chains.append(chain)
    odd, even = chains if top % 2 else chains[::-1]
    lines.append(
        f"  %rate = call {vector} @llvm.fmuladd.{tag}({vector} {even}, {vector} %hs_v, {vector} {odd})"
    )
    return "\n".join(lines)
