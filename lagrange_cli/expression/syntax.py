"""The parsed form of an expression: a small frozen tree, each node with its place in the text."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

from lagrange_cli.records import dataclass

if TYPE_CHECKING:
    from lagrange_cli.expression.number_table import NumberTable


@dataclass(frozen=True)
class Span:
    """A stretch ``text[start:stop]`` of the expression's text."""

    start: int
    stop: int


class ExpressionError(Exception):
    """A mistake in an expression: ``span`` of its text, what is wrong, and a way out."""

    def __init__(self, span: Span, message: str, hint: str = "") -> None:
        super().__init__(f"{message}: {hint}" if hint else message)
        self.span = span
        self.message = message
        self.hint = hint


@dataclass(frozen=True)
class Number:
    """A literal, kept as written so that each algebra may read it exactly."""

    text: str
    span: Span


@dataclass(frozen=True)
class Name:
    """A name, possibly dotted: ``theta``, ``theta_dot``, ``bead`` (a vector), ``bead.x``, ``bead.vx``.

    ``indices`` choose a member of a family: ``bob[i + 1].x`` is the name ``bob.x`` with the index ``i + 1``.
    """

    identifier: str
    span: Span
    indices: tuple[Tree, ...] = ()

    @property
    def base(self) -> str:
        """The name without its component."""
        return self.identifier.partition(".")[0]


@dataclass(frozen=True)
class Lookup:
    """A member of a table of whole numbers, where it is an index: ``a[n]`` in ``x[a[n]]``."""

    table: NumberTable
    span: Span
    indices: tuple[Tree, ...]


@dataclass(frozen=True)
class Negative:
    """``-operand``."""

    operand: Tree
    span: Span


@dataclass(frozen=True)
class Binary:
    """``left operator right`` with operator one of ``+ - * / **``, and ``// %`` of whole numbers."""

    operator: str
    left: Tree
    right: Tree
    span: Span


@dataclass(frozen=True)
class Call:
    """``function(arguments)``."""

    function: str
    arguments: tuple[Tree, ...]
    span: Span


@dataclass(frozen=True)
class Vector:
    """``(x, y, z)``: one, two or three components. A point of a body has coordinates there, ``places``."""

    items: tuple[Tree, ...]
    span: Span
    places: tuple[Tree, ...] = ()


@dataclass(frozen=True)
class Comparison:
    """``a < b <= c``: one operator fewer than operands, all of them whole numbers."""

    operators: tuple[str, ...]
    operands: tuple[Tree, ...]
    span: Span


@dataclass(frozen=True)
class Logic:
    """``and`` or ``or`` between conditions, or ``not`` before one."""

    operator: str
    operands: tuple[Tree, ...]
    span: Span


@dataclass(frozen=True)
class Sum:
    """``sum(body for index in range(...) if condition)``.

    ``bounds`` are the one to three arguments of ``range``. A sum with several loops is a sum of sums, the
    first loop outermost.
    """

    body: Tree
    index: str
    bounds: tuple[Tree, ...]
    conditions: tuple[Tree, ...]
    span: Span
    index_span: Span


@dataclass(frozen=True)
class Loop:
    """``for index in range(bounds) if conditions``, behind what it repeats; ``span`` is that of the index."""

    index: str
    bounds: tuple[Tree, ...]
    conditions: tuple[Tree, ...]
    span: Span


ONE_SIDED = "sqrt", "log", "asin", "acos"
"""Functions with values on one side of an edge only."""
Tree: TypeAlias = Number | Name | Lookup | Negative | Binary | Call | Vector | Comparison | Logic | Sum
"""``Comparison`` and ``Logic`` stand in the conditions of a ``Sum`` only, ``Lookup`` among whole numbers."""


@dataclass(frozen=True)
class Axis:
    """One index of a key: all of ``index in range(bounds) if conditions``, or with an empty ``index`` the one
    that ``bounds[0]`` is."""

    index: str
    bounds: tuple[Tree, ...]
    span: Span
    conditions: tuple[Tree, ...] = ()

    @property
    def trees(self) -> tuple[Tree, ...]:
        """All that its values are written with."""
        return *self.bounds, *self.conditions


@dataclass(frozen=True)
class Key:
    """What a section declares: a name, or with ``axes`` members of a family, ``u[i in range(N), 0]``."""

    name: str
    text: str
    axes: tuple[Axis, ...] = ()

    @cached_property
    def label(self) -> str:
        """The key as messages call it: ``u[i,0]``."""
        if not self.axes:
            return self.name
        shown = (axis.index or self.text[axis.span.start : axis.span.stop] for axis in self.axes)
        return f"{self.name}[{','.join(shown)}]"

    @cached_property
    def is_grid(self) -> bool:
        """Whether each index has the same values, whatever the others are."""
        indices = {axis.index for axis in self.axes}
        return not any(
            axis.conditions or any(plain_names(tree) & indices for tree in axis.bounds) for axis in self.axes
        )


def children(tree: Tree) -> tuple[Tree, ...]:
    """What ``tree`` is made of, from left to right."""
    if isinstance(tree, Name | Lookup):
        return tree.indices
    if isinstance(tree, Negative):
        return (tree.operand,)
    if isinstance(tree, Binary):
        return (tree.left, tree.right)
    if isinstance(tree, Call):
        return tree.arguments
    if isinstance(tree, Vector):
        return tree.items
    if isinstance(tree, Comparison | Logic):
        return tree.operands
    if isinstance(tree, Sum):
        return (tree.body, *tree.bounds, *tree.conditions)
    return ()


