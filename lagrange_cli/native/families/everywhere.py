"""Constants of the motion, the same for eight members side by side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

from lagrange_cli.expression.node import Kind, Node, union
from lagrange_cli.native.families.vectors import Vectors
from lagrange_cli.native.llvm.vector import Pointer
from lagrange_cli.native.numbers.kind import NumberKind, V
from lagrange_cli.native.numbers.lanes import LaneEmitter
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values


class Everywhere(Constants):
    """Constants of the motion in every lane."""

    def value(self, kind: NumberKind[V], node: Node) -> V | None:
        if node.kind is Kind.NUMBER:
            return kind.number(node.data)
        everywhere = cast("LaneEmitter", kind).everywhere
        return cast("V", everywhere("%constants", "0", self.slot(node)))


def put_scalars(
    vectors: Vectors,
    parameters: Sequence[Node | None],
    beyond: int,
    nodes: Sequence[tuple[Node, int]],
    target: Pointer | str,
) -> None:
    """Compute expressions in parameters, each for its place behind a ``target``. Their symbols are those of
    ``%parameters``, whose low parts are so much ``beyond``; None is one that no expression has."""
    single, inside = vectors.single(), union(node for node, _ in nodes)
    known: dict[Node, Any] = {
        symbol: single.load("%parameters", i, beyond)
        for i, symbol in enumerate(parameters)
        if symbol is not None and symbol.symbols & inside
    }
    emit_values(single, [node for node, _ in nodes], known, None)
    for node, place in nodes:
        vectors.store(vectors.of_single(known[node]), target, place)
