"""Whole numbers with names in them: what indices and the bounds of sums are, as they are printed.

``Whole`` is a linear expression of indices, of sizes, of remainders and quotients of such expressions, and of
numbers in tables, whose places are such expressions.
Its ``text`` is in the grammar of system files.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial, reduce
from operator import add, sub
from typing import TYPE_CHECKING, Any, TypeAlias

from lagrange_cli.expression.indices import EXTREMES, OPERATIONS, Unsuited, power
from lagrange_cli.expression.syntax import (
    WHOLE,
    WHOLE_FUNCTIONS,
    Binary,
    Call,
    Lookup,
    Name,
    Negative,
    Number,
    Tree,
)
from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.expression.number_table import NumberTable

Span: TypeAlias = tuple[int, int]
"""The least and the greatest value."""
Spans: TypeAlias = Mapping[str, Span]
Values: TypeAlias = Mapping[str, Any]


@dataclass(frozen=True)
class Operation:
    """``left operator right``, one of ``// % * **``; or ``min`` or ``max`` of both: |a| is max(a, -a)."""

    operator: str
    left: Whole
    right: Whole

    @property
    def text(self) -> str:
        """As it is written."""
        if self.operator in EXTREMES:
            if self.operator == "max" and self.right == self.left * -1:
                return f"abs({self.left.text})"
            return f"{self.operator}({self.left.text}, {self.right.text})"
        space = "" if self.operator == "**" else " "
        return f"{enclosed(self.left)}{space}{self.operator}{space}{enclosed(self.right)}"

    @property
    def names(self) -> frozenset[str]:
        """All names in it."""
        return self.left.names | self.right.names

    def each(self, change: Callable[[Whole], Whole]) -> Whole:
        """The same operation of what ``change`` makes of both."""
        return operation(self.operator, change(self.left), change(self.right))

    def value(self, values: Values) -> Any:
        """The number, or the array of numbers."""
        from lagrange_cli.expression.index_arrays import raised

        operate = raised if self.operator == "**" else (OPERATIONS | EXTREMES)[self.operator]
        return operate(self.left.value(values), self.right.value(values))

    def span(self, spans: Spans) -> Span:
        """Bounds of its values."""
        left, right = self.left.span(spans), self.right.span(spans)
        if self.operator == "*":
            ends = [a * b for a in left for b in right]
            return min(ends), max(ends)
        if self.operator in EXTREMES:
            return EXTREMES[self.operator](left[0], right[0]), EXTREMES[self.operator](left[1], right[1])
        if self.operator == "**":
            if min(left[0], right[0]) < 0:
                raise Unsuited
            return left[0] ** right[0] if left[0] else 0, max(1, power(left[1], right[1]))
        if right[0] <= 0:
            raise Unsuited
        if self.operator == "%":
            return 0, right[1] - 1
        ends = [a // b for a in left for b in right]
        return min(ends), max(ends)


@dataclass(frozen=True)
class Entry:
    """A number in a table: ``a[n]``."""

    table: NumberTable
    indices: tuple[Whole, ...]

    @property
    def text(self) -> str:
        """As it is written."""
        return f"{self.table.name}[{','.join(one.text for one in self.indices)}]"

    @property
    def names(self) -> frozenset[str]:
        """All names in its indices."""
        return frozenset[str]().union(*(one.names for one in self.indices))

    def each(self, change: Callable[[Whole], Whole]) -> Whole:
        """The number at other places: at those that ``change`` makes of its indices."""
        return entry(self.table, [change(one) for one in self.indices])

    def value(self, values: Values) -> Any:
        """The number, or the array of numbers."""
        from lagrange_cli.expression.index_arrays import looked_up

        return looked_up(self.table, [one.value(values) for one in self.indices])

    def span(self, spans: Spans) -> Span:
        """Bounds of its values."""
        numbers = self.table.numbers[self.table.given]
        return int(numbers.min()), int(numbers.max())


Atom: TypeAlias = "str | Operation | Entry"


@dataclass(frozen=True)
class Whole:
    """``constant`` + the sum of ``terms``: factor and atom, none of the factors 0."""

    terms: tuple[tuple[Atom, int], ...]
    constant: int

    def __add__(self, other: Whole) -> Whole:
        factors: dict[Atom, int] = dict(self.terms)
        for atom, factor in other.terms:
            factors[atom] = factors.get(atom, 0) + factor
        return Whole(tuple((a, f) for a, f in factors.items() if f), self.constant + other.constant)

    def __mul__(self, factor: int) -> Whole:
        return Whole(tuple((a, f * factor) for a, f in self.terms if factor), self.constant * factor)

    def __sub__(self, other: Whole) -> Whole:
        return self + other * -1

    @property
    def names(self) -> frozenset[str]:
        """All names in it."""
        found: set[str] = set()
        for atom, _ in self.terms:
            found |= {atom} if isinstance(atom, str) else atom.names
        return frozenset(found)

    @property
    def text(self) -> str:
        """As it is written: ``i + 1``."""
        parts = [(factor, atom) for atom, factor in self.terms]
        parts.sort(key=lambda part: part[0] < 0)
        text = ""
        for factor, atom in parts:
            single = atom if isinstance(atom, str) else atom.text
            beside = len(parts) > 1 or self.constant or abs(factor) != 1
            if beside and isinstance(atom, Operation) and atom.operator not in EXTREMES:
                single = f"({single})"
            product = single if abs(factor) == 1 else f"{abs(factor)}*{single}"
            text += (f" {'-' if factor < 0 else '+'} " if text else "-" * (factor < 0)) + product
        if self.constant or not text:
            sign = f" {'-' if self.constant < 0 else '+'} " if text else "-" * (self.constant < 0)
            text += f"{sign}{abs(self.constant)}"
        return text

    def with_names(self, known: Mapping[str, Whole]) -> Whole:
        """The same with other numbers in place of names."""
        if not self.names & known.keys():
            return self
        made = Whole((), self.constant)
        for atom, factor in self.terms:
            if isinstance(atom, str):
                part = known.get(atom, Whole(((atom, 1),), 0))
            else:
                part = atom.each(lambda one: one.with_names(known))
            made += part * factor
        return made

    def value(self, values: Values) -> Any:
        """The number, or the array of numbers, where names have these values."""
        made: Any = self.constant
        for atom, factor in self.terms:
            made = made + factor * (values[atom] if isinstance(atom, str) else atom.value(values))
        return made

    def span(self, spans: Spans) -> Span:
        """Bounds of its values, where names have values within bounds."""
        low = high = self.constant
        for atom, factor in self.terms:
            inner = spans[atom] if isinstance(atom, str) else atom.span(spans)
            ends = sorted(factor * end for end in inner)
            low, high = low + ends[0], high + ends[1]
        return low, high


def enclosed(whole: Whole) -> str:
    """In parentheses, unless it is a single name or number."""
    plain = (not whole.terms and whole.constant >= 0) or (
        len(whole.terms) == 1 and not whole.constant and isinstance(whole.terms[0][0], str)
        and whole.terms[0][1] == 1
    )  # fmt: skip
    return whole.text if plain else f"({whole.text})"


def number(value: int) -> Whole:
    """A number."""
    return Whole((), int(value))


def named(name: str) -> Whole:
    """A name."""
    return Whole(((name, 1),), 0)


def entry(table: NumberTable, indices: Sequence[Whole]) -> Whole:
    """A number in a table."""
    if not any(one.terms for one in indices):
        found = table.number([one.constant for one in indices])
        if found is None:
            raise Unsuited
        return number(found)
    return Whole(((Entry(table, tuple(indices)), 1),), 0)


def operation(operator: str, left: Whole, right: Whole) -> Whole:
    """A remainder, quotient or product, or the lesser or greater one."""
    if not left.terms and not right.terms:
        if (operator in WHOLE and right.constant == 0) or (operator == "**" and right.constant < 0):
            raise Unsuited
        return number((OPERATIONS | EXTREMES)[operator](left.constant, right.constant))
    if operator == "*":
        if not right.terms:
            return left * right.constant
        if not left.terms:
            return right * left.constant
    if operator == "%":
        left = without_multiples(left, right)
    if operator == "max" and right == left * -1:  # |i - j| is |j - i|
        terms = tuple(sorted(left.terms, key=lambda term: Whole((term,), 0).text.lstrip("-")))
        left = Whole(terms, left.constant) * (1 if terms[0][1] > 0 else -1)
        right = left * -1
    return Whole(((Operation(operator, left, right), 1),), 0)


def without_multiples(left: Whole, right: Whole) -> Whole:
    """What has the same remainder, without terms that are multiples of ``right``, and without remainders."""
    made = number(left.constant)
    for atom, factor in left.terms:
        term = Whole(((atom, 1),), 0)
        if isinstance(atom, Operation) and atom.operator == "%" and atom.right == right:
            term = atom.left
        if term != right:
            made += term * factor
    return made


def reduced(whole: Whole, spans: Spans) -> Whole:
    """Without remainders of what is within the same multiples of the divisor everywhere: -1 % N is N - 1."""
    made = number(whole.constant)
    for atom, factor in whole.terms:
        if isinstance(atom, str):
            made += Whole(((atom, factor),), 0)
            continue
        part = atom.each(lambda one: reduced(one, spans))
        if (
            isinstance(atom, Operation)
            and atom.operator == "%"
            and len(part.terms) == 1
            and isinstance(part.terms[0][0], Operation)
        ):
            inner = part.terms[0][0]
            multiple = quotient_of(inner, spans)
            if multiple is not None:
                part = inner.left - inner.right * multiple
        made += part * factor
    return made


def quotient_of(atom: Operation, spans: Spans) -> int | None:
    """How often the divisor of a remainder is in its dividend, where that is the same number everywhere."""
    (low, high), (least, most) = atom.left.span(spans), atom.right.span(spans)
    if least <= 0:
        return None
    found = low // least
    inside = max(found * least, found * most) <= low and high < min((found + 1) * least, (found + 1) * most)
    return found if inside else None


def whole_of(tree: Tree, names: Mapping[str, Whole]) -> Whole:
    """The whole number that a tree stands for. Raises ``Unsuited``."""
    if isinstance(tree, Number) and tree.text.isdecimal():
        return number(int(tree.text))
    if isinstance(tree, Name) and not tree.indices and tree.identifier in names:
        return names[tree.identifier]
    if isinstance(tree, Lookup):
        return entry(tree.table, [whole_of(one, names) for one in tree.indices])
    if isinstance(tree, Negative):
        return whole_of(tree.operand, names) * -1
    if isinstance(tree, Binary):
        left, right = whole_of(tree.left, names), whole_of(tree.right, names)
        linear: Mapping[str, Callable[[Whole, Whole], Whole]] = {"+": add, "-": sub}
        if tree.operator in linear:
            return linear[tree.operator](left, right)
        if tree.operator in ("*", "//", "%", "**"):
            return operation(tree.operator, left, right)
    if isinstance(tree, Call) and tree.function in WHOLE_FUNCTIONS:
        given = [whole_of(one, names) for one in tree.arguments]
        if tree.function == "abs":
            return operation("max", given[0], given[0] * -1)
        return reduce(partial(operation, tree.function), given)
    raise Unsuited
