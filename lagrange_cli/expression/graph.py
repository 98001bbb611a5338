"""The algebra that serves ``solve``: a small hash-consed expression graph.

Equal expressions are one node. Constants are folded, like terms and like factors collected, 0 and 1
vanish, and cos^2 + sin^2 = 1 is applied wherever both squares stand in one sum with equal factors.
Products of sums are kept as written (each costs one convolution in Taylor space). Nodes are numbered in
the order of their creation, so a node's arguments always have smaller numbers than the node itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from enum import Enum
from operator import attrgetter
from typing import Any

from lagrange_cli import limits
from lagrange_cli.errors import TooLarge
from lagrange_cli.expression.reals import real_function, real_power, tidy

MAX_NODES = limits.whole("nodes")
BITS_A_STEP = 9
"""The set of a node's symbols counts as a step for every 2**9 bits: 64 bytes."""
WIDE = 8
"""Arguments from which on it pays to know which symbols each of them holds."""

_number = attrgetter("number")


class Kind(Enum):
    """What a node is; ``Node.data`` holds what its arguments do not."""

    NUMBER = "number"  # data: the float
    SYMBOL = "symbol"  # data: the name
    SUM = "sum"  # data: (constant, coefficients); value = constant + sum coefficient_i * argument_i
    PRODUCT = "product"  # data: exponents (int or float); value = prod argument_i ** exponent_i
    POWER = "power"  # arguments: base and an exponent that is no number
    FUNCTION = "function"  # data: the function's name
    DDT = "ddt"  # the total time derivative of the argument along the motion

    __hash__ = object.__hash__  # that of the name takes a call for every look into the table


class Node:
    """One expression; made only by its ``Graph``. Combines with ``+ - * / **`` and numbers."""

    __slots__ = ("arguments", "data", "graph", "kind", "number", "symbols")

    def __init__(
        self, graph: Graph, kind: Kind, data: Any, arguments: tuple[Node, ...], symbols: int
    ) -> None:
        self.graph = graph
        self.kind = kind
        self.data = data
        self.arguments = arguments
        self.symbols = symbols
        """Bit set of the symbols this expression depends on."""
        self.number = len(graph.nodes)
        """Position in the order of creation."""

    def __add__(self, other: Node | float) -> Node:
        return self.graph.sum([(self, 1.0), (self.graph.lift(other), 1.0)])

    __radd__ = __add__

    def __sub__(self, other: Node | float) -> Node:
        return self.graph.sum([(self, 1.0), (self.graph.lift(other), -1.0)])

    def __rsub__(self, other: Node | float) -> Node:
        return self.graph.sum([(self.graph.lift(other), 1.0), (self, -1.0)])

    def __neg__(self) -> Node:
        return self.graph.sum([(self, -1.0)])

    def __mul__(self, other: Node | float) -> Node:
        return self.graph.product([(self, 1), (self.graph.lift(other), 1)])

    __rmul__ = __mul__

    def __truediv__(self, other: Node | float) -> Node:
        return self.graph.product([(self, 1), (self.graph.lift(other), -1)])

    def __rtruediv__(self, other: Node | float) -> Node:
        return self.graph.product([(self.graph.lift(other), 1), (self, -1)])

    def __pow__(self, other: Node | float) -> Node:
        return self.graph.power(self, self.graph.lift(other))

    def __rpow__(self, other: Node | float) -> Node:
        return self.graph.power(self.graph.lift(other), self)

    @property
    def is_zero(self) -> bool:
        """Whether the expression is identically 0 by structure."""
        return self.kind is Kind.NUMBER and self.data == 0.0

    def __repr__(self) -> str:
        inner = ", ".join([repr(self.data)] * (self.data is not None) + [repr(a) for a in self.arguments])
        return f"{self.kind.value}({inner})"


