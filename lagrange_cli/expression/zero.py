"""Whether an expression is identically 0. If that is not proven, it counts as not zero.

An expression vanishes if its normal form is 0, or if it vanishes at random arguments and is analytic on a
connected domain (the identity theorem). Whole powers, sin, cos, tan, exp, sinh, cosh and tanh, and what is
composed of them, continue to single-valued functions on a connected part of complex space: their poles divide
only the real line. Everything else has branches: roots and other powers, logarithms, inverse functions and
what switches. What such a function is at some arguments says nothing of others, so each is a variable of its
own here; two are the same one only where their arguments are equal. An expression that vanishes whatever
these variables are vanishes on every branch.

The same holds for the unit of the exponents in exp, sinh, cosh and tanh: identities between them do not
depend on it. So it is chosen such that nothing disappears in rounding that is only small.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from typing import Any, Protocol

from lagrange_cli.errors import BeyondDoubles
from lagrange_cli.expression.evaluate import Reals, evaluate
from lagrange_cli.expression.graph import Graph
from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.signs import Sign, signs

SINGLE_VALUED = frozenset({"sin", "cos", "tan"})
EXPONENTIAL = frozenset({"exp", "sinh", "cosh", "tanh"})
RANGE = 1.3
"""Random arguments are smaller than this."""
FARTHEST = 10.0
"""Exponents are kept smaller than this."""
UNITS = 8
"""Units of the exponents that are tried: one for each that stands in another, at most."""
POINTS = 2
"""Random arguments at which an expression must vanish to many digits, which hardly happens by chance even at
one."""
MOST_WORK = 2_000_000
"""Steps that proving zeros may take at once; what would take more is not proven."""
ROUNDED = 2.0**-44
"""What eliminations leave of rounded numbers, beside these, at most."""
STEPS, STEPS_OF_FUNCTION = 5, 30
"""Steps of an operation with 200 digits; they grow with the number of digits."""
COMMON = 1e3
"""Numbers up to this and down to its reciprocal need no more than 200 digits."""


class Digits(Protocol):
    """Arithmetic of functions without branches (see ``evaluate.Arithmetic``)."""

    rounding: Any

    def number(self, value: float) -> Any: ...
    def power(self, base: Any, exponent: int) -> Any: ...
    def function(self, name: str, arguments: Sequence[Any]) -> Any: ...
    def finite(self, value: Any) -> bool: ...

    def rounded(self, value: Any) -> Any:
        """The common key of values that differ by rounding errors at most."""


class Doubles(Reals):
    """Doubles as such an arithmetic: they show only what is not 0."""

    finite = staticmethod(math.isfinite)

    @staticmethod
    def number(value: float) -> float:  # type: ignore[override]
        """Raises ``BeyondDoubles``."""
        try:
            return float(value)
        except OverflowError as error:
            raise BeyondDoubles from error

    @staticmethod
    def rounded(value: float) -> float:
        return float(f"{value:.10g}")


class Branches:
    """Arithmetic in which everything with a branch is a variable, with a random value of its own."""

    def __init__(self, plain: Digits, source: random.Random, unit: float) -> None:
        self.plain, self.source, self.unit = plain, source, unit
        self.rounding = plain.rounding
        self.farthest = 0.0
        """The largest exponent, in terms of ``FARTHEST``."""
        self._variables: dict[tuple[Any, ...], Any] = {}

    def number(self, value: float) -> Any:
        return self.plain.number(value)

    def power(self, base: Any, exponent: Any) -> Any:
        """``base**n * exp(f*log(base))`` for the exponent n + f with n whole; the logarithm is a variable."""
        if isinstance(exponent, int):
            return self.plain.power(base, exponent)
        rest = exponent % 1
        result = self.plain.power(base, int(exponent - rest)) if self.plain.finite(exponent) else math.nan
        return result * self.plain.function("exp", [rest * self.variable("log", [base])]) if rest else result

    def function(self, name: str, arguments: Sequence[Any]) -> Any:
        if name in SINGLE_VALUED:
            return self.plain.function(name, arguments)
        if name not in EXPONENTIAL:
            return self.variable(name, arguments)
        exponent = arguments[0] * self.plain.number(self.unit)
        far = abs(exponent) / FARTHEST
        if not far <= 1:
            self.farthest = max(self.farthest, far)
            return math.nan
        return self.plain.function(name, [exponent])

    def weight(self, at: int, u: Any) -> Any:
        return (1 + self.variable("switch", [u, self.plain.number(at)])) / 2

    def variable(self, name: str, arguments: Sequence[Any]) -> Any:
        """The variable in place of a function's value; equal arguments have the same."""
        key = (name, *map(self.plain.rounded, arguments))
        if key not in self._variables:
            self._variables[key] = self.plain.number(self.source.uniform(-RANGE, RANGE))
        return self._variables[key]


def is_zero(node: Node) -> bool:
    """Whether an expression without ``ddt`` is proven to be 0 (see the module's first lines)."""
    return node in zeros([node])


