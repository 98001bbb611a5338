"""``Tree`` to a value over any algebra: the one place where operators and functions get their meaning."""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from operator import add, mul, sub, truediv
from typing import Any

from lagrange_cli.expression.algebra import Algebra, Value
from lagrange_cli.expression.syntax import Binary, Call, ExpressionError, Name, Negative, Number, Tree, Vector
from lagrange_cli.expression.vocabulary import FUNCTIONS

Scope = Callable[[str], Value]


def build(tree: Tree, scope: Scope, algebra: Algebra[Any]) -> Value:
    """The value of ``tree``: an element of ``algebra``, or a tuple of 1 to 3 elements for a vector.

    ``scope`` gives the value of each (possibly dotted) name; ``pi`` is asked of the algebra.

    Raises:
        ExpressionError: where a vector meets a scalar, lengths differ, or the algebra raises
            ``ArithmeticError`` (a division by zero among constants, say).
    """
    # Sums and products lean to the left, so the long way down is a loop and the recursion stays short.
    spine: list[Binary] = []
    while isinstance(tree, Binary):
        spine.append(tree)
        tree = tree.left
    value = _operand(tree, scope, algebra)
    for binary in reversed(spine):
        right = build(binary.right, scope, algebra)
        try:
            value = _OPERATIONS[binary.operator](value, right, binary)
        except ArithmeticError as error:
            raise _arithmetic(binary, error) from error
    return value


def norm(vector: tuple[Any, ...], algebra: Algebra[Any]) -> Any:
    """The length of a vector, sqrt(v . v)."""
    return algebra.function("sqrt", (dot(vector, vector),))


def dot(left: tuple[Any, ...], right: tuple[Any, ...]) -> Any:
    """The scalar product of two vectors of the same length."""
    return reduce(add, map(mul, left, right))


def cross(left: tuple[Any, ...], right: tuple[Any, ...]) -> tuple[Any, ...]:
    """The vector product of two vectors of three components."""
    a, b, c = left
    x, y, z = right
    return (b * z - c * y, c * x - a * z, a * y - b * x)


def _operand(tree: Tree, scope: Scope, algebra: Algebra[Any]) -> Value:
    if isinstance(tree, Number):
        return algebra.number(tree.text)
    if isinstance(tree, Name):
        return algebra.pi() if tree.identifier == "pi" else scope(tree.identifier)
    if isinstance(tree, Negative):
        operand = build(tree.operand, scope, algebra)
        return tuple(-item for item in operand) if isinstance(operand, tuple) else -operand
    if isinstance(tree, Vector):
        return tuple(_component(item, build(item, scope, algebra)) for item in tree.items)
    assert isinstance(tree, Call)
    arguments = [build(argument, scope, algebra) for argument in tree.arguments]
    try:
        return _call(tree, arguments, algebra)
    except ArithmeticError as error:
        raise _arithmetic(tree, error) from error


def _component(tree: Tree, value: Value) -> Any:
    if isinstance(value, tuple):
        raise ExpressionError(tree.span, "a component of a vector cannot be a vector", "write a scalar here")
    return value


def _call(tree: Call, arguments: list[Value], algebra: Algebra[Any]) -> Value:
    for argument, value in zip(tree.arguments, arguments, strict=True):
        if tree.function in FUNCTIONS and isinstance(value, tuple):
            raise ExpressionError(
                argument.span,
                f"'{tree.function}' needs a scalar, and this is a vector",
                "take a component or norm()",
            )
        if tree.function not in FUNCTIONS and not isinstance(value, tuple):
            raise ExpressionError(
                argument.span,
                f"'{tree.function}' needs a vector, and this is a scalar",
                "write a vector as (x, y, z)",
            )
    if tree.function in FUNCTIONS:
        return algebra.function(tree.function, arguments)
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
            f"vectors of {len(left)} and {len(right)} components do not go together",
            "give both the same number of components",
        )


def _sum(operation: Callable[[Any, Any], Any]) -> Callable[[Value, Value, Binary], Value]:
    def combine(left: Value, right: Value, tree: Binary) -> Value:
        if isinstance(left, tuple) and isinstance(right, tuple):
            _same_length(tree, left, right)
            return tuple(map(operation, left, right))
        if isinstance(left, tuple) or isinstance(right, tuple):
            raise ExpressionError(
                tree.span,
                f"a vector and a scalar cannot be combined by '{tree.operator}'",
                "take a component of the vector, as in bead.x, or its norm()",
            )
        return operation(left, right)

    return combine


def _product(left: Value, right: Value, tree: Binary) -> Value:
    if isinstance(left, tuple) and isinstance(right, tuple):
        raise ExpressionError(
            tree.span, "'*' does not multiply two vectors", "write dot(a, b) or cross(a, b)"
        )
    if isinstance(left, tuple):
        return tuple(item * right for item in left)
    if isinstance(right, tuple):
        return tuple(left * item for item in right)
    return left * right


def _quotient(left: Value, right: Value, tree: Binary) -> Value:
    if isinstance(right, tuple):
        raise ExpressionError(tree.right.span, "nothing can be divided by a vector", "divide by its norm()")
    if isinstance(left, tuple):
        return tuple(truediv(item, right) for item in left)
    return left / right


def _power(left: Value, right: Value, tree: Binary) -> Value:
    if isinstance(left, tuple) or isinstance(right, tuple):
        raise ExpressionError(
            tree.span, "'**' needs scalars, and this is a vector", "write dot(a, a) for a square"
        )
    power = left**right
    if isinstance(power, complex):  # Python's floats leave the real line for (-1)**0.5
        raise ArithmeticError("this power is not a real number")
    return power


_OPERATIONS: dict[str, Callable[[Value, Value, Binary], Value]] = {
    "+": _sum(add),
    "-": _sum(sub),
    "*": _product,
    "/": _quotient,
    "**": _power,
}


def _arithmetic(tree: Tree, error: ArithmeticError) -> ExpressionError:
    if isinstance(error, ZeroDivisionError):
        return ExpressionError(tree.span, "division by zero", "what is divided by must not be 0")
    if isinstance(error, OverflowError):
        return ExpressionError(tree.span, "this number is too large", "the largest is about 1.8e308")
    return ExpressionError(tree.span, str(error), "write it another way")
