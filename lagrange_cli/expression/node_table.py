"""The table of the expression graph: every node exists once, and takes a step of work."""

from __future__ import annotations

import math
from typing import Any, cast

from lagrange_cli import limits
from lagrange_cli.expression.node import Kind, Node, Table, bits
from lagrange_cli.expression.reals import real_function, real_power, tidy

MAX_NODES = limits.whole("nodes")
BITS_A_STEP = 9
"""A set of symbols that no other node has counts as a step for every 2**9 bits: 64 bytes."""
SCATTERING = 2**30 - 35
"""A prime that 2 generates: the hashes of Python give sets of single symbols the same 61 values."""


class NodeTable:
    """Nodes by their contents, and the leaves of the graph: numbers and symbols. What is done with nodes is
    added by ``switch_forms`` and ``normal_forms``."""

    number = staticmethod(float)
    """What numbers are; with ``tidy``, ``power_of`` and ``function_of`` the arithmetic of constants."""
    tidy, power_of, function_of = staticmethod(tidy), staticmethod(real_power), staticmethod(real_function)
    rounding = 2.0**-52
    """By how much numbers may be rounded, as a part of them."""

    def __init__(self) -> None:
        self.work = limits.Work()
        self.nodes: list[Node] = []
        self.vanishing: dict[Node, bool] = {}
        """The results of ``zero`` for nodes that are not 0 by their form."""
        self._table: dict[tuple[Any, ...], Node] = {}
        self._nan: float | None = None
        self._symbols: dict[str, int] = {}
        self._by_bit: list[Node] = []
        self._sets: dict[int, int] = {}
        """Every wide set of symbols once: a bit for each symbol is much, and most sets are equal."""
        self.zero = self.constant(0.0)
        self.one = self.constant(1.0)

    def constant(self, value: float) -> Node:
        """The node of a number (-0.0 is 0; nan is one number)."""
        value = self.number(value) + 0.0
        if value != value:
            value = self._nan = value if self._nan is None else self._nan
        return self._make(Kind.NUMBER, value, (), 0)

    def symbol(self, name: str) -> Node:
        """The node of a symbol; the same name gives the same node."""
        bit = self._symbols.setdefault(name, len(self._symbols))
        node = self._make(Kind.SYMBOL, name, (), 1 << bit)
        if bit == len(self._by_bit):
            self._by_bit.append(node)
        return node

    def symbols_of(self, node: Node, among: int = -1) -> list[Node]:
        """The symbols that ``node`` depends on, in the order of their creation; only those in a bit set."""
        return [self._by_bit[bit] for bit in bits(node.symbols & among)]

    def lift(self, value: Node | float) -> Node:
        """A node as it is, a number as its node."""
        return value if isinstance(value, Node) else self.constant(value)

    def _make(self, kind: Kind, data: Any, arguments: tuple[Node, ...], symbols: int | None = None) -> Node:
        key = (kind, data, arguments)
        node = self._table.get(key)
        if node is None:
            if symbols is None:
                symbols = 0
                for argument in arguments:
                    symbols |= argument.symbols
            work = self.work
            work.nodes += 1
            if len(self.nodes) >= MAX_NODES:
                limits.allow_nodes(math.inf)
            steps = 1 + len(arguments)
            if wide := symbols.bit_length() >> BITS_A_STEP:
                symbols, new = self._shared(symbols)
                steps += wide * new
            work.charge(steps)
            node = Node(cast(Table, self), kind, data, arguments, symbols)
            self.nodes.append(node)
            self._table[key] = node
        return node

    def _shared(self, symbols: int) -> tuple[int, bool]:
        """The set that is kept for all nodes with these symbols, and whether it is new."""
        place = symbols % SCATTERING
        while (known := self._sets.get(place)) != symbols:
            if known is None:
                self._sets[place] = symbols
                return symbols, True
            place += 1
        return known, False
