"""``@jet`` as loops over members: the code of a large system grows with its kinds of series, not with these.

Eight members of a batch are worked on at once, a lane for each (see ``stage``).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from lagrange_cli.mechanics.residual import Residual
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.flow import Variable
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Bit, Integer, Real
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.recurrences.batches.columns import column_at
from lagrange_cli.native.recurrences.batches.gathering import gathered, places_at
from lagrange_cli.native.recurrences.batches.layout import BEFORE, INVERSE, Blocks, count
from lagrange_cli.native.recurrences.batches.quotient import quotient
from lagrange_cli.native.recurrences.batches.saddle import Tabled, at_the_start, entries_of
from lagrange_cli.native.recurrences.batches.saddle_tables import SaddleTables, elimination_of
from lagrange_cli.native.recurrences.batches.stage import BatchStage, JetData
from lagrange_cli.native.recurrences.batches.tables import Tables
from lagrange_cli.native.recurrences.vector_stage import rests

BEGINNING = 2
"""The first stage that a loop may have where every series is of level 0 or more."""


def write_batched_jet(residual: Residual, blocks: Blocks, tables: Tables, low: int) -> tuple[str, int, int]:
    """The text of ``@jet`` and of what it calls, its doubles of ``%work``, and the number of its operations.

    Remainders of the state are ``low`` behind its numbers. Raises ``Misfit`` if the system is of another
    kind.
    """
    f = Function(
        "define internal i1 @jet(ptr noalias %constants, double %t, ptr noalias %state, ptr noalias %work) #0"
    )
    emitter = LaneEmitter(f)
    jet = JetData(residual, quotient(residual, blocks, tables, low), blocks, tables, f, emitter)
    jet.time = f.splat(Real(f, "%t", 1), LANES).name
    elimination = elimination_of(residual) if residual.multipliers else None
    if elimination is not None:
        jet.saddle = Tabled(f, emitter, SaddleTables(elimination, tables), "%work", blocks.doubles)
    last = blocks.order - 2
    rolled = max(1, BEGINNING - min(one.level for one in blocks.program.series))
    regular = f.variable(Bit(f, "true", 1))
    for k in range(-2, min(rolled, last + 1)):
        stage(jet, k, 1)
        if k == -1:
            factor(jet, regular)
    if rolled <= last:
        with f.loop(rolled, last + 1, tested=False) as counter:
            stage(jet, counter, last + 1 - rolled)
    copy_state(jet)
    f.give(regular.get())
    parts = [rests(blocks.order + 4), f.text()]
    work = blocks.doubles if jet.saddle is None else jet.saddle.end
    return "\n".join(parts), LANES * -(-work // LANES), f.operations


@contextmanager
def members(jet: JetData, batch: int, k: int | Integer, executed: int) -> Iterator[BatchStage]:
    """A loop over the members of a batch in stage ``k``, eight at a time."""
    blocks = count(jet.blocks.batches[batch].members)
    jet.emitter.repeated = blocks * executed
    with jet.f.loop(0, blocks, tested=False) as b:
        yield BatchStage(jet, k, batch, b)
    jet.emitter.repeated = 1


def stage(jet: JetData, k: int | Integer, executed: int) -> None:
    """All batches in stage ``k``, then the accelerations, and what depends on them."""
    series = jet.quotient.program.series
    for group in jet.groups:
        begun = [i for i in group if not isinstance(k, int) or k + series[i].level >= 0]
        if begun:
            with members(jet, begun[0], k, executed) as one:
                for batch in begun:
                    BatchStage(jet, k, batch, one.b).write()
    if isinstance(k, int) and k < 0:
        return
    moved = set[int]()
    if jet.saddle is not None:
        blocks, base = jet.blocks, jet.f.place("%work", k * LANES, "double")
        jet.saddle.solve(base, [blocks.offsets[i] for i in blocks.program.residual], blocks.zero)
    for moving in jet.quotient.motion:
        with members(jet, moving.coordinate, k, executed) as one:
            one.accelerate(BatchStage(jet, k, moving.velocity, one.b), moving)
        moved |= {moving.coordinate, moving.velocity}
    for batch, rows in jet.quotient.multipliers:
        with members(jet, batch, k, executed) as one:
            one.multiply(rows)
        moved.add(batch)
    for batch in range(len(jet.blocks.batches)):
        if series[batch].corrected and batch not in moved and batch in jet.quotient.read:
            with members(jet, batch, k, executed) as one:
                one.correct()


def factor(jet: JetData, regular: Variable[Bit]) -> None:
    """The matrix of the equations, and whether it is regular."""
    f, emitter = jet.f, jet.emitter
    if jet.saddle is not None:
        entries = entries_of(jet.saddle.tabled, jet.residual)
        nodes = [node for each in entries.values() for node in each]
        values = at_the_start(f, emitter, jet.residual, jet.blocks, nodes, jet.tables, jet.time)
        jet.saddle.factor(values.base, values.placed(entries), regular)
        return
    for moving in jet.quotient.motion:
        with members(jet, moving.coordinate, 0, 1) as one:
            assert moving.masses is not None
            mass = column_at(f, emitter, moving.masses, one.b * LANES, one.places)
            one.put(emitter.div(emitter.one, mass), INVERSE)
            size = mass if jet.residual.definite else emitter.magnitude(mass)
            good = Bit(f, emitter.compare("ogt", size, None), LANES)
            regular.set(regular.get() & f.all(good))


def copy_state(jet: JetData) -> None:
    """The coefficients of the state's rows to where steps read them."""
    blocks, f = jet.blocks, jet.f
    offsets = [blocks.offsets[i] for i in blocks.program.state]
    offsets += [blocks.zero] * (blocks.width - len(offsets))
    table = jet.tables.of_places(offsets)
    with f.loop(0, blocks.width // LANES, tested=False) as b:
        at = b * LANES
        places = places_at(f, at + table if table else at)
        row = b * (LANES * blocks.span)
        with f.loop(1, blocks.order + 1, tested=False) as m:
            value = gathered(jet.emitter, f.place("%work", m * LANES, "double").name, places)
            to = row + m * LANES + LANES * BEFORE
            f.store_row(Real(f, value, LANES), "%work", to, aligned=True)
