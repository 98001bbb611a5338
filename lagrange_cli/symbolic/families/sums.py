"""Sums beside one another and within one another: written as fewer, or shorter."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
import sympy

from lagrange_cli.expression.symbolic_switches import Extremum, Largest, Least
from lagrange_cli.symbolic.families.derivatives import bounding, spans_within
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.indexed.conditions import Loop, decided, relation
from lagrange_cli.symbolic.indexed.members import (
    HIDDEN,
    KNOWN,
    Loops,
    Summed,
    expression_of,
    names_in,
    renamed,
    summed_of,
)
from lagrange_cli.symbolic.indexed.whole import Spans, Values, Whole, named, number
from lagrange_cli.symbolic.order import Order
from lagrange_cli.symbolic.work import size_of

CLOSE = 3
"""Terms that sums may differ in to be written out."""


def merged(expression: sympy.Expr) -> sympy.Expr:
    """Sums of the same over ranges that are beside each other are one."""
    terms = list(sympy.Add.make_args(expression))
    done: list[sympy.Expr] = []
    while terms:
        one = terms.pop(0)
        for k, other in enumerate(terms):
            together = joined(one, other)
            if together is not None:
                terms[k] = together
                break
        else:
            done.append(one)
    return sympy.Add(*done)


def joined(one: sympy.Expr, other: sympy.Expr) -> sympy.Expr | None:
    """The sum of two sums that differ in the range of their loop only."""
    pairs = [single(term) for term in (one, other)]
    if pairs[0] is None or pairs[1] is None or any(len(summed.loops) != 1 for summed, _ in pairs):  # type: ignore[misc]
        return None
    (left, factor), (right, same) = pairs  # type: ignore[misc]
    if factor != same or left.body != right.body:
        return None
    loops = sorted_loops(left.loops[0], right.loops[0])
    return None if loops is None else factor * Summed(left.body, Loops([loops]))


def single(term: sympy.Expr) -> tuple[Summed, sympy.Expr] | None:
    """The only sum in a product, and what it is multiplied with."""
    factors = sympy.Mul.make_args(term)
    found = [one for one in factors if isinstance(one, Summed)]
    rest = [one for one in factors if one not in found]
    return (found[0], sympy.Mul(*rest)) if len(found) == 1 else None


def sorted_loops(one: Loop, other: Loop) -> Loop | None:
    """One loop in place of two, the second of which begins where the first ends, or one further."""
    if one.step != 1 or other.step != 1 or one.conditions != other.conditions:
        return None
    for first, second in ((one, other), (other, one)):
        gap = second.start - first.stop
        if gap == number(0):
            return Loop(one.index, first.start, second.stop, 1, one.conditions)
        if gap == number(1):
            apart = relation(named(one.index), "!=", first.stop)
            return Loop(one.index, first.start, second.stop, 1, (*one.conditions, apart))
    return None


def gathered(expression: sympy.Expr, order: Order) -> sympy.Expr:
    """Sums over the same loops as one, where that is shorter: cos(x)*sum(cos(y)) + sin(x)*sum(sin(y))."""
    alike: dict[Loops, list[sympy.Expr]] = {}
    others: list[sympy.Expr] = []
    for term in sympy.Add.make_args(expression):
        found = single(term)
        if found is None or found[1].has(Summed):
            others.append(term)
        else:
            alike.setdefault(found[0].args[1], []).append(term)
    for loops, terms in alike.items():
        bodies = [single(term) for term in terms]
        body = tidy(sympy.Add(*(one[0].body * one[1] for one in bodies if one is not None)), order)
        together = summed_of(body, loops.loops)
        shorter = len(terms) > 1 and size_of(together) < size_of(sympy.Add(*terms))
        others += [together] if shorter else terms
    return sympy.Add(*others)


def exchanged(summed: sympy.Expr, spans: Spans) -> sympy.Expr:
    """A sum in which a loop that changes nothing is left out, and counted: of f[j] for j in range(i + 1), for
    all i below N, it is the sum of (N - j)*f[j]."""
    if not isinstance(summed, Summed) or any(one.step != 1 for one in summed.loops):
        return summed
    *around, last = summed.loops
    used = names_in(summed.body)
    if len(last.conditions) == 1 and not around and last.index not in used:
        return times_from_two(summed, last, spans)
    if any(one.conditions for one in summed.loops):
        return summed
    if last.index not in used:
        inner = spans_within(around, spans)
        if not decided(relation(last.start, "<=", last.stop), inner):
            return summed
        body = summed.body * expression_of(last.stop - last.start)
        return exchanged(Summed(body, Loops(around)), spans) if around else body
    if not around or around[-1].index in used:
        return summed
    *further, outer = around
    inner = spans_within(further, spans)
    own = named(last.index)
    turned = turned_around(outer, last, inner)
    if turned is None:
        return summed
    loop, times = turned
    assert loop.index == own.text
    return exchanged(Summed(summed.body * times, Loops([*further, loop])), spans)


def times_from_two(summed: Summed, loop: Loop, spans: Spans) -> sympy.Expr:
    """A sum over k in range(i, N) if k >= j of what does not change: N - max(i, j) times that."""
    found = bounding(loop.conditions[0], loop.index)
    start, stop = loop.start, loop.stop
    if found is None or not decided(relation(start, "<=", stop), spans):
        return summed
    operator, bound = found
    if operator == "<" and decided(relation(start, "<=", bound), spans):
        return summed.body * (Least(*ends(stop, bound)) - expression_of(start))
    if operator == ">=" and decided(relation(bound, "<=", stop), spans):
        return summed.body * (expression_of(stop) - Largest(*ends(start, bound)))
    return summed


def ends(*bounds: Whole) -> list[sympy.Expr]:
    """Bounds as expressions."""
    return [*map(expression_of, bounds)]


def turned_around(outer: Loop, last: Loop, spans: Spans) -> tuple[Loop, sympy.Expr] | None:
    """Of two loops, the inner one alone, and how often its index has each value; None where that differs in
    form."""
    own, around = named(last.index), named(outer.index)
    up, down = last.stop - around, last.start - around
    if outer.index not in up.names | last.start.names:  # last.start <= own < outer.index + up
        loop = Loop(last.index, last.start, outer.stop - number(1) + up)
        first, inner = own - up + number(1), {**spans, last.index: loop.span(spans)}
        if decided(relation(first, ">=", outer.start), inner):
            return loop, expression_of(outer.stop - first)
        if not decided(relation(outer.start, "<=", outer.stop), spans):
            return None
        return loop, expression_of(outer.stop) - Largest(*ends(first, outer.start))
    if outer.index not in down.names | last.stop.names:  # outer.index + down <= own < last.stop
        loop = Loop(last.index, outer.start + down, last.stop)
        beyond, inner = own - down + number(1), {**spans, last.index: loop.span(spans)}
        if decided(relation(beyond, "<=", outer.stop), inner):
            return loop, expression_of(beyond - outer.start)
        if not decided(relation(outer.start, "<=", outer.stop), spans):
            return None
        return loop, Least(*ends(beyond, outer.stop)) - expression_of(outer.start)
    return None


def telescoped(expression: sympy.Expr, values: Values) -> sympy.Expr:
    """The difference of sums that differ in a few terms as these terms, where indices have these values."""
    terms = list(sympy.Add.make_args(expression))
    for i, one in enumerate(terms):
        for k in range(i):
            rest = difference(one, terms[k], values)
            if rest is not None:
                others = [term for n, term in enumerate(terms) if n not in (i, k)]
                return telescoped(sympy.Add(rest, *others), values)
    return expression


def difference(one: sympy.Expr, other: sympy.Expr, values: Values) -> sympy.Expr | None:
    """The sum of two sums whose terms cancel but for a few; None where there are more."""
    pairs = single(one), single(other)
    if pairs[0] is None or pairs[1] is None or pairs[0][1] != -pairs[1][1]:
        return None
    (left, factor), (right, _) = pairs[0], pairs[1]
    if not all(len(each.loops) == 1 and runs(each.loops[0], values) for each in (left, right)):
        return None
    (mine,), (its,) = left.loops, right.loops
    if renamed(right.body, {its.index: named(mine.index)}, {}) != left.body:
        return None
    for same, low, high in ((mine.start == its.start, its.stop, mine.stop),
                            (mine.stop == its.stop, mine.start, its.start)):  # fmt: skip
        apart = high - low
        if same and not apart.terms and abs(apart.constant) <= CLOSE:
            first = low if apart.constant > 0 else high
            places = [first + number(k) for k in range(abs(apart.constant))]
            listed = [renamed(left.body, {mine.index: place}, {}) for place in places]
            return factor * (1 if apart.constant > 0 else -1) * sympy.Add(*listed)
    return None


def runs(loop: Loop, values: Values) -> bool:
    """Whether a loop goes on from a number to one that is not less, whatever the indices around it."""
    if loop.conditions or loop.step != 1 or not loop.names <= values.keys():
        return False
    return bool(np.all(loop.start.value(values) <= loop.stop.value(values)))


def finished(expression: sympy.Expr, letters: Sequence[str], paths: Collection[str]) -> sympy.Expr:
    """An expression as it is printed: indices of sums are ``letters``, factors that all terms of a sum share
    are in front of them, and path[i,i] is 1."""
    if isinstance(expression, Summed):
        free = [one for one in letters if one not in {loop.index for loop in expression.loops}]
        known: dict[str, Whole] = {}
        loops = []
        for loop in expression.loops:
            loop = loop.changed(lambda whole: whole.with_names(known))
            if loop.index.startswith(HIDDEN):
                known[loop.index] = named(free.pop(0))
                loop = Loop(known[loop.index].text, loop.start, loop.stop, loop.step, loop.conditions)
            loops.append(loop)
        around = {loop.index for loop in loops}
        inside = [one for one in letters if one not in around]
        body = finished(renamed(expression.body, known, {}), inside, paths)
        return summed_of(with_common_factor(body), loops)
    if expression.is_Symbol and expression.name in KNOWN:
        base, indices = KNOWN[expression.name]
        return sympy.S.One if base in paths and indices[0] == indices[1] else expression
    if not expression.args:
        return expression
    made = [finished(one, letters, paths) for one in expression.args]
    if isinstance(expression, Extremum):
        made.sort(key=str)
    return expression if made == list(expression.args) else expression.func(*made)


def with_common_factor(expression: sympy.Expr) -> sympy.Expr:
    """A sum as a product of what all of its terms have, and the rest."""
    if not expression.is_Add:
        return expression
    powers = [one.as_coeff_Mul()[1].as_powers_dict() for one in expression.args]
    alike = [
        base**exponent
        for base, exponent in powers[0].items()
        if exponent.is_Integer and exponent > 0 and all(one.get(base) == exponent for one in powers)
    ]
    common = sympy.Mul(*alike)
    return common * sympy.Add(*(one / common for one in expression.args))