def is_rounding(node: Node, beside: Node) -> bool:
    """Whether an expression is 0, or as small ``beside`` another one as rounded numbers in the file make it:
    (0.3*v)**2 - 0.09*v**2 is not 0 to all digits."""
    if is_zero(node):
        return True
    source, found = random.Random(0), False
    symbols = [one.data for one in reachable([node, beside]) if one.kind is Kind.SYMBOL]
    for _ in range(POINTS):
        values, sizes = evaluate([node, beside], {name: source.uniform(-RANGE, RANGE) for name in symbols})
        found = abs(values[node]) <= ROUNDED * sizes[beside] < math.inf
        if not found:
            break
    return found


def branching(node: Node) -> Sequence[Node]:
    """Those arguments of a node that decide which of its branches counts.

    Where these change, derivatives may vanish of what is not constant: sqrt(x**2)/x.
    """
    if node.kind is Kind.SWITCH:
        return node.arguments[:1]
    if node.kind is Kind.PRODUCT:
        bases = [base for base, exponent in zip(node.arguments, node.data) if not isinstance(exponent, int)]
    elif node.kind is Kind.POWER or (node.kind is Kind.FUNCTION and node.data == "log"):
        bases = [node.arguments[0]]
    else:
        single = node.kind is not Kind.FUNCTION or node.data in SINGLE_VALUED | EXPONENTIAL
        return () if single else node.arguments
    return [base for base in bases if signs(base, {}) is not Sign.POSITIVE]


def branches_on(graph: Graph, nodes: Sequence[Node], symbol: Node) -> bool:
    """Whether it may depend on ``symbol`` which branch of some function counts in ``nodes``."""
    return not all(is_zero(graph.diff(u, symbol)) for u in deciding(nodes, symbol.symbols))


def deciding(nodes: Sequence[Node], symbols: int) -> list[Node]:
    """The arguments that depend on any of ``symbols``, a bit set, and decide which branch of some function
    counts in ``nodes``."""
    inside = reachable(nodes, lambda node: bool(node.symbols & symbols))
    return [*dict.fromkeys(u for node in inside for u in branching(node) if u.symbols & symbols)]


def independent(graph: Graph, nodes: Sequence[Node], symbol: Node) -> bool:
    """Whether it is proven that none of ``nodes`` depends on ``symbol``, not even by a jump."""
    slopes = {graph.diff(node, symbol) for node in nodes}
    return all(map(is_zero, slopes)) and not branches_on(graph, nodes, symbol)


def zeros(nodes: Sequence[Node]) -> set[Node]:
    """Those of the expressions that are proven to be 0; what they have in common is evaluated once."""
    doubtful = [node for node in dict.fromkeys(nodes) if not node.is_zero]
    known = doubtful[0].graph.vanishing if doubtful else {}
    new = [node for node in doubtful if node not in known]
    known |= dict.fromkeys(new, False) | dict.fromkeys(vanishing(new), True)
    return {node for node in nodes if node.is_zero or known[node]}


def vanishing(nodes: Sequence[Node]) -> list[Node]:
    """The expressions that vanish identically, although their normal form is not 0."""
    source = random.Random(len(nodes))
    at_a_point = at_random(nodes, source, Doubles())
    nodes = [node for node in nodes if at_a_point[node] is not False]
    if not nodes:
        return []
    below = reachable(nodes)
    digits = 1000 if any(map(unusual, below)) else 200
    functions = sum(node.kind in (Kind.FUNCTION, Kind.POWER) for node in below)
    steps = (STEPS * len(below) + STEPS_OF_FUNCTION * functions) * POINTS * digits // 200
    work = below[0].graph.work
    if steps > min(MOST_WORK, work.most - work.spent):
        return []
    work.charge(steps)
    from lagrange_cli.expression.many_digits import many_digits

    arithmetic = many_digits(digits)
    for _ in range(POINTS):
        at_a_point = at_random(nodes, source, arithmetic)
        nodes = [node for node in nodes if at_a_point[node]]
    return list(nodes)


def unusual(node: Node) -> bool:
    """Whether it holds a number of a scale that calls for more digits."""
    numbers = [node.data] if node.kind is Kind.NUMBER else []
    if node.kind is Kind.SUM:
        numbers = [node.data[0], *node.data[1]]
    return any(number != 0 and not 1 / COMMON <= abs(number) <= COMMON for number in numbers)


def at_random(nodes: Sequence[Node], source: random.Random, plain: Digits) -> dict[Node, bool | None]:
    """Whether each expression is 0 at random arguments, up to rounding; None: it has no value there."""
    symbols = [node.data for node in reachable(nodes) if node.kind is Kind.SYMBOL]
    arguments = {name: plain.number(source.uniform(-RANGE, RANGE)) for name in symbols}
    found: dict[Node, bool | None] = dict.fromkeys(nodes)
    unit = 1.0
    for _ in range(UNITS):
        pending = [node for node in nodes if found[node] is None]
        branches = Branches(plain, source, unit)
        value, size = evaluate(pending, arguments, branches)
        for node in pending:
            if plain.finite(value[node]) and plain.finite(size[node]):
                found[node] = bool(abs(value[node]) <= plain.rounding * size[node])
        if not branches.farthest:
            break
        unit *= source.uniform(0.5, 1.0) / branches.farthest
    return found
