"""The function ``@jet``: all Taylor coefficients of one step, order by order.

The first stages are unrolled; the later ones are loops over the stage k.
"""

from __future__ import annotations

import itertools

from lagrange_cli.native.llvm.text import operand
from lagrange_cli.native.recurrences.layout import CARRIED, Layout, lowest
from lagrange_cli.native.recurrences.rolled import Memory, Opening, Rolled
from lagrange_cli.records import replace
from lagrange_cli.series.program import SeriesProgram

UNROLLED = 3
"""Stages, besides the two that start the series, that are unrolled.

More are, where a convolution starts late.
"""
ALONE = 1
"""Groups up to which all stages are unrolled: that is little code."""
FEW_GROUPS = 3
"""Groups up to which their sums are unrolled; one of several levels counts as so many."""
SHORT_LOOP = 9
"""Stages of a loop whose sums are unrolled, at most: few zeros are summed, and few loops compiled."""
LOWEST = 3
"""In a loop every convolution is at this index or above, where the pairs with index 1 are two."""


def write_jet(memory: Memory) -> str:
    """The function's IR: coefficients of q, v and the integrals into ``%work``; false where M is singular."""
    expansion, emitter, layout = memory.expansion, memory.emitter, memory.layout
    last = layout.order - 2
    rolled = min(last + 1, first_rolled(expansion.program, layout))
    for k in range(-2, rolled):
        Opening(memory, k).write()
    memory.newest = {
        (index, age): expansion.table[index].get(rolled - 1 + one.level - age)
        for index, one in enumerate(expansion.program.series)
        for age in range(CARRIED)
    }
    deciding = layout.groups[: layout.motion] or layout.groups
    padded = sum(len({dot.level for dot in group.dots}) for group in deciding) <= FEW_GROUPS
    for start, stop in split(rolled, last, SHORT_LOOP if padded else last):
        write_loop(memory, start, stop, padded)
    finish(memory)
    body = "\n".join(emitter.lines)
    return (
        "define internal i1 @jet(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work)"
        f" #0 {{\n{body}\n  ret i1 {expansion.regular}\n}}\n"
    )


def first_rolled(program: SeriesProgram, layout: Layout) -> int:
    """The first stage that a loop may have, or one after the last.

    Where there are convolutions in the motion, these decide: its sums are rounded as without integrals.
    """
    motion = layout.groups[: layout.motion]
    if len(motion or layout.groups) <= ALONE:
        return layout.order - 1
    if not motion:
        program = replace(program, motion=len(program.series))
    return max(UNROLLED, LOWEST - lowest(program, motion or layout.groups))


def write_loop(memory: Memory, start: int, stop: int, padded: bool) -> None:
    """A loop over the stages start .. stop."""
    emitter, k = memory.emitter, f"%k{start}"
    emitter.line(f"  br label %before{start}\nbefore{start}:\n  br label %stages{start}\nstages{start}:")
    place = len(emitter.lines)
    emitter.forget_depths()
    emitter.repeated = stop - start + 1
    stage = Rolled(memory, k, start, stop, padded)
    latch = stage.write(f"stages{start}")
    emitter.repeated = 1
    phis = [f"  {k} = phi i64 [ {start}, %before{start} ], [ %next{start}, %{latch} ]"]
    for (index, age), name in stage.carried.items():
        old, new = operand(memory.newest[index, age - 1]), operand(stage.newest(index, age - 1))
        phis.append(f"  {name} = phi double [ {old}, %before{start} ], [ {new}, %{latch} ]")
    ages = [*((index, 0) for index in range(len(memory.expansion.table))), *stage.carried]
    memory.newest = {one: stage.newest(*one) for one in ages}
    emitter.lines[place:place] = phis
    emitter.line(
        f"  %next{start} = add nuw nsw i64 {k}, 1\n  %more{start} = icmp ule i64 %next{start}, {stop}"
    )
    emitter.line(f"  br i1 %more{start}, label %stages{start}, label %after{start}\nafter{start}:")


def finish(memory: Memory) -> None:
    """Store q's last coefficients, which are one order ahead of the velocities'."""
    layout, coordinates = memory.layout, memory.expansion.program.coordinates
    values = [memory.newest[index, 0] if index in coordinates else None for index in layout.state]
    memory.emitter.store_rows(layout.width, values, "%work", layout.width * layout.order)


def split(start: int, last: int, length: int) -> list[tuple[int, int]]:
    """The stages start .. last in as few parts of at most ``length`` as there can be, all about as long."""
    parts = max(0, -(-(last + 1 - start) // max(1, length)))
    cuts = [start + (last + 1 - start) * part // parts for part in range(parts + 1)] if parts else []
    return [(a, b - 1) for a, b in itertools.pairwise(cuts)]