class Graph:
    """A table in which every distinct expression exists once."""

    number = staticmethod(float)
    """What numbers are; with ``tidy``, ``power_of`` and ``function_of`` the arithmetic of constants."""
    tidy, power_of, function_of = staticmethod(tidy), staticmethod(real_power), staticmethod(real_function)

    def __init__(self) -> None:
        self.work = limits.Work()
        self.nodes: list[Node] = []
        self._table: dict[tuple[Any, ...], Node] = {}
        self._symbols: dict[str, int] = {}
        self._by_bit: list[Node] = []
        self._derivatives: dict[tuple[int, int], Node] = {}
        self._arguments: dict[Node, dict[int, list[tuple[Node, Any]]]] = {}
        self._split: dict[tuple[Node, int], tuple[Node, Node]] = {}
        self.zero = self.constant(0.0)
        self.one = self.constant(1.0)

    # ------------------------------------------------------------------ leaves

    def constant(self, value: float) -> Node:
        """The node of a number (-0.0 is 0)."""
        value = self.number(value) + 0.0
        return self._make(Kind.NUMBER, value, (), 0)

    def symbol(self, name: str) -> Node:
        """The node of a symbol; the same name gives the same node."""
        bit = self._symbols.setdefault(name, len(self._symbols))
        node = self._make(Kind.SYMBOL, name, (), 1 << bit)
        if bit == len(self._by_bit):
            self._by_bit.append(node)
        return node

    def symbols_of(self, node: Node) -> list[Node]:
        """The symbols that ``node`` depends on, in the order of their creation."""
        return [self._by_bit[bit] for bit in bits(node.symbols)]

    def lift(self, value: Node | float) -> Node:
        """A node as it is, a number as its node."""
        return value if isinstance(value, Node) else self.constant(value)

    def _make(self, kind: Kind, data: Any, arguments: tuple[Node, ...], symbols: int | None = None) -> Node:
        key = (kind, data, tuple(argument.number for argument in arguments))
        node = self._table.get(key)
        if node is None:
            if symbols is None:
                symbols = 0
                for argument in arguments:
                    symbols |= argument.symbols
            if len(self.nodes) >= MAX_NODES:
                raise TooLarge(
                    f"the equations have more than {MAX_NODES} terms and factors that differ",
                    "write a smaller system, " + limits.way_out("nodes"),
                )
            self.work.charge(1 + len(arguments) + (symbols.bit_length() >> BITS_A_STEP))
            node = Node(self, kind, data, arguments, symbols)
            self.nodes.append(node)
            self._table[key] = node
        return node

    # ------------------------------------------------------------------ sums

    def sum(self, terms: Iterable[tuple[Node, float]]) -> Node:
        """``sum coefficient * node``, flattened, like terms collected."""
        constant = 0.0
        collected: dict[Node, float] = {}
        count = 0
        for node, coefficient in terms:
            count += 1
            if node.kind is Kind.NUMBER:
                constant += coefficient * node.data
            elif node.kind is Kind.SUM:
                count += len(node.arguments)
                inner, coefficients = node.data
                constant += coefficient * inner
                for argument, factor in zip(node.arguments, coefficients):
                    collected[argument] = collected.get(argument, 0.0) + coefficient * factor
            else:
                collected[node] = collected.get(node, 0.0) + coefficient
        self.work.charge(count)
        collected = {node: c for node, c in collected.items() if c != 0.0}
        constant += self._fold_squares(collected)
        if not collected:
            return self.constant(constant)
        if constant == 0.0 and len(collected) == 1:
            ((node, coefficient),) = collected.items()
            if coefficient == 1.0:
                return node
        ordered = sorted(collected.items(), key=lambda item: item[0].number)
        data = (constant + 0.0, tuple(coefficient for _, coefficient in ordered))
        return self._make(Kind.SUM, data, tuple(node for node, _ in ordered))

    def _fold_squares(self, collected: dict[Node, float]) -> float:
        """Replace c R cos(u)^2 + c R sin(u)^2 by c R in place; returns what became a constant."""
        constant = 0.0
        pending = [node for node in collected if node.kind is Kind.PRODUCT]
        while pending:
            node = pending.pop()
            if node not in collected:
                continue
            for factor, exponent in zip(node.arguments, node.data):
                if exponent != 2 or factor.kind is not Kind.FUNCTION or factor.data not in ("cos", "sin"):
                    continue
                rest = self.product([(node, 1), (factor, -2)])
                partner = self.function("sin" if factor.data == "cos" else "cos", factor.arguments)
                twin = self.product([(rest, 1), (partner, 2)])
                if collected.get(twin) != collected[node]:
                    continue
                coefficient = collected.pop(node)
                del collected[twin]
                scale, left = self.split_coefficient(rest)
                if left is self.one:
                    constant += coefficient * scale
                else:
                    total = collected.pop(left, 0.0) + coefficient * scale
                    if total != 0.0:
                        collected[left] = total
                        if left.kind is Kind.PRODUCT:
                            pending.append(left)
                break
        return constant

    def split_coefficient(self, node: Node) -> tuple[float, Node]:
        """``node`` as a number times a node that carries no numerical factor.

        Out of a sum comes what its first term has of a sign and powers of two, which is exact: y - x and
        2*x - 2*y are multiples of x - y.
        """
        if node.kind is Kind.NUMBER:
            return node.data, self.one
        if node.kind is not Kind.SUM:
            return 1.0, node
        constant, (first, *others) = node.data
        if not others and constant == 0.0:
            return first, node.arguments[0]
        if first == 1.0 or abs(math.frexp(first)[0]) != 0.5:
            return 1.0, node
        data = (constant / first + 0.0, (1.0, *(coefficient / first for coefficient in others)))
        return first, self._make(Kind.SUM, data, node.arguments)

    # ------------------------------------------------------------------ products and powers

    def product(self, factors: Iterable[tuple[Node, int | float]]) -> Node:
        """``prod node ** exponent``, flattened, like factors collected, numbers in front."""
        coefficient = 1.0
        collected: dict[Node, int | float] = {}
        pending = list(factors)
        count = 0
        while pending:
            count += 1
            node, exponent = pending.pop()
            if node.kind is Kind.NUMBER:
                coefficient *= self.power_of(node.data, exponent)
                continue
            if node.kind is Kind.PRODUCT:
                if whole(exponent):
                    pending.extend((a, e * exponent) for a, e in zip(node.arguments, node.data))
                    continue
            elif node.kind is Kind.SUM:
                scale, rest = self.split_coefficient(node)
                if rest is not node and (scale > 0.0 or whole(exponent)):
                    coefficient *= self.power_of(scale, exponent)
                    pending.append((rest, exponent))
                    continue
            collected[node] = collected.get(node, 0) + exponent
        self.work.charge(count)
        if coefficient == 0.0:
            return self.zero
        parts = [(a, self.tidy(e)) for a, e in collected.items() if e != 0]
        if not parts:
            return self.constant(coefficient)
        parts.sort(key=lambda part: part[0].number)
        if len(parts) == 1 and parts[0][1] == 1:
            node = parts[0][0]
        else:
            node = self._make(Kind.PRODUCT, tuple(e for _, e in parts), tuple(a for a, _ in parts))
        return node if coefficient == 1.0 else self.sum([(node, coefficient)])

    def power(self, base: Node, exponent: Node) -> Node:
        """``base ** exponent``; a numerical exponent makes a product, any other a power node."""
        if exponent.kind is Kind.NUMBER:
            return self.product([(base, self.tidy(exponent.data))])
        if base is self.one:
            return self.one
        return self._make(Kind.POWER, None, (base, exponent))

    def function(self, name: str, arguments: Sequence[Node]) -> Node:
        """An elementary function; of numbers, its value; ``sqrt`` is the power 1/2."""
        arguments = tuple(arguments)
        if name == "sqrt":
            return self.product([(arguments[0], 0.5)])
        if all(argument.kind is Kind.NUMBER for argument in arguments):
            return self.constant(self.function_of(name, [argument.data for argument in arguments]))
        return self._make(Kind.FUNCTION, name, arguments)

    def ddt(self, node: Node) -> Node:
        """The total time derivative along the motion, left for the Taylor series to take."""
        if node.kind is Kind.NUMBER:
            return self.zero
        return self._make(Kind.DDT, None, (node,))

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
        for inner in sorted(new, key=_number):
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
                    rest = self.product([(node, 1), (argument, -1), (rate, 1)])
                    terms.append((rest, self.number(exponent)))
            return self.sum(terms)
        return self.sum(
            [
                (self.product([(partial, 1), (inner(argument), 1)]), 1.0)
                for argument, partial in zip(node.arguments, self.partials(node))
                if not inner(argument).is_zero
            ]
        )

    def partials(self, node: Node) -> tuple[Node, ...]:
        """Partial derivatives of a function or power node with respect to its arguments."""
        u = node.arguments[0]
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
        return coefficient * self.product(fixed), self.product(moving)


