"""``@observe``, ``@linearize`` and ``@prepare``: functions of states and parameters, for any kind of numbers.

Where numbers have low parts, all rows of these follow after all of the high parts.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from lagrange_cli.expression.node import Node
from lagrange_cli.mechanics.explicit import Unknowns
from lagrange_cli.native.holding import hold, solved_for
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer
from lagrange_cli.native.numbers.kind import V, Written
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values

ROUNDS = 10
"""Steps of Newton's method for multipliers: these are about as large as without the forces that depend on
them."""


def write_values(
    name: str,
    make: Callable[[Function], Written[V]],
    time: Node,
    symbols: Sequence[Node],
    rows: int,
    nodes: list[Node],
    constants: Constants,
    *,
    at_one_time: bool = False,
    unknowns: Unknowns | None = None,
) -> tuple[str, int]:
    """A function that computes ``nodes`` at each of ``%count`` samples, and its number of operations.

    The arrays of states (so many ``rows``, the first ones those of ``symbols``) and of results have
    ``%stride`` columns. Times are doubles, or there is ``at_one_time`` one sample and the low part of its
    time follows. The nodes may contain ``unknowns``, which are solved for.
    """
    head = "ptr noalias %constants, ptr noalias %times, ptr noalias %states, ptr noalias %results"
    f = Function(f"define void @{name}({head}, i64 %stride, i64 %count) #0")
    kind, stride = make(f), Integer(f, "%stride")
    room = 0
    if unknowns is not None:
        room = len(symbols) if unknowns.quiet is not None else len(unknowns.holders)
    guess = f.define(f"alloca double, i64 {kind.parts * room}, align 8") if room else ""
    with f.loop(0, Integer(f, "%count")) as i:

        def place(row: int, count: int) -> tuple[str, str]:
            return (stride * row + i).name, (stride * count).name if kind.parts > 1 else "0"

        known: dict[Node, V | None] = {time: kind.load("%times", i.name, int(at_one_time))}
        for row, symbol in enumerate(symbols):
            known[symbol] = kind.load("%states", *place(row, rows))
        if unknowns is not None:
            solve_for(f, unknowns, kind, known, constants, guess)
        emit_values(kind, nodes, known, constants)
        for row, node in enumerate(nodes):
            kind.store(known[node], "%results", *place(row, len(nodes)))
    f.give()
    return f.text(), f.operations


def solve_for(
    f: Function,
    unknowns: Unknowns,
    kind: Written[V],
    known: dict[Node, V | None],
    constants: Constants,
    guess: str,
) -> None:
    """Add the values of accelerations and multipliers at a state to what is ``known`` of it.

    Where the equations are not linear in multipliers, by Newton's method in memory at ``guess``; where a
    force that jumps may hold the motion, with the modes in memory there.
    """
    if unknowns.holders:
        hold(f, unknowns, kind, known, constants, guess)
        return
    if unknowns.quiet is None:
        values = solved_for(unknowns, kind, known, constants)
        known.update(zip(unknowns.symbols, values))
        return
    multipliers = unknowns.residual.multipliers
    count = len(multipliers)

    def keep(values: Sequence[V | None]) -> None:
        for i, value in enumerate(values):
            kind.store(value, guess, i, count)

    def better() -> list[V | None]:
        here = {**known, **{one: kind.load(guess, i, count) for i, one in enumerate(multipliers)}}
        values = solved_for(unknowns, kind, dict(here), constants)
        first = len(values) - count
        moved = [kind.add(here[one], value) for one, value in zip(multipliers, values[first:])]
        return [*values[:first], *map(kind.normalized, moved)]

    start = solved_for(unknowns.quiet, kind, dict(known), constants)
    keep(start[len(start) - count :])
    with f.loop(0, ROUNDS, tested=False):
        keep(better()[-count:])
    known.update(zip(unknowns.symbols, better()))


def write_prepare(
    make: Callable[[Function], Written[V]],
    constants: Constants,
    parameters: Mapping[str, Node],
    name: str = "void @prepare",
) -> tuple[str, int]:
    """The function that fills ``%constants`` from the parameters' values, and how many doubles it fills."""
    text, parts = write_map(make, parameters, [*constants.slots.items()], name)
    return text, parts * len(constants.slots)


def write_map(
    make: Callable[[Function], Written[V]],
    parameters: Mapping[str, Node],
    placed: Sequence[tuple[Node, int]],
    name: str,
) -> tuple[str, int]:
    """A function that puts nodes at their places in ``%constants``; and the doubles of a number."""
    f = Function(f"define {name}(ptr noalias %parameters, ptr noalias %constants) nounwind")
    kind = make(f)
    known: dict[Node, V | None] = {}
    for i, node in enumerate(parameters.values()):
        known[node] = kind.load("%parameters", i, len(parameters))
    emit_values(kind, [node for node, _ in placed], known, None)
    for node, place in placed:
        kind.store(known[node], "%constants", kind.parts * place, kind.parts - 1)
    f.give()
    return f.text(), kind.parts
