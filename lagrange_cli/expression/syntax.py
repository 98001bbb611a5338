"""The parsed form of an expression: a small frozen tree, each node with its place in the text."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True)
class Span:
    """A stretch ``text[start:stop]`` of the expression's text."""

    start: int
    stop: int


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
