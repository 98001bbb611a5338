"""The function ``@jet``: all Taylor coefficients of one step, order by order.

The first stages are written out; the later ones are loops over the stage k. (Written out in full, the
code of the double pendulum takes five times as long to compile and runs no faster; docs/benchmarks.md.)
"""

from __future__ import annotations

from lagrange_cli.native.expansion import Expansion
from lagrange_cli.native.layout import LANES
from lagrange_cli.native.looped import Looped
from lagrange_cli.native.written_out import WrittenOut

WRITTEN_OUT = 3
"""Stages 0 .. WRITTEN_OUT - 1 (and the two before, that start the series) are written out."""


def write_jet(expansion: Expansion) -> str:
    """The function's IR: coefficients of q, v and the integrals into ``%work``; false where M is singular."""
    emitter = expansion.emitter
    last = expansion.layout.order - 2
    for k in range(-2, min(last + 1, WRITTEN_OUT)):
        WrittenOut(expansion, k).write()
    if last >= WRITTEN_OUT:
        label = "written"
        emitter.line(f"  br label %{label}\n{label}:")
        for start, stop in segments(WRITTEN_OUT, last):
            label = write_loop(expansion, start, stop, label)
    body = "\n".join(emitter.lines)
    return (
        "define internal i1 @jet(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work)"
        f" #0 {{\n{body}\n  ret i1 {expansion.regular}\n}}\n"
    )


def write_loop(expansion: Expansion, start: int, stop: int, before: str) -> str:
    """A loop over the stages start .. stop; returns the label after it."""
    emitter = expansion.emitter
    head, after = f"stages{start}", f"after{stop}"
    emitter.line(f"  br label %{head}\n{head}:")
    emitter.line(f"  %k{start} = phi i64 [ {start}, %{before} ], [ %next{start}, %{head} ]")
    Looped(expansion, f"%k{start}", start, stop).write()
    emitter.line(f"  %next{start} = add nuw nsw i64 %k{start}, 1")
    emitter.line(f"  %more{start} = icmp ule i64 %next{start}, {stop}")
    emitter.line(f"  br i1 %more{start}, label %{head}, label %{after}\n{after}:")
    return after


def segments(start: int, last: int) -> list[tuple[int, int]]:
    """Split the looped stages where convolutions outgrow a vector: (first stage, last stage)."""
    cuts = [k for k in range(LANES - 2, last, LANES) if k > start]
    starts = [start, *(cut + 1 for cut in cuts)]
    return list(zip(starts, [*cuts, last]))
