"""Values of graph nodes, for any kind of numbers: parameters' constants once a run, anything at one state.

Small integer powers are products, of square roots where the exponent is half an integer.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from typing import TypeAlias, TypeVar, cast

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.native.numbers.kind import Number, NumberKind, V
from lagrange_cli.records import dataclass, field

K = TypeVar("K")
X = TypeVar("X")
Powers: TypeAlias = "tuple[tuple[Node, Number], ...]"
"""Factors and their exponents."""


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
    kind: NumberKind[V],
    nodes: list[Node],
    known: dict[Node, V | None],
    constants: Constants | None,
    *,
    inverses: bool = False,
) -> None:
    """Compute ``nodes`` into ``known``, which holds the symbols' values (and any node computed before).

    With ``constants``, a node that ``known`` has no symbol for is a constant of the motion and comes
    from its slot. With ``inverses``, quotients with the same denominator are products with its inverse: of
    all arithmetic, divisions take longest.
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

    order = reachable(nodes, enter)
    times = Counter(map(denominator, order)) if inverses else Counter()
    found: dict[Powers, V | None] = {}

    def quotient(above: V | None, powers: Powers) -> V | None:
        if times[powers] < 2:
            below = emit_product(kind, powers, inner)
            return above if below == kind.one else kind.div(above, below)
        if powers not in found:
            found[powers] = kind.div(kind.one, emit_product(kind, powers, inner))
        return kind.mul(above, found[powers])

    multiples = dict[tuple[Node, Number], V | None]()
    for node in order:
        number, factor = multiple(node)
        if number is not None and (number, -factor) in multiples:  # no rounding differs
            known[node] = kind.neg(multiples[number, -factor])
            continue
        known[node] = emit_node(kind, node, inner, quotient)
        if number is not None:
            multiples[number, factor] = known[node]
    for node in nodes:
        known.setdefault(node, inner(node))


def multiple(node: Node) -> tuple[Node | None, Number]:
    """What a node is a multiple of, and by which factor."""
    if node.kind is not Kind.SUM or len(node.arguments) != 1 or node.data[0] != 0:
        return None, 1
    return node.arguments[0], node.data[1][0]


def denominator(node: Node) -> Powers:
    """What a product is divided by."""
    if node.kind is not Kind.PRODUCT:
        return ()
    return tuple((one, -exponent) for one, exponent in zip(node.arguments, node.data) if exponent < 0)


def emit_product(
    kind: NumberKind[V], powers: Iterable[tuple[Node, Number]], inner: Callable[[Node], V | None]
) -> V | None:
    """The product of powers."""
    found: V | None = kind.one
    for argument, exponent in powers:
        found = kind.mul(found, emit_power(kind, inner(argument), exponent))
    return found


def emit_node(
    kind: NumberKind[V],
    node: Node,
    inner: Callable[[Node], V | None],
    quotient: Callable[[V | None, Powers], V | None],
) -> V | None:
    """One node from its arguments' values; ``quotient`` divides by a denominator."""
    arguments = node.arguments
    if node.kind is Kind.SUM:
        constant, coefficients = node.data
        total = kind.number(constant)
        for argument, coefficient in zip(arguments, coefficients):
            total = add_scaled(kind, total, inner(argument), coefficient)
        return total
    if node.kind is Kind.PRODUCT:
        positive = ((one, exponent) for one, exponent in zip(arguments, node.data) if exponent > 0)
        above, powers = emit_product(kind, positive, inner), denominator(node)
        return quotient(above, powers) if powers else above
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
