"""The equations of the members of a family: a line for all of them, and separate lines for those at the
ends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import sympy

from lagrange_cli.expression.vocabulary import member_name
from lagrange_cli.records import dataclass
from lagrange_cli.spec.spec import Family
from lagrange_cli.symbolic.families.builder import WrittenBuilder
from lagrange_cli.symbolic.families.derivatives import Part, placed, resolved, spans_within
from lagrange_cli.symbolic.families.kinds import LETTERS
from lagrange_cli.symbolic.families.sums import exchanged, gathered, merged
from lagrange_cli.symbolic.grouping import tidy
from lagrange_cli.symbolic.indexed.conditions import (
    Condition,
    Loop,
    changed,
    decided,
    holds,
    negation,
    relation,
)
from lagrange_cli.symbolic.indexed.members import Loops, Summed, even, member, renamed, summed_of
from lagrange_cli.symbolic.indexed.whole import Spans, Whole, named, number, reduced
from lagrange_cli.symbolic.order import Order

TARGET = "@@{}"
"""The name of an index of the member that a line is of, while it is made: no index of a loop has it."""


@dataclass(frozen=True)
class Line:
    """``expression`` belongs to each member with these ``indices`` of a ``family``, as ``loops`` run."""

    family: Family
    indices: tuple[Whole, ...]
    loops: tuple[Loop, ...]
    expression: sympy.Expr

    def name(self, prefix: str = "", suffix: str = "") -> str:
        """The name of the member: ``p_x[i]``, ``x_ddot[i]``."""
        base = f"{prefix}{self.family.name}{suffix}"
        return member_name(base, [one.text for one in self.indices]) if self.indices else base

    def of(self, expression: sympy.Expr) -> Line:
        """The same members with another expression."""
        return Line(self.family, self.indices, self.loops, expression)


class Lines:
    """Makes lines of parts."""

    def __init__(self, builder: WrittenBuilder, order: Order) -> None:
        self.builder, self.order = builder, order
        self.sizes: Spans = {name: (size, size) for name, size in builder.sizes.items()}

    def of(
        self, family: Family, several: Mapping[str, Sequence[Part]]
    ) -> list[tuple[Line, Mapping[str, sympy.Expr]]]:
        """The members of a family that are alike in all of ``several`` sums of parts, and these sums."""
        shape = family.shape
        targets = [TARGET.format(k) for k in range(len(shape))]
        spans = {**self.sizes, **{name: (0, size - 1) for name, size in zip(targets, shape)}}
        found = [(key, resolved(one, targets, spans)) for key, listed in several.items() for one in listed]
        places = {name: one.ravel() for name, one in zip(targets, np.indices(shape))}
        values = {**self.builder.sizes, **places}
        count = int(np.prod(shape, dtype=np.int64))
        guards = list(dict.fromkeys(guard for _, one in found for guard in one.guards))
        masks = {guard: np.broadcast_to(holds(guard, values), count) for guard in guards}
        labels = np.zeros(count, dtype=np.int64)
        for mask in masks.values():
            _, labels = np.unique(2 * labels + mask, return_inverse=True)
        lines: list[tuple[Line, Mapping[str, sympy.Expr]]] = []
        for label in dict.fromkeys(labels[np.sort(np.unique(labels, return_index=True)[1])].tolist()):
            chosen = np.flatnonzero(labels == label)
            true = {guard for guard, mask in masks.items() if mask[chosen[0]]}
            loops, indices = self.described(
                family, {n: p[chosen] for n, p in places.items()}, masks, true, targets
            )
            known = dict(zip(targets, indices))
            line = Line(family, indices, loops, sympy.S.Zero)
            sums: dict[str, list[sympy.Expr]] = {key: [] for key in several}
            for key, one in found:
                if true.issuperset(one.guards):
                    sums[key].append(self.shown(one.expression, known, loops))
            lines.append((line, {key: self.shortened(sympy.Add(*listed)) for key, listed in sums.items()}))
        return lines

    def described(
        self, family: Family, places: Mapping[str, np.ndarray], masks: Mapping[Condition, np.ndarray],
        true: set[Condition], targets: Sequence[str],
    ) -> tuple[tuple[Loop, ...], tuple[Whole, ...]]:  # fmt: skip
        """The loops through some members, and their indices."""
        loops: list[Loop] = []
        indices: list[Whole] = []
        names = self.index_names(family)
        ends = [(int(one.min()), int(one.max())) for one in places.values()]
        count = len(next(iter(places.values()))) if places else 1
        whole = np.prod([high - low + 1 for low, high in ends], dtype=np.int64) == count
        for axis, (low, high) in enumerate(ends):
            if low == high:
                indices.append(self.builder.bound(family, axis, low))
                continue
            start, stop = number(low), self.builder.bound(family, axis, high + 1)
            if low > 2:
                start = self.builder.bound(family, axis, low)
            indices.append(named(names[axis]))
            loops.append(Loop(names[axis], start, stop))
        if not whole:
            known = dict(zip(targets, indices))
            conditions = [one if one in true else negation(one) for one in masks]
            spans = spans_within(loops, self.sizes)
            listed = [
                changed(one, lambda index: reduced(index.with_names(known), spans)) for one in conditions
            ]
            kept = tuple(one for one in dict.fromkeys(listed) if decided(one, spans) is not True)
            last = loops[-1]
            loops[-1] = Loop(last.index, last.start, last.stop, last.step, kept)
        return tuple(loops), tuple(indices)

    def index_names(self, family: Family) -> list[str]:
        """The names of a family's indices."""
        free = [one for one in LETTERS if one not in self.builder.taken]
        return free[: len(family.shape)]

    # expressions

    def shortened(self, expression: sympy.Expr) -> sympy.Expr:
        """With as few sums as can be."""
        return gathered(merged(expression), self.order)

    def shown(self, expression: sympy.Expr, known: Mapping[str, Whole], around: Sequence[Loop]) -> sympy.Expr:
        """An expression with the indices of a line, its sums with indices in the order of the alphabet."""
        spans = spans_within(around, self.sizes)
        inner = {**spans, **{name: one.span(spans) for name, one in known.items()}}
        return self.settled(renamed(expression, known, inner), spans)

    def settled(self, expression: sympy.Expr, spans: Spans) -> sympy.Expr:
        """The expression with its sums simplified, and tidy."""
        return tidy(even(self.with_sums(expression, spans)), self.order)

    def with_sums(self, expression: sympy.Expr, spans: Spans) -> sympy.Expr:
        """Sums with bounds that are simple, and bodies that are tidy."""
        if isinstance(expression, Summed):
            return self.settled_sum(expression, spans)
        if not expression.args or not expression.has(Summed):
            return expression
        return expression.func(*(self.with_sums(one, spans) for one in expression.args))

    def settled_sum(self, summed: Summed, spans: Spans) -> sympy.Expr:
        """A sum whose indices are the first letters that are free."""
        body, (_, loops) = summed.body, placed((), summed.loops, spans)
        inner = spans_within(loops, spans)
        if any(decided(relation(one.start, "<", one.stop), inner) is False for one in loops):
            return sympy.S.Zero
        known_loops = Summed(body, Loops(loops))
        fewer = exchanged(known_loops, spans)
        if fewer != known_loops:
            return self.with_sums(fewer, spans)
        single = [one for one in loops if one.step == 1 and one.stop - one.start == number(1)]
        if single and not single[0].conditions:
            known = {single[0].index: single[0].start}
            rest = [
                one.changed(lambda whole: whole.with_names(known)) for one in loops if one is not single[0]
            ]
            return self.with_sums(Summed(renamed(body, known, inner), Loops(rest)), spans)
        used = set(spans) | self.builder.taken
        letters = [one for one in LETTERS if one not in used][: len(loops)]
        names = {loop.index: named(letter) for loop, letter in zip(loops, letters)}
        shown = [one.changed(lambda whole: whole.with_names(names)) for one in loops]
        loops = [
            Loop(letter, one.start, one.stop, one.step, one.conditions) for letter, one in zip(letters, shown)
        ]
        inner = {**inner, **spans_within(loops, spans)}
        return summed_of(self.settled(renamed(body, names, inner), inner), loops)


def symbol_of(line: Line, base: str) -> sympy.Symbol:
    """A symbol with a line's indices."""
    return member(base, line.indices) if line.indices else sympy.Symbol(base)
