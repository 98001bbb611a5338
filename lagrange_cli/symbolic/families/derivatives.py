"""Derivatives of sums over families by one member, whose indices stay names.

Of sum_a f(.., x[e(a)], ..) by x[i] that is the sum of df/dx[e] over all a with e(a) = i. Where e is such that
one a belongs to each i (a + 1, (a - 1) % N), it takes a's place, and the loop is gone. Else e(a) = i is a
condition.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import count as iterate

import sympy

from lagrange_cli.expression.indices import Unsuited
from lagrange_cli.records import dataclass
from lagrange_cli.symbolic.indexed.conditions import (
    SWAPPED,
    Condition,
    Loop,
    Relation,
    changed,
    decided,
    names_of,
    relation,
    single,
)
from lagrange_cli.symbolic.indexed.members import (
    HIDDEN,
    KNOWN,
    Loops,
    Summed,
    apart,
    hidden,
    names_around,
    opened,
    renamed,
)
from lagrange_cli.symbolic.indexed.whole import Operation, Spans, Whole, named, number, operation, reduced


@dataclass(frozen=True)
class Part:
    """``factor``, for all values of the indices of ``loops``, of the member that has these ``indices``."""

    factor: sympy.Expr
    loops: tuple[Loop, ...]
    indices: tuple[Whole, ...]


@dataclass(frozen=True)
class Resolved:
    """The contribution of a part to the member whose indices are names: ``expression`` where the ``guards``
    hold."""

    expression: sympy.Expr
    guards: tuple[Condition, ...]


Meaning = Callable[[str, Sequence[Whole]], "sympy.Expr | None"]
"""What a name with indices stands for, if it stands for an expression."""


def parts(expression: sympy.Expr, base: str, meaning: Meaning, around: Sequence[Loop] = ()) -> Iterator[Part]:
    """The derivatives of an expression by the members of a family, within the loops ``around``."""
    plain, sums = opened(expression)
    for symbol in sorted(plain.free_symbols, key=str):
        if symbol in sums:
            outer = slope(plain, symbol).xreplace(sums)
            summed = apart(sums[symbol], names_around(around))
            for one in parts(summed.body, base, meaning, (*around, *summed.loops)):
                yield Part(outer * one.factor, (*summed.loops, *one.loops), one.indices)
            continue
        own, indices = KNOWN.get(symbol.name, (symbol.name, ()))
        if own == base:
            yield Part(slope(plain, symbol).xreplace(sums), (), indices)
            continue
        stands_for = meaning(own, indices)
        if stands_for is not None:
            outer = slope(plain, symbol).xreplace(sums)
            for one in parts(stands_for, base, meaning, around):
                yield Part(outer * one.factor, one.loops, one.indices)


def slope(expression: sympy.Expr, symbol: sympy.Symbol) -> sympy.Expr:
    """The partial derivative; of x**n it is n*x**(n - 1), also where n is an index, and not n*x**n/x."""
    made = expression.diff(symbol)
    if any(not one.exp.is_number for one in made.atoms(sympy.Pow)):
        made = sympy.powsimp(made, combine="exp")
    return made


def resolved(part: Part, indices: Sequence[str], spans: Spans) -> Resolved:
    """What it adds to the member with ``indices``, each of them within its bounds; sizes are in ``spans``."""
    count = iterate()
    own = {loop.index: named(f"{HIDDEN}{next(count)}") for loop in part.loops}
    loops = [
        Loop(own[one.index].text, one.start, one.stop, one.step, one.conditions)
        for one in (loop.changed(lambda whole: whole.with_names(own)) for loop in part.loops)
    ]
    wide = spans_within(loops, spans)
    expression = hidden(renamed(part.factor, own, wide), count)
    conditions = [
        relation(one.with_names(own), "==", named(name)) for one, name in zip(part.indices, indices)
    ]
    further: list[Condition] = []
    while conditions:
        condition = conditions.pop(0)
        found = solved(condition.operands[0], named(condition.operands[1].text), loops, spans)
        if found is None:
            further.append(condition)
            continue
        loop, whole, limits = found
        known = {loop.index: whole}
        inner = spans_within(loops, spans)

        def change(one: Whole, known: Mapping[str, Whole] = known, inner: Spans = inner) -> Whole:
            return reduced(one.with_names(known), inner)

        loops = [one.changed(change) for one in loops if one is not loop]
        further += [changed(one, change) for one in (*loop.conditions, *limits)]
        further = [changed(one, change) for one in further]
        conditions = [changed(one, change) for one in conditions]  # type: ignore[misc]
        expression = renamed(expression, known, inner)
    guards, loops = placed(further, loops, spans)
    return Resolved(Summed(expression, Loops(loops)), guards)


def spans_within(loops: Sequence[Loop], spans: Spans) -> Spans:
    """The bounds of all indices."""
    found = dict(spans)
    pending = list(loops)
    while pending:
        known = [one for one in pending if one.names <= found.keys()]
        if not known:
            raise Unsuited
        for one in known:
            found[one.index] = one.span(found)
            pending.remove(one)
    return found


def solved(
    whole: Whole, target: Whole, loops: Sequence[Loop], spans: Spans
) -> tuple[Loop, Whole, list[Condition]] | None:
    """The loop whose index follows from ``whole == target``, what it is, and that it is in its range."""
    for loop in reversed(loops):
        own = named(loop.index)
        made = None
        for atom, factor in whole.terms:
            if atom == loop.index and abs(factor) == 1 and loop.index not in (whole - own * factor).names:
                made = (target - (whole - own * factor)) * factor
            single_term = len(whole.terms) == 1 and not whole.constant and factor == 1
            if isinstance(atom, Operation) and atom.operator == "%" and single_term:
                made = remainder(atom, loop, target, spans)
        if made is None:
            continue
        others = [one for one in loops if one is not loop]
        if any(loop.index in one.names and one.index in made.names for one in others):
            continue
        later = loops[loops.index(loop) + 1 :]
        if any(one.index in made.names and loop.index in one.names for one in later):
            continue
        return loop, made, within(loop, made)
    return None


def remainder(atom: Operation, loop: Loop, target: Whole, spans: Spans) -> Whole | None:
    """The index of a loop where the remainder is ``target``, if it runs through no two numbers with the same
    remainder."""
    own = named(loop.index)
    factor = dict(atom.left.terms).get(loop.index, 0)
    rest = atom.left - own * factor
    if abs(factor) != 1 or loop.index in rest.names | atom.right.names:
        return None
    if not (loop.names | rest.names | atom.right.names) <= spans.keys():
        return None
    low, high = loop.span(spans)
    if low < 0 or high >= atom.right.span(spans)[0] or target.span(spans)[1] >= atom.right.span(spans)[0]:
        return None
    return operation("%", (target - rest) * factor, atom.right)


def within(loop: Loop, whole: Whole) -> list[Condition]:
    """That a number is in a loop's range."""
    found: list[Condition] = [relation(loop.start, "<=", whole), relation(whole, "<", loop.stop)]
    if loop.step > 1:
        found.append(relation(operation("%", whole - loop.start, number(loop.step)), "==", number(0)))
    return found


