"""``@observe``, ``@linearize`` and ``@prepare``: functions of states and parameters, for any kind of numbers.

Where numbers have low parts, all rows of these follow after all of the high parts. At a state in which forces
that jump may hold the motion, these are found first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import reduce

from lagrange_cli.expression.node import Kind, Node, union
from lagrange_cli.mechanics.explicit import Holder, Unknowns
from lagrange_cli.native.guards import HELD
from lagrange_cli.native.linear.blocks import all_unrolled
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Integer
from lagrange_cli.native.numbers.kind import V, Written
from lagrange_cli.native.recurrences.evaluation import Constants, emit_values
from lagrange_cli.native.recurrences.matrix import factored, solved


def solved_for(
    unknowns: Unknowns, kind: Written[V], known: dict[Node, V | None], constants: Constants
) -> list[V | None]:
    """Accelerations, and by how much multipliers are more than what is ``known`` of them."""
    rest = [*unknowns.rest]
    emit_values(kind, rest, known, constants)
    right = [kind.neg(known[node]) for node in rest]
    modes = union(one.mode for one in unknowns.holders)
    factors, _ = factored(unknowns.residual, all_unrolled(kind), known, constants, modes)
    return solved(unknowns.residual, factors, right, kind.one)


ROUNDING = 2.0**8
"""Where the argument of a switch is no more than so many units of rounding of its terms, or of what it would
change by in the time t, it is 0."""
WITHOUT = 2.0**300
"""What stands for a force in place of its part of a limit that is 0: much more than that if it is not 0."""

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

    def side(one: Holder) -> V:
        """That of an argument; a vector has one."""
        return kind.one if one.parts else side_of(kind, here[one.arguments[0]])

    for i, one in enumerate(holders):
        kind.store(side(one), modes, i, count)
    elapsed = kind.magnitude(known[unknowns.residual.model.time])
    for i, one in able:
        rates = []
        for which in (1.0, -1.0):
            kind.store(kind.number(which), modes, i, count)
            rates.append(solution([one.rate])[one.rate] if one.rate else None)
        reach, zero = kind.mul(elapsed, kind.magnitude(kind.sub(*rates))), kind.true
        for argument in reversed(one.arguments):
            size = kind.add(size_of(kind, argument, here), reach)
            bound = kind.mul(kind.number(ROUNDING * kind.unit), size)
            zero = kind.both(zero, kind.compare("ole", kind.magnitude(here[argument]), bound))
            reach = kind.mul(elapsed, size)
        kind.store(kind.select(zero, None, side(one)), modes, i, count)

    sought = [x for _, one in able for x in (one.force, one.limit)]

    def ratios(here: Values[V]) -> list[V]:
        """The multipliers of switches that are able to hold."""
        found = []
        for _, one in able:
            force, limit = (here[x] if x else None for x in (one.force, one.limit))
            beyond = kind.mul(kind.number(WITHOUT), force)
            found.append(kind.select(kind.compare("one", limit, None), kind.div(force, limit), beyond))
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
            to = side_of(kind, value)
            if one.parts and one.limit:  # friction that is 0 has no direction
                to = kind.select(kind.compare("one", here[one.limit], None), kind.one, kind.number(-1.0))
            kind.store(kind.select(beyond, to, here[one.mode]), modes, i, count)
    here = solution([*sought, *(value for one in holders for _, value in one.parts)])
    known.update({one: here[one] for one in (*unknowns.symbols, *(one.mode for one in holders))})
    known.update({one.multiplier: value for (_, one), value in zip(able, ratios(here)) if one.multiplier})
    for one in holders:
        for multiplier, part in one.parts:  # without a limit there is no force
            limit = here[one.limit] if one.limit else None
            known[multiplier] = kind.select(kind.compare("one", limit, None), here[part], None)


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
