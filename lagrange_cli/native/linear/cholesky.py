"""Factorization of a large definite block of the mass matrix, eight rows at a time.

``@factor_definite`` leaves D L^T in the upper triangle; what earlier rows take off eight others is taken off
in registers, so that each is read and written once. ``@arrange_definite`` makes of it what the solution
(``definite_solve``) reads. With blocks L_JK of eight by eight and W_J the inverse of L_JJ, those above the
diagonal become -(L_JK W_K)^T, and those on it W_J^T; the W_J are behind the matrix.
"""

from __future__ import annotations

from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.template import fill_in
from lagrange_cli.native.numbers.eights import VECTOR, fma, splat


def definite() -> str:
    """IR of ``@factor_definite`` and ``@arrange_definite``."""
    return fill_in(
        "definite",
        {
            "eliminate_diagonal": _eliminate("d", "%rows_at"),
            "pivots": _pivots(),
            "eliminate": _eliminate("c", "%place"),
            "within": _within(),
            "inverse": _inverse(),
            "scale": _scale(),
        },
    )


def _eliminate(name: str, place: str) -> str:
    """``%NAME.R``: rows R of the block at ``place`` less what all the rows above the panel take off them.

    It ends in a loop over these rows, k: their numbers are at ``%factors``, and their columns are those of
    ``place``.
    """
    rows = range(LANES)
    lines = []
    for r in rows:
        lines += [
            f"  %{name}.o{r} = mul i64 %stride, {r}",
            f"  %{name}.p{r} = getelementptr inbounds double, ptr {place}, i64 %{name}.o{r}",
            f"  %{name}.a{r} = load {VECTOR}, ptr %{name}.p{r}, align 64",
        ]
    lines += [f"  br i1 %above, label %{name}.loop, label %{name}.done", f"{name}.loop:"]
    before = f"%{name}.before"
    lines.append(f"  %{name}.k = phi i64 [ 0, {before} ], [ %{name}.kn, %{name}.loop ]")
    lines += [
        f"  %{name}.s{r} = phi {VECTOR} [ %{name}.a{r}, {before} ], [ %{name}.n{r}, %{name}.loop ]"
        for r in rows
    ]
    lines += [
        f"  %{name}.ko = mul i64 %{name}.k, %stride",
        f"  %{name}.kc = add i64 %{name}.ko, %{name}.column",
        f"  %{name}.kp = getelementptr inbounds double, ptr %a, i64 %{name}.kc",
        f"  %{name}.v = load {VECTOR}, ptr %{name}.kp, align 64",
        f"  %{name}.fo = mul i64 %{name}.k, {LANES}",
        f"  %{name}.fp = getelementptr inbounds double, ptr %factors, i64 %{name}.fo",
    ]
    for r in rows:
        lines += _broadcast(f"{name}.f{r}", f"%{name}.fp", r)
        lines.append(f"  %{name}.n{r} = {fma(f'%{name}.f{r}', f'%{name}.v', f'%{name}.s{r}')}")
    lines += [
        f"  %{name}.kn = add nuw nsw i64 %{name}.k, 1",
        f"  %{name}.more = icmp ult i64 %{name}.kn, %j",
        f"  br i1 %{name}.more, label %{name}.loop, label %{name}.done",
        f"{name}.done:",
    ]
    lines += [
        f"  %{name}.{r} = phi {VECTOR} [ %{name}.a{r}, {before} ], [ %{name}.n{r}, %{name}.loop ]"
        for r in rows
    ]
    return "\n".join(lines)


def _pivots() -> str:
    """The block on the diagonal, ``%d.R``: its pivots, what its rows take off those below, and ``%fine``."""
    lines, fine = [], "%regular"
    rows = [f"%d.{r}" for r in range(LANES)]
    for r, row in enumerate(rows):
        lines += [
            f"  %p{r} = extractelement {VECTOR} {row}, i64 {r}",
            f"  %p{r}.i = add i64 %j, {r}",
            f"  %p{r}.rp = getelementptr inbounds double, ptr %reciprocal, i64 %p{r}.i",
            f"  %p{r}.given = load double, ptr %p{r}.rp, align 8",
            f"  %p{r}.least = fmul double %p{r}.given, %floor",
            f"  %p{r}.good = fcmp ogt double %p{r}, %p{r}.least",
            f"  %p{r}.outside = icmp uge i64 %p{r}.i, %n",
            f"  %p{r}.fine = or i1 %p{r}.good, %p{r}.outside",
            f"  %p{r}.all = and i1 {fine}, %p{r}.fine",
            f"  %p{r}.q = fdiv double 1.0, %p{r}",
            f"  %p{r}.r = select i1 %p{r}.outside, double 0.0, double %p{r}.q",
            f"  store double %p{r}.r, ptr %p{r}.rp, align 8",
            f"  %p{r}.m = fneg double %p{r}.r",
            f"  %p{r}.ms = insertelement {VECTOR} poison, double %p{r}.m, i64 0",
            f"  %p{r}.mv = {splat(f'%p{r}.ms', 0)}",
            f"  %p{r}.f = fmul {VECTOR} {row}, %p{r}.mv",
            f"  %p{r}.fo = mul i64 %p{r}.i, {LANES}",
            f"  %p{r}.fp = getelementptr inbounds double, ptr %factors, i64 %p{r}.fo",
            f"  store {VECTOR} %p{r}.f, ptr %p{r}.fp, align 64",
        ]
        fine = f"%p{r}.all"
        for below in range(r + 1, LANES):
            here = f"%p{r}.{below}"
            lines += [
                f"  {here}.s = {splat(f'%p{r}.f', below)}",
                f"  {here} = {fma(here + '.s', row, rows[below])}",
            ]
            rows[below] = here
        upper = ", ".join(f"i1 {str(lane >= r).lower()}" for lane in range(LANES))
        lines += [
            f"  %p{r}.kept = select <{LANES} x i1> <{upper}>, {VECTOR} {row}, {VECTOR} zeroinitializer",
            f"  store {VECTOR} %p{r}.kept, ptr %d.p{r}, align 64",
        ]
    lines.append(f"  %fine = and i1 {fine}, true")
    return "\n".join(lines)


