"""How much work ``equations`` may do: what sympy makes is counted, and how large expressions get.

sympy has no bounds of its own, and an expression of a few lines may multiply into millions of terms. Every
object that sympy makes goes through ``Basic.__new__``, which counts it while ``counting`` lasts. What only
walks over expressions is bounded by their size: ``check_size`` counts it with shared parts written out, as
sympy walks.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

import sympy
from sympy.core.basic import Basic

from lagrange_cli.errors import TooLarge
from lagrange_cli.limits import Work, way_out, whole

T = TypeVar("T")

STEPS_AN_OBJECT, STEPS_AN_ARGUMENT = 40, 10
"""What sympy takes to make an expression and to sort an argument into it."""
STEPS_A_LOOK = 20
"""What is done with an expression however small it is."""
ADVICE = "'check' and 'solve' may work nevertheless, "


class Counter:
    """What has been counted: ``work`` while counting lasts, and results that come again."""

    def __init__(self) -> None:
        self.work: Work | None = None
        self.settled: dict[sympy.Expr, sympy.Expr] = {}


COUNTER = Counter()


@contextmanager
def counting(work: Work | None = None) -> Iterator[None]:
    """A context in which the work of sympy is counted, in ``work`` if it has begun before.

    ``TooLarge`` is raised where it is too much.
    """
    work = COUNTER.work = Work() if work is None else work
    plain = Basic.__new__

    def counted(cls: type[Basic], *arguments: Any) -> Any:
        work.charge(STEPS_AN_OBJECT + STEPS_AN_ARGUMENT * len(arguments))
        return plain(cls, *arguments)

    Basic.__new__ = staticmethod(counted)
    try:
        yield
    except TooLarge as error:
        raise TooLarge(error.message, ADVICE + error.hint) from error
    finally:
        Basic.__new__ = staticmethod(plain)
        COUNTER.work = None
        COUNTER.settled.clear()


def charge(steps: int) -> None:
    """Count steps of our own; raises ``TooLarge``."""
    if COUNTER.work is not None:
        COUNTER.work.charge(steps)


def check_size(expression: sympy.Expr) -> sympy.Expr:
    """The expression itself; raises ``TooLarge`` where nobody could read it, nor sympy walk over it."""
    size = size_of(expression)
    charge(STEPS_A_LOOK + size)
    if size > whole("printed"):
        raise TooLarge(
            f"an expression of the equations has {size} terms and factors, more than {whole('printed')}",
            way_out("printed"),
        )
    return expression


def size_of(expression: sympy.Expr) -> int:
    """Leaves and operations of an expression, shared parts as often as they occur."""
    return folded(expression, lambda _, sizes: 1 + sum(sizes))


def folded(expression: sympy.Expr, combine: Callable[[sympy.Expr, list[T]], T]) -> T:
    """What ``combine`` makes of an expression and of what it has made of the arguments, each part once."""
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
