"""Code for the values of graph nodes: parameters' constants once a run, anything at one state.

Functions come from the C library through LLVM's intrinsics; small integer powers are products.
"""

from __future__ import annotations

from collections.abc import Mapping

from lagrange_cli.expression.node import Kind, Node, reachable
from lagrange_cli.native.numbers.double import ONE, Emitter, Value, literal
from lagrange_cli.records import dataclass, field

INTRINSICS = {"sin": 1, "cos": 1, "exp": 1, "log": 1, "pow": 2, "sqrt": 1, "fabs": 1, "floor": 1}
LIBRARY = {
    "tan": 1, "asin": 1, "acos": 1, "atan": 1, "sinh": 1, "cosh": 1, "tanh": 1, "atan2": 2,
}  # fmt: skip

DECLARATIONS = "\n".join(
    [f"declare double @llvm.{n}.f64({', '.join(['double'] * a)})" for n, a in INTRINSICS.items()]
    + [f"declare double @{n}({', '.join(['double'] * a)}) memory(none)" for n, a in LIBRARY.items()]
    + ["declare double @llvm.fmuladd.f64(double, double, double)"]
)


@dataclass
class Constants:
    """Parameter-only expressions, each computed once a run and kept in the array ``%constants``."""

    slots: dict[Node, int] = field(default_factory=dict)
    extra: int = 0

    def value(self, emitter: Emitter, node: Node) -> Value:
        """The operand of a constant of the motion: a literal, or a load from its slot."""
        if node.kind is Kind.NUMBER:
            return literal(node.data)
        return emitter.load("%constants", self.slots.setdefault(node, len(self.slots) + self.extra))


def emit_function(emitter: Emitter, name: str, arguments: list[Value]) -> Value:
    """A call of one of the expression language's functions."""
    return emitter.call(f"llvm.{name}.f64" if name in INTRINSICS else name, *arguments)


def emit_power(emitter: Emitter, base: Value, exponent: float) -> Value:
    """``base ** exponent`` for an exponent known now."""
    if exponent == int(exponent) and abs(exponent) <= 16:
        count, square, result = abs(int(exponent)), base, literal(1.0)
        while count:
            if count & 1:
                result = emitter.mul(result, square)
            count >>= 1
            if count:
                square = emitter.mul(square, square)
        return emitter.div(ONE, result) if exponent < 0 else result
    if abs(exponent) <= 8 and 2 * exponent == int(2 * exponent):
        root = emitter.call("llvm.sqrt.f64", base)
        return emit_power(emitter, root, 2 * exponent)
    return emitter.call("llvm.pow.f64", base, literal(exponent))


def emit_values(
    emitter: Emitter, nodes: list[Node], known: dict[Node, Value], constants: Constants | None
) -> None:
    """Compute ``nodes`` into ``known``, which holds the symbols' values (and any node computed before).

    With ``constants``, a node that ``known`` has no symbol for is a constant of the motion and comes
    from its slot.
    """
    moving = 0
    for node in known:
        moving |= node.symbols if node.kind is Kind.SYMBOL else 0
    loaded: dict[Node, Value] = {}

    def inner(argument: Node) -> Value:
        if argument.kind is Kind.NUMBER:
            return literal(argument.data)
        if constants is not None and not argument.symbols & moving and argument not in known:
            if argument not in loaded:
                loaded[argument] = constants.value(emitter, argument)
            return loaded[argument]
        return known[argument]

    def enter(node: Node) -> bool:
        if node in known or node.kind is Kind.NUMBER:
            return False
        return constants is None or bool(node.symbols & moving)

    for node in reachable(nodes, enter):
        known[node] = emit_node(emitter, node, inner)
    for node in nodes:
        known.setdefault(node, inner(node))


def emit_node(emitter: Emitter, node: Node, inner: object) -> Value:
    """One node from its arguments' values."""
    assert callable(inner)
    arguments = node.arguments
    if node.kind is Kind.SUM:
        constant, coefficients = node.data
        total = literal(constant)
        for argument, coefficient in zip(arguments, coefficients):
            if coefficient == -1.0:
                total = emitter.sub(total, inner(argument))
            else:
                total = emitter.fma(literal(coefficient), inner(argument), total)
        return total
    if node.kind is Kind.PRODUCT:
        above: Value = ONE
        below: Value = ONE
        for argument, exponent in zip(arguments, node.data):
            power = emit_power(emitter, inner(argument), abs(exponent))
            if exponent > 0:
                above = emitter.mul(above, power)
            else:
                below = emitter.mul(below, power)
        return above if below == ONE else emitter.div(above, below)
    if node.kind is Kind.POWER:
        return emitter.call("llvm.pow.f64", inner(arguments[0]), inner(arguments[1]))
    if node.kind is Kind.FUNCTION:
        return emit_function(emitter, node.data, [inner(argument) for argument in arguments])
    raise ValueError(f"{node.kind} has no value at a single state")


def emit_prepare(
    constants: Constants, parameters: Mapping[str, Node], name: str = "void @prepare"
) -> tuple[str, int]:
    """The function that fills ``%constants`` from the parameters' values, and how many it fills."""
    emitter = Emitter()
    known: dict[Node, Value] = {}
    for i, node in enumerate(parameters.values()):
        known[node] = emitter.load("%parameters", i)
    emit_values(emitter, list(constants.slots), known, None)
    for node, slot in constants.slots.items():
        emitter.store(known[node], "%constants", slot)
    body = "\n".join(emitter.lines)
    head = f"{name}(ptr noalias %parameters, ptr noalias %constants) nounwind"
    return f"define {head} {{\n{body}\n  ret void\n}}\n", len(constants.slots)