def whole(exponent: float) -> bool:
    """Whether a power is one of a whole number."""
    return isinstance(exponent, int) or (math.isfinite(exponent) and exponent == int(exponent))


def reachable(roots: Iterable[Node], enter: Any = None) -> list[Node]:
    """All nodes below ``roots`` (those for which ``enter`` holds), arguments before their users."""
    seen: set[Node] = set()
    pending = [root for root in roots if enter is None or enter(root)]
    count = 0
    while pending:
        node = pending.pop()
        if node not in seen:
            seen.add(node)
            count += 1 + len(node.arguments)
            pending.extend(a for a in node.arguments if a not in seen and (enter is None or enter(a)))
    if seen:
        node.graph.work.charge(count)
    return sorted(seen, key=_number)


def bits(mask: int) -> Iterator[int]:
    """The positions of the ones in ``mask``, in ascending order."""
    while mask:
        lowest = mask & -mask
        yield lowest.bit_length() - 1
        mask ^= lowest


class GraphAlgebra:
    """``Algebra[Node]`` over one graph; see ``expression.algebra``."""

    def __init__(self) -> None:
        self.graph = Graph()

    def number(self, text: str) -> Node:
        return self.graph.constant(float(text))

    def pi(self) -> Node:
        return self.graph.constant(math.pi)

    def symbol(self, name: str) -> Node:
        return self.graph.symbol(name)

    def function(self, name: str, arguments: Sequence[Node]) -> Node:
        return self.graph.function(name, arguments)

    def total(self, terms: Sequence[Node]) -> Node:
        return self.graph.sum([(term, 1.0) for term in terms])

    def symbols(self, expression: Node) -> list[Node]:
        return self.graph.symbols_of(expression)

    def diff(self, expression: Node, symbol: Node) -> Node:
        return self.graph.diff(expression, symbol)
