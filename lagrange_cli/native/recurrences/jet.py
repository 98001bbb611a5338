"""The function ``@jet``: all Taylor coefficients of one step, order by order.

The first stages are unrolled; the later ones are loops over the stage k.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable

from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import operand
from lagrange_cli.native.llvm.vector import Bit, Real
from lagrange_cli.native.numbers.double import Emitter
from lagrange_cli.native.recurrences.compensated import compensated_expansion
from lagrange_cli.native.recurrences.evaluation import Constants
from lagrange_cli.native.recurrences.layout import CARRIED, SeriesLayout, lowest
from lagrange_cli.native.recurrences.rolled import Memory, Opening, Rolled
from lagrange_cli.native.state import whole_vectors
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


def write_jet(
    residual: Residual,
    program: SeriesProgram,
    constants: Constants,
    make: Callable[[Function], Emitter],
    layout: SeriesLayout,
    name: str = "jet",
    *,
    alone: bool = True,
) -> tuple[str, int, int]:
    """IR that computes coefficients of q, v and the integrals into ``%work``, false where M is singular; the
    doubles of ``%work``; and the number of operations. If it is not ``alone``, another such function brings
    along what it calls."""
    arguments = "ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work"
    f = Function(f"define internal i1 @{name}({arguments}) #0")
    emitter = make(f)
    expansion = compensated_expansion(emitter, residual, program, constants, layout.width, layout.doubles)
    memory = Memory(f, expansion, emitter, layout)
    last = layout.order - 2
    rolled = min(last + 1, first_rolled(program, layout))
    for k in range(-2, rolled):
        Opening(memory, k).write()
    memory.newest = {
        (index, age): expansion.table[index].get(rolled - 1 + one.level - age)
        for index, one in enumerate(program.series)
        for age in range(CARRIED)
    }
    deciding = layout.groups[: layout.motion] or layout.groups
    padded = sum(len({dot.level for dot in group.dots}) for group in deciding) <= FEW_GROUPS
    for start, stop in split(rolled, last, SHORT_LOOP if padded else last):
        write_loop(memory, range(start, stop + 1), padded)
    finish(memory)
    f.give(Bit(f, expansion.regular))
    factorization = expansion.factorization
    text = "\n".join([f.text(), *(factorization.functions if alone else ())])
    return text, whole_vectors(factorization.place), f.operations


def first_rolled(program: SeriesProgram, layout: SeriesLayout) -> int:
    """The first stage that a loop may have, or one after the last.

    Where there are convolutions in the motion, these decide: its sums are rounded as without integrals.
    """
    motion = layout.groups[: layout.motion]
    if len(motion or layout.groups) <= ALONE:
        return layout.order - 1
    if not motion:
        program = replace(program, motion=len(program.series))
    return max(UNROLLED, LOWEST - lowest(program, motion or layout.groups))


def write_loop(memory: Memory, stages: range, padded: bool) -> None:
    """A loop over stages."""
    f, emitter = memory.f, memory.emitter
    before = {
        (index, age + 1): f.variable(Real(f, operand(value))) for (index, age), value in memory.newest.items()
    }
    with f.loop(stages[0], stages[-1] + 1, tested=False) as k:
        emitter.forget_depths()
        emitter.repeated = len(stages)
        stage = Rolled(memory, k, stages, padded, before)
        stage.write()
        emitter.repeated = 1
        for index, age in stage.carried:
            before[index, age].set(Real(f, operand(stage.newest(index, age - 1))))
    ages = [*((index, 0) for index in range(len(memory.expansion.table))), *stage.carried]
    memory.newest = {one: stage.newest(*one) for one in ages}


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
