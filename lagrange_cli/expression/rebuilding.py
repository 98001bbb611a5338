"""Trees like others, but for some of their parts."""

from __future__ import annotations

from collections.abc import Callable

from lagrange_cli.expression.syntax import (
    Binary,
    Call,
    Comparison,
    Logic,
    Lookup,
    Name,
    Negative,
    Sum,
    Tree,
    Vector,
    children,
    parts,
)
from lagrange_cli.records import replace


def with_children(tree: Tree, given: tuple[Tree, ...]) -> Tree:
    """The same made of other ``children``."""
    if isinstance(tree, Name | Lookup):
        return replace(tree, indices=given)
    if isinstance(tree, Negative):
        return replace(tree, operand=given[0])
    if isinstance(tree, Binary):
        return replace(tree, left=given[0], right=given[1])
    if isinstance(tree, Call):
        return replace(tree, arguments=given)
    if isinstance(tree, Vector):
        return replace(tree, items=given)
    if isinstance(tree, Comparison | Logic):
        return replace(tree, operands=given)
    if isinstance(tree, Sum):
        count = 1 + len(tree.bounds)
        return replace(tree, body=given[0], bounds=given[1:count], conditions=given[count:])
    return tree


def rebuilt(tree: Tree, change: Callable[[Tree, tuple[Tree, ...]], Tree]) -> Tree:
    """What ``change`` makes of ``tree``: of each part, and of what it has made of the part's children."""
    made: dict[int, Tree] = {}
    for node in reversed([*parts(tree)]):
        made[id(node)] = change(node, tuple(made[id(one)] for one in children(node)))
    return made[id(tree)]


def size_of(tree: Tree) -> int:
    """How many parts it has."""
    return sum(1 for _ in parts(tree))
