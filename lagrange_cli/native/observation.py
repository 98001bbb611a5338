"""``@observe``, ``@linearize`` and ``@prepare``: functions of states and parameters, for any kind of numbers.

Where numbers have low parts, all rows of these follow after all of the high parts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer
from lagrange_cli.native.numbers.kind import V, Written
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values


def write_values(
    name: str,
    kind: Written[V],
    time: Node,
    symbols: Sequence[Node],
    rows: int,
    nodes: list[Node],
    constants: Constants,
    *,
    at_one_time: bool = False,
) -> tuple[str, int]:
    """A function that computes ``nodes`` at each of ``%count`` samples, and its number of operations.

    The arrays of states (so many ``rows``, the first ones those of ``symbols``) and of results have
    ``%stride`` columns. Times are doubles, or there is ``at_one_time`` one sample and the low part of its
    time follows.
    """
    head = "ptr noalias %constants, ptr noalias %times, ptr noalias %states, ptr noalias %results"
    f = Function(f"define void @{name}({head}, i64 %stride, i64 %count) #0")
    kind.body.lines, stride = f.sink, Integer(f, "%stride")
    with f.loop(0, Integer(f, "%count")) as i:

        def place(row: int, count: int) -> tuple[str, str]:
            return (stride * row + i).name, (stride * count).name if kind.parts > 1 else "0"

        known: dict[Node, V | None] = {time: kind.load("%times", i.name, int(at_one_time))}
        for row, symbol in enumerate(symbols):
            known[symbol] = kind.load("%states", *place(row, rows))
        emit_values(kind, nodes, known, constants)
        for row, node in enumerate(nodes):
            kind.store(known[node], "%results", *place(row, len(nodes)))
    f.give()
    return f.text(), kind.body.operations


def write_prepare(
    kind: Written[V], constants: Constants, parameters: Mapping[str, Node], name: str = "void @prepare"
) -> tuple[str, int]:
    """The function that fills ``%constants`` from the parameters' values, and how many doubles it fills."""
    known: dict[Node, V | None] = {}
    for i, node in enumerate(parameters.values()):
        known[node] = kind.load("%parameters", i, len(parameters))
    emit_values(kind, list(constants.slots), known, None)
    for node, slot in constants.slots.items():
        kind.store(known[node], "%constants", kind.parts * slot, kind.parts - 1)
    lines = "\n".join(kind.body.lines)
    head = f"{name}(ptr noalias %parameters, ptr noalias %constants) nounwind"
    return f"define {head} {{\n{lines}\n  ret void\n}}\n", kind.parts * len(constants.slots)
