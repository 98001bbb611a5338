"""Factors and constants of eight members at once: the same in every lane, or from tables."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.native.interface import LANES
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.text import Operand
from lagrange_cli.native.llvm.vector import Integer
from lagrange_cli.native.numbers.kind import NumberKind, V
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.recurrences.batches.gathering import gathered
from lagrange_cli.native.recurrences.batches.quotient import FactorColumn
from lagrange_cli.native.recurrences.evaluation import Constants


def column_at(
    f: Function, emitter: LaneEmitter, column: FactorColumn, at: Integer, places: Callable[[int], Operand]
) -> Operand:
    """Numbers of eight members, or terms, from the ``at``-th on, whose row of a table ``places`` loads."""
    if column.node is not None:
        if column.node.kind is Kind.NUMBER:
            return emitter.written(emitter.number(column.node.data))
        return emitter.everywhere("%constants", "0", column.table)
    if column.numbers:
        place = at + column.table if column.table else at
        return f.load_row("@factors", place, LANES, aligned=True).name
    return gathered(emitter, "%constants", places(column.table))


class Everywhere(Constants):
    """Constants of the motion in every lane."""

    def value(self, kind: NumberKind[V], node: Node) -> V | None:
        if node.kind is Kind.NUMBER:
            return kind.number(node.data)
        everywhere = cast("LaneEmitter", kind).everywhere
        return cast("V", everywhere("%constants", "0", self.slot(node)))
