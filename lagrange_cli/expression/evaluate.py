"""Values of graph nodes, with the size of their rounding errors, over any kind of real numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.expression.reals import real_function, real_power


class Arithmetic(Protocol):
    """The arithmetic of one kind of numbers: nan or inf where there is no real value."""

    rounding: Any
    """The error of many operations in units of their results."""

    def number(self, value: float) -> Any:
        """A number of the graph as one of this kind."""

    def power(self, base: Any, exponent: Any) -> Any:
        """``base ** exponent``."""

    def function(self, name: str, arguments: Sequence[Any]) -> Any:
        """An elementary function."""

    def weight(self, at: int, u: Any) -> Any:
        """The weight of the upper expression of a switch by ``u``; the lower one has the rest of 1."""


class Reals:
    """Doubles."""

    rounding = 1e-12
    number = staticmethod(float)
    power = staticmethod(real_power)
    function = staticmethod(real_function)

    @staticmethod
    def weight(at: int, u: float) -> float:
        if u != u:
            return math.nan
        return float(u > 0) if u != 0 else (1 + at) / 2


Step = tuple[Node, Kind, Sequence[Any], Sequence[Any]]
"""A node, its kind, and the number that it is, or its coefficients and constant; their absolute values."""


def evaluate(
    nodes: Sequence[Node], values: Mapping[str, Any], arithmetic: Arithmetic | None = None
) -> tuple[dict[Node, Any], dict[Node, Any]]:
    """Values of ``nodes`` and all below them, and for each the size of its rounding error.

    The second number is that error in units of the last place, to first order (a running error bound; Higham,
    Accuracy and Stability of Numerical Algorithms, 2nd ed., sec. 3.3): what a value must be compared with
    before it is called zero. It is infinite where a function's argument has lost half its digits.
    """
    of = arithmetic or Reals()
    return evaluated(prepared(nodes, of), values, of)


def prepared(nodes: Sequence[Node], of: Arithmetic) -> list[Step]:
    """All below ``nodes``, arguments first, with their numbers in an arithmetic: for many ``values``."""
    found: list[Step] = []
    for node in reachable(nodes):
        numbers: Sequence[Any] = ()
        if node.kind is Kind.NUMBER:
            numbers = [of.number(node.data)]
        elif node.kind is Kind.SUM:
            numbers = [*map(of.number, node.data[1]), of.number(node.data[0])]
        found.append((node, node.kind, numbers, [*map(abs, numbers)]))
    return found


def evaluated(
    steps: Sequence[Step], values: Mapping[str, Any], of: Arithmetic
) -> tuple[dict[Node, Any], dict[Node, Any]]:
    """What ``evaluate`` returns, of what is ``prepared`` in an arithmetic."""
    value: dict[Node, Any] = {}
    size: dict[Node, Any] = {}
    for node, kind, numbers, sizes in steps:
        a = node.arguments
        if kind is Kind.SUM:
            value[node] = numbers[-1] + sum([c * value[x] for c, x in zip(numbers, a)])
            size[node] = sizes[-1] + sum([c * size[x] for c, x in zip(sizes, a)])
        elif kind is Kind.NUMBER:
            (value[node],), (size[node],) = numbers, sizes
        elif kind is Kind.SYMBOL:
            value[node] = values[node.data]
            size[node] = abs(value[node])
        elif kind is Kind.PRODUCT:
            value[node], size[node] = product([(value[x], size[x], e) for x, e in zip(a, node.data)], of)
        elif kind is Kind.POWER:
            base, exponent = a
            value[node] = of.power(value[base], value[exponent])
            grown = abs(value[exponent]) * size[base] / abs(value[base]) if value[base] != 0 else math.inf
            size[node] = abs(value[node]) * (1 + grown + size[exponent])
        elif kind is Kind.FUNCTION:
            value[node] = of.function(node.data, [value[x] for x in a])
            lost = size[a[0]] > of.rounding**-0.5
            size[node] = math.inf if lost else size_of(node.data, value[node], size[a[0]])
        elif kind is Kind.SWITCH:
            u, above, below = a
            weight = of.weight(node.data, value[u])
            value[node] = weighted(weight, value[above], value[below])
            parts = ((weight, above), (1 - weight, below))
            size[node] = sum([abs(part) * size[x] for part, x in parts if part != 0])
        else:
            raise ValueError("a time derivative has no value without a motion")
    return value, size


def weighted(weight: Any, above: Any, below: Any) -> Any:
    """A switch's value; the branch that is not chosen may be anything."""
    return above if weight == 1 else below if weight == 0 else weight * above + (1 - weight) * below


def product(factors: Sequence[tuple[Any, Any, float]], of: Arithmetic) -> tuple[Any, Any]:
    """The product of (base, its size, exponent), and its size: the sum of the factors' relative ones."""
    result: Any = 1
    alone: Any = 1
    grown: Any = 0
    for base, size, exponent in factors:
        if exponent == 1 and base != 0:  # most of them
            result *= base
            grown += size / abs(base)
            alone *= abs(base)
            continue
        factor = of.power(base, exponent if isinstance(exponent, int) else of.number(exponent))
        result *= factor
        if base != 0:
            grown += abs(of.number(exponent)) * (size / abs(base))
            alone *= abs(factor)
        else:  # whatever is left of it is a rounding error
            alone *= of.power(size, math.ceil(exponent)) if exponent > 0 else math.inf
    return result, alone * max(grown, 1)


def size_of(name: str, value: Any, size: Any) -> Any:
    """The size of a function's value: the argument's times the slope, and its own."""
    if name in ("exp", "sinh", "cosh"):
        return (abs(value) + (name != "exp")) * max(size, 1)
    if name in ("sin", "cos", "tanh"):
        return max(abs(value), size)
    if name == "tan":
        return (1 + value * value) * max(size, 1)
    return max(abs(value), 1)
