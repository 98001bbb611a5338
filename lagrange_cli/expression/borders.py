"""Where expressions end: quotients, roots, logarithms and the like, whose arguments may not pass a value."""

from __future__ import annotations

from collections.abc import Iterator

from lagrange_cli.expression.indices import Indices, holds
from lagrange_cli.expression.loops import narrowed
from lagrange_cli.expression.syntax import Binary, Call, Comparison, Name, Sum, Tree, children
from lagrange_cli.records import dataclass

ENDS = {"sqrt": (0.0,), "log": (0.0,), "asin": (1.0, -1.0), "acos": (1.0, -1.0), "tan": ()}
"""The ends of the domains of functions."""


@dataclass(frozen=True)
class Border:
    """An ``argument`` that may not pass one of its ``ends``, in ``whole``; of tan there are many ends."""

    whole: Tree
    argument: Tree
    ends: tuple[float, ...] = (0.0,)


def outside_branches(tree: Tree) -> Iterator[Tree]:
    """``tree`` and its parts, but for those that a ``where`` may leave out."""
    pending = [tree]
    while pending:
        yield (one := pending.pop())
        pending += counting(one)


def counting(tree: Tree) -> tuple[Tree, ...]:
    """What ``tree`` is made of, but for branches that a ``where`` may leave out."""
    chosen = isinstance(tree, Call) and tree.function == "where"
    return children(tree)[:1] if chosen else children(tree)


def borders(tree: Tree, indices: Indices, *, branches: bool = True) -> Iterator[tuple[Border, Indices]]:
    """All arguments in an expression that may reach an end, from the outside in; with ``branches`` also those
    that a ``where`` may leave out."""
    pending: list[tuple[Tree, Indices]] = [(tree, indices)]
    while pending:
        one, known = pending.pop()
        if isinstance(one, Sum):
            for index in narrowed(one, known):
                inner = {**known, one.index: index}
                if all(holds(condition, inner) for condition in one.conditions):
                    yield from borders(one.body, inner, branches=branches)
            continue
        if isinstance(one, Name | Comparison):
            continue
        if isinstance(one, Binary) and one.operator in ("/", "**"):
            yield Border(one, one.right if one.operator == "/" else one.left), known
        if isinstance(one, Call) and one.function in ENDS:
            yield Border(one, one.arguments[0], ENDS[one.function]), known
        if isinstance(one, Call) and one.function == "norm":
            yield Border(one, one), known
        pending += ((child, known) for child in reversed(children(one) if branches else counting(one)))