def components(tree: Tree, of_name: Callable[[Name], int]) -> int:
    """How many components an expression has as far as its form shows: ``of_name`` gives those of a name, 0
    where it says nothing."""
    if isinstance(tree, Name):
        return of_name(tree)
    if isinstance(tree, Vector):
        return len(tree.items)
    inside = children(tree)
    if isinstance(tree, Call) and tree.function != "cross":
        inside = inside[1:] if tree.function == "where" else ()
    return max((components(one, of_name) for one in inside), default=1)


def names(tree: Tree) -> Iterator[Name]:
    """Every name in ``tree`` that stands for a quantity, from left to right.

    Names within indices, ranges and conditions, and the indices of the sums around a name, are whole
    numbers and left out.
    """
    pending: list[tuple[Tree, frozenset[str]]] = [(tree, frozenset())]
    while pending:
        node, bound = pending.pop()
        if isinstance(node, Name):
            if node.indices or node.identifier not in bound:
                yield node
        elif isinstance(node, Lookup):
            continue
        elif isinstance(node, Sum):
            pending.append((node.body, bound | {node.index}))
        elif not (isinstance(node, Binary) and node.operator in WHOLE):
            pending += ((child, bound) for child in reversed(children(node)))


def sums(tree: Tree) -> Iterator[tuple[Sum, frozenset[str]]]:
    """Every sum in ``tree`` with the indices of the sums around it, outer ones first."""
    pending: list[tuple[Tree, frozenset[str]]] = [(tree, frozenset())]
    while pending:
        node, bound = pending.pop()
        if isinstance(node, Sum):
            yield node, bound
            bound |= {node.index}
        pending += ((child, bound) for child in reversed(children(node)))


def parts(tree: Tree) -> Iterator[Tree]:
    """``tree`` and all that it is made of, wherever it stands: whole ones before their parts."""
    pending = [tree]
    while pending:
        yield (node := pending.pop())
        pending += children(node)


def equalities(tree: Tree) -> Iterator[Comparison]:
    """Every comparison by ``==`` or ``!=`` in the conditions of ``where``."""
    pending = [tree]
    while pending:
        node = pending.pop()
        if isinstance(node, Comparison) and not {"==", "!="}.isdisjoint(node.operators):
            yield node
        pending += (node.body,) if isinstance(node, Sum) else () if isinstance(node, Name) else children(node)


def calls(tree: Tree, functions: Collection[str]) -> bool:
    """Whether one of the functions is called in ``tree``."""
    return any(isinstance(one, Call) and one.function in functions for one in parts(tree))


def ends_somewhere(tree: Tree) -> bool:
    """Whether it is a function with values on one side of an edge only: a power whose exponent is no whole
    number, whatever parameters are, or one of ``ONE_SIDED``."""
    if isinstance(tree, Call):
        return tree.function in ONE_SIDED
    if not isinstance(tree, Binary) or tree.operator != "**":
        return False
    exponent = constant(tree.right)
    return exponent is not None and exponent % 1.0 != 0.0


def constant(tree: Tree) -> float | None:
    """The number that a tree made of literals stands for."""
    if isinstance(tree, Number):
        return float(tree.text)
    if isinstance(tree, Negative):
        inner = constant(tree.operand)
        return None if inner is None else -inner
    if not isinstance(tree, Binary):
        return None
    left, right = constant(tree.left), constant(tree.right)
    if left is None or right is None or (tree.operator == "/" and right == 0.0):
        return None
    known = {"+": left + right, "-": left - right, "*": left * right}
    return left / right if tree.operator == "/" else known.get(tree.operator)


def has_decimals(tree: Tree) -> bool:
    """Whether a number in ``tree`` is not whole."""
    return any(isinstance(one, Number) and not one.text.isdecimal() for one in parts(tree))


def plain_names(tree: Tree) -> frozenset[str]:
    """All undotted names in ``tree``, wherever they stand."""
    return frozenset(one.identifier for one in parts(tree) if isinstance(one, Name) and not one.indices)


def is_whole(tree: Tree, known: Callable[[Name], bool]) -> bool:
    """Whether ``tree`` is made of whole numbers and of names that are ``known`` to be some."""
    if isinstance(tree, Number):
        return tree.text.isdecimal()
    if isinstance(tree, Name):
        return known(tree)
    if isinstance(tree, Negative):
        return is_whole(tree.operand, known)
    if isinstance(tree, Binary):
        return tree.operator in KEEP_WHOLE and is_whole(tree.left, known) and is_whole(tree.right, known)
    if isinstance(tree, Call):
        return tree.function in WHOLE_FUNCTIONS and all(is_whole(one, known) for one in tree.arguments)
    return False


WHOLE = frozenset({"//", "%"})
"""Operators of whole numbers."""
KEEP_WHOLE = WHOLE | {"+", "-", "*"}
"""Operators that make whole numbers of whole numbers."""
WHOLE_FUNCTIONS = frozenset({"abs", "min", "max"})
"""Functions that do."""
