"""The function ``@jet``: all Taylor coefficients of one step, order by order.

The first stages are written out; the later ones are loops over the stage k. (Written out in full, the
code of the double pendulum takes five times as long to compile and runs no faster; docs/benchmarks.md.)
"""

from __future__ import annotations

from lagrange_cli.mechanics.series import Op
from lagrange_cli.native.expansion import Expansion
from lagrange_cli.native.layout import LANES
from lagrange_cli.native.looped import SECOND, Loop, Looped, Window
from lagrange_cli.native.written_out import WrittenOut

FEW_STAGES, MANY_STAGES = 3, 10
"""Stages (besides the two that start the series) that are written out, in large and in small systems.

More are, where a convolution starts late.
"""
SMALL = 12
"""Convolutions of a small system."""
LOWEST = 3
"""In a loop every convolution is at this index or above, where the pairs with index 1 are two."""


def write_jet(expansion: Expansion) -> str:
    """The function's IR: coefficients of q, v and the integrals into ``%work``; false where M is singular."""
    emitter = expansion.emitter
    last = expansion.layout.order - 2
    written_out = FEW_STAGES if expansion.program.convolutions > SMALL else MANY_STAGES
    for one in expansion.program.series:
        if one.op in (Op.MULTIPLY, Op.POWER):
            written_out = max(written_out, LOWEST - one.level)
    for k in range(-2, min(last + 1, written_out)):
        WrittenOut(expansion, k).write()
    if last >= written_out:
        label, windows = "written", dict[Window, str]()
        emitter.line(f"  br label %{label}\n{label}:")
        for start, stop in segments(written_out, last):
            label, windows = write_loop(expansion, start, stop, label, windows)
    body = "\n".join(emitter.lines)
    return (
        "define internal i1 @jet(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work)"
        f" #0 {{\n{body}\n  ret i1 {expansion.regular}\n}}\n"
    )


def write_loop(
    expansion: Expansion, start: int, stop: int, before: str, windows: dict[Window, str]
) -> tuple[str, dict[Window, str]]:
    """A loop over the stages start .. stop; returns the label after it and what its windows hold then."""
    emitter = expansion.emitter
    head, after = f"stages{start}", f"after{stop}"
    loop = Loop(f"%k{start}", start, stop, windows)
    place = len(emitter.lines)
    Looped(expansion, loop, (before, head)).write()
    body = emitter.lines[place:]
    counter = f"  {loop.k} = phi i64 [ {start}, %{before} ], [ %next{start}, %{head} ]"
    emitter.lines[place:] = [*loop.entry, f"  br label %{head}\n{head}:", counter, *loop.phis, *body]
    emitter.line(f"  %next{start} = add nuw nsw i64 {loop.k}, 1")
    emitter.line(f"  %more{start} = icmp ule i64 %next{start}, {stop}")
    emitter.line(f"  br i1 %more{start}, label %{head}, label %{after}\n{after}:")
    return after, {window: following for window, (_, following) in loop.windows.items()}


def segments(start: int, last: int) -> list[tuple[int, int]]:
    """Split the looped stages where convolutions outgrow a vector: (first stage, last stage)."""
    cuts = [k for k in (SECOND - 1, SECOND + LANES - 1) if start <= k < last]
    return list(zip([start, *(cut + 1 for cut in cuts)], [*cuts, last]))
