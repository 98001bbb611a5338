"""Series of one kind, side by side: the common operations of a family's members are written once.

A *batch* is a set of series with the same operation on operands of the same kinds: the differences
x[i] - x[j] of all pairs of bodies, the sines of all angles. They are found in the finished series, not in the
text: so an expanded system has the same ones. They are the coarsest partition that
is stable: all members of a batch have operands in the same batches (J. E. Hopcroft 1971, for automata).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import cast

from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.records import dataclass
from lagrange_cli.series.program import Op, Series, SeriesProgram, needs

LONG = 6
"""Terms of a sum beyond which its operands may be of any kinds: it is then a row of a table."""
_DIGITS = re.compile(r"\d+")


@dataclass(frozen=True)
class Batch:
    """Series that are computed together, in the order of their operands.

    ``operands`` has a row for each operand with that of every member, and ``scales`` those of a sum's terms,
    likewise. A ``long`` sum has rows for each member instead. The members of a ``copy`` are those of
    their operands.
    """

    members: tuple[int, ...]
    one: Series
    operands: tuple[tuple[int, ...], ...]
    scales: tuple[tuple[Node, ...], ...]
    constants: tuple[Node, ...]
    long: bool = False
    copy: bool = False


def batches(program: SeriesProgram, variables: int) -> list[Batch]:
    """The series of ``program`` in batches, in an order in which these may be evaluated."""
    series = program.series
    ranks = same_stage_ranks(program)
    state = set(program.state)
    own = [_own_key(one, rank, i in state, variables) for i, (one, rank) in enumerate(zip(series, ranks))]
    kind, before, now = numbered(own), 0, len({*own})
    while before < now:
        kind = numbered([(mine, _operand_kinds(one, kind)) for mine, one in zip(kind, series)])
        before, now = now, len({*kind})
    members: dict[int, list[int]] = {}
    for index, number in enumerate(kind):
        members.setdefault(number, []).append(index)
    place: dict[int, int] = {}
    found = []
    for same in sorted(members.values(), key=lambda same: (ranks[same[0]], same[0])):
        long = is_long(series[same[0]])
        ways = {i: range(len(series[i].arguments)) if long else arranged(series[i], kind) for i in same}
        if not long:
            same.sort(key=lambda i: [place.get(series[i].arguments[p], -1) for p in ways[i]] or [i])
        for i in same:
            place[i] = len(place)
        found.append(made(program, same, ways, long))
    return found


def made(
    program: SeriesProgram, members: Sequence[int], ways: Mapping[int, Sequence[int]], long: bool
) -> Batch:
    """The batch of these ``members``, whose operands are taken in the order of ``ways``."""
    series = program.series
    operands = [tuple(series[i].arguments[p] for p in ways[i]) for i in members]
    scales: list[tuple[Node, ...]] = []
    constants: list[Node] = []
    for i in members:
        if series[i].op is Op.LINEAR:
            constant, listed = cast("tuple[Node, tuple[Node, ...]]", series[i].data)
            constants.append(constant)
            scales.append(tuple(listed[p] for p in ways[i]))
    one = series[members[0]]
    if long:
        return Batch(tuple(members), one, tuple(operands), tuple(scales), tuple(constants), long)
    return Batch(tuple(members), one, tuple(zip(*operands)), tuple(zip(*scales)), tuple(constants))


def arranged(one: Series, kind: Sequence[int]) -> list[int]:
    """The places of its operands in an order that is the same for all of its kind."""
    places = list(range(len(one.arguments)))
    if one.op is Op.LINEAR:
        scales = cast("tuple[Node, tuple[Node, ...]]", one.data)[1]
        places.sort(key=lambda p: (_scale_key(scales[p]), kind[one.arguments[p]]))
    elif one.op is Op.MULTIPLY:
        places.sort(key=lambda p: kind[one.arguments[p]])
    return places


def is_long(one: Series) -> bool:
    """Whether it is a sum of many terms."""
    return one.op is Op.LINEAR and len(one.arguments) > LONG


def same_stage_ranks(program: SeriesProgram) -> list[int]:
    """How many series of the same stage must be known, one after the other, before each."""
    ranks: list[int] = []
    for one in program.series:
        same = [i for i, ahead in needs(one) if program.series[i].level == one.level + ahead]
        ranks.append(1 + max((ranks[i] for i in same), default=0))
    return ranks


def numbered(keys: Sequence[object]) -> list[int]:
    """Equal keys as equal numbers, in the order in which they appear."""
    seen: dict[object, int] = {}
    return [seen.setdefault(key, len(seen)) for key in keys]


def _operand_kinds(one: Series, kind: Sequence[int]) -> tuple[int, ...]:
    """The kinds of the operands; those of a long sum are free."""
    if is_long(one):
        return ()
    return tuple([kind[one.arguments[p]] for p in arranged(one, kind)] + [kind[a] for a in one.sources])


def _own_key(one: Series, rank: int, state: bool, variables: int) -> object:
    """The common properties of series that are computed together, apart from their operands."""
    shape = one.op, rank, one.level, one.order, one.degree, state
    if one.op is Op.COORDINATE:
        assert one.node is not None
        return shape, _DIGITS.sub("#", str(one.node.data))
    if one.op is Op.LINEAR:
        constant, scales = cast("tuple[Node, tuple[Node, ...]]", one.data)
        if is_long(one):
            return shape, (len(scales) - 1).bit_length(), constant.is_zero
        return shape, constant.is_zero, tuple(sorted(map(_scale_key, scales)))
    if one.op is Op.PRIMITIVE and one.node is not None:
        fixed = tuple(None if a.symbols & variables else a for a in one.node.arguments)
        return shape, one.node.kind, None if one.node.kind is Kind.POWER else one.node.data, fixed
    return shape, one.data if one.op in (Op.POWER, Op.SELECT) else None


def _scale_key(scale: Node) -> float:
    """1 and -1 stand in the code, other factors may differ from member to member."""
    return float(scale.data) if scale.kind is Kind.NUMBER and scale.data in (1, -1) else 0.0
