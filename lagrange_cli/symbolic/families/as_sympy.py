"""Expressions with indices as objects of sympy: members of families are ``Indexed``, sums ``Sum``."""

from __future__ import annotations

from collections.abc import Sequence

import sympy

from lagrange_cli.symbolic.indexed.conditions import Condition, Joined, Loop
from lagrange_cli.symbolic.indexed.members import KNOWN, Summed
from lagrange_cli.symbolic.indexed.whole import Entry, Whole, number

RELATIONS = {"==": sympy.Eq, "!=": sympy.Ne, "<": sympy.Lt, "<=": sympy.Le, ">": sympy.Gt, ">=": sympy.Ge}
EXTREMES = {"min": sympy.Min, "max": sympy.Max}
JOINED = {"and": sympy.And, "or": sympy.Or, "not": sympy.Not}


def as_sympy(expression: sympy.Expr, sizes: Sequence[str] = (), loops: Sequence[Loop] = ()) -> sympy.Expr:
    """The expression, with ``IndexedBase`` for families and ``Sum`` for sums. ``sizes``, and the indices of
    the ``loops`` around it, are integer symbols."""
    whole = frozenset({*sizes, *(loop.index for loop in loops)})
    return _walk(expression, whole)


def _walk(one: sympy.Expr, whole: frozenset[str]) -> sympy.Expr:
    if one.is_Symbol:
        if one.name not in KNOWN:
            return sympy.Symbol(one.name, integer=True) if one.name in whole else one
        base, indices = KNOWN[one.name]
        if not base:
            return integer(indices[0])
        return sympy.IndexedBase(base.replace(".", "_"))[tuple(map(integer, indices))]
    if isinstance(one, Summed):
        made = _walk(one.body, whole | {loop.index for loop in one.loops})
        for loop in reversed(one.loops):
            made = summed(made, loop)
        return made
    return one.func(*(_walk(each, whole) for each in one.args)) if one.args else one


def summed(body: sympy.Expr, loop: Loop) -> sympy.Sum:
    """The sum over a loop; terms that a condition leaves out are 0."""
    index = sympy.Symbol(loop.index, integer=True)
    start, last = integer(loop.start), integer(loop.stop + number(-1))
    conditions = [*map(condition, loop.conditions)]
    if loop.step != 1:
        conditions.append(sympy.Eq(sympy.Mod(index - start, loop.step), 0))
    if conditions:
        body = sympy.Piecewise((body, sympy.And(*conditions)), (0, True))
    return sympy.Sum(body, (index, start, last))


def condition(one: Condition) -> sympy.Basic:
    """A condition on indices."""
    if isinstance(one, Joined):
        return JOINED[one.operator](*map(condition, one.parts))
    pairs = zip(one.operators, one.operands, one.operands[1:])
    return sympy.And(*(RELATIONS[word](integer(left), integer(right)) for word, left, right in pairs))


def integer(whole: Whole) -> sympy.Expr:
    """A whole number with indices and sizes in it."""
    made = sympy.Integer(whole.constant)
    for atom, factor in whole.terms:
        if isinstance(atom, str):
            made += factor * sympy.Symbol(atom, integer=True)
            continue
        if isinstance(atom, Entry):
            table = sympy.IndexedBase(atom.table.name, integer=True)
            made += factor * table[tuple(integer(one) for one in atom.indices)]
            continue
        left, right = integer(atom.left), integer(atom.right)
        if atom.operator == "*":
            made += factor * left * right
        elif atom.operator == "**":
            made += factor * left**right
        elif atom.operator in EXTREMES:
            absolute = atom.operator == "max" and right == -left
            made += factor * (sympy.Abs(left) if absolute else EXTREMES[atom.operator](left, right))
        else:
            made += factor * (sympy.Mod(left, right) if atom.operator == "%" else sympy.floor(left / right))
    return made
