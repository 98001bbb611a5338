"""Comparison of the printed equations with the compiled ones, and with the system file differentiated
directly (``direct``), at random states near the start, along the motion and on both sides of switches and
poles (``states``).

The printed text itself is parsed as an expression of the system file and evaluated with 30 digits. A
difference is divided by the *scale* of the printed expression, which bounds the effect of rounding errors in
its sums, products and functions (a running error bound; Higham, Accuracy and Stability of Numerical
Algorithms, section 3.3). For accelerations it is at least the effect of rounding errors in M and f (Skeel's
bound, section 7.2). Rounding errors due to cancellation, or to an almost singular M, therefore do not count
as a difference.

With constraints the states satisfy them, and the multipliers are compared like the accelerations.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import chain
from typing import Any

import mpmath

from lagrange_cli.decimals import scientific
from lagrange_cli.errors import SpecError, UsageError
from lagrange_cli.expression.syntax import ExpressionError
from lagrange_cli.mechanics.switching.saturation import LARGE
from lagrange_cli.records import dataclass, field
from lagrange_cli.symbolic.direct import Direct
from lagrange_cli.symbolic.equations import Equations
from lagrange_cli.symbolic.measured import Measured
from lagrange_cli.symbolic.printed import Printed, evaluate, read_back
from lagrange_cli.symbolic.states import Admissible, State, near

BOUND = 1e-12
"""The largest relative difference of equations that agree."""
DIGITS = 30
STATES = 12
ATTEMPTS = 50
"""Attempts to draw each state: at some states the equations may have no finite value."""

Compiled = Callable[
    [Sequence[float], float, Sequence[float], Sequence[float]], tuple[Any, Any, float, Any, Any]
]
"""(parameters, t, q, v) -> (accelerations, momenta, h, multipliers, constraints), by the compiled program."""
Directly = Callable[[State, Sequence[Any], Sequence[Any], bool], Direct]
"""(state, accelerations, multipliers, with many digits) -> ``direct.directly`` of the system file."""
COMPILED, DIRECT = "printed and compiled", "printed and directly differentiated"
WRITTEN = "the equations of motion and their solution, both as printed"
"""Pairs of routes."""


@dataclass(frozen=True)
class Verification:
    """The difference of several routes to the equations: ``difference`` is the largest relative difference
    over ``states`` states, found in ``quantity`` between two ``routes``. ``counted`` says where the states
    were, ``directly`` whether L was differentiated directly, too, ``compiled`` whether there were compiled
    equations."""

    difference: float
    quantity: str
    states: int
    routes: str = COMPILED
    counted: Mapping[str, int] = field(default_factory=dict)
    directly: bool = False
    compiled: bool = True

    @property
    def agrees(self) -> bool:
        """Whether the difference is within ``BOUND``."""
        return self.difference <= BOUND

    def __str__(self) -> str:
        verdict = "agree" if self.agrees else "DIFFER"
        compared = "printed, compiled and directly differentiated" if self.directly else COMPILED
        compared = compared if self.compiled else DIRECT
        of = f"of {self.quantity}, {self.routes}" if self.directly else f"in {self.quantity}"
        where = ", ".join(f"{count} {where}" for where, count in self.counted.items())
        return (
            f"{compared} equations {verdict}: largest relative difference {scientific(self.difference)} "
            f"({of}) over {self.states} states: {where}"
        )


def verify(
    equations: Equations,
    compiled: Compiled,
    start: State,
    others: Sequence[State] = (),
    direct: Directly | None = None,
    admissible: Admissible = lambda state: state,
) -> Verification:
    """Compare printed and compiled equations, and those that ``direct`` has of the system file, at random
    states near ``start``, moved to ``admissible`` ones, and at ``others`` (those of them at which the
    equations have finite values).

    Raises ``UsageError`` where no state near the start is found at which they have.
    """
    printed = read_back(equations)
    source = random.Random(0)
    largest, where, routes = 0.0, "h", COMPILED
    counted: dict[str, int] = {}
    drawn = (
        somewhere(source, start, partial(compare, equations, printed, compiled, direct), admissible)
        for _ in range(STATES)
    )
    given = ((one, compare(equations, printed, compiled, direct, one)) for one in others)
    for state, differences in chain(drawn, given):
        if differences is None:
            continue
        counted[state.where] = counted.get(state.where, 0) + 1
        for pair, quantity, difference in differences:
            if difference > largest:
                largest, where, routes = difference, quantity, pair
    return Verification(largest, where, sum(counted.values()), routes, counted, direct is not None)


def somewhere(
    source: random.Random,
    start: State,
    compared: Callable[[State], list[tuple[str, str, float]] | None],
    admissible: Admissible,
) -> tuple[State, list[tuple[str, str, float]]]:
    """A random state near ``start``, the first one at which all values are finite, and the differences.

    Parameters are varied in the first half of the attempts: constraints may agree with certain values only.
    """
    for attempt in range(ATTEMPTS):
        state = admissible(near(start, source, varied=2 * attempt < ATTEMPTS))
        differences = None if state is None else compared(state)
        if state is not None and differences is not None:
            return state, differences
    raise UsageError("the equations have no finite values at random states near the initial one")


def compare(
    equations: Equations, printed: Printed, compiled: Compiled, direct: Directly | None, state: State
) -> list[tuple[str, str, float]] | None:
    """The relative differences at a state, with the routes and the quantity that they are of; None if the
    printed equations have no finite values there."""
    values = dict(state.parameters) | {str(equations.time): state.t}
    values |= {str(symbol): value for symbol, value in zip(equations.q, state.q, strict=True)}
    values |= {str(symbol): value for symbol, value in zip(equations.v, state.v, strict=True)}
    try:
        with mpmath.workdps(DIGITS):
            known = {name: Measured(mpmath.mpf(x), abs(mpmath.mpf(x))) for name, x in values.items()}
            exact = evaluate(equations, printed, known)
    except (ArithmeticError, ValueError, ExpressionError):
        return None
    if not all(mpmath.isfinite(each.value) and mpmath.im(each.value) == 0 for _, each in exact.all):
        return None
    a, p, h, multipliers, constraints = compiled(list(state.parameters.values()), state.t, state.q, state.v)
    numbers = [float(x) for x in (*a, *multipliers, *p, h, *constraints)]
    pairs = zip(exact.all, numbers, strict=True)
    found = [(COMPILED, name, relative_difference(each, number)) for (name, each), number in pairs]
    if max((difference for _, _, difference in found), default=0.0) > BOUND:
        with mpmath.workdps(DIGITS):
            held = evaluate(equations, printed, known, LARGE)
        found = [
            (COMPILED, name, min(difference, faded_difference(each, bounded, number)))
            for (_, name, difference), (_, each), (_, bounded), number in zip(
                found, exact.all, held.all, numbers, strict=True
            )
        ]
    found += [(WRITTEN, name, relative_difference(each, 0)) for name, each in exact.equations]
    if direct is None:
        return found
    unknowns = [mpmath.re(each.value) for _, each in (*exact.accelerations, *exact.multipliers)]
    n = len(state.q)
    for digits in (False, True):  # doubles lose some where terms cancel that the printed equations have not
        try:
            with mpmath.workdps(DIGITS):
                own = direct(state, unknowns[:n], unknowns[n:], digits)
                values_there = (*own.momenta, own.h, *own.constraints, *own.residual, *own.rates)
                both = zip((*exact.functions, *exact.zeros), values_there, strict=True)
                rest = [(DIRECT, name, relative_difference(each, number)) for (name, each), number in both]
        except (ArithmeticError, ValueError, SpecError):
            return None
        if max(difference for _, _, difference in rest) <= BOUND / 10:
            break
    return found + rest


def faded_difference(exact: Measured, bounded: Measured, number: float) -> float:
    """The difference of a compiled number from what is ``bounded``: exponentials are held where nothing grows
    with them (``saturation``), so that what fades with them ends there. Infinite where it grows."""
    fades = abs(exact.value) <= abs(bounded.value) * (1 + BOUND)
    return relative_difference(bounded, number) if fades else float("inf")


def relative_difference(exact: Measured, number: Any) -> float:
    """The difference of a compiled number from the exact one, relative to its scale; infinite for nan."""
    difference = abs(number - exact.value) / (exact.scale or 1)
    return float(difference) if mpmath.isfinite(difference) else float("inf")