def _within() -> str:
    """The rows ``%c.R`` of a block beside that on the diagonal, less what the ones above in it take off."""
    lines = []
    rows = [f"%c.{r}" for r in range(LANES)]
    for r in range(LANES):
        lines += [
            f"  %t{r}.i = add i64 %j, {r}",
            f"  %t{r}.o = mul i64 %t{r}.i, {LANES}",
            f"  %t{r}.p = getelementptr inbounds double, ptr %factors, i64 %t{r}.o",
        ]
        for below in range(r + 1, LANES):
            lines += _broadcast(f"t{r}.f{below}", f"%t{r}.p", below)
            lines.append(f"  %t{r}.{below} = {fma(f'%t{r}.f{below}', rows[r], rows[below])}")
            rows[below] = f"%t{r}.{below}"
        lines.append(f"  store {VECTOR} {rows[r]}, ptr %c.p{r}, align 64")
    return "\n".join(lines)


def _broadcast(name: str, place: str, offset: int) -> list[str]:
    """``%NAME``: the double there in all lanes."""
    return [
        f"  %{name}.p = getelementptr inbounds double, ptr {place}, i64 {offset}",
        f"  %{name}.x = load double, ptr %{name}.p, align 8",
        f"  %{name}.i = insertelement {VECTOR} poison, double %{name}.x, i64 0",
        f"  %{name} = {splat(f'%{name}.i', 0)}",
    ]


def _inverse() -> str:
    """From the rows of -L in the block at ``%block`` those of its inverse, columns at ``%corner_at``.

    Row i of it is that of the unit matrix less the sum over j < i of L_ij times row j.
    """
    lines = []
    for i in range(LANES):
        unit = ", ".join(f"double {float(lane == i)}" for lane in range(LANES))
        current = f"<{unit}>"
        if i:
            lines += [
                f"  %b{i}.p = getelementptr inbounds double, ptr %block, i64 {LANES * i}",
                f"  %b{i} = load {VECTOR}, ptr %b{i}.p, align 64",
            ]
        for j in range(i):
            here = f"%w{i}.{j}"
            lines += [
                f"  {here}.s = {splat(f'%b{i}', j)}",
                f"  {here} = {fma(here + '.s', f'%w{j}', current)}",
            ]
            current = here
        lines.append(f"  %w{i} = fadd {VECTOR} {current}, zeroinitializer")
    for i in range(LANES):
        lines += [
            f"  %s{i}.p = getelementptr inbounds double, ptr %block, i64 {LANES * i}",
            f"  store {VECTOR} %w{i}, ptr %s{i}.p, align 64",
        ]
        for j in range(LANES):
            here = f"%e{i}.{j}"
            lines += [
                f"  {here} = extractelement {VECTOR} %w{i}, i64 {j}",
                f"  {here}.o = mul i64 %stride, {j}",
                f"  {here}.c = add i64 {here}.o, {i}",
                f"  {here}.p = getelementptr inbounds double, ptr %corner_at, i64 {here}.c",
                f"  store double {here}, ptr {here}.p, align 8",
            ]
    return "\n".join(lines)


def _scale() -> str:
    """The block at ``%upper``, of -L^T, times W^T, which stands at ``%of_rows``, from the left."""
    lines = []
    for lane in range(LANES):
        lines.append(f"  %o{lane} = mul i64 %stride, {lane}")
        for name, place in (("u", "%upper"), ("f", "%of_rows")):
            lines.append(f"  %{name}{lane}.p = getelementptr inbounds double, ptr {place}, i64 %o{lane}")
        lines.append(f"  %u{lane} = load {VECTOR}, ptr %u{lane}.p, align 64")
    for row in range(LANES):
        total = f"%u{row}"
        for lane in range(row + 1, LANES):
            lines += _broadcast(f"f{row}.{lane}", f"%f{row}.p", lane)
            lines.append(f"  %u{row}.{lane} = {fma(f'%f{row}.{lane}', f'%u{lane}', total)}")
            total = f"%u{row}.{lane}"
        lines.append(f"  store {VECTOR} {total}, ptr %u{row}.p, align 64")
    return "\n".join(lines)
