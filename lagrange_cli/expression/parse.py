"""Text to ``Tree``: Python's ``ast`` in ``eval`` mode, walked by a whitelist and never evaluated."""

from __future__ import annotations

import ast
import warnings

from lagrange_cli.expression.bounds import check_exponent
from lagrange_cli.expression.near import near_hint
from lagrange_cli.expression.numbers import evaluate
from lagrange_cli.expression.scan import scan
from lagrange_cli.expression.syntax import (
    Axis,
    Binary,
    Call,
    Comparison,
    ExpressionError,
    Key,
    Logic,
    Name,
    Negative,
    Number,
    Span,
    Sum,
    Tree,
    Vector,
    names,
)
from lagrange_cli.expression.vocabulary import CALLABLE, CONSTANTS, NON_SMOOTH, RESERVED

_OPERATORS: dict[type[ast.operator], str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.Pow: "**",
    ast.FloorDiv: "//",
    ast.Mod: "%",
}
_COMPARISONS: dict[type[ast.cmpop], str] = {
    ast.Eq: "==", ast.NotEq: "!=", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=",
}  # fmt: skip
_SUM = "write sum(m[j]*x[j] for j in range(N))"
_LOOP = "write 'for j in range(N)'"
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
    root = _read(text, offset)
    return _Walk(text, offset).tree(root)


def parse_key(text: str) -> Key:
    """What a section declares: a name, ``theta[i in range(N)]`` for members of a family, or ``u[0, N - 1]``.

    Raises:
        ExpressionError: where the text is neither.
    """
    root = _read(text, 0, key=True)
    walk = _Walk(text, 0)
    if isinstance(root, ast.Subscript) and isinstance(root.value, ast.Name):
        axes = tuple(walk.axis(index) for index in _indices(root))
        twice = [axis for i, axis in enumerate(axes) if axis.index in [one.index for one in axes[:i]]]
        if any(axis.index for axis in twice):
            axis = next(axis for axis in twice if axis.index)
            raise ExpressionError(axis.span, f"the index '{axis.index}' comes twice", "call it another name")
        return Key(root.value.id, text, axes)
    if not isinstance(root, ast.Name):
        hint = "write a name, or a family as theta[i in range(N)]"
        raise ExpressionError(Span(0, max(1, len(text))), "this is no name", hint)
    return Key(root.id, text)


def _read(text: str, offset: int, key: bool = False) -> ast.expr:
    try:
        scan(text, key)
        return _python_tree(text)
    except ExpressionError as error:
        span = Span(error.span.start + offset, error.span.stop + offset)
        raise ExpressionError(span, error.message, error.hint) from error


def _indices(node: ast.Subscript) -> list[ast.expr]:
    return list(node.slice.elts) if isinstance(node.slice, ast.Tuple) else [node.slice]


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
            raise ExpressionError(span, "this operator is not accepted", "only + - * / ** are, and // %")
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
        if isinstance(node, ast.Subscript):
            return self._member(node, span)
        if isinstance(node, ast.Compare):
            operators = tuple(_COMPARISONS.get(type(operator), "in") for operator in node.ops)
            if "in" in operators:
                raise ExpressionError(span, "'in' cannot stand here", _LOOP)
            return Comparison(operators, tuple(map(self.tree, (node.left, *node.comparators))), span)
        if isinstance(node, ast.BoolOp):
            operator = "and" if isinstance(node.op, ast.And) else "or"
            return Logic(operator, tuple(map(self.tree, node.values)), span)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return Logic("not", (self.tree(node.operand),), span)
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

    def _member(self, node: ast.Subscript, span: Span) -> Name:
        if isinstance(node.value, ast.Attribute):
            raise ExpressionError(span, "an index comes before the component", "write bob[i].x")
        if not isinstance(node.value, ast.Name):
            raise ExpressionError(span, "only a named family has members", "as in theta[0] or theta[i]")
        indices = tuple(map(self.tree, _indices(node)))
        return Name(node.value.id, span, indices)

    def _component(self, node: ast.Attribute, span: Span) -> Name:
        owner = node.value
        if isinstance(owner, ast.Subscript):
            member = self._member(owner, self._span(owner))
            return Name(f"{member.identifier}.{node.attr}", span, member.indices)
        if not isinstance(owner, ast.Name):
            raise ExpressionError(span, "only a named vector has components", "as in bead.x or bead.vx")
        return Name(f"{owner.id}.{node.attr}", span)

    def axis(self, node: ast.expr) -> Axis:
        """One index of a key."""
        span = self._span(node)
        if not isinstance(node, ast.Compare):
            return Axis("", (self.tree(node),), span)
        if len(node.ops) != 1 or not isinstance(node.ops[0], ast.In):
            raise ExpressionError(span, "this is no index", "write theta[i in range(N)] or theta[0]")
        index, _ = self._index(node.left)
        return Axis(index, self._range(node.comparators[0]), span)

    def _index(self, node: ast.expr) -> tuple[str, Span]:
        span = self._span(node)
        if not isinstance(node, ast.Name):
            raise ExpressionError(span, "an index must be a name", _LOOP)
        if node.id in RESERVED:
            raise ExpressionError(
                span, f"the name '{node.id}' is reserved", f"call the index {node.id}_ or another name"
            )
        return node.id, span

    def _range(self, node: ast.expr) -> tuple[Tree, ...]:
        if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "range"):
            raise ExpressionError(self._span(node), "an index runs through a range", "write range(N)")
        if not 1 <= len(node.args) <= 3:
            raise ExpressionError(
                self._span(node),
                f"'range' takes 1 to 3 arguments, not {len(node.args)}",
                "write range(N), or range(start, stop, step) where stop does not belong to it",
            )
        return tuple(map(self.tree, node.args))

    def _sum(self, node: ast.Call, span: Span) -> Sum:
        inner = node.args[0] if len(node.args) == 1 else None
        if not isinstance(inner, ast.GeneratorExp):
            raise ExpressionError(span, "a sum needs a loop", _SUM)
        tree: Tree = self.tree(inner.elt)
        for loop in reversed(inner.generators):
            index, place = self._index(loop.target)
            conditions = tuple(map(self.tree, loop.ifs))
            tree = Sum(tree, index, self._range(loop.iter), conditions, span, place)
        assert isinstance(tree, Sum)
        return tree

    def _call(self, node: ast.Call, span: Span) -> Tree:
        if not isinstance(node.func, ast.Name):
            raise ExpressionError(span, "only functions can be called", "write * for a product")
        function, place = node.func.id, self._span(node.func)
        if function == "sum":
            return self._sum(node, span)
        if function in NON_SMOOTH:
            raise ExpressionError(
                place,
                f"'{function}' is not supported yet: it is not smooth",
                "use a smooth function, such as tanh or sqrt(x**2 + eps**2)",
            )
        if function == "range":
            raise ExpressionError(place, "'range' can stand only after 'in'", _SUM)
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
