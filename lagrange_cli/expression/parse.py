"""Text to ``Tree``: Python's ``ast`` in ``eval`` mode, walked by a whitelist and never evaluated."""

from __future__ import annotations

import ast
import warnings

from lagrange_cli.expression.bounds import check_exponent
from lagrange_cli.expression.near import near_hint
from lagrange_cli.expression.numbers import evaluate
from lagrange_cli.expression.scan import scan
from lagrange_cli.expression.syntax import (
    Binary,
    Call,
    ExpressionError,
    Name,
    Negative,
    Number,
    Span,
    Tree,
    Vector,
    names,
)
from lagrange_cli.expression.vocabulary import CALLABLE, CONSTANTS, FAMILY_WORDS, NON_SMOOTH

_OPERATORS: dict[type[ast.operator], str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.Pow: "**",
}
_SPLIT = "write it in smaller parts, named under 'definitions'"
_OTHER_NAMES = {
    "arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2", "ln": "log",
    "arcsinh": "log(x + sqrt(x**2 + 1))", "asinh": "log(x + sqrt(x**2 + 1))", "log10": "log(x)/log(10)",
    "cot": "1/tan(x)", "sec": "1/cos(x)", "csc": "1/sin(x)", "pow": "x**y",
}  # fmt: skip
"""What some functions are called elsewhere, and how to write them here."""


def parse(text: str, offset: int = 0) -> Tree:
    """The tree of the expression ``text``; ``offset`` is added to every span.

    A top-level ``x, y`` is a vector with or without its parentheses. Numbers keep their text. Names are
    normalized as Python's are (NFKC).

    Raises:
        ExpressionError: where the text is not an expression of the language, or passes its bounds; its
            span includes ``offset``.
    """
    try:
        scan(text)
        root = _python_tree(text)
    except ExpressionError as error:
        span = Span(error.span.start + offset, error.span.stop + offset)
        raise ExpressionError(span, error.message, error.hint) from error
    return _Walk(text, offset).tree(root)


def _python_tree(text: str) -> ast.expr:
    flat = "".join(" " if character.isspace() else character for character in text)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return ast.parse(f"({flat})", mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise ExpressionError(Span(0, len(text)), "this cannot be read as an expression", _SPLIT) from error


class _Walk:
    """Turns Python's nodes into ours; whatever is not listed is refused."""

    def __init__(self, text: str, offset: int) -> None:
        self.text = text
        self.offset = offset
        self.encoded = None if text.isascii() else text.encode()

    def tree(self, node: ast.expr) -> Tree:
        # Sums and products lean to the left, so the long way down is a loop and the recursion stays short.
        spine: list[ast.BinOp] = []
        while isinstance(node, ast.BinOp):
            spine.append(node)
            node = node.left
        tree = self._operand(node)
        for binary in reversed(spine):
            tree = self._binary(binary, tree)
        return tree

    def _span(self, node: ast.expr) -> Span:
        stop = node.end_col_offset if node.end_col_offset is not None else node.col_offset
        return Span(self._column(node.col_offset), self._column(stop))

    def _column(self, byte: int) -> int:
        """Python counts UTF-8 bytes, and one parenthesis that was put before the text."""
        byte -= 1
        if self.encoded is None:
            return self.offset + max(0, min(byte, len(self.text)))
        return self.offset + len(self.encoded[: max(0, byte)].decode(errors="ignore"))

    def _binary(self, node: ast.BinOp, left: Tree) -> Tree:
        span = self._span(node)
        operator = _OPERATORS.get(type(node.op))
        if operator is None:
            raise ExpressionError(span, "this operator is not accepted", "only + - * / ** are")
        right = self.tree(node.right)
        if operator == "**" and all(name.identifier in CONSTANTS for name in names(right)):
            _check_literal_exponent(right)
        return Binary(operator, left, right, span)

    def _operand(self, node: ast.expr) -> Tree:
        span = self._span(node)
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            return Number(self.text[span.start - self.offset : span.stop - self.offset], span)
        if isinstance(node, ast.Name):
            return Name(node.id, span)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            return Negative(self.tree(node.operand), span)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.UAdd):
            return self.tree(node.operand)
        if isinstance(node, ast.Attribute):
            return self._component(node, span)
        if isinstance(node, ast.Call):
            return self._call(node, span)
        if isinstance(node, ast.Tuple | ast.List):
            if not 1 <= len(node.elts) <= 3:
                raise ExpressionError(
                    span, f"a vector has one to three components, not {len(node.elts)}", "as in (x, y, z)"
                )
            return Vector(tuple(self.tree(item) for item in node.elts), span)
        raise ExpressionError(span, "this is not accepted in an expression", "only names, numbers, calls are")

    def _component(self, node: ast.Attribute, span: Span) -> Name:
        if not isinstance(node.value, ast.Name):
            raise ExpressionError(span, "only a named vector has components", "as in bead.x or bead.vx")
        return Name(f"{node.value.id}.{node.attr}", span)

    def _call(self, node: ast.Call, span: Span) -> Call:
        if not isinstance(node.func, ast.Name):
            raise ExpressionError(span, "only functions can be called", "write * for a product")
        function, place = node.func.id, self._span(node.func)
        if function in NON_SMOOTH:
            raise ExpressionError(
                place,
                f"'{function}' is not supported yet: it is not smooth",
                "use a smooth function, such as tanh or sqrt(x**2 + eps**2)",
            )
        if function in FAMILY_WORDS:
            raise ExpressionError(
                place,
                f"'{function}': indexed families are not supported yet",
                "write the terms out one by one",
            )
        if function not in CALLABLE:
            raise ExpressionError(place, f"unknown function '{function}'", _function_hint(function))
        arity = CALLABLE[function]
        if len(node.args) != arity:
            arguments = "1 argument" if arity == 1 else f"{arity} arguments"
            raise ExpressionError(
                span,
                f"'{function}' takes {arguments}, not {len(node.args)}",
                f"write {function}({', '.join('xyz'[:arity])})",
            )
        return Call(function, tuple(self.tree(argument) for argument in node.args), span)


def _check_literal_exponent(exponent: Tree) -> None:
    try:
        check_exponent(evaluate(exponent))
    except ArithmeticError as error:
        raise ExpressionError(exponent.span, str(error), "write the power another way") from error


def _function_hint(function: str) -> str:
    if function in _OTHER_NAMES:
        return f"write {_OTHER_NAMES[function]}"
    return near_hint(function, CALLABLE) or "for a product write * before the parenthesis"