def placed(
    conditions: Sequence[Condition], loops: Sequence[Loop], spans: Spans
) -> tuple[tuple[Condition, ...], list[Loop]]:
    """Conditions without those that always hold, each in the outermost loop that knows its names or, where
    that is none, beside the loops."""
    ordered: list[Loop] = []
    pending, known = list(loops), set(spans)
    while pending:  # a loop comes after those whose indices it uses
        following = next((one for one in pending if one.names <= known | {one.index}), None)
        if following is None:
            raise Unsuited
        ordered.append(following)
        known.add(following.index)
        pending.remove(following)
    guards: dict[Condition, None] = {}
    bounds: dict[str, tuple[int, int]] = dict(spans)
    waiting = [one for each in conditions for one in single(each)]
    made: list[Loop] = []
    for loop in [None, *ordered]:
        if loop is not None:
            bounds[loop.index] = loop.span(bounds)
        ready = [one for one in waiting if names_of(one) <= bounds.keys()]
        waiting = [one for one in waiting if one not in ready]
        if loop is None:
            guards |= {one: None for one in ready if decided(one, bounds) is not True}
            continue
        own = [one for each in (*loop.conditions, *ready) for one in single(each)]
        loop = Loop(loop.index, loop.start, loop.stop, loop.step)
        for one in own:
            loop = narrowed(loop, one, bounds)
        bounds[loop.index] = loop.span(bounds)
        made.append(loop)
    return tuple(guards), made


def narrowed(loop: Loop, condition: Condition, spans: Spans) -> Loop:
    """The loop with one condition more, in its bounds if it can be."""
    if decided(condition, spans) is True:
        return loop
    found = bounding(condition, loop.index) if loop.step == 1 else None
    if found is not None:
        operator, bound = found
        if operator in (">", "<="):
            bound, operator = bound + number(1), ">=" if operator == ">" else "<"
        if operator == ">=" and decided(relation(bound, ">=", loop.start), spans):
            return Loop(loop.index, bound, loop.stop, 1, loop.conditions)
        if operator == "<" and decided(relation(bound, "<=", loop.stop), spans):
            return Loop(loop.index, loop.start, bound, 1, loop.conditions)
        if operator == "!=" and bound == loop.start:
            return Loop(loop.index, loop.start + number(1), loop.stop, 1, loop.conditions)
        if operator == "!=" and bound + number(1) == loop.stop:
            return Loop(loop.index, loop.start, bound, 1, loop.conditions)
        if operator == "==":
            span = relation(loop.start, "<=", bound), relation(bound, "<", loop.stop)
            if all(decided(one, spans) for one in span):
                return Loop(loop.index, bound, bound + number(1), 1, loop.conditions)
        condition = relation(named(loop.index), operator, bound)
    return Loop(loop.index, loop.start, loop.stop, loop.step, (*loop.conditions, condition))


def bounding(condition: Condition, index: str) -> tuple[str, Whole] | None:
    """How a condition compares an index to what is without it; None where it says something else."""
    if not isinstance(condition, Relation) or len(condition.operators) > 1:
        return None
    difference = condition.operands[0] - condition.operands[1]
    factor = dict(difference.terms).get(index, 0)
    rest, operator = named(index) * factor - difference, condition.operators[0]
    if abs(factor) != 1 or index in rest.names:
        return None
    return operator if factor > 0 else SWAPPED.get(operator, operator), rest * factor
