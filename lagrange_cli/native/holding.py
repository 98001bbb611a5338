"""Accelerations and multipliers at a state in which forces that jump may hold the motion, in machine code."""

from __future__ import annotations

from collections.abc import Iterable
from functools import reduce

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.mechanics.explicit import Unknowns
from lagrange_cli.native.guards import HELD
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.numbers.kind import V, Written
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values
from lagrange_cli.native.unknowns import solved_for

ROUNDING = 2.0**8
"""Where the argument of a switch is no more than so many units of rounding of its terms, or of what it would
change by in the time t, it is 0."""

Values = dict[Node, "V | None"]


def hold(
    f: Function, unknowns: Unknowns, kind: Written[V], known: Values[V], constants: Constants, modes: str
) -> None:
    """Add accelerations, multipliers and modes to what is ``known`` of a state; ``modes`` is memory for them.

    All switches are held at first. Then the one whose multiplier exceeds its bound most is released,
    repeatedly.
    """
    holders, count = unknowns.holders, len(unknowns.holders)
    able = [(i, one) for i, one in enumerate(holders) if one.multiplier is not None]

    def solution(nodes: Iterable[Node | None]) -> Values[V]:
        """All values with the modes in memory, those of some ``nodes`` among them."""
        here = {**known, **{one.mode: kind.load(modes, i, count) for i, one in enumerate(holders)}}
        values = solved_for(unknowns, kind, dict(here), constants)
        here.update(zip(unknowns.symbols, values))
        emit_values(kind, [node for node in nodes if node is not None], here, constants)
        return here

    here, plain = dict(known), [argument for one in holders for argument in one.arguments]
    emit_values(kind, [*plain, *(a for node in plain for a in node.arguments)], here, constants)
    for i, one in enumerate(holders):
        kind.store(side_of(kind, here[one.arguments[0]]), modes, i, count)
    elapsed = kind.magnitude(known[unknowns.residual.model.time])
    for i, one in able:
        rates = []
        for side in (1.0, -1.0):
            kind.store(kind.number(side), modes, i, count)
            rates.append(solution([one.rate])[one.rate] if one.rate else None)
        reach, zero = kind.mul(elapsed, kind.magnitude(kind.sub(*rates))), kind.true
        for argument in reversed(one.arguments):
            size = kind.add(size_of(kind, argument, here), reach)
            bound = kind.mul(kind.number(ROUNDING * kind.unit), size)
            zero = kind.both(zero, kind.compare("ole", kind.magnitude(here[argument]), bound))
            reach = kind.mul(elapsed, size)
        kind.store(kind.select(zero, None, side_of(kind, here[one.arguments[0]])), modes, i, count)

    sought = [x for _, one in able for x in (one.force, one.limit)]

    def ratios(here: Values[V]) -> list[V]:
        """The multipliers of switches that are able to hold."""
        found = []
        for _, one in able:
            force, limit = (here[x] if x else None for x in (one.force, one.limit))
            found.append(kind.select(kind.compare("one", limit, None), kind.div(force, limit), None))
        return found

    with f.loop(0, len(able), tested=False):
        here = solution(sought)
        values = ratios(here)
        sizes = [
            kind.select(kind.compare("oeq", here[one.mode], None), kind.magnitude(value), None)
            for (_, one), value in zip(able, values)
        ]
        most = reduce(kind.larger, sizes, kind.number(HELD))
        for (i, one), value, size in zip(able, values, sizes):
            beyond = kind.both(kind.compare("oge", size, most), kind.compare("ogt", size, kind.number(HELD)))
            kind.store(kind.select(beyond, side_of(kind, value), here[one.mode]), modes, i, count)
    parts = dict(part for one in holders for part in one.parts)
    here = solution([*sought, *parts.values()])
    known.update({one: here[one] for one in (*unknowns.symbols, *(one.mode for one in holders))})
    known.update({one.multiplier: value for (_, one), value in zip(able, ratios(here)) if one.multiplier})
    known.update({symbol: here[value] for symbol, value in parts.items()})


def side_of(kind: Written[V], value: V | None) -> V:
    """-1 or 1."""
    return kind.select(kind.compare("olt", value, None), kind.number(-1.0), kind.one)


def size_of(kind: Written[V], node: Node, known: Values[V]) -> V | None:
    """The size of the terms of a sum; 0 for anything else, whose sign is known to the last bit."""
    if node.kind is not Kind.SUM:
        return None
    constant, coefficients = node.data
    terms = [(kind.number(abs(c)), kind.magnitude(known[a])) for a, c in zip(node.arguments, coefficients)]
    return kind.total(terms, kind.number(abs(constant)))
