"""The parsed form of an expression: a small frozen tree, each node with its place in the text."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias

from lagrange_cli.records import dataclass


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
    """A name, possibly dotted: ``theta``, ``theta_dot``, ``bead`` (a vector), ``bead.x``, ``bead.vx``."""

    identifier: str
    span: Span


@dataclass(frozen=True)
class Negative:
    """``-operand``."""

    operand: Tree
    span: Span


@dataclass(frozen=True)
class Binary:
    """``left operator right`` with operator one of ``+ - * / **``."""

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
    """``(x, y, z)``: one, two or three components."""

    items: tuple[Tree, ...]
    span: Span


Tree: TypeAlias = Number | Name | Negative | Binary | Call | Vector


def names(tree: Tree) -> Iterator[Name]:
    """Every name in ``tree``, from left to right."""
    pending = [tree]
    while pending:
        node = pending.pop()
        if isinstance(node, Name):
            yield node
        elif isinstance(node, Negative):
            pending.append(node.operand)
        elif isinstance(node, Binary):
            pending += (node.right, node.left)
        elif isinstance(node, Call):
            pending += reversed(node.arguments)
        elif isinstance(node, Vector):
            pending += reversed(node.items)
