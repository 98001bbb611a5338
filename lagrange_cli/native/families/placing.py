"""``@place`` and ``@prepare_place``: totals at states, for a page that draws families.

Both functions come beside a program, so all names in their text are their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lagrange_cli.expression.node import Node
from lagrange_cli.families.arrays import Array, Source, Total
from lagrange_cli.families.values import Described
from lagrange_cli.native.families.evaluation import Evaluation, room
from lagrange_cli.native.families.loops import needed
from lagrange_cli.native.families.vectors import DoubleVectors
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer
from lagrange_cli.native.recurrences.batches.tables import Tables
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values
from lagrange_cli.spec.content import names_of

SCRATCH = "@scratch_of_places"
TABLES = {"@places": "@places_of_points", "@factors": "@factors_of_points"}
"""The tables of a program, and what they are called here."""


def write_placing(system: Described, axes: Sequence[Total]) -> tuple[str, int]:
    """The functions, and the doubles of constants that they take.

    ``@place(constants, times, states, results, stride, count)`` puts the components of all points, one point
    after the other, into rows of ``results``, a column for each of ``count`` samples; states have rows, too.
    """
    return _Writer(system, axes).written()


class _Writer:
    """The functions, and where their arrays are: behind the constants of the motion."""

    def __init__(self, system: Described, axes: Sequence[Total]) -> None:
        self.system, self.axes = system, axes
        self.tables = Tables(Constants())
        self.totals = needed(axes, system.slots)
        whole = [one for one in system.slots.of.values() if one.array.source is Source.WHOLE]
        self.largest = 1 + max((int(one.table.max()) for one in whole), default=0)
        self.wholes = {one.array for one in whole}
        self.places: dict[Array, int] = {}
        self.size = room(self.largest)
        for array in (system.given, system.q, *self.totals):
            self.places[array] = self.size
            self.size += room(array.count)
        self.places |= dict.fromkeys(self.wholes, 0)

    def written(self) -> tuple[str, int]:
        """Both functions."""
        place, prepare = self.place(), self.prepare()
        scalars = LANES * -(-len(self.tables.constants.slots) // LANES)
        text = "".join([place, prepare, self.tables.text()])
        for name, own in TABLES.items():
            text = text.replace(f"{name},", f"{own},").replace(f"{name} ", f"{own} ")
        return f"{text}{SCRATCH} = private constant i64 {scalars}\n", scalars + self.size

    def place(self) -> str:
        """``@place``."""
        system, degrees = self.system, self.system.q.count
        head = "ptr noalias %constants, ptr noalias %times, ptr noalias %states, ptr noalias %results"
        f = Function(f"define void @place({head}, i64 %stride, i64 %count) #0")
        stride, vectors = Integer(f, "%stride", 1), DoubleVectors(f)
        base = vectors.place("%constants", f.load_integer(SCRATCH))
        at = {array: vectors.place(base, first) for array, first in self.places.items()}
        with f.loop(0, Integer(f, "%count", 1)) as sample:
            with f.loop(0, degrees, tested=False) as i:
                f.store(f.load("%states", stride * i + sample), at[system.q], i)
            time = vectors.operand(vectors.splat(f.load("%times", sample), LANES))
            evaluation = Evaluation(vectors, system.slots, at.__getitem__, self.tables, {system.time: time})
            evaluation.write(self.totals)
            for k, axis in enumerate(self.axes):
                with f.loop(0, axis.count, tested=False) as i:
                    row = stride * (i * len(self.axes) + k) + sample
                    f.store(f.load(at[axis], i), "%results", row)
        f.give()
        return f.text()

    def prepare(self) -> str:
        """``@prepare_place``: parameters, whole numbers and constants of the motion."""
        system = self.system
        f = Function("define void @prepare_place(ptr noalias %parameters, ptr noalias %constants) #0")
        vectors = DoubleVectors(f)
        base = vectors.place("%constants", f.load_integer(SCRATCH))
        given = vectors.place(base, self.places[system.given])
        with f.loop(0, system.given.count) as i:
            f.store(f.load("%parameters", i), given, i)
        with f.loop(0, self.largest, tested=False) as i:
            f.store(vectors.whole(i), base, i)
        single, slots = vectors.single(), self.tables.constants.slots
        known: dict[Node, Any] = {
            system.parameters[name]: single.load("%parameters", i, system.given.count)
            for i, name in enumerate(names_of(system.spec.parameters))
            if name in system.parameters
        }
        emit_values(single, [*slots], known, None)
        for node, slot in slots.items():
            vectors.store(vectors.of_single(known[node]), "%constants", slot)
        f.give()
        return f.text()
