"""The algebra that serves ``solve``: a small hash-consed expression graph and its derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lagrange_cli.expression.node import Kind, Node, bits, in_order, reachable
from lagrange_cli.expression.normal_forms import NormalForms
from lagrange_cli.expression.switch_forms import whole

WIDE = 8
"""Arguments from which on it pays to know which symbols each of them holds."""
STEEP = {"asin", "acos", "atan2"}
"""Functions with infinite slopes where they have values."""
MOST = 6
"""Switches of a rate that are looked at one by one."""


class Graph(NormalForms):
    """A table in which every distinct expression exists once, with partial derivatives."""

    def __init__(self) -> None:
        super().__init__()
        self._derivatives: dict[tuple[int, int], Node] = {}
        self._arguments: dict[Node, dict[int, list[tuple[Node, Any]]]] = {}
        self._split: dict[tuple[Node, int], tuple[Node, Node]] = {}
        self._vanishing: dict[Node, tuple[Node, int] | None] = {}

    def check_numbers(self) -> None:
        """Raise ``BeyondDoubles`` where a number is no double, as those of exact graphs may be."""

    # ------------------------------------------------------------------ derivatives

    def diff(self, node: Node, symbol: Node) -> Node:
        """The partial derivative of ``node`` with respect to ``symbol`` (no ``ddt`` may stand in it)."""
        if not node.symbols & symbol.symbols:
            return self.zero
        known, number = self._derivatives, symbol.number
        new: set[Node] = set()
        pending = [node]
        while pending:
            inner = pending.pop()
            if inner not in new and (inner.number, number) not in known:
                new.add(inner)
                pending += [argument for argument, _ in self._arguments_with(inner, symbol)]
        self.work.charge(len(new))
        for inner in in_order(new):
            known[inner.number, number] = self._derivative(inner, symbol)
        return known[node.number, number]

    def gradient(self, node: Node, symbols: Mapping[Node, int]) -> dict[int, Node]:
        """The partial derivatives that are not 0, by what ``symbols`` numbers the symbols with."""
        slopes = ((symbols[one], self.diff(node, one)) for one in self.symbols_of(node) if one in symbols)
        return {index: slope for index, slope in slopes if slope is not self.zero}

    def _arguments_with(self, node: Node, symbol: Node) -> list[tuple[Node, Any]]:
        """The arguments that ``symbol`` occurs in, with their coefficients or exponents."""
        data = node.data[1] if node.kind is Kind.SUM else node.data if node.kind is Kind.PRODUCT else None
        if len(node.arguments) < WIDE or data is None:
            every = zip(node.arguments, data or (None,) * len(node.arguments))
            return [(argument, own) for argument, own in every if argument.symbols & symbol.symbols]
        index = self._arguments.get(node)
        if index is None:  # so that all the derivatives of a long sum together take one walk over it
            index = self._arguments[node] = {}
            for argument, own in zip(node.arguments, data):
                for bit in bits(argument.symbols):
                    index.setdefault(bit, []).append((argument, own))
        return index.get(symbol.symbols.bit_length() - 1, [])

    def _derivative(self, node: Node, symbol: Node) -> Node:
        if node is symbol:
            return self.one

        def inner(argument: Node) -> Node:
            return self._derivatives.get((argument.number, symbol.number), self.zero)

        if node.kind is Kind.SUM:
            return self.sum([(inner(a), c) for a, c in self._arguments_with(node, symbol)])
        if node.kind is Kind.PRODUCT:
            terms = []
            for argument, exponent in self._arguments_with(node, symbol):
                rate = inner(argument)
                if not rate.is_zero:
                    parts = zip(node.arguments, node.data)
                    lower = [(a, self.tidy(e - 1) if a is argument else e) for a, e in parts]
                    steep = exponent < 1 and not whole(exponent)
                    rest = self._chained(lower, rate, MOST if steep else 0)
                    terms.append((rest, self.number(exponent)))
            return self.sum(terms)
        if node.kind is Kind.SWITCH:
            u, above, below = node.arguments
            return self.switch(u, inner(above), inner(below), node.data)
        most = MOST if node.kind is Kind.POWER or node.data in STEEP else 0
        return self.sum(
            [
                (self._chained([(partial, 1)], inner(argument), most), 1.0)
                for argument, partial in zip(node.arguments, self.partials(node))
                if not inner(argument).is_zero
            ]
        )

    def _chained(self, slope: Sequence[tuple[Node, Any]], rate: Node, most: int) -> Node:
        """The product of the factors ``slope`` and a ``rate``, 0 on the sides of switches where the rate is
        0: there the argument is a constant, and the slope may be infinite, as that of max(0, u)**0.5 is.
        Only so many switches of the rate are looked at."""
        decides = self._vanishes_by(rate) if most else None
        if decides is None:
            return self.product([*slope, (rate, 1)])
        above, below = (self._chained(slope, self._on_side(rate, decides, k), most - 1) for k in (1, 2))
        return self.switch(decides[0], above, below, decides[1])

    def _vanishes_by(self, node: Node) -> tuple[Node, int] | None:
        """The argument of a switch that has to be on one side for ``node`` to be 0 all along, if any has, and
        the side that the switch takes where this is 0."""
        known = self._vanishing
        for one in reachable([node], lambda inner: inner not in known):
            below = [known[argument] for argument in one.arguments]
            found = next((u for u in below if u is not None), None)
            if one.kind is Kind.SWITCH:
                u, *branches = one.arguments
                zero = any(a.is_zero or by is not None for a, by in zip(branches, below[1:]))
                known[one] = (u, one.data) if zero else None
            elif one.kind is Kind.SUM:
                known[one] = found if not one.data[0] and None not in below else None
            elif one.kind is Kind.PRODUCT:
                known[one] = next((u for u, e in zip(below, one.data) if u is not None and e > 0), None)
            else:
                known[one] = None
        return known[node]

    def _on_side(self, node: Node, decides: tuple[Node, int], side: int) -> Node:
        """``node`` with the branch ``side`` of switches by this argument, in terms, factors and branches.
        Those that take another side where it is 0 stay: it may be a constant."""
        made: dict[Node, Node] = {}
        for one in reachable([node], lambda inner: inner.kind in (Kind.SWITCH, Kind.SUM, Kind.PRODUCT)):
            parts = [made.get(argument, argument) for argument in one.arguments]
            if one.kind is Kind.SWITCH:
                u, above, below = parts
                known = (u, one.data) == decides
                made[one] = parts[side] if known else self.switch(u, above, below, one.data)
            elif one.kind is Kind.SUM:
                constant, coefficients = one.data
                made[one] = self.sum([(self.constant(constant), 1.0), *zip(parts, coefficients)])
            else:
                made[one] = self.product(zip(parts, one.data))
        return made.get(node, node)

    def partials(self, node: Node) -> tuple[Node, ...]:
        """Partial derivatives of a function, power or switch with respect to its arguments.

        That of a switch by what decides is 0: where it jumps, it has none.
        """
        u = node.arguments[0]
        if node.kind is Kind.SWITCH:
            one, zero, at = self.one, self.zero, node.data
            return (zero, self.switch(u, one, zero, at), self.switch(u, zero, one, at))
        if node.kind is Kind.POWER:
            exponent = node.arguments[1]
            return (exponent * self.power(u, exponent - 1.0), node * self.function("log", (u,)))
        if node.kind is not Kind.FUNCTION:
            raise ValueError(f"no partial derivatives of {node.kind}")
        name = node.data
        if name == "atan2":  # atan2(y, x)
            x = node.arguments[1]
            square = u * u + x * x
            return (x / square, -u / square)
        rules = {
            "sin": lambda: self.function("cos", (u,)),
            "cos": lambda: -self.function("sin", (u,)),
            "tan": lambda: 1.0 + node * node,
            "sinh": lambda: self.function("cosh", (u,)),
            "cosh": lambda: self.function("sinh", (u,)),
            "tanh": lambda: 1.0 - node * node,
            "exp": lambda: node,
            "log": lambda: 1.0 / u,
            "asin": lambda: (1.0 - u * u) ** -0.5,
            "acos": lambda: -((1.0 - u * u) ** -0.5),
            "atan": lambda: 1.0 / (1.0 + u * u),
        }
        return (rules[name](),)

    # ------------------------------------------------------------------ parameters apart

    def split_parameters(self, node: Node, variables: int) -> tuple[Node, Node]:
        """``node`` as (constant of the motion) * (rest); ``variables`` is the bit set of q, v and t."""
        key = node, variables
        if key not in self._split:
            self._split[key] = self._split_parameters(node, variables)
        return self._split[key]

    def _split_parameters(self, node: Node, variables: int) -> tuple[Node, Node]:
        if not node.symbols & variables:
            return node, self.one
        coefficient, rest = self.split_coefficient(node)
        if rest.kind is not Kind.PRODUCT:
            return self.constant(coefficient), rest
        parts = list(zip(rest.arguments, rest.data))
        fixed = [(a, e) for a, e in parts if not a.symbols & variables]
        if not fixed:
            return self.constant(coefficient), rest
        moving = [(a, e) for a, e in parts if a.symbols & variables]
        constant = self.product(fixed)
        return constant if coefficient == 1.0 else coefficient * constant, self.product(moving)
