"""The limit on the work of ``equations``: it counts sympy's objects and bounds the size of expressions.

sympy has no bounds of its own, and an expression of a few lines may multiply into millions of terms. While
``counting`` lasts, every object that sympy makes is counted (all go through ``Basic.__new__``), and every
visit of a node in the walks that it repeats (``VISITS``). sympy walks shared parts as often as they occur:
``check_size`` bounds the size of expressions with shared parts written out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any, TypeVar

import sympy
from sympy.core import evalf
from sympy.core.basic import Basic
from sympy.core.traversal import preorder_traversal
from sympy.printing.printer import Printer

from lagrange_cli.errors import TooLarge, TooLong
from lagrange_cli.limits import Work, way_out, whole

T = TypeVar("T")

STEPS_AN_OBJECT, STEPS_AN_ARGUMENT = 40, 10
"""The work of making an expression in sympy, and of sorting an argument into it."""
VISITS = (
    (Basic, "free_symbols", 1),
    (Basic, "compare", 2),
    (Basic, "_xreplace", 1),
    (preorder_traversal, "_preorder_traversal", 1),
    (sympy.Expr, "_expand_hint", 2),
    (Printer, "_print", 3),
    (import_module("sympy.core.assumptions"), "_ask", 3),
    (evalf, "evalf", 5),
)
"""Where sympy visits one node in the course of a walk, and the steps that this takes."""
STEPS_A_LOOK = 20
"""The work for an expression of any size."""
ADVICE = "'check' and 'solve' may work nevertheless, "


class Counter:
    """The counters: ``work`` while counting lasts, and repeated results."""

    def __init__(self) -> None:
        self.work: Work | None = None
        self.settled: dict[sympy.Expr, sympy.Expr] = {}
        self.factored: dict[sympy.Expr, sympy.Expr] = {}
        self.turned: dict[sympy.Expr, sympy.Expr | None] = {}


COUNTER = Counter()


@contextmanager
def counting(work: Work | None = None) -> Iterator[None]:
    """A context in which the work of sympy is counted, in ``work`` if it has begun before.

    ``TooLarge`` is raised where it is too much.
    """
    work = COUNTER.work = Work() if work is None else work
    plain = {(owner, name): vars(owner)[name] for owner, name, _ in VISITS}
    new = Basic.__new__

    def counted(cls: type[Basic], *arguments: Any) -> Any:
        work.charge(STEPS_AN_OBJECT + STEPS_AN_ARGUMENT * len(arguments))
        return new(cls, *arguments)

    Basic.__new__ = staticmethod(counted)
    for owner, name, steps in VISITS:
        setattr(owner, name, counting_calls(plain[owner, name], steps, work))
    try:
        yield
    except TooLarge as error:
        raise type(error)(error.message, ADVICE + error.hint) from error
    finally:
        Basic.__new__ = staticmethod(new)
        for (owner, name), attribute in plain.items():
            setattr(owner, name, attribute)
        COUNTER.work = None
        COUNTER.settled.clear()
        COUNTER.factored.clear()
        COUNTER.turned.clear()


def counting_calls(attribute: Any, steps: int, work: Work) -> Any:
    """A function, method or property that counts so many steps at each call."""
    if isinstance(attribute, property):
        return property(counting_calls(attribute.fget, steps, work))
    if isinstance(attribute, staticmethod):
        return staticmethod(counting_calls(attribute.__func__, steps, work))

    def counted(*arguments: Any, **named: Any) -> Any:
        work.charge(steps)
        return attribute(*arguments, **named)

    return counted


def charge(steps: int) -> None:
    """Count steps of our own; raises ``TooLarge``."""
    if COUNTER.work is not None:
        COUNTER.work.charge(steps)


def attempt(steps: int, function: Callable[[], T]) -> T | None:
    """The result of ``function``, None if it would take more than so many steps."""
    return function() if COUNTER.work is None else COUNTER.work.attempt(steps, function)


def later(function: Callable[[], T]) -> Callable[[], T]:
    """``function``, to be called later: its work is then counted where that of now is, unless other work is
    being counted."""
    work = COUNTER.work

    def counted() -> T:
        if work is None or COUNTER.work is not None:
            return function()
        with counting(work):
            return function()

    return counted


def check_size(expression: sympy.Expr) -> sympy.Expr:
    """The expression itself; raises ``TooLong`` where it is too long to be read or to be walked by sympy."""
    size = size_of(expression)
    charge(STEPS_A_LOOK + size)
    if size > whole("printed"):
        raise TooLong(
            f"an expression of the equations has {size} terms and factors, more than {whole('printed')}",
            way_out("printed"),
        )
    return expression


def size_of(expression: sympy.Expr) -> int:
    """Leaves and operations of an expression, shared parts as often as they occur."""
    return folded(expression, lambda _, sizes: 1 + sum(sizes))


def folded(expression: sympy.Expr, combine: Callable[[sympy.Expr, list[T]], T]) -> T:
    """The result of ``combine`` for an expression, from its results for the arguments, each part once."""
    made: dict[int, T] = {}
    pending = [expression]
    while pending:
        node = pending[-1]
        missing = [argument for argument in node.args if id(argument) not in made]
        if missing:
            pending += missing
        else:
            pending.pop()
            made[id(node)] = combine(node, [made[id(argument)] for argument in node.args])
    charge(len(made))
    return made[id(expression)]
