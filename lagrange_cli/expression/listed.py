"""Lists of expressions that a loop may repeat: ``(bead[i], bead[i + 1]) for i in range(N - 1)``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import groupby

from lagrange_cli.expression.cursor import PARTS_HINT, WRITTEN, Hopeless
from lagrange_cli.expression.indices import Indices, Unsuited, counted, holds, integer
from lagrange_cli.expression.operators import Parser
from lagrange_cli.expression.syntax import Axis, ExpressionError, Loop, Number, Span, Tree
from lagrange_cli.expression.vocabulary import OR
from lagrange_cli.records import dataclass

MANY = 64
"""Values of an index from which on they are examined together."""
EXAMPLE = "(bead[i], bead[i + 1]) for i in range(N - 1)"


@dataclass(frozen=True)
class Listed:
    """The expressions, and the loops that repeat them, the first one outermost."""

    items: tuple[Tree, ...]
    loops: tuple[Loop, ...]


def read_listed(text: str, *, several: bool) -> tuple[Listed, list[ExpressionError]]:
    """What ``text`` lists, and all that is wrong with it.

    Where there may be ``several``, they have commas between them, and parentheses or brackets around all of
    them or none. Else there is one expression, and commas make it a vector.
    """
    parser = Parser(text, 0)
    whole = Span(0, len(text))
    try:
        if len(text) > WRITTEN.length:
            message = f"an expression of {len(text)} characters is too long (limit {WRITTEN.length})"
            parser.refuse(Span(0, 1), message, PARTS_HINT)
        if several and parser.next.text in ("(", "[") and _encloses(parser):
            items, comma = parser.enclosed(parser.advance())
        else:
            items, comma = _items(parser)
        loops = parser.several_loops(EXAMPLE)
        while parser.next.kind != "end":
            parser.unexpected(items)
        if comma and not several:
            items = [parser.vector(items, whole)]
        found = Listed(tuple(items) or (Number("0", whole),), tuple(loops))  # what '=' follows is dropped
    except Hopeless:
        found = Listed((Number("0", whole),), ())
    except RecursionError:  # called from deep within something else
        return Listed((Number("0", whole),), ()), [ExpressionError(whole, "nested too deep", PARTS_HINT)]
    return found, parser.errors


def _items(parser: Parser) -> tuple[list[Tree], bool]:
    """Expressions up to a loop or the end, and whether there is a comma."""
    if parser.next.kind == "end":
        return [parser.missing()], False
    items = [parser.expression(OR)]
    while parser.sees(","):
        parser.advance()
        items.append(parser.expression(OR))
    return items, len(items) > 1


def _encloses(parser: Parser) -> bool:
    """Whether what the first bracket opens ends before a loop, or with the text."""
    depth = 0
    for k, token in enumerate(parser.tokens):
        if token.kind == "sign":
            depth += (token.text in ("(", "[")) - (token.text in (")", "]"))
        if depth == 0:
            after = parser.tokens[k + 1]
            return after.kind == "end" or after.text == "for"
    return True


def repeated(loops: Sequence[Loop], indices: Indices, most: int) -> Iterator[dict[str, int]]:
    """The values of the loops' indices, one after the other: an empty mapping where there are no loops.

    Raises:
        ExpressionError: where a range is none, or where there are more than ``most`` values of all loops.
    """
    steps = 0

    def run(k: int, own: dict[str, int]) -> Iterator[dict[str, int]]:
        nonlocal steps
        if k == len(loops):
            yield own
            return
        for value in counted(loops[k], {**indices, **own}):
            steps += 1
            if steps > most:
                raise ExpressionError(loops[k].span, f"more than {most} repetitions", "shorten the ranges")
            inner = {**own, loops[k].index: value}
            if all(holds(condition, {**indices, **inner}) for condition in loops[k].conditions):
                yield from run(k + 1, inner)

    yield from run(0, {})


def grids(axes: Sequence[Axis], indices: Indices, most: int) -> list[tuple[range, ...]]:
    """The places of the members that a key stands for, in ascending order, as few grids: those of
    ``range(i)`` are one for each i. Raises as ``places``."""
    steps = 0

    def run(k: int, known: Indices) -> list[tuple[range, ...]]:
        nonlocal steps
        if k == len(axes):
            return [()]
        axis = axes[k]
        if not axis.index:
            value = integer(axis.bounds[0], known)
            return [(range(value, value + 1), *tail) for tail in run(k + 1, known)]
        values = counted(axis, known)
        steps += len(values)
        if steps > most:
            raise ExpressionError(axis.span, f"more than {most} repetitions", "shorten the ranges")
        found = satisfying(axis, values if values.step > 0 else values[::-1], known)
        if k + 1 == len(axes):
            return [(one,) for one in found]
        rows = [(i, run(k + 1, {**known, axis.index: i})) for one in found for i in one]
        rows = [(i, tails) for i, tails in rows if tails]
        alike = groupby(rows, lambda row: row[1])
        return [(one, *tail) for tails, own in alike for one in runs([i for i, _ in own]) for tail in tails]

    return run(0, indices)


def satisfying(axis: Axis, values: range, known: Indices) -> list[range]:
    """The values of an index that satisfy the conditions of its axis; they ascend."""
    if not axis.conditions or not values:
        return [values] if values else []
    if len(values) >= MANY:
        from lagrange_cli.expression.index_arrays import satisfied

        with suppress(Unsuited):
            return runs(satisfied(axis, values, known))
    return runs([i for i in values if all(holds(one, {**known, axis.index: i}) for one in axis.conditions)])


def runs(values: Sequence[int]) -> list[range]:
    """Ascending numbers as few ranges."""
    found: list[range] = []
    first = 0
    while first < len(values):
        step = values[first + 1] - values[first] if first + 1 < len(values) else 1
        last = first
        while last + 1 < len(values) and values[last + 1] - values[last] == step:
            last += 1
        found.append(range(values[first], values[last] + step, step))
        first = last + 1
    return found


def places(
    axes: Sequence[Axis], indices: Indices, most: int
) -> Iterator[tuple[tuple[int, ...], dict[str, int]]]:
    """The places of the members that a key stands for, each with the values of the indices in it.

    Raises:
        ExpressionError: where an index or a range is none, or where there are more than ``most``.
    """
    loops = [Loop(one.index, one.bounds, one.conditions, one.span) for one in axes if one.index]
    if not loops:
        yield tuple(integer(one.bounds[0], indices) for one in axes), {}
        return
    for own in repeated(loops, indices, most):
        known = {**indices, **own}
        yield tuple(own[one.index] if one.index else integer(one.bounds[0], known) for one in axes), own
