"""What operators and functions do to scalars and vectors over any algebra."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce
from operator import add, mul, sub, truediv
from typing import Any

from lagrange_cli.expression.algebra import Algebra, Value
from lagrange_cli.expression.indices import Indices, known_indices
from lagrange_cli.expression.node import Kind, Node
from lagrange_cli.expression.reals import FADED, SMALLEST, TOO_SMALL, Underflow
from lagrange_cli.expression.syntax import Binary, Call, ExpressionError, Name, Tree, Vector, parts
from lagrange_cli.expression.vocabulary import VECTOR_FUNCTIONS


def norm(vector: tuple[Any, ...], algebra: Algebra[Any]) -> Any:
    """The length of a vector, sqrt(v . v)."""
    return algebra.function("sqrt", (dot(vector, vector),))


def dot(left: tuple[Any, ...], right: tuple[Any, ...]) -> Any:
    """The scalar product of two vectors of the same length."""
    return reduce(add, map(mul, left, right))


def cross(left: Sequence[Any], right: Sequence[Any]) -> tuple[Any, Any, Any]:
    """The vector product of two vectors of three components."""
    a, b, c = left
    x, y, z = right
    return (b * z - c * y, c * x - a * z, a * y - b * x)


def component(tree: Tree, value: Value) -> Any:
    """The value of ``tree`` as a component of a vector."""
    if isinstance(value, tuple):
        raise ExpressionError(
            tree.span, "a component of a vector cannot be a vector itself", "write a scalar here"
        )
    return value


def call(tree: Call, arguments: list[Value], algebra: Algebra[Any], *, fades: bool = False) -> Value:
    """The value of a function of the language.

    Raises ``Underflow`` where an exponential is too small for a double, unless it ``fades``: is 0 then, also
    where it is hardly more, as its product with a small number would be.
    """
    for argument, value in zip(tree.arguments, arguments, strict=True):
        if tree.function not in VECTOR_FUNCTIONS and isinstance(value, tuple):
            raise ExpressionError(
                argument.span, f"'{tree.function}' needs a scalar, not a vector", "take a component or norm()"
            )
        if tree.function in VECTOR_FUNCTIONS and not isinstance(value, tuple):
            raise ExpressionError(
                argument.span,
                f"'{tree.function}' needs a vector, not a scalar",
                "write a vector as (x, y, z)",
            )
    if tree.function not in VECTOR_FUNCTIONS:
        value = algebra.function(tree.function, arguments)
        if tree.function != "exp":
            return value
        return faded(value) if fades else kept(value)
    if tree.function == "norm":
        return norm(arguments[0], algebra)
    left, right = arguments
    _same_length(tree, left, right)
    if tree.function == "dot":
        return dot(left, right)
    if len(left) != 3:
        raise ExpressionError(
            tree.span,
            f"'cross' needs vectors of three components, not {len(left)}",
            "give both a z component, such as 0",
        )
    return cross(left, right)


def _same_length(tree: Tree, left: tuple[Any, ...], right: tuple[Any, ...]) -> None:
    if len(left) != len(right):
        raise ExpressionError(
            tree.span,
            f"vectors of {len(left)} and {len(right)} components cannot be combined",
            "give both the same number of components",
        )


def kept(value: Any, *operands: Any) -> Any:
    """``value``. Raises ``Underflow`` where it is 0 and none of ``operands`` is."""
    if nothing(value) and not any(map(nothing, operands)):
        raise Underflow
    return value


def faded(value: Any) -> Any:
    """An exponential, or 0 where it is next to nothing."""
    return 0.0 if isinstance(value, float) and value < FADED else value


def nothing(value: Any) -> bool:
    """Whether an element is a number, and its double is 0."""
    if isinstance(value, Node):
        return value.kind is Kind.NUMBER and float(value.data) == 0.0
    return isinstance(value, float) and value == 0.0


def _bracketed(tree: Tree) -> str:
    """The way out where square brackets stand for parentheses; nothing where they do not."""
    alone = any(isinstance(one, Vector) and len(one.items) == 1 for one in parts(tree))
    return "write parentheses: [ and ] make a vector" if alone else ""


def _sum(operation: Callable[[Any, Any], Any]) -> Callable[[Value, Value, Binary], Value]:
    def combine(left: Value, right: Value, tree: Binary) -> Value:
        if isinstance(left, tuple) and isinstance(right, tuple):
            _same_length(tree, left, right)
            return tuple(map(operation, left, right))
        if isinstance(left, tuple) or isinstance(right, tuple):
            vector, side = (left, tree.left) if isinstance(left, tuple) else (right, tree.right)
            hint = "take a component of the vector, as in bead.x, or its norm()"
            if isinstance(side, Name) and not side.indices:
                name = side.identifier
                hint = f"write {name}.x for its component"
                if len(vector) > 1:
                    hint = f"write {name}.x for a component, or norm({name})"
            message = f"a vector and a scalar cannot be combined by '{tree.operator}'"
            raise ExpressionError(tree.span, message, _bracketed(side) or hint)
        return operation(left, right)

    return combine


def _product(left: Value, right: Value, tree: Binary) -> Value:
    if isinstance(left, tuple) and isinstance(right, tuple):
        raise ExpressionError(
            tree.span, "two vectors cannot be multiplied by '*'", "write dot(a, b) or cross(a, b)"
        )
    if isinstance(left, tuple):
        return tuple(kept(item * right, item, right) for item in left)
    if isinstance(right, tuple):
        return tuple(kept(left * item, left, item) for item in right)
    return kept(left * right, left, right)


def _quotient(left: Value, right: Value, tree: Binary) -> Value:
    if isinstance(right, tuple):
        raise ExpressionError(tree.right.span, "division by a vector", "divide by its norm()")
    if isinstance(left, tuple):
        return tuple(kept(truediv(item, right), item) for item in left)
    return kept(left / right, left)


def _power(left: Value, right: Value, tree: Binary) -> Value:
    if isinstance(left, tuple) or isinstance(right, tuple):
        hint = _bracketed(tree.left) or _bracketed(tree.right) or "write dot(a, a) for a square"
        raise ExpressionError(tree.span, "a vector cannot stand in a power", hint)
    power = left**right
    if isinstance(power, complex):  # Python's floats leave the real line for (-1)**0.5
        raise ArithmeticError("this power is not a real number")
    return kept(power, left)


def joined(tree: Call, one: Value, other: Value, function: Callable[[Any, Any], Any]) -> Value:
    """What ``function`` makes of two branches of ``tree``; of vectors, of their components."""
    if isinstance(one, tuple) and isinstance(other, tuple):
        _same_length(tree, one, other)
        return tuple(map(function, one, other))
    if isinstance(one, tuple) or isinstance(other, tuple):
        message = f"'{tree.function}' cannot choose between a vector and a scalar"
        raise ExpressionError(tree.span, message, "give both the same number of components")
    return function(one, other)


OPERATIONS: dict[str, Callable[[Value, Value, Binary], Value]] = {
    "+": _sum(add),
    "-": _sum(sub),
    "*": _product,
    "/": _quotient,
    "**": _power,
}


def arithmetic(tree: Tree, error: ArithmeticError, indices: Indices) -> ExpressionError:
    """What an algebra could not do, at its place, with the values of the indices there."""
    where = known_indices(tree, indices)
    if isinstance(error, ZeroDivisionError):
        return ExpressionError(tree.span, f"division by zero{where}", "the divisor must not be 0")
    if isinstance(error, Underflow):
        return ExpressionError(tree.span, f"{TOO_SMALL}{where}", SMALLEST)
    if isinstance(error, OverflowError):
        return ExpressionError(tree.span, f"number too large{where}", "the largest is about 1.8e308")
    return ExpressionError(tree.span, f"{error}{where}", "write it another way")
