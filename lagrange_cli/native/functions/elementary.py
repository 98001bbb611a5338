"""The elementary functions as LLVM IR of our own, for one double or for eight at a time.

LLVM computes the sine of a vector by one call of the C library per lane. These functions compute all lanes
together, sine and cosine share their reduction, and the low part of a compensated argument is taken in.
``FUNCTIONS`` are called by their name and number of lanes: ``@pow.8(x, y)``, ``@exp.1(x, low)``. Sine and
cosine, ``@sin_cos.8(x, low)``, are returned together. ``low`` is at most some units in the last place of x.
``definitions(text)`` returns the functions that a program's text calls, to be appended to it.

Every number of lanes gives the same bits, and within a formula's range so should every processor: each
operation is rounded as IEEE 754 says. Where a lane is not in that range (an angle beyond 10^6, an infinity,
not-a-number) all are computed one by one, by the version for one double, which asks the C library for such
arguments. The functions that have no formula here (tan, atan2, ..) are the C library's, one lane after the
other. The sign of a sine that is zero is lost: sin(-0) is 0.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from lagrange_cli.native.functions import formulas
from lagrange_cli.native.llvm.declarations import LIBRARY
from lagrange_cli.native.llvm.function import Function
from lagrange_cli.native.llvm.vector import Real
from lagrange_cli.records import dataclass


@dataclass(frozen=True)
class Elementary:
    """A function: its formula, if any, and what computes it for one double where that does not hold."""

    arguments: int
    results: int
    formula: Callable[..., formulas.Results] | None
    beyond: Callable[..., list[Real]]


FUNCTIONS = {
    "sin_cos": Elementary(2, 2, formulas.sine_and_cosine, formulas.library_sine_and_cosine),
    "exp": Elementary(2, 1, formulas.exponential, formulas.library_exponential),
    "log": Elementary(1, 1, formulas.logarithm, formulas.library("log")),
    "pow": Elementary(2, 1, formulas.power, formulas.library("pow")),
    **{name: Elementary(count, 1, None, formulas.library(name)) for name, count in LIBRARY.items()},
}


def definitions(text: str) -> str:
    """The functions that ``text`` calls and lacks."""
    head = rf"@({'|'.join(FUNCTIONS)})\.(\d+)\("
    called = set(re.findall(head, text))
    called |= {(name, "1") for name, _ in called}
    called -= set(re.findall(rf"^define .*{head}", text, re.MULTILINE))
    return "".join(definition(name, int(lanes)) for name, lanes in sorted(called))


def definition(name: str, lanes: int) -> str:
    """The text of one function."""
    function = FUNCTIONS[name]
    result = "{ REAL, REAL }" if function.results == 2 else "REAL"
    given = ", ".join(f"REAL %a{i}" for i in range(function.arguments))
    f = Function(f"define internal {result} @{name}.{lanes}({given}) noinline #0", lanes)
    arguments = [Real(f, f"%a{i}") for i in range(function.arguments)]
    if function.formula is not None:
        condition, made = function.formula(f, *arguments)
        with f.when(f.all(condition)):
            f.give(*made)
    if lanes == 1:
        f.give(*function.beyond(f, *arguments))
    else:
        kinds = [Real] * function.results
        f.give(*f.lane_by_lane(arguments, len(kinds), lambda one: f.parts(kinds, f"{name}.1", *one, lanes=1)))
    return f.text()
