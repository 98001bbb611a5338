"""Conditions on indices, and the loops of sums, as they are printed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

from lagrange_cli.expression.syntax import Comparison, Logic, Tree
from lagrange_cli.records import dataclass
from lagrange_cli.symbolic.indexed.whole import Entry, Operation, Span, Spans, Values, Whole, number, whole_of

if TYPE_CHECKING:
    from lagrange_cli.expression.number_table import NumberTable


@dataclass(frozen=True)
class Relation:
    """``a < b <= c``."""

    operators: tuple[str, ...]
    operands: tuple[Whole, ...]


@dataclass(frozen=True)
class Joined:
    """Conditions with ``and`` or ``or`` between them, or ``not`` before one."""

    operator: str
    parts: tuple[Condition, ...]


Condition: TypeAlias = "Relation | Joined"


def relation(left: Whole, operator: str, right: Whole) -> Relation:
    """``left operator right``."""
    return Relation((operator,), (left, right))


def condition_of(tree: Tree, names: Mapping[str, Whole]) -> Condition:
    """The condition that a tree stands for."""
    if isinstance(tree, Logic):
        return Joined(tree.operator, tuple(condition_of(one, names) for one in tree.operands))
    if isinstance(tree, Comparison):
        return Relation(tree.operators, tuple(whole_of(one, names) for one in tree.operands))
    return relation(whole_of(tree, names), "!=", number(0))


OPPOSITE = {"==": "!=", "!=": "==", "<": ">=", ">=": "<", ">": "<=", "<=": ">"}
SWAPPED = {"==": "==", "!=": "!=", "<": ">", ">": "<", "<=": ">=", ">=": "<="}


def negation(condition: Condition) -> Condition:
    """Its opposite."""
    if isinstance(condition, Relation) and len(condition.operators) == 1:
        return relation(condition.operands[0], OPPOSITE[condition.operators[0]], condition.operands[1])
    if isinstance(condition, Joined) and condition.operator == "not":
        return condition.parts[0]
    return Joined("not", (condition,))


def holds(condition: Condition, values: Values) -> Any:
    """Whether it holds, or for which members."""
    from lagrange_cli.expression.index_arrays import compared, joined

    if isinstance(condition, Joined):
        return joined(condition.operator, [holds(one, values) for one in condition.parts])
    return compared(condition.operators, [one.value(values) for one in condition.operands])


def changed(condition: Condition, change: Callable[[Whole], Whole]) -> Condition:
    """The same of other numbers."""
    if isinstance(condition, Joined):
        return Joined(condition.operator, tuple(changed(one, change) for one in condition.parts))
    return Relation(condition.operators, tuple(map(change, condition.operands)))


def names_of(condition: Condition) -> frozenset[str]:
    """All names in it."""
    parts = condition.parts if isinstance(condition, Joined) else ()
    operands = () if isinstance(condition, Joined) else condition.operands
    return frozenset[str]().union(*map(names_of, parts), *(one.names for one in operands))


def tables_in(one: Condition | Whole) -> list[NumberTable]:
    """All tables in a condition, or in a number."""
    if isinstance(one, Joined):
        return [table for part in one.parts for table in tables_in(part)]
    if isinstance(one, Relation):
        return [table for operand in one.operands for table in tables_in(operand)]
    found: list[NumberTable] = []
    for atom, _ in one.terms:
        if isinstance(atom, Operation):
            found += [*tables_in(atom.left), *tables_in(atom.right)]
        elif isinstance(atom, Entry):
            found += [atom.table, *(table for index in atom.indices for table in tables_in(index))]
    return found


def single(condition: Condition) -> list[Condition]:
    """The conditions that hold together where it does."""
    if isinstance(condition, Joined) and condition.operator == "and":
        return [one for part in condition.parts for one in single(part)]
    if isinstance(condition, Relation):
        pairs = zip(condition.operators, condition.operands, condition.operands[1:])
        return [relation(left, operator, right) for operator, left, right in pairs]
    return [condition]


def decided(condition: Condition, spans: Spans) -> bool | None:
    """Whether it always holds, or never; None where that depends."""
    if isinstance(condition, Joined) or len(condition.operators) > 1:
        return None
    low, high = (condition.operands[0] - condition.operands[1]).span(spans)
    operator = condition.operators[0]
    if operator in ("==", "!="):
        equal = True if low == high == 0 else False if low > 0 or high < 0 else None
        return equal if operator == "==" or equal is None else not equal
    true = {"<": high < 0, "<=": high <= 0, ">": low > 0, ">=": low >= 0}[operator]
    false = {"<": low >= 0, "<=": low > 0, ">": high <= 0, ">=": high < 0}[operator]
    return True if true else False if false else None


def written(condition: Condition, level: int = 0) -> str:
    """In the grammar of system files."""
    if isinstance(condition, Relation):
        text = condition.operands[0].text
        for operator, operand in zip(condition.operators, condition.operands[1:]):
            text += f" {operator} {operand.text}"
        return text
    if condition.operator == "not":
        return f"not ({written(condition.parts[0])})"
    text = f" {condition.operator} ".join(written(one, 1) for one in condition.parts)
    return f"({text})" if level else text


@dataclass(frozen=True)
class Loop:
    """``for index in range(start, stop, step) if conditions``, with a positive step."""

    index: str
    start: Whole
    stop: Whole
    step: int = 1
    conditions: tuple[Condition, ...] = ()

    def changed(self, change: Callable[[Whole], Whole]) -> Loop:
        """The same with other numbers."""
        conditions = tuple(changed(one, change) for one in self.conditions)
        return Loop(self.index, change(self.start), change(self.stop), self.step, conditions)

    @property
    def names(self) -> frozenset[str]:
        """All names in it but its own index."""
        inside = self.start.names | self.stop.names
        return inside.union(*map(names_of, self.conditions)) - {self.index}

    @property
    def tables(self) -> list[NumberTable]:
        """All tables in it."""
        return [table for one in (self.start, self.stop, *self.conditions) for table in tables_in(one)]

    def span(self, spans: Spans) -> Span:
        """Bounds of its index."""
        starts, stops = self.start.span(spans), self.stop.span(spans)
        return starts[0], max(starts[0], stops[1] - 1)

    @property
    def bounds(self) -> str:
        """The arguments of ``range``."""
        listed = [self.start.text, self.stop.text, str(self.step)]
        if self.step == 1:
            listed = listed[1:2] if self.start == number(0) else listed[:2]
        return ", ".join(listed)

    @property
    def text(self) -> str:
        """As it is written in system files."""
        conditions = [written(one, 1) for one in self.conditions]
        return f"for {self.index} in range({self.bounds})" + "".join(f" if {one}" for one in conditions)
