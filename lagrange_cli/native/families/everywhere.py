"""Constants of the motion, the same for eight members side by side."""

from __future__ import annotations

from typing import cast

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.native.numbers.kind import NumberKind, V
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.recurrences.evaluation import Constants


class Everywhere(Constants):
    """Constants of the motion in every lane."""

    def value(self, kind: NumberKind[V], node: Node) -> V | None:
        if node.kind is Kind.NUMBER:
            return kind.number(node.data)
        everywhere = cast("LaneEmitter", kind).everywhere
        return cast("V", everywhere("%constants", "0", self.slot(node)))
