"""The stepping loop as machine code: step size, check, dense output at the sample times, compensated update.

``@advance`` takes steps until its sample times are used up, the end is reached, or something stops it.
Its state is
an array of doubles: the rows' values (q, v, integrals), the low parts that compensated summation keeps
for each (Kahan, CACM 8, 1965), then t, its low part, and the last step's length.

The step follows Jorba and Zou (2005), eq. 3-8: the radius of convergence is estimated from the last two
coefficients, and h = radius / e^2 at the order that fits the tolerance. Each velocity is measured
against its own
size or its change within a step (by its first three terms), whichever is largest, so that units and mixed
scales do not matter.
"""

from __future__ import annotations

from lagrange_cli.native.emitter import literal, operand
from lagrange_cli.native.interface import Stop
from lagrange_cli.native.layout import LANES, ZERO_SLOT, Layout
from lagrange_cli.native.template import fill_in

VECTOR = f"<{LANES} x double>"


CAREFUL = 4
"""Terms of the series that are summed with twice the precision."""
LAST_TERM = 0.01
"""Far enough below the tolerance that truncation, which adds up, stays below rounding, which does not."""


def stepper(layout: Layout, degrees: int, rows: int, tolerance: float) -> str:
    """IR of ``@advance`` and its helpers for ``degrees`` coordinates and ``rows`` rows of state.

    The last term of a velocity's series is kept below ``LAST_TERM * tolerance`` of the velocity's size.
    """
    order, span = layout.order, layout.span
    top = order - 1  # velocities are known to this order
    values = {
        "degrees": degrees,
        "two_degrees": 2 * degrees,
        "rows": rows,
        "low": rows,
        "time": 2 * rows,
        "span": span,
        "top": top,
        "top_slot": ZERO_SLOT + top,
        "below_slot": ZERO_SLOT + top - 1,
        "lowest": 4,
        "slot_1": ZERO_SLOT + 1,
        "slot_2": ZERO_SLOT + 2,
        "slot_3": ZERO_SLOT + 3,
        "zero_slot": ZERO_SLOT,
        "root_top": operand(literal(1.0 / top)),
        "root_below": operand(literal(1.0 / (top - 1))),
        "safety": operand(literal((LAST_TERM * tolerance) ** (1.0 / top))),
        "horner": _horner(order, "double", "%h", "%row"),
        "horner_update": _careful_horner(order, "%hs", "%row"),
        "trial_offset": LANES * -(-2 * rows // LANES),
        "horner_vector": _horner(order, VECTOR, "%dt", "%srow"),
        "horner_rate": _horner_rate(top, "%h", "%vrow"),
        "lanes": LANES,
        "vector": VECTOR,
        "end": int(Stop.END),
        "samples": int(Stop.SAMPLES),
        "pause": int(Stop.PAUSE),
        "singular": int(Stop.SINGULAR),
        "not_finite": int(Stop.NOT_FINITE),
        "underflow": int(Stop.UNDERFLOW),
    }
    return fill_in("stepper", values)


def _horner(order: int, kind: str, step: str, row: str, lowest: int = 1) -> str:
    """``%poly`` = sum_{m=1}^{order} row[m] step^m by Horner's rule."""
    fma = "llvm.fmuladd.f64" if kind == "double" else f"llvm.fmuladd.v{LANES}f64"
    tag = row[1:]
    lines, total = [], ""
    for m in range(order, lowest - 1, -1):
        lines.append(f"  %{tag}.a{m} = getelementptr inbounds double, ptr {row}, i64 {ZERO_SLOT + m}")
        lines.append(f"  %{tag}.l{m} = load double, ptr %{tag}.a{m}, align 8")
        value = f"%{tag}.l{m}"
        if kind != "double":
            lines.append(f"  %{tag}.i{m} = insertelement {kind} poison, double {value}, i64 0")
            zeros = f"<{LANES} x i32> zeroinitializer"
            lines.append(f"  %{tag}.c{m} = shufflevector {kind} %{tag}.i{m}, {kind} poison, {zeros}")
            value = f"%{tag}.c{m}"
        if total:
            lines.append(f"  %{tag}.s{m} = call {kind} @{fma}({kind} {total}, {kind} {step}, {kind} {value})")
            total = f"%{tag}.s{m}"
        else:
            total = value
    if lowest == 1:
        lines.append(f"  %{tag}.poly = fmul {kind} {total}, {step}")
    else:
        lines.append(f"  %{tag}.t = fadd {kind} {total}, 0x8000000000000000")
    return "\n".join(lines)


def _careful_horner(order: int, step: str, row: str) -> str:
    """``%row.poly + %row.rest`` = sum_{m=1}^{order} row[m] step^m, the first terms free of rounding.

    (Compensated Horner scheme: Graillat, Langlois and Louvet 2005. It is what keeps the error of a step below
    that of its coefficients.)
    """
    real, fma = "double", "call double @llvm.fma.f64(double {}, double {}, double {})"
    lines = [_horner(order, real, step, row, lowest=CAREFUL + 1)]
    total, rest = "%row.t", "0x0000000000000000"
    for m in range(CAREFUL, -1, -1):
        name = f"%c{m}."
        product = f"{name}p"
        lines += [
            f"  {product} = fmul {real} {total}, {step}",
            f"  {name}n = fneg {real} {product}",
            f"  {name}e = {fma.format(total, step, name + 'n')}",
            f"  {name}r = {fma.format(rest, step, name + 'e')}",
        ]
        total, rest = product, f"{name}r"
        if m:
            lines += [
                f"  {name}a = getelementptr inbounds double, ptr {row}, i64 {ZERO_SLOT + m}",
                f"  {name}c = load double, ptr {name}a, align 8",
                f"  {name}s = fadd {real} {name}c, {product}",
                f"  {name}b = fsub {real} {name}s, {name}c",
                f"  {name}x = fsub {real} {name}s, {name}b",
                f"  {name}y = fsub {real} {name}c, {name}x",
                f"  {name}z = fsub {real} {product}, {name}b",
                f"  {name}w = fadd {real} {name}y, {name}z",
                f"  {name}q = fadd {real} {rest}, {name}w",
            ]
            total, rest = f"{name}s", f"{name}q"
    lines.append(f"  %row.poly = fadd {real} {total}, 0x8000000000000000")
    lines.append(f"  %row.rest = fadd {real} {rest}, 0x8000000000000000")
    return "\n".join(lines)


def _horner_rate(order: int, step: str, row: str) -> str:
    """``%vrow.rate`` = sum_{m=1}^{order} m row[m] step^(m-1): the derivative at the step's end."""
    lines, total = [], ""
    for m in range(order, 0, -1):
        lines.append(f"  %r.a{m} = getelementptr inbounds double, ptr {row}, i64 {ZERO_SLOT + m}")
        lines.append(f"  %r.l{m} = load double, ptr %r.a{m}, align 8")
        lines.append(f"  %r.m{m} = fmul double %r.l{m}, {operand(literal(m))}")
        if total:
            lines.append(
                f"  %r.s{m} = call double @llvm.fmuladd.f64(double {total}, double {step}, double %r.m{m})"
            )
            total = f"%r.s{m}"
        else:
            total = f"%r.m{m}"
    return "\n".join(lines) + f"\n  %rate = fadd double {total}, 0x0000000000000000"
