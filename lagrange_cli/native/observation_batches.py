"""``@observe`` and ``@prepare`` of large systems, in batches (see ``recurrences.batches.values``)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer
from lagrange_cli.native.recurrences.batches.tables import Tables
from lagrange_cli.native.recurrences.batches.values import BatchedValues


def batched_values(
    time: Node, symbols: Sequence[Node], nodes: Sequence[Node], tables: Tables
) -> tuple[str, int]:
    """``@observe``, as ``observation.write_values`` writes it, in batches; and its number of operations."""
    head = "ptr noalias %constants, ptr noalias %times, ptr noalias %states, ptr noalias %results"
    f = Function(f"define void @observe({head}, i64 %stride, i64 %count) #0")
    stride, leaves = Integer(f, "%stride"), [time, *symbols]
    values = BatchedValues(f, leaves, nodes, tables)
    with f.loop(0, Integer(f, "%count")) as i:
        f.store(f.load("%times", i), values.base)
        with f.loop(1, len(leaves)) as row:
            f.store(f.load("%states", stride * (row - 1) + i), values.base, row)
        values.write()
        with f.loop(0, len(nodes)) as row:
            f.store(values.root(row), "%results", stride * row + i)
    f.give()
    return f.text(), f.operations


def batched_prepare(parameters: Mapping[str, Node], tables: Tables) -> tuple[str, int]:
    """``observation.write_prepare`` in batches."""
    f = Function("define void @prepare(ptr noalias %parameters, ptr noalias %constants) #0")
    leaves, nodes = [*parameters.values()], [*tables.constants.slots]
    values = BatchedValues(f, leaves, nodes, tables)
    with f.loop(0, len(leaves)) as row:
        f.store(f.load("%parameters", row), values.base, row)
    values.write()
    with f.loop(0, len(nodes)) as row:
        f.store(values.root(row), "%constants", row)
    f.give()
    begin = f"@scratch = private constant i64 {len(nodes)}\n"
    return begin + f.text(), len(nodes) + tables.scratch
