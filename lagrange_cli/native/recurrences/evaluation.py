"""Values of graph nodes, for any kind of numbers: parameters' constants once a run, anything at one state.

Small integer powers are products, of square roots where the exponent is half an integer.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.native.numbers.kind import Number, NumberKind, V
from lagrange_cli.records import dataclass, field

K = TypeVar("K")
X = TypeVar("X")


class Loaded(dict[K, X]):
    """A mapping to what ``load`` writes, each time that it is asked for, or to what has been set; ``has``
    tells for which keys there are values."""

    def __init__(self, load: Callable[[K], X], has: Callable[[K], bool] = lambda key: True) -> None:
        self._load, self._has = load, has

    def __missing__(self, key: K) -> X:
        return self._load(key)

    def __contains__(self, key: object) -> bool:
        return self._has(key)  # type: ignore[arg-type]

    def get(self, key: K, default: X = None) -> X:  # type: ignore[assignment, override]
        return self[key] if self._has(key) else default


N = TypeVar("N")


@dataclass
class Constants:
    """Parameter-only expressions, each computed once a run and stored in the array ``%constants``."""

    slots: dict[Node, int] = field(default_factory=dict)

    def slot(self, node: Node) -> int:
        """The place of a constant of the motion."""
        return self.slots.setdefault(node, len(self.slots))

    def value(self, kind: NumberKind[V], node: Node) -> V | None:
        """A constant of the motion: a number, or what its slot holds."""
        if node.kind is Kind.NUMBER:
            return kind.number(node.data)
        return kind.load("%constants", kind.parts * self.slot(node), kind.parts - 1)


def whole_power(base: N, exponent: int, times: Callable[[N, N], N]) -> N:
    """``base ** exponent`` for a whole exponent above 0, from squares of squares."""
    result: N | None = None
    square = base
    while exponent:
        if exponent & 1:
            result = square if result is None else times(result, square)
        exponent >>= 1
        if exponent:
            square = times(square, square)
    return cast("N", result)


def emit_power(kind: NumberKind[V], base: V | None, exponent: Number) -> V | None:
    """``base ** exponent`` for an exponent known now."""
    size = -exponent if exponent < 0 else exponent
    if size == int(size) and size <= kind.products:
        result = whole_power(base, int(size), kind.mul) if size else kind.one
        return kind.div(kind.one, result) if exponent < 0 else result
    if 2 * size == int(2 * size) and 2 * size <= kind.products:
        return emit_power(kind, kind.function("sqrt", base), 2 * exponent)
    return kind.function("pow", base, kind.number(exponent))


def add_scaled(kind: NumberKind[V], total: V | None, value: V | None, factor: Number) -> V | None:
    """``total + factor * value``."""
    if factor == -1:
        return kind.sub(total, value)
    return kind.fma(kind.number(factor), value, total)


def emit_values(
    kind: NumberKind[V], nodes: list[Node], known: dict[Node, V | None], constants: Constants | None
) -> None:
    """Compute ``nodes`` into ``known``, which holds the symbols' values (and any node computed before).

    With ``constants``, a node that ``known`` has no symbol for is a constant of the motion and comes
    from its slot.
    """
    moving = 0
    for node in known:
        moving |= node.symbols if node.kind is Kind.SYMBOL else 0
    loaded: dict[Node, V | None] = {}

    def inner(argument: Node) -> V | None:
        if argument.kind is Kind.NUMBER:
            return kind.number(argument.data)
        if constants is not None and not argument.symbols & moving and argument not in known:
            if argument not in loaded:
                loaded[argument] = constants.value(kind, argument)
            return loaded[argument]
        return known[argument]

    def enter(node: Node) -> bool:
        if node in known or node.kind is Kind.NUMBER:
            return False
        return constants is None or bool(node.symbols & moving)

    for node in reachable(nodes, enter):
        known[node] = emit_node(kind, node, inner)
    for node in nodes:
        known.setdefault(node, inner(node))


def emit_node(kind: NumberKind[V], node: Node, inner: Callable[[Node], V | None]) -> V | None:
    """One node from its arguments' values."""
    arguments = node.arguments
    if node.kind is Kind.SUM:
        constant, coefficients = node.data
        total = kind.number(constant)
        for argument, coefficient in zip(arguments, coefficients):
            total = add_scaled(kind, total, inner(argument), coefficient)
        return total
    if node.kind is Kind.PRODUCT:
        above: V | None = kind.one
        below: V | None = kind.one
        for argument, exponent in zip(arguments, node.data):
            power = emit_power(kind, inner(argument), abs(exponent))
            if exponent > 0:
                above = kind.mul(above, power)
            else:
                below = kind.mul(below, power)
        return above if below == kind.one else kind.div(above, below)
    if node.kind in (Kind.POWER, Kind.FUNCTION):
        name = "pow" if node.kind is Kind.POWER else node.data
        return kind.function(name, *map(inner, arguments))
    if node.kind is Kind.SWITCH:
        return emit_switch(kind, node.data, *map(inner, arguments))
    raise ValueError(f"{node.kind} has no value at a single state")


def emit_switch(kind: NumberKind[V], at: int, u: V | None, above: V | None, below: V | None) -> V | None:
    """``above`` or ``below`` by the sign of ``u``; where it is 0, that of the side ``at``, 0: their mean. The
    value that is not chosen may be nan; where ``u`` is nan, so is the value.
    """
    u = kind.normalized(u)
    on = kind.mul(kind.number(0.5), kind.add(above, below)) if at == 0 else above if at > 0 else below
    if u is None:
        return on
    otherwise = kind.select(kind.compare("olt", u, None), below, kind.add(on, u))
    return kind.select(kind.compare("ogt", u, None), above, otherwise)
