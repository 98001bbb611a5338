"""Expressions of members from all digits of the state: low parts of coordinates, velocities and t, too."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from typing import Any, cast

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.native.families.evaluation import Writer
from lagrange_cli.native.families.everywhere import Everywhere
from lagrange_cli.native.families.vectors import Operands
from lagrange_cli.native.numbers.kind import NumberKind, V
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.recurrences.compensated import Compensated, Sum
from lagrange_cli.native.recurrences.evaluation import emit_values
from lagrange_cli.records import replace


class ExactConstants(Everywhere):
    """Constants of the motion as numbers of which nothing is lost."""

    def value(self, kind: NumberKind[V], node: Node) -> V | None:
        if node.kind is Kind.NUMBER:
            return kind.number(node.data)
        assert isinstance(kind, Compensated) and isinstance(kind.emitter, LaneEmitter)
        return cast("V", (kind.emitter.everywhere("%constants", "0", self.slot(node)), None))


def careful_values(
    writer: Writer,
    nodes: list[Node],
    known: Mapping[Node, Operands],
    slots: Callable[[Any], Mapping[Node, Operands]],
) -> list[Operands]:
    """The expressions of eight members from sums of two doubles, rounded once. What is ``known`` of them are
    the high parts; ``slots`` finds the numbers of a writer."""
    evaluation, low, lower = writer.evaluation, writer.evaluation.low, copy(writer)
    assert low is not None
    lower.evaluation = replace(evaluation, where=low.where)
    rest = slots(lower)
    whole: dict[Node, Sum | None] = {
        symbol: (value, None) for symbol, value in known.items() if symbol.kind is Kind.SYMBOL
    }
    for symbol, slot in writer.used.items():
        if slot.array in low.arrays:
            whole[symbol] = known[symbol], rest[symbol]
    for time in evaluation.known:
        whole[time] = known[time], low.time
    emitter, constants = evaluation.emitter, ExactConstants(evaluation.tables.constants.slots)
    emit_values(Compensated(emitter), nodes, whole, constants)
    found = (whole[node] for node in nodes)
    return [None if one is None else emitter.add(*one) for one in found]
